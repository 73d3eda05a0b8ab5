//! Convex cones of directions: what a point sees of convex planar polygons, cut by planes through the point.

use super::Polygon;
use super::angle::angle;
use glam::Vec3;

/// Corners that a cone can have; a cut adds at most one.
pub(crate) const MOST_CORNERS: usize = 12;

/// The direction of an edge over a smaller angle [rad] than this may be rounding.
const SHORT: f32 = 1.0 / 1024.0;

/// All directions from a point to a convex planar polygon, as the polygon's corners relative to the point, which does
/// not lie in its plane.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    corners: [Vec3; MOST_CORNERS],
    count: usize,
}

impl Cone {
    const EMPTY: Self = Self {
        corners: [Vec3::ZERO; MOST_CORNERS],
        count: 0,
    };

    /// The cone from `point` to `polygon`.
    pub fn new(polygon: &Polygon, point: Vec3) -> Self {
        let mut cone = Self::EMPTY;
        for &corner in polygon.corners() {
            cone.push(corner - point);
        }
        cone
    }

    /// Corners relative to the point; none when nothing is left.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// True when nothing is left.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// True when a further cut might need more corners than there is room for.
    pub fn is_full(&self) -> bool {
        self.count == MOST_CORNERS
    }

    fn push(&mut self, corner: Vec3) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// Inward unit normals of its sides, those of no length left out. `front`: the point is in front of the polygon.
    ///
    /// Cutting leaves edges that are hardly longer than rounding, whose normals point anywhere: those that do not
    /// have the whole cone on their inner side are left out too.
    pub fn sides(&self, front: bool) -> impl Iterator<Item = Vec3> + '_ {
        let corners = self.corners();
        (0..self.count).filter_map(move |i| {
            let (a, b) = (corners[i], corners[(i + 1) % self.count]);
            let inward = if front { b.cross(a) } else { a.cross(b) };
            let side = inward.try_normalize()?;
            let squares = a.length_squared() * b.length_squared();
            let is_short = inward.length_squared() < SHORT * SHORT * squares;
            let is_inside = |corner: &Vec3| corner.dot(side) >= -SHORT * SHORT * corner.length();
            (!is_short || corners.iter().all(is_inside)).then_some(side)
        })
    }

    /// The part whose corners c have `normal`·c > `offset`.
    ///
    /// With offset 0 that is the part of the cone on one side of a plane through the point; otherwise, of the polygon.
    pub fn above(&self, normal: Vec3, offset: f32) -> Self {
        let mut heights = [0.0; MOST_CORNERS];
        let mut all = true;
        for (height, corner) in heights.iter_mut().zip(self.corners()) {
            *height = corner.dot(normal) - offset;
            all &= *height >= 0.0;
        }
        if all {
            return *self;
        }
        let mut kept = Self::EMPTY;
        for i in 0..self.count {
            let j = (i + 1) % self.count;
            if heights[i] >= 0.0 {
                kept.push_checked(self.corners[i]);
            }
            if (heights[i] > 0.0 && heights[j] < 0.0) || (heights[i] < 0.0 && heights[j] > 0.0) {
                let t = heights[i] / (heights[i] - heights[j]);
                kept.push_checked(self.corners[i].lerp(self.corners[j], t));
            }
        }
        if kept.count < 3 { Self::EMPTY } else { kept }
    }

    /// Rounding on a nearly tangent plane may cut every edge: corners beyond the room lie in a sliver.
    fn push_checked(&mut self, corner: Vec3) {
        if self.count < MOST_CORNERS {
            self.push(corner);
        }
    }

    /// Vector irradiance [sr] of radiance 1 from the whole cone, for a point in front of the polygon.
    pub fn vector_irradiance(&self) -> Vec3 {
        vector_irradiance(self.corners())
    }
}

/// Vector irradiance v [sr] of radiance 1 from a polygon with `corners` relative to a point in front of it, by Lambert's
/// formula, v = ½ Σ γᵢ Γᵢ over the edges (`exact_cases.md` 2a).
pub(super) fn vector_irradiance(corners: &[Vec3]) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[if i + 1 < corners.len() { i + 1 } else { 0 }];
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += cross * (angle(sine, a.dot(b)) / sine);
        }
    }
    sum * -0.5
}
