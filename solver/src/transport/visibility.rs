//! Visibility between two points: rays on a bounding volume hierarchy, tinted by clear glass.

use crate::radiometry::Rgb;
use crate::transport::query::{Query, Record, SCALE, SCALE_EXPONENT, ray, scaled};
#[cfg(target_arch = "x86_64")]
use crate::transport::wide::Wide;
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

/// Rounding of a point on a surface in normalised coordinates.
const LEAST_GAP: f32 = 2.0 * f32::EPSILON;

#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) corner: Vec3A,
    pub(super) edge1: Vec3A,
    pub(super) edge2: Vec3A,
    pub(super) normal: Vec3A,
}

/// What a face is of: rays ask for this far more often than for its shape.
#[derive(Clone, Copy, Debug)]
struct Surface {
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

/// Brings a tree of normalised boxes to the coordinates of [`scaled`]. Its builder's checks have tolerances for boxes of
/// about unit size.
fn enlarge(tree: &mut CwBvh) {
    for node in &mut tree.nodes {
        node.p *= SCALE;
        // Exponents of the steps that children's boxes are counted in.
        node.e = node.e.map(|exponent| exponent + SCALE_EXPONENT);
    }
    let all = &mut tree.total_aabb;
    *all = Aabb::new(all.min * SCALE, all.max * SCALE);
    // Exact boxes serve refitting only.
    tree.exact_node_aabbs = None;
}

/// All surfaces of a scene as occluders.
pub struct Occluders {
    bvh: CwBvh,
    /// In the order of the hierarchy's leaves.
    faces: Vec<Face>,
    /// Of each face.
    surfaces: Vec<Surface>,
    tints: Vec<Rgb>,
    /// The faces once more, where the machine can test several at a time.
    #[cfg(target_arch = "x86_64")]
    wide: Option<Wide>,
    record: Option<Record>,
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
    /// How far.
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
        let mut bvh = build_cwbvh(&boxes, params, &mut Duration::default());
        enlarge(&mut bvh);
        let mut tints: Vec<Rgb> = Vec::new();
        let (faces, surfaces): (Vec<Face>, Vec<Surface>) = bvh
            .primitive_indices
            .iter()
            .map(|&index| {
                let triangle = &triangles[index as usize];
                let [a, b, c] = triangle.corners.map(scaled);
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
                let face = Face {
                    corner: a,
                    edge1,
                    edge2,
                    normal: edge1.cross(edge2),
                };
                let patch = triangle.patch;
                (face, Surface { patch, tint })
            })
            .unzip();
        Self {
            #[cfg(target_arch = "x86_64")]
            wide: Wide::new(&bvh, &faces),
            bvh,
            faces,
            surfaces,
            tints,
            record: None,
        }
    }

    /// From now on keeps the first `most` questions that are asked for transmittance between two points.
    pub fn record(&mut self, most: usize) {
        self.record = Some(Record::new(most));
    }

    /// What was kept, and no more is.
    pub fn recorded(&mut self) -> Vec<Query> {
        self.record
            .take()
            .map_or_else(Vec::new, Record::into_queries)
    }

    /// Asks once more; true when nothing opaque stands there.
    pub fn passes(&self, query: &Query) -> bool {
        self.along(*query).1 == NO_PATCH
    }

