//! The non-adaptive basis (§4.1): a tetrahedron subdivided evenly, linear between values at its vertices.
//!
//! The baseline of the adaptive basis. A distribution is a slice of words too: the scale, negative where [`packed`] has a
//! positive one; the level n; the RGB9E5 colours of the 2 · 4ⁿ + 2 vertices: four corners, the points within the six edges,
//! those within the four faces, row by row.
//!
//! [`packed`]: super::packed

use super::haar::{Projection, Source};
use super::octahedron::{self, Corners};
use super::packed::{self, decode, encode};
use crate::radiometry::Rgb;
use glam::{UVec3, Vec3};

/// Words before the colours: scale and level.
const HEAD: usize = 2;

/// Deepest level: half a million colours.
pub const MAX_LEVEL: u32 = 9;

/// Corners of the tetrahedron; face k is the one opposite to corner k, and has the others in their order.
const CORNERS: [Vec3; 4] = {
    const C: f32 = 0.577_350_26;
    [
        Vec3::new(C, C, C),
        Vec3::new(C, -C, -C),
        Vec3::new(-C, C, -C),
        Vec3::new(-C, -C, C),
    ]
};

/// Corners of each face.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// True for the words of a distribution on this basis.
pub fn is_uniform(words: &[u32]) -> bool {
    words[0] >> 31 != 0
}

/// Vertices of a level.
pub fn vertex_count(level: u32) -> usize {
    2 * 4usize.pow(level) + 2
}

/// Number of the vertex of a face that has the integer barycentric coordinates `at`, which sum to 2 to the `level`.
fn vertex(face: usize, at: UVec3, level: u32) -> usize {
    let side = 1 << level;
    let inside = side - 1;
    let [i, j, k] = at.to_array();
    let corner = |local: usize| FACES[face][local];
    // From one corner of the face, `steps` towards a later one.
    let on_edge = |from: usize, to: usize, steps: u32| {
        let edge = match (corner(from), corner(to)) {
            (0, to) => to - 1,
            (1, to) => to + 1,
            _ => 5,
        };
        4 + edge * inside + (steps as usize - 1)
    };
    match (i, j, k) {
        (_, 0, 0) => corner(0),
        (0, _, 0) => corner(1),
        (0, 0, _) => corner(2),
        (_, _, 0) => on_edge(0, 1, j),
        (_, 0, _) => on_edge(0, 2, k),
        (0, _, _) => on_edge(1, 2, k),
        _ => {
            let (i, j) = (i as usize, j as usize);
            let before = (i - 1) * inside - i * (i - 1) / 2 + (j - 1);
            4 + 6 * inside + face * (inside * (inside.max(1) - 1) / 2) + before
        }
    }
}

/// A triangle on its way down: corners, and their coordinates on the face.
#[derive(Clone, Copy)]
struct Cell {
    corners: Corners,
    at: [UVec3; 3],
}

impl Cell {
    fn face(face: usize, level: u32) -> Self {
        let side = 1 << level;
        Self {
            corners: FACES[face].map(|corner| CORNERS[corner]),
            at: [UVec3::X * side, UVec3::Y * side, UVec3::Z * side],
        }
    }

    fn child(&self, child: usize) -> Self {
        let [a, b, c] = self.at;
        let [m12, m20, m01] = [(b + c) / 2, (c + a) / 2, (a + b) / 2];
        let at = match child {
            0 => [a, m01, m20],
            1 => [m01, b, m12],
            2 => [m20, m12, c],
            _ => [m12, m20, m01],
        };
        let midpoints = octahedron::edge_midpoints(self.corners);
        Self {
            corners: octahedron::child_corners(self.corners, midpoints, child),
            at,
        }
    }
}

/// Calls `visit` with the face and each cell of the `level`.
fn visit(level: u32, mut visit: impl FnMut(usize, &Cell)) {
    for face in 0..4 {
        let mut pending = vec![(Cell::face(face, level), level)];
        while let Some((cell, left)) = pending.pop() {
            if left == 0 {
                visit(face, &cell);
            } else {
                pending.extend([0, 1, 2, 3].map(|child| (cell.child(child), left - 1)));
            }
        }
    }
}

/// Radiance of the distribution that starts at `words[0]`, towards `direction`.
pub fn evaluate(words: &[u32], direction: Vec3) -> Rgb {
    let level = words[1];
    let height = CORNERS.map(|corner| corner.dot(direction));
    let face = (1..4).fold(0, |low, k| if height[k] < height[low] { k } else { low });
    let mut cell = Cell::face(face, level);
    for _ in 0..level {
        let midpoints = octahedron::edge_midpoints(cell.corners);
        cell = cell.child(octahedron::child_of(cell.corners, midpoints, direction));
    }
    let weights = octahedron::barycentric(cell.corners, direction);
    let colour = |corner: usize| decode(words[HEAD + vertex(face, cell.at[corner], level)]);
    let sum = colour(0) * weights.x + colour(1) * weights.y + colour(2) * weights.z;
    sum * -f32::from_bits(words[0])
}

