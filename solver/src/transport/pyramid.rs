//! Pyramids from a point: where something may stand between it and what it looks at.

use crate::geometry::{Cone, Polygon};
use crate::transport::link::COPLANAR;
use crate::transport::region::Region;
use glam::Vec3;

/// Planes of a pyramid: the sides of what a cone may have, and two more.
const MOST_PLANES: usize = 8;

/// A convex region between an eye and what it looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pyramid {
    /// Normal and offset, relative to the eye: inside where normal·p > offset.
    planes: [(Vec3, f32); MOST_PLANES],
    count: usize,
    /// A box around it, relative to the eye.
    lower: Vec3,
    upper: Vec3,
}

impl Pyramid {
    const EMPTY: Self = Self {
        planes: [(Vec3::ZERO, 0.0); MOST_PLANES],
        count: 0,
        lower: Vec3::ZERO,
        upper: Vec3::ZERO,
    };

    /// Before a polygon with a plane normal·p = `offset`. What lies in that plane is inside.
    pub(super) fn to_polygon(
        cone: &Cone,
        normal: Vec3,
        offset: f32,
        horizon: Option<Vec3>,
    ) -> Self {
        let mut pyramid = Self::EMPTY;
        for &corner in cone.corners() {
            pyramid.lower = pyramid.lower.min(corner);
            pyramid.upper = pyramid.upper.max(corner);
        }
        pyramid.push(normal, offset - 2.0 * COPLANAR);
        if let Some(horizon) = horizon {
            pyramid.push(horizon, 0.0);
        }
        // Fewer planes only make it larger.
        for side in cone.sides(true).take(MOST_PLANES - 2) {
            pyramid.push(side, 0.0);
        }
        pyramid
    }

    fn push(&mut self, normal: Vec3, offset: f32) {
        self.planes[self.count] = (normal, offset);
        self.count += 1;
    }

    /// The region that it covers when seen from `eye`.
    pub(super) fn region(&self, eye: Vec3) -> Region<'_> {
        Region {
            origin: eye,
            lower: self.lower,
            upper: self.upper,
            planes: &self.planes[..self.count],
        }
    }

    /// True when a polygon lies wholly outside one of its planes, or touches it from outside.
    pub(super) fn misses(&self, polygon: &Polygon, eye: Vec3) -> bool {
        let corners = polygon.corners();
        self.planes[..self.count].iter().any(|&(normal, offset)| {
            let least = offset + COPLANAR + normal.dot(eye);
            corners.iter().all(|c| c.dot(normal) <= least)
        })
    }
}
