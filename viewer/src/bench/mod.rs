//! Measurements that users repeat: tables of time, memory and error.

pub mod convergence;
pub mod plot;
