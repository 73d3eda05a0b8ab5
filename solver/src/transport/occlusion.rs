//! What a point sees of a polygon, exactly: the polygons that stand before it are cut out of it.
//!
//! Which may stand before it is found once, in the pyramid from the point to a sender, and handed down to its parts:
//! most pyramids hold nothing, and most others one or two patches. Where there are more, rays decide.

use crate::geometry::cone::MOST_CORNERS;
use crate::geometry::{Cone, Polygon};
use crate::transport::link::COPLANAR;
use crate::transport::pyramid::Pyramid;
use crate::transport::region::PatchTree;
use glam::Vec3;

/// Candidates that are cut exactly.
pub(super) const MOST_CANDIDATES: usize = 32;

/// Parts of a sender that are still seen; more are not worth their time.
const MOST_PIECES: usize = 48;

/// Patches that may stand between a point and a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Candidates {
    /// Not looked for yet.
    Unknown,
    /// A range of [`Occlusion::lists`].
    List(u32, u32),
    /// Too many, or glass.
    Many,
}

impl Candidates {
    /// True where it is known that nothing does.
    pub(super) fn is_none(&self) -> bool {
        matches!(self, Self::List(from, to) if from == to)
    }
}

/// A polygon as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// The part above the point's horizon.
    cone: Cone,
    /// A part of it lies below the horizon.
    pub(super) is_cut: bool,
    patch: u32,
    /// Plane of the polygon relative to the point: c·normal = offset < 0 on it; nearer is greater.
    normal: Vec3,
    offset: f32,
}

impl Target {
    /// `polygon` of `patch` from `point`, cut at the horizon; `None` when nothing of it can be seen.
    pub(super) fn new(
        polygon: &Polygon,
        normal: Vec3,
        patch: u32,
        point: Vec3,
        horizon: Option<Vec3>,
    ) -> Option<Self> {
        let offset = normal.dot(polygon.corners()[0] - point);
        if offset >= 0.0 {
            return None;
        }
        let whole = Cone::new(polygon, point);
        let below = |normal: Vec3| whole.corners().iter().any(|c| c.dot(normal) < 0.0);
        let is_cut = horizon.is_some_and(below);
        let cone = match horizon {
            Some(horizon) if is_cut => whole.above(horizon, 0.0),
            _ => whole,
        };
        (!cone.is_empty()).then_some(Self {
            cone,
            is_cut,
            patch,
            normal,
            offset,
        })
    }

    /// Where something may stand before it.
    pub(super) fn pyramid(&self, horizon: Option<Vec3>) -> Pyramid {
        Pyramid::to_polygon(&self.cone, self.normal, self.offset, horizon)
    }

    /// Vector irradiance of all of it [sr].
    pub(super) fn vector(&self) -> Vec3 {
        self.cone.vector_irradiance()
    }
}

/// Where occluders are found.
#[derive(Clone, Copy)]
pub(super) struct Geometry<'a> {
    pub(super) tree: &'a PatchTree,
    /// Shape of each patch.
    pub(super) shapes: &'a [Polygon],
}

impl Geometry<'_> {
    /// True when a patch lies in a plane.
    pub(super) fn is_in_plane(&self, patch: u32, origin: Vec3, normal: Vec3) -> bool {
        let polygon = &self.shapes[patch as usize];
        let mut corners = polygon.corners().iter();
        corners.all(|&corner| (corner - origin).dot(normal).abs() <= COPLANAR)
    }

    /// Vector irradiance [sr] of what `eye` sees of `target` past `candidates`; `None` when it falls into too many
    /// pieces.
    pub(super) fn visible(&self, eye: Vec3, target: &Target, candidates: &[u32]) -> Option<Vec3> {
        let mut pieces = vec![Piece::new(target.cone, true)];
        for &patch in candidates {
            let Some((occluder, front)) = self.occluder(eye, patch, target) else {
                continue;
            };
            let occluder = Piece::new(occluder, front);
            // From the last to the first: what is left of those that are cut goes where no cut comes any more.
            for at in (0..pieces.len()).rev() {
                if !pieces[at].is_apart(&occluder) {
                    let piece = pieces.swap_remove(at);
                    piece.subtract(&occluder, &mut pieces)?;
                }
            }
            if pieces.is_empty() {
                break;
            }
        }
        let vectors = pieces.iter().map(|piece| piece.cone.vector_irradiance());
        Some(vectors.sum())
    }

    /// The part of `patch` that lies before `target`, and whether it shows its front to the point.
    fn occluder(&self, eye: Vec3, patch: u32, target: &Target) -> Option<(Cone, bool)> {
        let polygon = &self.shapes[patch as usize];
        let normal = polygon.vector_area().normalize_or_zero();
        let height = normal.dot(polygon.corners()[0] - eye);
        // Seen from its edge, or the surface that the point lies on under another name.
        if height.abs() <= COPLANAR {
            return None;
        }
        let cone = Cone::new(polygon, eye);
        let heights = || {
            cone.corners()
                .iter()
                .map(|c| c.dot(target.normal) - target.offset)
        };
        if heights().all(|h| h <= COPLANAR) {
            // In one place with the target: the first patch is seen.
            let coincident = heights().all(|h| h >= -COPLANAR) && patch < target.patch;
            return coincident.then_some((cone, height < 0.0));
        }
        let before = cone.above(target.normal, target.offset);
        (!before.is_empty()).then_some((before, height < 0.0))
    }
}

