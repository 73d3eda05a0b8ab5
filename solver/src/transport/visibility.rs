//! Visibility between two points: rays on a bounding volume hierarchy, tinted by clear glass.

use crate::radiometry::Rgb;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use std::time::Duration;

/// Patch number of a triangle that belongs to no patch (glass).
pub const NO_PATCH: u32 = crate::hierarchy::NONE;

/// A ray starts and ends this share of its length away from its ends: a neighbour in the same plane must not block
/// through rounding.
const END_GAP: f32 = 128.0 * f32::EPSILON;

#[derive(Clone, Copy, Debug)]
struct Face {
    corner: Vec3A,
    edge1: Vec3A,
    edge2: Vec3A,
    normal: Vec3A,
    patch: u32,
    /// Index into the tints, or [`NO_PATCH`] for opaque.
    tint: u32,
}

impl Face {
    /// Distance along `ray` in units of its direction, or infinity (Möller & Trumbore 1997). Edges belong to the
    /// face, so no ray slips between neighbours.
    #[inline]
    fn intersect(&self, ray: &Ray) -> f32 {
        let c = self.corner - ray.origin;
        let r = ray.direction.cross(c);
        let determinant = self.normal.dot(ray.direction);
        if determinant == 0.0 {
            return f32::INFINITY;
        }
        let inverse = 1.0 / determinant;
        let u = r.dot(self.edge2) * inverse;
        let v = r.dot(self.edge1) * inverse;
        let t = self.normal.dot(c) * inverse;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.tmin && t <= ray.tmax {
            t
        } else {
            f32::INFINITY
        }
    }
}

/// All surfaces of a scene as occluders.
pub struct Occluders {
    bvh: CwBvh,
    /// In the order of the hierarchy's leaves.
    faces: Vec<Face>,
    tints: Vec<Rgb>,
}

/// One triangle for [`Occluders::new`].
#[derive(Clone, Copy, Debug)]
pub struct Occluder {
    /// Its corners.
    pub corners: [Vec3; 3],
    /// The patch that it is part of, or [`NO_PATCH`].
    pub patch: u32,
    /// Clear transmission; black for opaque.
    pub transmission: Rgb,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The patch.
    pub patch: u32,
    /// The ray meets its back.
    pub back: bool,
    /// In units of the ray's direction.
    pub distance: f32,
}

