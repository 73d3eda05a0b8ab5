//! Distributions of radiance over directions, on an octahedron subdivided 4:1 along great circles (§4.2).

mod cells;
mod fit;
pub mod haar;
pub mod octahedron;
pub mod packed;

pub use haar::{Projection, ProjectionCost, Projector, Source};
