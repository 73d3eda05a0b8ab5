//! Measurements that users repeat: tables of time, memory and error.

pub mod convergence;
pub mod fit;
pub mod frames;
pub mod plot;
pub mod rays;
pub mod scaling;
pub mod table;
pub mod tables;
