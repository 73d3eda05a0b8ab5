//! Directions to spherical triangles and back.
//!
//! Eight faces, one an octant; 4:1 subdivision by the midpoints of the great-circle edges. Children 0, 1, 2 hold
//! the parent's corner 0, 1, 2; child 3 is the middle one with corners (m12, m20, m01).

use glam::Vec3;

/// Corners of a spherical triangle, unit vectors.
pub type Corners = [Vec3; 3];

/// Octant of a direction: bit 0 set for x < 0, bit 1 for y < 0, bit 2 for z < 0.
pub fn octant(direction: Vec3) -> usize {
    usize::from(direction.x < 0.0) | usize::from(direction.y < 0.0) << 1 | usize::from(direction.z < 0.0) << 2
}

/// Corners of an octant's face: on the x, the y and the z axis, in this order.
pub fn octant_corners(octant: usize) -> Corners {
    let sign = |bit: usize| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
    [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]
}

/// Midpoints of the edges opposite to corner 0, 1, 2: (m12, m20, m01), unit vectors.
pub fn edge_midpoints([a, b, c]: Corners) -> Corners {
    [(b + c).normalize(), (c + a).normalize(), (a + b).normalize()]
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
        if normal.dot(corner) < 0.0 { -side } else { side }
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
    let weights = if a.dot(b.cross(c)) < 0.0 { -weights } else { weights };
    let weights = weights.max(Vec3::ZERO);
    let sum = weights.element_sum();
    if sum > 0.0 { weights / sum } else { Vec3::splat(1.0 / 3.0) }
}

/// Solid angle of a spherical triangle [sr] (Van Oosterom & Strackee 1983), in f64.
pub fn solid_angle(corners: Corners) -> f64 {
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c)).abs();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * volume.atan2(denominator)
}
