//! Convex planar polygons of three or four corners, and their exact form factors to a point.

use super::cone::{self, Cone};
use glam::{Vec2, Vec3};

/// A convex, planar triangle or quad, counter-clockwise seen from its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    corners: [Vec3; 4],
    count: usize,
}

impl Polygon {
    /// From three or four corners.
    pub fn new(corners: &[Vec3]) -> Self {
        debug_assert!(corners.len() == 3 || corners.len() == 4);
        let mut all = [corners[0]; 4];
        all[..corners.len()].copy_from_slice(corners);
        Self {
            corners: all,
            count: corners.len(),
        }
    }

    /// Its corners.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// Vector area: normal times area [m²].
    pub fn vector_area(&self) -> Vec3 {
        let c = &self.corners;
        if self.count == 4 {
            (c[2] - c[0]).cross(c[3] - c[1]) * 0.5
        } else {
            (c[1] - c[0]).cross(c[2] - c[0]) * 0.5
        }
    }

    /// Solid angle seen from a point [sr].
    pub fn solid_angle(&self, point: Vec3) -> f32 {
        let [a, b, c, d] = self.corners.map(|corner| corner - point);
        let rest = if self.count == 4 {
            solid_angle([a, c, d])
        } else {
            0.0
        };
        (solid_angle([a, b, c]) + rest) as f32
    }

    /// Mean of the corners.
    pub fn centre(&self) -> Vec3 {
        let c = &self.corners;
        if self.count == 4 {
            (c[0] + c[1] + c[2] + c[3]) * 0.25
        } else {
            (c[0] + c[1] + c[2]) * (1.0 / 3.0)
        }
    }

    /// Largest distance of a corner from [`Self::centre`].
    pub fn radius(&self) -> f32 {
        let centre = self.centre();
        self.corners()
            .iter()
            .map(|c| c.distance_squared(centre))
            .fold(0.0, f32::max)
            .sqrt()
    }

    /// True for a point of its plane that lies within it.
    pub fn holds(&self, point: Vec3) -> bool {
        let (corners, normal) = (self.corners(), self.vector_area());
        (0..self.count).all(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % self.count]);
            (b - a).cross(point - a).dot(normal) >= 0.0
        })
    }

    /// The point at `uv` of the unit square: bilinear on quads, area-preserving on triangles.
    pub fn point(&self, uv: Vec2) -> Vec3 {
        let c = &self.corners;
        if self.count == 4 {
            c[0].lerp(c[1], uv.x).lerp(c[3].lerp(c[2], uv.x), uv.y)
        } else {
            let s = uv.x.sqrt();
            c[0] * (1.0 - s) + c[1] * (s * (1.0 - uv.y)) + c[2] * (s * uv.y)
        }
    }

    /// Where [`Self::point`] takes a point of its plane from.
    pub fn uv(&self, point: Vec3) -> Vec2 {
        let [a, b, c, d] = self.corners;
        // x and y of `at` = x u + y v.
        let solve = |at: Vec3, u: Vec3, v: Vec3| {
            let normal = u.cross(v);
            let squared = normal.length_squared();
            Vec2::new(at.cross(v).dot(normal), u.cross(at).dot(normal)) / squared
        };
        if self.count == 3 {
            let weights = solve(point - a, b - a, c - a);
            let s = weights.x + weights.y;
            return if s > 0.0 {
                Vec2::new(s * s, weights.y / s)
            } else {
                Vec2::ZERO
            };
        }
        let mut uv = Vec2::splat(0.5);
        // Newton's method: exact after one step on parallelograms.
        for _ in 0..4 {
            let along = (b - a).lerp(c - d, uv.y);
            let across = (d - a).lerp(c - b, uv.x);
            uv += solve(point - self.point(uv), along, across);
        }
        uv
    }

    /// Visits the points of a quadrature of equal weights that is exact for quadratic functions on triangles and
    /// cubic ones on parallelograms: a mean over the shape.
    pub fn quadrature(&self, mut visit: impl FnMut(Vec3)) {
        if self.count == 4 {
            // Gauss-Legendre, ½ ± ½/√3 along each axis.
            const NEAR: f32 = 0.211_324_87;
            for uv in [
                (NEAR, NEAR),
                (1.0 - NEAR, NEAR),
                (NEAR, 1.0 - NEAR),
                (1.0 - NEAR, 1.0 - NEAR),
            ] {
                visit(self.point(uv.into()));
            }
        } else {
            let sum = self.corners[0] + self.corners[1] + self.corners[2];
            for &corner in self.corners() {
                visit(corner * 0.5 + sum * (1.0 / 6.0));
            }
        }
    }

    /// Middles of the parts of the 4:1 subdivision.
    pub fn quarter_centres(&self) -> [Vec3; 4] {
        let (c, centre) = (&self.corners, self.centre());
        std::array::from_fn(|i| match (self.count, i) {
            (4, _) => 0.5 * c[i] + 0.125 * (c[(i + 1) % 4] + c[(i + 3) % 4]) + 0.25 * centre,
            (_, 3) => centre,
            _ => 0.5 * (c[i] + centre),
        })
    }

    /// Child 0..4 of the 4:1 subdivision by edge midpoints. Child i < 3 (triangle) or i < 4 (quad) holds corner i.
    pub fn child(&self, child: usize) -> Self {
        let c = &self.corners;
        let mid = |a: usize, b: usize| (c[a] + c[b]) * 0.5;
        if self.count == 4 {
            let centre = self.centre();
            let corners = match child {
                0 => [c[0], mid(0, 1), centre, mid(3, 0)],
                1 => [mid(0, 1), c[1], mid(1, 2), centre],
                2 => [centre, mid(1, 2), c[2], mid(2, 3)],
                _ => [mid(3, 0), centre, mid(2, 3), c[3]],
            };
            Self { corners, count: 4 }
        } else {
            let (m01, m12, m20) = (mid(0, 1), mid(1, 2), mid(2, 0));
            match child {
                0 => Self::new(&[c[0], m01, m20]),
                1 => Self::new(&[m01, c[1], m12]),
                2 => Self::new(&[m20, m12, c[2]]),
                _ => Self::new(&[m12, m20, m01]),
            }
        }
    }

    /// Vector irradiance at `point` of the unoccluded polygon with radiance 1, times π⁻¹ … times π: the vector v
    /// [sr] with E(n) = L n·v for every normal n whose horizon does not cut the polygon; it points towards the
    /// polygon. Zero when `point` is behind the polygon's plane.
    ///
    /// With `horizon`, only the part above the plane through `point` with that normal counts.
    pub fn vector_irradiance(&self, point: Vec3, horizon: Option<Vec3>) -> Vec3 {
        if (point - self.corners[0]).dot(self.vector_area()) <= 0.0 {
            return Vec3::ZERO;
        }
        let corners = self.corners.map(|corner| corner - point);
        let corners = &corners[..self.corners().len()];
        match horizon {
            Some(normal) if corners.iter().any(|corner| corner.dot(normal) < 0.0) => {
                let cone = Cone::new(self, point);
                cone.above(normal, 0.0).vector_irradiance()
            }
            _ => cone::vector_irradiance(corners),
        }
    }
}

