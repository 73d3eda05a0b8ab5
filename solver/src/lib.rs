//! Hierarchical radiance clustering with illumination samples and an adaptive octahedral Haar basis.
//!
//! M. Stamminger, A. Scheel, X. Granier, F. Perez-Cazorla, G. Drettakis, F. X. Sillion: *Efficient Glossy Global
//! Illumination with Interactive Viewing*, Computer Graphics Forum 19(1), 2000. Sections in the docs refer to it.
//!
//! A [`Scene`] goes in, a [`Solution`] comes out: no files, no GPU, no terminal.

pub mod brdf;
pub mod config;
pub mod directional;
pub mod error;
mod export;
pub mod geometry;
pub mod hierarchy;
pub mod normalise;
pub mod path;
pub mod radiometry;
pub mod scene;
pub mod solution;
pub mod solve;
pub mod stats;
pub mod transport;

pub use config::Quality;
pub use error::{SceneError, SolveError};
pub use path::PathTracer;
pub use radiometry::Rgb;
pub use scene::{Camera, Gloss, Material, PointLight, Scene, SceneParts, Triangle};
pub use solution::Solution;
pub use solve::{Observer, Progress, SolveConfig, solve};
pub use stats::Stats;
