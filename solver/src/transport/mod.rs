//! Light from surface to surface: exitant light, links and their bounds, visibility, propagation, reflection, pull.

mod blockers;
pub mod closure;
pub mod clustering;
mod connect;
pub mod exitant;
pub mod gather;
pub mod illumination;
pub mod kernel;
pub mod link;
mod lobes;
mod merge;
mod occlusion;
pub mod openness;
mod packed_sample;
mod point_light;
pub mod propagate;
pub mod pull;
mod pyramid;
pub mod query;
mod rays;
pub mod reflect;
pub mod region;
mod sample;
mod sent;
pub mod shaft;
mod stray;
mod views;
pub mod visibility;
#[cfg(target_arch = "x86_64")]
mod wide;
