//! Distributions of radiance over directions, on an octahedron subdivided 4:1 along great circles (§4.2).

mod cells;
mod fit;
pub mod haar;
pub mod octahedron;
pub mod packed;
mod sum;
mod tree;
pub mod uniform;

pub use haar::{Basis, Peak, Projection, ProjectionCost, Projector, Source};
pub use sum::Sum;