/// Evaluates a source at the vertices of `how.max_level` and appends the packed distribution to `words`; returns the
/// number of vertices. Vertices below the horizon are black.
pub fn project(source: &mut impl Source, how: &Projection, words: &mut Vec<u32>) -> u64 {
    let level = how.max_level.min(MAX_LEVEL);
    let candidates: Vec<u32> = (0..source.candidate_count()).collect();
    let mut values: Vec<Option<Rgb>> = vec![None; vertex_count(level)];
    let mut sum = 0.0f64;
    visit(level, |face, cell| {
        let of_corners = [0, 1, 2].map(|corner| {
            let direction: Vec3 = cell.corners[corner];
            let value =
                values[vertex(face, cell.at[corner], level)].get_or_insert_with(|| {
                    match how.horizon {
                        Some(normal) if normal.dot(direction) < 0.0 => Rgb::BLACK,
                        _ => source.eval(&candidates, direction),
                    }
                });
            value.mean()
        });
        if how.integral.is_some() {
            // Larger than an octahedron's cell of the level.
            let size = level.saturating_sub(1) as usize;
            sum += f64::from(octahedron::integral(
                cell.corners,
                of_corners,
                how.horizon,
                size,
            ));
        }
    });
    let factor = match how.integral {
        Some(target) if sum > 0.0 => ((f64::from(target) / sum) as f32).clamp(0.5, 2.0),
        _ => 1.0,
    };
    let value = |value: &Option<Rgb>| value.unwrap_or(Rgb::BLACK) * factor;
    let values: Vec<Rgb> = values.iter().map(value).collect();
    pack(&values, words)
}

/// Smallest and largest value [mean over channels] within `half_angle` of `axis`: those at the vertices of the cells
/// that are met.
pub fn bounds_in_cone(words: &[u32], axis: Vec3, half_angle: f32) -> (f32, f32) {
    let level = words[1];
    let (mut low, mut high) = (f32::INFINITY, 0.0f32);
    visit(level, |face, cell| {
        let centre = octahedron::centre(cell.corners);
        let to_corner = cell.corners.map(|corner| centre.angle_between(corner));
        let radius = to_corner.into_iter().fold(0.0, f32::max);
        if centre.angle_between(axis) <= half_angle + radius {
            for at in cell.at {
                let value = decode(words[HEAD + vertex(face, at, level)]).mean();
                low = low.min(value);
                high = high.max(value);
            }
        }
    });
    let scale = -f32::from_bits(words[0]);
    (low.min(high) * scale, high * scale)
}

/// Largest stored value [mean over channels].
pub fn peak(words: &[u32]) -> f32 {
    let largest = words[HEAD..].iter().map(|&word| decode(word).mean());
    largest.fold(0.0, f32::max) * -f32::from_bits(words[0])
}

/// Number of cells, and the level.
pub fn leaves_and_depth(words: &[u32]) -> (usize, usize) {
    (4usize.pow(words[1] + 1), words[1] as usize)
}

/// Adds `factor` times the values of a packed distribution to those at the same vertices.
pub(super) fn add(values: &mut Vec<Rgb>, words: &[u32], factor: Rgb) {
    let factor = factor * -f32::from_bits(words[0]);
    values.resize(vertex_count(words[1]), Rgb::BLACK);
    for (value, &word) in values.iter_mut().zip(&words[HEAD..]) {
        *value += decode(word) * factor;
    }
}

/// Appends values at the vertices of a level to `words`; returns their number.
pub(super) fn pack(values: &[Rgb], words: &mut Vec<u32>) -> u64 {
    let largest = values.iter().fold(0.0f32, |m, v| m.max(v.max_channel()));
    let scale = packed::scale_for(largest);
    let level = (0..MAX_LEVEL).find(|&level| vertex_count(level) >= values.len());
    words.push((-scale).to_bits());
    words.push(level.unwrap_or(MAX_LEVEL));
    words.extend(values.iter().map(|&value| encode(value / scale)));
    values.len() as u64
}

/// True when the words are those of a level.
pub fn is_well_formed(words: &[u32]) -> bool {
    words.len() >= HEAD
        && f32::from_bits(words[0]).is_finite()
        && words[1] <= MAX_LEVEL
        && words.len() == HEAD + vertex_count(words[1])
}

#[cfg(test)]
mod tests {
    use super::super::haar::tests::{HOW, Plain};
    use super::*;

    #[test]
    fn every_vertex_has_a_number_of_its_own() {
        for level in 0..5 {
            let mut directions: Vec<Option<Vec3>> = vec![None; vertex_count(level)];
            let mut cells = 0;
            visit(level, |face, cell| {
                cells += 1;
                for (&at, &direction) in cell.at.iter().zip(&cell.corners) {
                    let slot = &mut directions[vertex(face, at, level)];
                    let known = *slot.get_or_insert(direction);
                    // Midpoints of one edge from both sides, each rounded.
                    assert!(known.distance(direction) < 1e-6, "{face} {at}");
                }
            });
            assert_eq!(cells, 4usize.pow(level + 1));
            assert!(directions.iter().all(Option::is_some), "level {level}");
        }
    }

    #[test]
    fn vertices_hold_the_function() {
        let f = |d: Vec3| 2.0 + d.x - 0.5 * d.y * d.z;
        let how = Projection {
            max_level: 3,
            ..HOW
        };
        let mut words = Vec::new();
        assert_eq!(project(&mut Plain(f), &how, &mut words), 130);
        assert!(is_well_formed(&words));
        visit(3, |_, cell| {
            for corner in cell.corners {
                let found = evaluate(&words, corner).g;
                // Nine bits of mantissa.
                assert!(
                    (found - f(corner)).abs() < f(corner) / 500.0,
                    "{corner}: {found}"
                );
            }
        });
        let (low, high) = bounds_in_cone(&words, Vec3::Z, std::f32::consts::PI);
        assert!(
            low < 1.1 && high > 2.9 && peak(&words) == high,
            "{low} {high}"
        );
    }
}
