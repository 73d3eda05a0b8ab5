//! Initial faces: triangles, and quads merged from coplanar triangle pairs.

use crate::scene::Triangle;
use glam::Vec3;
use rustc_hash::FxHashMap;

/// A triangle or a planar convex quad, with one material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Corner points; the fourth is [`super::NONE`] for triangles.
    pub points: [u32; 4],
    /// Shading normals at the corners, if smooth.
    pub normals: Option<[Vec3; 4]>,
    /// Index of the material.
    pub material: u32,
}

impl Patch {
    /// Its corners, three or four.
    pub fn corners(&self, points: &[Vec3]) -> Vec<Vec3> {
        self.points
            .iter()
            .filter(|&&p| p != super::NONE)
            .map(|&p| points[p as usize])
            .collect()
    }
}

/// Two faces lie in one plane when a corner is this much of an edge length away from it: rounding of f32 input.
const COPLANAR: f32 = 1e-5;

/// For each point the first one in the same place: files may list the corners of every face anew.
pub fn welded(points: &[Vec3]) -> Vec<u32> {
    let mut first = FxHashMap::default();
    let of_point = |(point, index): (&Vec3, u32)| {
        // -0 and 0 are the same.
        let place = (point + Vec3::ZERO).to_array().map(f32::to_bits);
        *first.entry(place).or_insert(index)
    };
    points.iter().zip(0..).map(of_point).collect()
}

/// Merges pairs of `triangles` into quads where they share an edge, a plane and a material and the quad is convex.
///
/// Returns the patches and, for each triangle, the patch that it became part of.
pub fn merge(points: &[Vec3], normals: &[Vec3], triangles: &[Triangle]) -> (Vec<Patch>, Vec<u32>) {
    let mut by_edge: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    for (index, triangle) in triangles.iter().enumerate() {
        for i in 0..3 {
            let edge = (triangle.points[i], triangle.points[(i + 1) % 3]);
            by_edge.entry(edge).or_default().push(index as u32);
        }
    }
    let mut patch_of = vec![super::NONE; triangles.len()];
    let mut patches = Vec::new();
    for (index, triangle) in triangles.iter().enumerate() {
        if patch_of[index] != super::NONE {
            continue;
        }
        // The neighbour with which the quad is closest to a rectangle.
        let mut best: Option<(f32, u32, Patch)> = None;
        for i in 0..3 {
            let (a, b) = (triangle.points[i], triangle.points[(i + 1) % 3]);
            for &other in by_edge.get(&(b, a)).into_iter().flatten() {
                if patch_of[other as usize] != super::NONE || other as usize == index {
                    continue;
                }
                if let Some((skew, patch)) =
                    quad(points, normals, triangle, i, &triangles[other as usize])
                    && best.as_ref().is_none_or(|(s, ..)| skew < *s)
                {
                    best = Some((skew, other, patch));
                }
            }
        }
        patch_of[index] = patches.len() as u32;
        match best {
            Some((_, other, patch)) => {
                patch_of[other as usize] = patches.len() as u32;
                patches.push(patch);
            }
            None => {
                let [a, b, c] = triangle.points;
                let normals = triangle.normals.map(|n| {
                    let [na, nb, nc] = n.map(|n| normals[n as usize]);
                    [na, nb, nc, na]
                });
                patches.push(Patch {
                    points: [a, b, c, super::NONE],
                    normals,
                    material: triangle.material,
                });
            }
        }
    }
    (patches, patch_of)
}

/// The quad of `first` and `second`, which share the edge from corner `edge` of `first`, with its skew: how far it
/// is from a rectangle, relative to its size.
fn quad(
    points: &[Vec3],
    normals: &[Vec3],
    first: &Triangle,
    edge: usize,
    second: &Triangle,
) -> Option<(f32, Patch)> {
    if first.material != second.material || first.normals.is_some() != second.normals.is_some() {
        return None;
    }
    let far = (0..3).find(|&i| second.points[i] == first.points[edge])?;
    // `second` runs b → a along the shared edge, so its far corner follows a.
    let far_corner = (far + 1) % 3;
    let corner = |i: usize| first.points[(edge + i) % 3];
    let ids = [corner(2), corner(0), second.points[far_corner], corner(1)];
    let p = ids.map(|i| points[i as usize]);
    let normal = (p[1] - p[0]).cross(p[3] - p[0]).normalize_or_zero();
    let size = (p[2] - p[0]).length().max((p[3] - p[1]).length());
    if (p[2] - p[0]).dot(normal).abs() > COPLANAR * size {
        return None;
    }
    // Convex with corners well inside 180 degrees: each corner turns left by a share of its edges.
    for i in 0..4 {
        let (u, v) = (p[(i + 1) % 4] - p[i], p[(i + 2) % 4] - p[(i + 1) % 4]);
        if u.cross(v).dot(normal) < 0.02 * u.length() * v.length() {
            return None;
        }
    }
    let shading = match (first.normals, second.normals) {
        (Some(a), Some(b)) => {
            let of_first = |i: usize| normals[a[(edge + i) % 3] as usize];
            let of_second = |i: usize| normals[b[i % 3] as usize];
            if of_first(0) != of_second(far) || of_first(1) != of_second(far + 2) {
                return None;
            }
            Some([of_first(2), of_first(0), of_second(far_corner), of_first(1)])
        }
        _ => None,
    };
    let skew = (p[0] + p[2] - p[1] - p[3]).length() / size;
    // In a grid each triangle is half of one square and of two sheared ones.
    let shear = (p[2] - p[0]).length() - (p[3] - p[1]).length();
    Some((
        skew + shear.abs() / size,
        Patch {
            points: ids,
            normals: shading,
            material: first.material,
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_two_triangles_is_one_patch() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        for (a, b) in [
            ([0, 1, 2], [0, 2, 3]),
            ([1, 2, 0], [3, 0, 2]),
            ([2, 0, 1], [2, 3, 0]),
        ] {
            let triangles = [a, b].map(|points| Triangle {
                points,
                normals: None,
                material: 0,
            });
            let (patches, patch_of) = merge(&points, &[], &triangles);
            assert_eq!((patches.len(), patch_of.as_slice()), (1, [0, 0].as_slice()));
            let p = patches[0].points;
            assert!(
                (0..4).all(|i| (p[(i + 1) % 4] + 4 - p[i]) % 4 == 1),
                "keeps the winding: {p:?}"
            );
        }
    }

    #[test]
    fn a_grid_of_triangles_is_one_of_squares() {
        const SIDE: u32 = 4;
        let at = |i: u32, j: u32| j * (SIDE + 1) + i;
        let points: Vec<Vec3> = (0..(SIDE + 1) * (SIDE + 1))
            .map(|p| Vec3::new((p % (SIDE + 1)) as f32, (p / (SIDE + 1)) as f32, 0.0) * 0.1)
            .collect();
        // All lower halves first, then all upper ones.
        let cells = || (0..SIDE * SIDE).map(|cell| (cell % SIDE, cell / SIDE));
        let lower = cells().map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        let upper = cells().map(|(i, j)| [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        let triangles: Vec<Triangle> = lower
            .chain(upper)
            .map(|points| Triangle {
                points,
                normals: None,
                material: 0,
            })
            .collect();
        let (patches, _) = merge(&points, &[], &triangles);
        assert_eq!(patches.len() as u32, SIDE * SIDE);
    }

    #[test]
    fn corners_that_are_listed_anew_are_one_point() {
        let points = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::new(-0.0, 0.0, -0.0),
            Vec3::X,
            Vec3::Y,
        ];
        assert_eq!(welded(&points), [0, 1, 0, 1, 4]);
    }
}