/// Finds occluders of one point.
pub(super) struct Occlusion<'a> {
    pub(super) geometry: Geometry<'a>,
    /// The point.
    pub(super) eye: Vec3,
    /// The patch that it lies on.
    pub(super) own: u32,
    /// Candidates of all senders so far.
    pub(super) lists: Vec<u32>,
}

impl Occlusion<'_> {
    /// What may stand in `pyramid`, but for its own patch and `target`, from what may stand in one that holds it.
    pub(super) fn candidates(
        &mut self,
        pyramid: &Pyramid,
        target: u32,
        of_parent: Candidates,
    ) -> Candidates {
        let (first, eye, shapes) = (self.lists.len(), self.eye, self.geometry.shapes);
        if let Candidates::List(from, to) = of_parent {
            for i in from..to {
                let patch = self.lists[i as usize];
                if patch != target && !pyramid.misses(&shapes[patch as usize], eye) {
                    self.lists.push(patch);
                }
            }
        } else {
            let (own, lists) = (self.own, &mut self.lists);
            let visit = |patch: u32| {
                if patch != own && patch != target && !pyramid.misses(&shapes[patch as usize], eye)
                {
                    lists.push(patch);
                }
                lists.len() - first <= MOST_CANDIDATES
            };
            if !self.geometry.tree.visit(&pyramid.region(eye), visit) {
                self.lists.truncate(first);
                return Candidates::Many;
            }
        }
        Candidates::List(first as u32, self.lists.len() as u32)
    }

    /// [`Geometry::visible`] past the range `from..to` of the lists.
    pub(super) fn visible(&self, target: &Target, from: u32, to: u32) -> Option<Vec3> {
        let candidates = &self.lists[from as usize..to as usize];
        self.geometry.visible(self.eye, target, candidates)
    }
}

/// A cone and its sides.
#[derive(Clone, Copy, Debug)]
struct Piece {
    cone: Cone,
    /// Their inward normals.
    sides: [Vec3; MOST_CORNERS],
    count: usize,
}

impl Piece {
    /// `front`: the point is in front of the polygon.
    fn new(cone: Cone, front: bool) -> Self {
        let mut piece = Self {
            cone,
            sides: [Vec3::ZERO; MOST_CORNERS],
            count: 0,
        };
        for side in cone.sides(front) {
            piece.sides[piece.count] = side;
            piece.count += 1;
        }
        piece
    }

    fn sides(&self) -> &[Vec3] {
        &self.sides[..self.count]
    }

    /// True when some side of one has the other outside.
    fn is_apart(&self, other: &Self) -> bool {
        let has_outside = |piece: &Self, cone: &Cone| {
            let beside = |side: &Vec3| cone.corners().iter().all(|c| c.dot(*side) <= COPLANAR);
            piece.sides().iter().any(beside)
        };
        has_outside(other, &self.cone) || has_outside(self, &other.cone)
    }

