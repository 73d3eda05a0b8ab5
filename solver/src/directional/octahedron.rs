//! Directions to spherical triangles and back.
//!
//! Eight faces, one an octant; 4:1 subdivision by the midpoints of the great-circle edges. Children 0, 1, 2 hold
//! the parent's corner 0, 1, 2; child 3 is the middle one with corners (m12, m20, m01).

use glam::Vec3;

/// Corners of a spherical triangle, unit vectors.
pub type Corners = [Vec3; 3];

/// Octant of a direction: bit 0 set for x < 0, bit 1 for y < 0, bit 2 for z < 0.
pub fn octant(direction: Vec3) -> usize {
    usize::from(direction.x < 0.0)
        | usize::from(direction.y < 0.0) << 1
        | usize::from(direction.z < 0.0) << 2
}

/// Corners of an octant's face: on the x, the y and the z axis, in this order.
pub fn octant_corners(octant: usize) -> Corners {
    let sign = |bit: usize| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
    [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]
}

/// Midpoints of the edges opposite to corner 0, 1, 2: (m12, m20, m01), unit vectors.
pub fn edge_midpoints([a, b, c]: Corners) -> Corners {
    [
        (b + c).normalize(),
        (c + a).normalize(),
        (a + b).normalize(),
    ]
}

/// Corners of child `child` (0..4), given the midpoints of [`edge_midpoints`].
pub fn child_corners([a, b, c]: Corners, [m12, m20, m01]: Corners, child: usize) -> Corners {
    match child {
        0 => [a, m01, m20],
        1 => [m01, b, m12],
        2 => [m20, m12, c],
        _ => [m12, m20, m01],
    }
}

/// The child that holds `direction`, which lies in the triangle `corners`.
///
/// The corner with the largest excess over the great circle through its two midpoints wins; the middle child has
/// what lies beyond none of them.
pub fn child_of(corners: Corners, midpoints: Corners, direction: Vec3) -> usize {
    let [m12, m20, m01] = midpoints;
    // Sign of the plane through two midpoints, turned so that the corner is positive.
    let beyond = |m: Vec3, n: Vec3, corner: Vec3| {
        let normal = m.cross(n);
        let side = normal.dot(direction);
        if normal.dot(corner) < 0.0 {
            -side
        } else {
            side
        }
    };
    if beyond(m01, m20, corners[0]) > 0.0 {
        0
    } else if beyond(m01, m12, corners[1]) > 0.0 {
        1
    } else if beyond(m20, m12, corners[2]) > 0.0 {
        2
    } else {
        3
    }
}

/// Barycentric coordinates of `direction` in the flat triangle of `corners`, clamped to it; they sum to 1.
pub fn barycentric([a, b, c]: Corners, direction: Vec3) -> Vec3 {
    let weights = Vec3::new(
        direction.dot(b.cross(c)),
        direction.dot(c.cross(a)),
        direction.dot(a.cross(b)),
    );
    // The orientation of the triangle gives all three the same sign inside.
    let weights = if a.dot(b.cross(c)) < 0.0 {
        -weights
    } else {
        weights
    };
    clamped(weights)
}

/// Barycentric coordinates that are not negative and sum to 1.
pub(super) fn clamped(weights: Vec3) -> Vec3 {
    let weights = weights.max(Vec3::ZERO);
    let sum = weights.element_sum();
    if sum > 0.0 {
        weights / sum
    } else {
        Vec3::splat(1.0 / 3.0)
    }
}

/// A fold through triangles of this level does not matter.
const SMOOTH: usize = 4;

/// Integral over a triangle of `level` of the function that [`barycentric`] interpolates between `values` at its
/// corners; with a `horizon`, weighted with the cosine to it above, and zero below.
///
/// At a point p of the flat triangle with area A, whose plane lies h from the centre, dω = h |p|⁻³ dA.
pub fn integral(corners: Corners, values: [f32; 3], horizon: Option<Vec3>, level: usize) -> f32 {
    // Dunavant 1985: exact for polynomials of degree 5, and of degree 2 for small triangles. Weight, first corner's
    // coordinate, the others'.
    const FINE: [(f32, f32, f32); 2] = [
        (0.132_394_15, 0.059_715_87, 0.470_142_06),
        (0.125_939_18, 0.797_427, 0.101_286_51),
    ];
    const COARSE: [(f32, f32, f32); 1] = [(1.0 / 3.0, 2.0 / 3.0, 1.0 / 6.0)];
    let [a, b, c] = corners;
    let is_below = |corner: Vec3| horizon.is_some_and(|normal| normal.dot(corner) < 0.0);
    if level < SMOOTH && (is_below(a) != is_below(b) || is_below(b) != is_below(c)) {
        // The weight has a fold: parts of the same flat triangle, until they are small.
        let mid = [(b + c) * 0.5, (c + a) * 0.5, (a + b) * 0.5];
        let [u, v, w] = values;
        let between = [0.5 * (v + w), 0.5 * (w + u), 0.5 * (u + v)];
        let part = |corners, values| integral(corners, values, horizon, level + 1);
        return part([a, mid[2], mid[1]], [u, between[2], between[1]])
            + part([mid[2], b, mid[0]], [between[2], v, between[0]])
            + part([mid[1], mid[0], c], [between[1], between[0], w])
            + part(mid, between);
    }
    let at = |weights: [f32; 3]| {
        let p = a * weights[0] + b * weights[1] + c * weights[2];
        let value = values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
        let squared = p.length_squared();
        match horizon {
            Some(normal) => value * normal.dot(p).max(0.0) / (squared * squared),
            None => value / (squared * squared.sqrt()),
        }
    };
    let ring = |&(weight, one, other): &(f32, f32, f32)| {
        weight * (at([one, other, other]) + at([other, one, other]) + at([other, other, one]))
    };
    let mean = if level < 2 {
        0.225 * at([1.0 / 3.0; 3]) + FINE.iter().map(ring).sum::<f32>()
    } else {
        COARSE.iter().map(ring).sum::<f32>()
    };
    0.5 * a.dot(b.cross(c)).abs() * mean
}