/// Solid angle of a triangle seen from the origin [sr] (Van Oosterom & Strackee 1983), in f64.
pub fn solid_angle(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c)).abs();
    let rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * volume.atan2(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_square(z: f32) -> Polygon {
        // Front towards -z.
        Polygon::new(&[
            Vec3::new(0.0, 0.0, z),
            Vec3::new(0.0, 1.0, z),
            Vec3::new(1.0, 1.0, z),
            Vec3::new(1.0, 0.0, z),
        ])
    }

    #[test]
    fn quarters_have_their_middles() {
        let square = unit_square(1.0);
        let skewed = [Vec3::ZERO, Vec3::X, Vec3::new(2.0, 3.0, 0.0), Vec3::Y];
        for polygon in [square, Polygon::new(&skewed), Polygon::new(&skewed[..3])] {
            for (child, centre) in polygon.quarter_centres().into_iter().enumerate() {
                assert!(centre.distance(polygon.child(child).centre()) < 1e-6);
            }
        }
    }

    #[test]
    fn mean_over_the_receiver_is_the_parallel_plates_form_factor() {
        let square = unit_square(1.0);
        let n = 64;
        let mut sum = 0.0f64;
        for i in 0..n * n {
            let at = Vec3::new(
                ((i % n) as f32 + 0.5) / n as f32,
                ((i / n) as f32 + 0.5) / n as f32,
                0.0,
            );
            sum += f64::from(square.vector_irradiance(at, None).z) / std::f64::consts::PI;
        }
        let form_factor = sum / f64::from(n * n);
        // Midpoint rule over 64² points: error O(h²).
        assert!(
            (form_factor - 0.199824895698387).abs() < 2e-5,
            "{form_factor}"
        );
    }

    #[test]
    fn places_in_the_square_are_found_again() {
        let trapezium = [
            Vec3::ZERO,
            Vec3::new(3.0, 0.0, 1.0),
            Vec3::new(2.0, 1.0, 1.0),
            Vec3::new(0.5, 1.0, 0.5),
        ];
        let flat = trapezium.map(|c| Vec3::new(c.x, c.y, 0.3 * c.x - c.y));
        for shape in [
            unit_square(0.5),
            Polygon::new(&flat),
            Polygon::new(&flat[1..]),
        ] {
            for i in 0..100 {
                let uv = crate::geometry::sampling::spread(i);
                let found = shape.uv(shape.point(uv));
                assert!((found - uv).length() < 1e-4, "{uv}, found {found}");
            }
        }
    }

    #[test]
    fn the_quadrature_is_exact_for_quadratics() {
        let quad = unit_square(0.0);
        let triangle = Polygon::new(&[Vec3::ZERO, Vec3::X, Vec3::Y]);
        // Means of x² + xy: 1/3 + 1/4 over the square, 1/6 + 1/12 over the triangle.
        for (shape, mean) in [(quad, 7.0 / 12.0), (triangle, 0.25)] {
            let (mut sum, mut count) = (0.0, 0.0f32);
            shape.quadrature(|p| {
                sum += p.x * p.x + p.x * p.y;
                count += 1.0;
            });
            assert!(
                (sum / count - mean).abs() < 1e-6,
                "{} against {mean}",
                sum / count
            );
        }
    }

    #[test]
    fn a_box_around_a_point_fills_the_hemisphere() {
        let at = Vec3::new(0.3, 0.2, 0.0);
        let top = unit_square(1.0).vector_irradiance(at, Some(Vec3::Z)).z;
        let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let mut sides = 0.0;
        for i in 0..4 {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            // Walls from z = -1 to z = 1: the horizon cuts them in half.
            let wall = Polygon::new(&[b - Vec3::Z, a - Vec3::Z, a + Vec3::Z, b + Vec3::Z]);
            sides += wall.vector_irradiance(at, Some(Vec3::Z)).z;
        }
        assert!(
            (top + sides - std::f32::consts::PI).abs() < 1e-5,
            "{top} {sides}"
        );
    }
}
