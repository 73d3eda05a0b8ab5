//! Patches that are known to stand before a point: what lies wholly in the shadow of one of them need not be looked at.
//!
//! Most of what a point in a furnished room could be lit by stands behind something, and much of it behind one and the
//! same table or wall. Patches that hid a sender are kept, the last one first, and a sender whose box is in the shadow
//! of one is left out before it is refined any further.

use crate::geometry::{Cone, Polygon};
use crate::transport::link::COPLANAR;
use glam::Vec3;

/// Patches that are kept.
const MOST_BLOCKERS: usize = 16;

/// Sides of a patch's shadow, and the patch itself.
const MOST_PLANES: usize = 5;

/// The shadow of a patch.
#[derive(Clone, Copy, Debug)]
struct Shadow {
    patch: u32,
    /// Normal and offset, relative to the eye: inside where normal·p > offset.
    planes: [(Vec3, f32); MOST_PLANES],
    count: usize,
}

impl Shadow {
    /// `None` for a patch that is seen from its edge.
    fn new(eye: Vec3, patch: u32, polygon: &Polygon) -> Option<Self> {
        let normal = polygon.vector_area().normalize_or_zero();
        let height = normal.dot(polygon.corners()[0] - eye);
        if height.abs() <= COPLANAR {
            return None;
        }
        let mut shadow = Self {
            patch,
            planes: [(Vec3::ZERO, 0.0); MOST_PLANES],
            count: 1,
        };
        shadow.planes[0] = (normal * height.signum(), height.abs());
        let cone = Cone::new(polygon, eye);
        let sides = cone.corners().len();
        for side in cone.sides(height < 0.0) {
            shadow.planes[shadow.count] = (side, 0.0);
            shadow.count += 1;
        }
        // A side that is left out would leave the shadow open.
        (shadow.count == sides + 1).then_some(shadow)
    }

    /// True when a box, relative to the eye, lies wholly in it.
    fn holds(&self, centre: Vec3, half: Vec3) -> bool {
        self.planes[..self.count].iter().all(|&(normal, offset)| {
            normal.dot(centre) - normal.abs().dot(half) > offset + COPLANAR
        })
    }
}

/// What is known to stand before a point.
pub(super) struct Blockers<'a> {
    eye: Vec3,
    /// Shape of each patch.
    shapes: &'a [Polygon],
    /// The last that hid something first.
    shadows: Vec<Shadow>,
}

impl<'a> Blockers<'a> {
    /// None yet.
    pub(super) fn new(eye: Vec3, shapes: &'a [Polygon]) -> Self {
        Self {
            eye,
            shapes,
            shadows: Vec::with_capacity(MOST_BLOCKERS),
        }
    }

    /// True when a box lies wholly behind one of them.
    pub(super) fn hide(&mut self, lower: Vec3, upper: Vec3) -> bool {
        let centre = 0.5 * (lower + upper) - self.eye;
        let half = 0.5 * (upper - lower);
        let found = self.shadows.iter().position(|s| s.holds(centre, half));
        if let Some(at) = found {
            self.shadows[..=at].rotate_right(1);
        }
        found.is_some()
    }

    /// Remembers an opaque patch that hid something.
    pub(super) fn add(&mut self, patch: Option<u32>) {
        let Some(patch) = patch else { return };
        if let Some(at) = self.shadows.iter().position(|s| s.patch == patch) {
            self.shadows[..=at].rotate_right(1);
            return;
        }
        if let Some(shadow) = Shadow::new(self.eye, patch, &self.shapes[patch as usize]) {
            self.shadows.truncate(MOST_BLOCKERS - 1);
            self.shadows.insert(0, shadow);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;

    /// The plain twin: the segment from the origin to `to` passes through the polygon.
    fn crosses(polygon: &Polygon, to: Vec3) -> bool {
        let normal = polygon.vector_area();
        let corners = polygon.corners();
        let t = normal.dot(corners[0]) / normal.dot(to);
        let inside = (0..corners.len()).all(|i| {
            let edge = corners[(i + 1) % corners.len()] - corners[i];
            edge.cross(to * t - corners[i]).dot(normal) >= 0.0
        });
        t > 0.0 && t < 1.0 && inside
    }

    #[test]
    fn what_is_hidden_is_seen_from_nowhere() {
        let mut hidden = 0;
        for case in 0..4000 {
            let u = |k: u32| unit(case, k) - 0.5;
            let at = Vec3::new(u(0), u(1), 0.5 + 0.3 * u(2));
            let (a, b) = (
                Vec3::new(1.0 + u(3), u(4), u(5)),
                Vec3::new(u(6), 1.0 + u(7), u(8)),
            );
            let corner = at - 0.5 * (a + b);
            let corners = [corner, corner + a, corner + a + b, corner + b];
            let shape = if case % 2 == 0 {
                Polygon::new(&corners)
            } else {
                Polygon::new(&[corners[3], corners[1], corners[0]])
            };
            let lower = Vec3::new(u(9), u(10), 0.4 + u(11));
            let upper = lower + 0.3 * Vec3::new(unit(case, 12), unit(case, 13), unit(case, 14));
            let shapes = [shape];
            let mut blockers = Blockers::new(Vec3::ZERO, &shapes);
            assert!(!blockers.hide(lower, upper), "nothing is known yet");
            blockers.add(Some(0));
            if blockers.hide(lower, upper) {
                hidden += 1;
                for i in 0..200 {
                    let v = |k: u32| unit(i, case.wrapping_mul(3) + k);
                    let to = lower + (upper - lower) * Vec3::new(v(0), v(1), v(2));
                    assert!(crosses(&shape, to), "case {case}: {to} is seen");
                }
            }
        }
        assert!(hidden > 100, "{hidden} boxes are hidden");
    }

    #[test]
    fn the_last_to_hide_something_is_asked_first() {
        let square = |z: f32| {
            Polygon::new(&[
                Vec3::new(-1.0, -1.0, z),
                Vec3::new(1.0, -1.0, z),
                Vec3::new(1.0, 1.0, z),
                Vec3::new(-1.0, 1.0, z),
            ])
        };
        let shapes: Vec<Polygon> = (1..=20).map(|z| square(z as f32)).collect();
        let mut blockers = Blockers::new(Vec3::ZERO, &shapes);
        for patch in 0..20 {
            blockers.add(Some(patch));
        }
        let order = |b: &Blockers<'_>| b.shadows.iter().map(|s| s.patch).collect::<Vec<_>>();
        assert_eq!(order(&blockers), (4..20).rev().collect::<Vec<_>>());
        // Before the ninth square only what is nearer hides.
        assert!(blockers.hide(Vec3::new(-0.1, -0.1, 8.2), Vec3::new(0.1, 0.1, 8.3)));
        assert_eq!(order(&blockers)[0], 7);
        assert!(!blockers.hide(Vec3::new(-0.1, -0.1, 0.5), Vec3::new(0.1, 0.1, 0.6)));
    }
}
