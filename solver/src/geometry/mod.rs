//! Planar polygons: area, points on them, the light they send to a point.

mod angle;
pub mod cone;
pub mod hash;
pub mod polygon;
pub mod sampling;

pub use cone::Cone;
pub use polygon::Polygon;
