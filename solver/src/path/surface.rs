//! Where a ray meets a surface.

use super::PathTracer;
use crate::transport::visibility::Hit;
use glam::Vec3;

/// A point on a triangle, as seen from where a ray comes.
pub(super) struct Surface {
    /// On the triangle.
    pub(super) point: Vec3,
    /// Shading normal, on the side of the ray.
    pub(super) normal: Vec3,
    /// Normal of the triangle's front.
    pub(super) front: Vec3,
    /// Of the triangle.
    pub(super) area: f32,
    /// Triangle.
    pub(super) triangle: u32,
    /// Material.
    pub(super) material: u32,
    /// The ray meets the back.
    pub(super) back: bool,
    /// This side does not scatter.
    pub(super) is_black: bool,
}

impl Surface {
    pub(super) fn new(tracer: &PathTracer, from: Vec3, direction: Vec3, hit: &Hit) -> Self {
        let triangle = &tracer.triangles[hit.patch as usize];
        let [a, b, c] = triangle.points.map(|p| tracer.frame.points[p as usize]);
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let squared = normal.length_squared();
        // Back on the triangle's plane: distances along a ray are rounded.
        let offset = from + direction * hit.distance - a;
        let u = offset.cross(ac).dot(normal) / squared;
        let v = ab.cross(offset).dot(normal) / squared;
        let length = squared.sqrt();
        let front = normal / length;
        let shading = triangle.normals.map_or(front, |normals| {
            let [na, nb, nc] = normals.map(|n| tracer.normals[n as usize]);
            (na * (1.0 - u - v) + nb * u + nc * v).normalize_or(front)
        });
        let material = &tracer.frame.materials[triangle.material as usize];
        Self {
            point: a + ab * u + ac * v,
            normal: if shading.dot(direction) > 0.0 {
                -shading
            } else {
                shading
            },
            front,
            area: 0.5 * length,
            triangle: hit.patch,
            material: triangle.material,
            back: hit.back,
            is_black: hit.back && !material.two_sided,
        }
    }
}