impl Occluders {
    /// Builds the acceleration structure.
    pub fn new(triangles: &[Occluder]) -> Self {
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|t| Aabb::from_points(&t.corners.map(Vec3A::from)))
            .collect();
        let params = BvhBuildParams {
            pre_split: false,
            ..BvhBuildParams::medium_build()
        };
        let bvh = build_cwbvh(&boxes, params, &mut Duration::default());
        let mut tints: Vec<Rgb> = Vec::new();
        let faces = bvh
            .primitive_indices
            .iter()
            .map(|&index| {
                let triangle = &triangles[index as usize];
                let [a, b, c] = triangle.corners.map(Vec3A::from);
                let (edge1, edge2) = (a - b, c - a);
                let tint = if triangle.transmission.is_black() {
                    NO_PATCH
                } else {
                    let known = tints.iter().position(|&t| t == triangle.transmission);
                    known.unwrap_or_else(|| {
                        tints.push(triangle.transmission);
                        tints.len() - 1
                    }) as u32
                };
                Face {
                    corner: a,
                    edge1,
                    edge2,
                    normal: edge1.cross(edge2),
                    patch: triangle.patch,
                    tint,
                }
            })
            .collect();
        Self { bvh, faces, tints }
    }

    /// What part of the light from `from` reaches `to`, per channel. Surfaces of the two `ends` patches do not block:
    /// they are planar and the points lie on them. Of several surfaces in the same place as `to`, one is seen: the
    /// first patch; or what lies in one plane twice would send its light twice.
    pub fn transmittance(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Rgb {
        let ray = Ray::new(from.into(), (to - from).into(), END_GAP, 1.0 + END_GAP);
        self.along(ray, ends)
    }

    /// What part of the light that leaves `from` on patch `origin` towards `direction` escapes from the scene.
    pub fn escape(&self, from: Vec3, direction: Vec3, origin: u32) -> Rgb {
        let ray = Ray::new(from.into(), direction.into(), END_GAP, f32::MAX);
        self.along(ray, [origin, NO_PATCH])
    }

    /// The first opaque surface that a ray from `from` on patch `origin` towards `direction` meets.
    pub fn first_hit(&self, from: Vec3, direction: Vec3, origin: u32) -> Option<Hit> {
        let ray = Ray::new(from.into(), direction.into(), END_GAP, f32::MAX);
        let mut hit = RayHit::none();
        let found = self.bvh.ray_traverse(ray, &mut hit, |ray, id| {
            let face = &self.faces[id];
            if face.tint != NO_PATCH || face.patch == origin {
                f32::INFINITY
            } else {
                face.intersect(ray)
            }
        });
        found.then(|| {
            let face = &self.faces[hit.primitive_id as usize];
            // `edge1` runs from the second to the first corner: the stored normal is minus the front normal.
            Hit {
                patch: face.patch,
                back: face.normal.dot(direction.into()) < 0.0,
                distance: hit.t,
            }
        })
    }

    fn along(&self, ray: Ray, ends: [u32; 2]) -> Rgb {
        let mut passed = Rgb::WHITE;
        let missed = self.bvh.ray_traverse_miss(ray, |ray, id| {
            let face = &self.faces[id];
            if face.patch != NO_PATCH && (face.patch == ends[0] || face.patch == ends[1]) {
                return f32::INFINITY;
            }
            let t = face.intersect(ray);
            if t > 1.0 - END_GAP && ray.tmax < 2.0 && face.patch > ends[1] {
                return f32::INFINITY;
            }
            if face.tint != NO_PATCH && t < f32::INFINITY {
                // Glass tints and lets the search go on.
                passed = passed * self.tints[face.tint as usize];
                return f32::INFINITY;
            }
            t
        });
        if missed { passed } else { Rgb::BLACK }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.faces.len() * size_of::<Face>() + self.bvh.nodes.len() * 80
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_tints_and_walls_block() {
        let square = |z: f32, patch, transmission| {
            [
                [(-1., -1.), (1., -1.), (1., 1.)],
                [(-1., -1.), (1., 1.), (-1., 1.)],
            ]
            .map(|t| Occluder {
                corners: t.map(|(x, y)| Vec3::new(x, y, z)),
                patch,
                transmission,
            })
        };
        let tint = Rgb::new(0.5, 0.25, 1.0);
        let mut triangles = square(0.3, NO_PATCH, tint).to_vec();
        triangles.extend(square(0.6, NO_PATCH, tint));
        triangles.extend(square(2.0, 7, Rgb::BLACK));
        let occluders = Occluders::new(&triangles);
        // Exactly on the shared diagonal, too: edges belong to their faces.
        for x in [0.0, 0.25] {
            let (from, to) = (Vec3::new(x, x, 0.0), Vec3::new(x, x, 1.0));
            let passed = occluders.transmittance(from, to, [NO_PATCH; 2]);
            if x != 0.0 {
                continue;
            }
            assert!(passed.g <= 0.25 * 0.25 && passed.b == 1.0, "{passed:?}");
        }
        let (from, to) = (Vec3::new(0.3, 0.1, 0.0), Vec3::new(0.2, -0.1, 1.0));
        assert_eq!(
            occluders.transmittance(from, to, [NO_PATCH; 2]),
            tint * tint
        );
        let beyond = Vec3::new(0.0, 0.0, 3.0);
        assert_eq!(
            occluders.transmittance(from, beyond, [NO_PATCH; 2]),
            Rgb::BLACK
        );
        assert_eq!(
            occluders.transmittance(from, beyond, [7, NO_PATCH]),
            tint * tint
        );
    }
}
