//! Figures of a solution: areas, means, which of its triangles show the front of the scene's.

use glam::{DVec3, Vec3};
use sheen_solver::{Rgb, Scene, Solution};

/// Triangles of `solution` that show the front of a triangle of `scene`, with that triangle's number.
///
/// A solution holds both sides of two-sided surfaces. Cost: every triangle against every triangle; for small scenes.
pub fn front_triangles(scene: &Scene, solution: &Solution) -> Vec<(usize, usize)> {
    let (low, high) = scene.bounds();
    // Positions pass through normalised coordinates in f32: some roundings of the scene's size.
    let near = f64::from((high - low).max_element()) * 1e-5;
    let surfaces: Vec<[DVec3; 3]> = scene
        .triangles()
        .iter()
        .map(|t| scene.corners(t).map(|corner| corner.as_dvec3()))
        .collect();
    let mut found = Vec::new();
    for (index, triangle) in solution.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| solution.position[v as usize].as_dvec3());
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
        let shows = |&(_, corners): &(usize, &[DVec3; 3])| {
            let [p, q, r] = *corners;
            let face = (q - p).cross(r - p);
            let inside = [(p, q), (q, r), (r, p)].iter().all(|&(from, to)| {
                let edge = (to - from).normalize();
                face.normalize().cross(edge).dot(middle - from) > -near
            });
            inside && (middle - p).dot(face.normalize()).abs() < near && face.dot(normal) > 0.0
        };
        if let Some((surface, _)) = surfaces.iter().enumerate().find(shows) {
            found.push((index, surface));
        }
    }
    found
}

/// Area of a triangle of `solution` [m²].
pub fn area(solution: &Solution, triangle: usize) -> f64 {
    let [a, b, c] = solution.triangles[triangle].map(|v| solution.position[v as usize].as_dvec3());
    (b - a).cross(c - a).length() * 0.5
}

/// Mean over the corners of a triangle of the direction-independent radiance, per channel: its exact mean over the
/// triangle, since radiance is linear between vertices.
pub fn mean_of_corners(solution: &Solution, triangle: usize) -> [f64; 3] {
    let corners = solution.triangles[triangle].map(|v| solution.radiance[v as usize].to_array());
    [0, 1, 2].map(|i| corners.iter().map(|c| f64::from(c[i])).sum::<f64>() / 3.0)
}

/// Area-weighted mean of the direction-independent radiance, mean over channels, and the area, of `triangles`.
pub fn mean_radiance(
    solution: &Solution,
    triangles: impl IntoIterator<Item = usize>,
) -> (f64, f64) {
    let (mut sum, mut total) = (0.0, 0.0);
    for triangle in triangles {
        let area = area(solution, triangle);
        sum += area * mean_of_corners(solution, triangle).iter().sum::<f64>() / 3.0;
        total += area;
    }
    (sum / total, total)
}

/// Area-weighted mean of the radiance of the front of all surfaces with `material`.
pub fn mean_radiance_of(scene: &Scene, solution: &Solution, material: &str) -> f64 {
    let is_it = |surface: usize| {
        let index = scene.triangles()[surface].material as usize;
        scene.materials()[index].name == material
    };
    let triangles = front_triangles(scene, solution);
    let chosen = triangles.iter().filter(|(_, surface)| is_it(*surface));
    mean_radiance(solution, chosen.map(|(triangle, _)| *triangle)).0
}

/// Smallest and largest channel.
pub fn extremes(values: impl IntoIterator<Item = Rgb>) -> (f32, f32) {
    values
        .into_iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| {
            (low.min(value.min_channel()), high.max(value.max_channel()))
        })
}

/// A fixed sequence of numbers within 0..1 (PCG of O'Neill, 32 bits out).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// The next number within 0..1.
    pub fn unit(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (mixed.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / 16_777_216.0
    }

    /// The next number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count - 1)
    }

    /// A point of the unit square.
    pub fn square(&mut self) -> glam::Vec2 {
        glam::Vec2::new(self.unit(), self.unit())
    }
}

/// Solid angle of a triangle seen from the origin [sr] (van Oosterom & Strackee 1983).
pub fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c)).abs();
    let rest = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * volume.atan2(rest)
}

/// Form factor integral ∫ cosθ dω [sr] of a convex polygon at the origin of a surface with `normal`: Lambert's formula
/// on what lies above the horizon. Corners in any order of turning.
pub fn lambert(corners: &[DVec3], normal: DVec3) -> f64 {
    let mut above: Vec<DVec3> = Vec::with_capacity(corners.len() + 1);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (ha, hb) = (a.dot(normal), b.dot(normal));
        if ha >= 0.0 {
            above.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            above.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    if above.len() < 3 {
        return 0.0;
    }
    let mut sum = 0.0;
    for (i, &a) in above.iter().enumerate() {
        let b = above[(i + 1) % above.len()];
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += cross.dot(normal) * (sine.atan2(a.dot(b)) / sine);
        }
    }
    0.5 * sum.abs()
}

/// Corners of a polygon relative to `from`, in f64.
pub fn relative(corners: &[Vec3], from: Vec3) -> Vec<DVec3> {
    corners
        .iter()
        .map(|c| c.as_dvec3() - from.as_dvec3())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_face_seen_from_the_centre() {
        let face = [
            DVec3::new(-1.0, -1.0, 1.0),
            DVec3::new(1.0, -1.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(-1.0, 1.0, 1.0),
        ];
        let angle =
            solid_angle([face[0], face[1], face[2]]) + solid_angle([face[0], face[2], face[3]]);
        assert!((angle - 4.0 * std::f64::consts::PI / 6.0).abs() < 1e-12);
        // The top and four half sides of a box fill the hemisphere; each side has (π - top) / 4.
        let top = lambert(&face, DVec3::Z);
        let side = lambert(&face, DVec3::X);
        assert!(
            (top + 4.0 * side - std::f64::consts::PI).abs() < 1e-12,
            "{top} {side}"
        );
    }
}