    /// Appends the parts outside `occluder` to `kept`; `None` when they are too many.
    fn subtract(&self, occluder: &Self, kept: &mut Vec<Self>) -> Option<()> {
        let mut rest = self.cone;
        for &side in occluder.sides() {
            if rest.is_full() || kept.len() >= MOST_PIECES {
                return None;
            }
            let outside = rest.above(-side, 0.0);
            if !outside.is_empty() {
                kept.push(Self::new(outside, true));
            }
            rest = rest.above(side, 0.0);
            if rest.is_empty() {
                break;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;
    use glam::Vec2;

    /// The plain twin: many small parts of the target, each seen or not by what stands before its middle.
    fn by_parts(target: &Polygon, normal: Vec3, occluders: &[Polygon]) -> Vec3 {
        const SIDE: usize = 128;
        let mut sum = Vec3::ZERO;
        for i in 0..SIDE * SIDE {
            let uv = Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32;
            let point = target.point(uv);
            let hidden = occluders.iter().any(|o| {
                let normal = o.vector_area();
                let t = normal.dot(o.corners()[0]) / normal.dot(point);
                let at = point * t;
                let corners = o.corners();
                let inside = (0..corners.len()).all(|k| {
                    let edge = corners[(k + 1) % corners.len()] - corners[k];
                    edge.cross(at - corners[k]).dot(normal) >= 0.0
                });
                t > 0.0 && t < 1.0 && inside
            });
            if !hidden {
                let squared = point.length_squared();
                let cosine = -normal.dot(point) / squared.sqrt();
                sum += point / squared.sqrt() * (cosine / squared);
            }
        }
        sum * (target.vector_area().length() / (SIDE * SIDE) as f32)
    }

    #[test]
    fn what_is_cut_out_is_what_is_hidden() {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 1.0);
        // Front towards the eye at the origin.
        let target = Polygon::new(&[
            corner(-0.4, -0.4),
            corner(-0.4, 0.4),
            corner(0.4, 0.4),
            corner(0.4, -0.4),
        ]);
        let mut partly = 0;
        for case in 0..60 {
            let count = 1 + case % 5;
            // Some of them reach through the target's plane.
            let mut shapes: Vec<Polygon> = (0..count)
                .map(|i| {
                    let u = |k: u32| unit(case * 16 + i, k) - 0.5;
                    let at = Vec3::new(u(0), u(1), 0.6 + 0.7 * u(2));
                    let side = |k: u32| Vec3::new(u(k), u(k + 1), u(k + 2)) * 0.6;
                    let (a, b) = (side(3), side(6));
                    if i % 2 == 0 {
                        Polygon::new(&[at, at + a, at + b])
                    } else {
                        Polygon::new(&[at, at + a, at + a + b, at + b])
                    }
                })
                .collect();
            let expected = by_parts(&target, -Vec3::Z, &shapes);
            let own = shapes.len() as u32;
            shapes.push(target);
            let tree = PatchTree::new(&shapes, &[]);
            let geometry = Geometry {
                tree: &tree,
                shapes: &shapes,
            };
            let seen = Target::new(&target, -Vec3::Z, own, Vec3::ZERO, None).expect("in front");
            let mut occlusion = Occlusion {
                geometry,
                eye: Vec3::ZERO,
                own: u32::MAX,
                lists: Vec::new(),
            };
            let found = occlusion.candidates(&seen.pyramid(None), own, Candidates::Unknown);
            let Candidates::List(from, to) = found else {
                panic!("case {case}: {found:?}");
            };
            let visible = occlusion.visible(&seen, from, to).expect("few pieces");
            let whole = seen.vector().length();
            // Parts along edges are wholly seen or wholly hidden: an error of their share of the target.
            assert!(
                (visible - expected).length() < 0.02 * whole,
                "case {case}: {visible} against {expected}"
            );
            partly += u32::from(visible.length() > 0.05 * whole && visible.length() < 0.95 * whole);
        }
        assert!(partly > 20, "{partly} cases are partly hidden");
    }

    /// The six faces of a box seen from the origin, fronts outwards.
    fn faces(low: Vec3, high: Vec3) -> Vec<Polygon> {
        let corner = |bits: usize| {
            let pick = |axis: usize| [low, high][bits >> axis & 1][axis];
            Vec3::new(pick(0), pick(1), pick(2))
        };
        let faces = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let polygon = |face: [usize; 4]| Polygon::new(&face.map(corner));
        faces.into_iter().map(polygon).collect()
    }

    #[test]
    fn boxes_hide_the_same_in_any_order() {
        // Two boxes between the origin and a floor, as found in a room: cutting leaves edges as short as rounding.
        let seen_from = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) - Vec3::new(0.625, 1.5, 0.5);
        let mut shapes = faces(seen_from(1.1, 0.1, 1.0), seen_from(1.7, 0.4, 1.8));
        shapes.extend(faces(seen_from(0.3, 0.2, 0.4), seen_from(0.8, 0.9, 0.9)));
        let floor = Polygon::new(&[
            seen_from(1.0, 0.0, 1.0),
            seen_from(1.0, 0.0, 2.0),
            seen_from(2.0, 0.0, 2.0),
            seen_from(2.0, 0.0, 1.0),
        ]);
        let expected = by_parts(&floor, Vec3::Y, &shapes);
        let count = shapes.len() as u32;
        shapes.push(floor);
        let geometry = Geometry {
            tree: &PatchTree::new(&shapes, &[]),
            shapes: &shapes,
        };
        let seen = Target::new(&floor, Vec3::Y, count, Vec3::ZERO, None).expect("in front");
        let mut order: Vec<u32> = (0..count).collect();
        for trial in 0..4000 {
            for i in (1..count).rev() {
                let other = (unit(trial, i) * (i + 1) as f32) as usize;
                order.swap(i as usize, other);
            }
            let visible = geometry
                .visible(Vec3::ZERO, &seen, &order)
                .expect("few pieces");
            assert!(
                (visible - expected).length() < 0.02 * expected.length(),
                "{order:?}: {visible} against {expected}"
            );
        }
    }
}
