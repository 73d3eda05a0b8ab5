//! Planar polygons: area, points on them, the light they send to a point.

pub mod hash;
pub mod polygon;

pub use polygon::Polygon;