    /// What part of the light from `from` reaches `to`, per channel. Surfaces of the two `ends` patches do not block:
    /// they are planar and the points lie on them. Of several surfaces in the same place as `to`, one is seen: the
    /// first patch; or what lies in one plane twice would send its light twice.
    pub fn transmittance(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Rgb {
        self.passage(from, to, ends).0
    }

    /// The same, and a patch that blocks, or [`NO_PATCH`].
    pub fn passage(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> (Rgb, u32) {
        let (direction, length) = (to - from).normalize_and_length();
        let span = [END_GAP * length, (1.0 + END_GAP) * length];
        let end = (1.0 - END_GAP) * length;
        self.along(Query {
            ray: ray(from, direction, span),
            ends,
            end: Some((end, ends[1])),
        })
    }

    /// The same, of what lies strictly in between, however near to the ends: in a corner the other wall is within the
    /// usual gap. A neighbour in the plane of an end may block through rounding, where the end is within that of it.
    pub fn strict_transmittance(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Rgb {
        let (direction, length) = (to - from).normalize_and_length();
        let span = [LEAST_GAP, length - LEAST_GAP];
        let query = Query {
            ray: ray(from, direction, span),
            ends,
            end: None,
        };
        self.along(query).0
    }

    /// What part of the light that leaves `from` on patch `origin` towards `direction` escapes from the scene.
    pub fn escape(&self, from: Vec3, direction: Vec3, origin: u32) -> Rgb {
        let query = Query {
            ray: ray(from, direction, [LEAST_GAP, f32::INFINITY]),
            ends: [origin, NO_PATCH],
            end: None,
        };
        self.along(query).0
    }

    /// The first opaque surface that a ray from `from` on patch `origin` towards `direction` meets.
    pub fn first_hit(&self, from: Vec3, direction: Vec3, origin: u32) -> Option<Hit> {
        self.hit_beyond(END_GAP, from, direction, origin)
    }

    /// The same, however near: in a corner a ray meets the other wall within the usual gap. A neighbour in the same plane
    /// may be met through rounding by rays that start within rounding of it.
    pub fn nearest_hit(&self, from: Vec3, direction: Vec3, origin: u32) -> Option<Hit> {
        self.hit_beyond(LEAST_GAP, from, direction, origin)
    }

    fn hit_beyond(&self, gap: f32, from: Vec3, direction: Vec3, origin: u32) -> Option<Hit> {
        let ray = ray(from, direction, [gap, f32::INFINITY]);
        let (distance, face) = self.nearest(&ray, |t, surface| {
            if surface.tint != NO_PATCH || surface.patch == origin {
                f32::INFINITY
            } else {
                t
            }
        })?;
        let (face, surface) = (&self.faces[face], self.surfaces[face]);
        // `edge1` runs from the second to the first corner: the stored normal is minus the front normal.
        Some(Hit {
            patch: surface.patch,
            back: face.normal.dot(direction.into()) < 0.0,
            distance: distance / SCALE,
        })
    }

    /// Distance and number of the nearest face for which `meet` returns its distance and not infinity.
    fn nearest(
        &self,
        ray: &Ray,
        mut meet: impl FnMut(f32, Surface) -> f32,
    ) -> Option<(f32, usize)> {
        #[cfg(target_arch = "x86_64")]
        if let Some(wide) = &self.wide {
            return wide.nearest(ray, |t, face| meet(t, self.surfaces[face]));
        }
        let mut hit = RayHit::none();
        let found = self.bvh.ray_traverse(*ray, &mut hit, |ray, face| {
            let t = self.faces[face].intersect(ray);
            if t < f32::INFINITY {
                meet(t, self.surfaces[face])
            } else {
                t
            }
        });
        found.then_some((hit.t, hit.primitive_id as usize))
    }

    /// Calls `meet` with the faces that the ray meets until it returns less than the ray's end. True when it did.
    fn meets(&self, ray: &Ray, mut meet: impl FnMut(f32, Surface) -> f32) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(wide) = &self.wide {
            return wide.meets(ray, |t, face| meet(t, self.surfaces[face]));
        }
        !self.bvh.ray_traverse_miss(*ray, |ray, face| {
            let t = self.faces[face].intersect(ray);
            if t < f32::INFINITY {
                meet(t, self.surfaces[face])
            } else {
                t
            }
        })
    }

    /// What passes, and a patch that blocks, or [`NO_PATCH`].
    fn along(&self, query: Query) -> (Rgb, u32) {
        if let Some(record) = &self.record {
            record.keep(query);
        }
        let Query { ray, ends, end } = query;
        let mut passed = Rgb::WHITE;
        let mut blocker = NO_PATCH;
        let is_blocked = self.meets(&ray, |t, surface| {
            if surface.patch != NO_PATCH && (surface.patch == ends[0] || surface.patch == ends[1]) {
                return f32::INFINITY;
            }
            if end.is_some_and(|(near, first)| t > near * SCALE && surface.patch > first) {
                return f32::INFINITY;
            }
            if surface.tint != NO_PATCH {
                // Glass tints and lets the search go on.
                passed = passed * self.tints[surface.tint as usize];
                return f32::INFINITY;
            }
            blocker = surface.patch;
            t
        });
        if is_blocked {
            (Rgb::BLACK, blocker)
        } else {
            (passed, NO_PATCH)
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        #[cfg(target_arch = "x86_64")]
        let wide = self.wide.as_ref().map_or(0, Wide::bytes);
        #[cfg(not(target_arch = "x86_64"))]
        let wide = 0;
        self.faces.len() * (size_of::<Face>() + size_of::<Surface>())
            + self.bvh.nodes.len() * 80
            + wide
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

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn many_lanes_find_what_one_finds() {
        let unit = |i: u32, salt: u32| crate::geometry::hash::unit(i, salt);
        let point = |i: u32, salt: u32| Vec3::from([0, 1, 2].map(|axis| unit(i, salt + axis)));
        let triangles = |count: u32| {
            let triangle = move |i: u32| {
                let corner = point(i, 0);
                // Of all sizes, some in the plane of an axis.
                let edge = |salt: u32| {
                    let mut edge = (point(i, salt) - 0.5) * unit(i, 9).powi(4);
                    if i.is_multiple_of(3) {
                        edge.x = 0.0;
                    }
                    edge
                };
                Occluder {
                    corners: [corner, corner + edge(3), corner + edge(6)],
                    patch: if i.is_multiple_of(5) { NO_PATCH } else { i / 2 },
                    transmission: Rgb::splat(if i.is_multiple_of(5) { 0.5 } else { 0.0 }),
                }
            };
            (0..count).map(triangle).collect::<Vec<_>>()
        };
        for count in [1, 7, 9, 100, 1000] {
            let wide = Occluders::new(&triangles(count));
            let mut plain = Occluders::new(&triangles(count));
            plain.wide = None;
            assert_eq!(wide.wide.is_some(), crate::transport::wide::is_supported());
            let mut blocked = 0;
            for ray in 0..20_000 {
                let (from, mut to) = (point(ray, 20), point(ray, 30));
                if ray.is_multiple_of(4) {
                    to[ray as usize % 3] = from[ray as usize % 3];
                }
                let ends = [ray % count / 2, NO_PATCH];
                let (one, other) = (wide.passage(from, to, ends), plain.passage(from, to, ends));
                assert_eq!(one, other, "{count} triangles, from {from} to {to}");
                blocked += u32::from(one.1 != NO_PATCH);
                let direction = (to - from).normalize();
                let hits = [&wide, &plain].map(|all| all.first_hit(from, direction, ends[0]));
                assert_eq!(hits[0], hits[1], "{count} triangles, from {from} to {to}");
            }
            assert!(
                count < 100 || (2_000..18_000).contains(&blocked),
                "{blocked}"
            );
        }
    }

    #[test]
    fn rays_along_axes_meet_what_is_there_whatever_the_sign_of_their_zeros() {
        let wall = [(-1., -1.), (1., -1.), (1., 1.)];
        for axis in 0..3 {
            let at = |(x, y): (f32, f32)| {
                let mut point = Vec3::splat(0.5);
                (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (x, y);
                point
            };
            let occluders = Occluders::new(&[Occluder {
                corners: wall.map(at),
                patch: 7,
                transmission: Rgb::BLACK,
            }]);
            for signs in 0..4u32 {
                let zero = |bit: u32| if signs >> bit & 1 == 1 { -0.0 } else { 0.0 };
                let mut direction = Vec3::ONE;
                (direction[(axis + 1) % 3], direction[(axis + 2) % 3]) = (zero(0), zero(1));
                let from = at((0.25, 0.0)) - Vec3::ONE * direction;
                let hit = occluders.nearest_hit(from, direction, NO_PATCH);
                assert_eq!(hit.map(|hit| hit.distance), Some(1.0), "{direction:?}");
            }
        }
    }

    #[test]
    fn rays_from_the_edges_of_a_box_meet_its_other_walls() {
        let corner =
            |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32) - 0.5;
        let walls = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangle = |(patch, corners): (usize, [u32; 3])| Occluder {
            corners: corners.map(corner),
            patch: patch as u32,
            transmission: Rgb::BLACK,
        };
        let triangles = walls
            .iter()
            .flat_map(|w| [[w[0], w[1], w[2]], [w[0], w[2], w[3]]]);
        let triangles: Vec<Occluder> = triangles.enumerate().map(triangle).collect();
        let occluders = Occluders::new(&triangles);
        for i in 0..40_000 {
            let unit = |salt: u32| crate::geometry::hash::unit(i, salt);
            // On the first edge of a triangle's wall, and a little inwards: nearer than the tree's own tolerance.
            let origin = (i % 12) & !1;
            let [a, b, c] = triangles[origin as usize].corners;
            let (along, across) = ((b - a).normalize(), (c - b).normalize());
            let from = a + along * (0.1 + 0.8 * unit(0)) + across * (1e-6 + 1e-4 * unit(1));
            let normal = along.cross(across);
            let inwards = if normal.dot(a) > 0.0 { -normal } else { normal };
            let direction = inwards * (0.05 + unit(2)) + along * (unit(3) - 0.5) - across * unit(4);
            let direction = direction.normalize();
            let hit = occluders.nearest_hit(from, direction, origin);
            assert!(hit.is_some(), "from {from} towards {direction}");
            // And what is behind that wall is hidden.
            let passed =
                occluders.strict_transmittance(from, from + direction * 2.0, [origin, NO_PATCH]);
            assert!(passed.is_black(), "from {from} towards {direction}");
        }
    }
}