/// Deepest level for which [`radius`] is tabulated.
pub const MAX_LEVEL: usize = 9;

/// Largest angle between the centre and a corner of any triangle of a level [rad].
pub fn radius(level: usize) -> f32 {
    static RADII: std::sync::LazyLock<[f32; MAX_LEVEL + 1]> = std::sync::LazyLock::new(|| {
        // The largest triangle of each level is the middle one: the octant's centre grows slowest under subdivision.
        let mut radii = [0.0; MAX_LEVEL + 1];
        let mut corners = octant_corners(0);
        for radius in &mut radii {
            *radius = corners[0].dot(centre(corners)).min(1.0).acos();
            corners = edge_midpoints(corners);
        }
        radii
    });
    RADII[level.min(MAX_LEVEL)]
}

/// Direction in the middle of a triangle.
pub fn centre([a, b, c]: Corners) -> Vec3 {
    (a + b + c).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon::solid_angle;

    fn visit(corners: Corners, level: usize, leaf: &mut impl FnMut(Corners)) {
        if level == 0 {
            return leaf(corners);
        }
        let midpoints = edge_midpoints(corners);
        for child in 0..4 {
            visit(child_corners(corners, midpoints, child), level - 1, leaf);
        }
    }

    #[test]
    fn solid_angles_fill_the_sphere_and_vary_as_published() {
        // `exact_cases.md` 2f.
        for (level, ratio) in [(1, 1.622), (2, 1.962), (3, 2.068), (4, 2.096), (5, 2.104)] {
            let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, 0.0f64);
            for octant in 0..8 {
                visit(octant_corners(octant), level, &mut |c| {
                    let omega = solid_angle(c);
                    sum += omega;
                    low = low.min(omega);
                    high = high.max(omega);
                });
            }
            // Corners are f32: their rounding moves each triangle's angle by some 1e-7 of its size.
            assert!(
                (sum - 4.0 * std::f64::consts::PI).abs() < 1e-5,
                "level {level}: {sum}"
            );
            assert!(
                (high / low - ratio).abs() < 1e-3,
                "level {level}: {}",
                high / low
            );
        }
    }

    #[test]
    fn the_integral_is_that_of_many_small_parts() {
        // The small parts themselves are exact to a few ten-thousandths.
        const MOST: f64 = 2e-3;
        for level in 1..5 {
            let mut sphere = 0.0;
            for octant in 0..8 {
                visit(octant_corners(octant), level, &mut |corners| {
                    sphere += f64::from(integral(corners, [1.0; 3], None, level));
                });
            }
            let error = sphere / (4.0 * std::f64::consts::PI) - 1.0;
            assert!(error.abs() < MOST, "level {level}: {error}");
            for normal in [(0.3, 0.8, -0.5), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)] {
                let normal = Vec3::from(normal).normalize();
                let (mut whole, mut by_parts) = (0.0f64, 0.0f64);
                for octant in 0..8 {
                    visit(octant_corners(octant), level, &mut |corners| {
                        let values = corners.map(|c| 1.0 + c.x * c.y);
                        whole += f64::from(integral(corners, values, Some(normal), level));
                        visit(corners, 7 - level, &mut |part| {
                            let middle = centre(part);
                            let value = barycentric(corners, middle).dot(values.into());
                            by_parts +=
                                solid_angle(part) * f64::from(value * normal.dot(middle).max(0.0));
                        });
                    });
                }
                let error = whole / by_parts - 1.0;
                assert!(error.abs() < MOST, "level {level}, {normal}: {error}");
            }
        }
    }

    #[test]
    fn no_triangle_is_wider_than_the_tabulated_radius() {
        for level in 0..6 {
            for octant in 0..8 {
                visit(octant_corners(octant), level, &mut |c| {
                    for corner in c {
                        let angle = corner.dot(centre(c)).min(1.0).acos();
                        assert!(
                            angle <= radius(level) + 1e-3,
                            "level {level}: {angle} {}",
                            radius(level)
                        );
                    }
                });
            }
        }
    }

    #[test]
    fn the_descent_ends_in_a_triangle_that_holds_the_direction() {
        for i in 0..2000 {
            let (u, v) = (
                crate::geometry::hash::unit(i, 1),
                crate::geometry::hash::unit(i, 2),
            );
            let z = 2.0 * u - 1.0;
            let (s, phi) = ((1.0 - z * z).sqrt(), v * std::f32::consts::TAU);
            let direction = Vec3::new(s * phi.cos(), s * phi.sin(), z);
            let mut corners = octant_corners(octant(direction));
            for _ in 0..6 {
                let midpoints = edge_midpoints(corners);
                let child = child_of(corners, midpoints, direction);
                corners = child_corners(corners, midpoints, child);
            }
            let b = barycentric(corners, direction);
            let back = (corners[0] * b.x + corners[1] * b.y + corners[2] * b.z).normalize();
            assert!(back.distance(direction) < 1e-5, "{direction} {back}");
        }
    }
}
