//! Light from surface to surface: exitant light, links and their bounds, visibility, propagation, reflection, pull.

pub mod exitant;
pub mod illumination;
pub mod link;
pub mod propagate;
pub mod pull;
pub mod reflect;
pub mod shaft;
pub mod visibility;
