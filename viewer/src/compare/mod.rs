//! How far an image is from its reference: figures, and a map of where.

pub mod flip;
pub mod heatmap;
pub mod metrics;

pub use metrics::{CompareError, Comparison, compare};
