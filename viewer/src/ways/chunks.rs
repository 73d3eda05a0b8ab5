//! Cuts a solution into parts whose buffers keep to WebGPU's default limits. Nearly always there is one part.

use crate::gpu::layout::{GlossyVertex, LineEnd, ShadedVertex};
use glam::Vec3;
use sheen_solver::Solution;
use sheen_solver::solution::NO_DISTRIBUTION;

/// Not in the chunk yet.
const ABSENT: u32 = u32::MAX;

/// Largest sizes of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Vertices.
    pub vertices: usize,
    /// Words of distributions.
    pub words: usize,
    /// Triangles.
    pub triangles: usize,
}

impl Default for Limits {
    /// Under 128 MiB for each storage binding, 256 MiB for each buffer, 65,535 workgroups of 64.
    fn default() -> Self {
        Self {
            vertices: 4_000_000,
            words: 32 << 20,
            triangles: 11_000_000,
        }
    }
}

/// A part of a mesh that can be drawn by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Positions [m].
    pub positions: Vec<[f32; 3]>,
    /// Radiance that does not depend on direction; fourth: 1 where the vertex is glossy.
    pub colours: Vec<[f32; 4]>,
    /// Vertices with a distribution.
    pub glossy: Vec<GlossyVertex>,
    /// All vertices as samples are shaded from them.
    pub shaded: Vec<ShadedVertex>,
    /// Their distributions.
    pub words: Vec<u32>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
}

/// Where each vertex's distribution ends, for vertices that have one.
fn distribution_ends(solution: &Solution) -> Vec<u32> {
    let mut next = solution.distribution_words.len() as u32;
    let mut ends: Vec<u32> = solution
        .distribution_offset
        .iter()
        .rev()
        .map(|&offset| {
            let end = next;
            if offset != NO_DISTRIBUTION {
                next = offset;
            }
            end
        })
        .collect();
    ends.reverse();
    ends
}

/// Cuts `solution`. Triangles keep their order; vertices that several chunks use are copied, with their distributions.
pub fn cut(solution: &Solution, limits: Limits) -> Vec<Chunk> {
    let ends = distribution_ends(solution);
    let word_count = |vertex: usize| match solution.distribution_offset[vertex] {
        NO_DISTRIBUTION => 0,
        offset => (ends[vertex] - offset) as usize,
    };
    let mut chunks = Vec::new();
    let mut chunk = Chunk::default();
    let mut local = vec![ABSENT; solution.position.len()];
    let mut members: Vec<usize> = Vec::new();
    for corners in &solution.triangles {
        let corners = corners.map(|corner| corner as usize);
        let new = corners
            .iter()
            .enumerate()
            .filter(|&(i, &v)| local[v] == ABSENT && !corners[..i].contains(&v));
        let (vertices, words) = new.fold((0, 0), |(vertices, words), (_, &vertex)| {
            (vertices + 1, words + word_count(vertex))
        });
        let full = chunk.positions.len() + vertices > limits.vertices
            || chunk.words.len() + words > limits.words
            || chunk.triangles.len() == limits.triangles;
        if full && !chunk.triangles.is_empty() {
            chunks.push(std::mem::take(&mut chunk));
            for vertex in members.drain(..) {
                local[vertex] = ABSENT;
            }
        }
        for vertex in corners {
            if local[vertex] == ABSENT {
                local[vertex] = chunk.positions.len() as u32;
                members.push(vertex);
                let end = ends[vertex];
                add_vertex(&mut chunk, solution, vertex, end);
            }
        }
        chunk.triangles.push(corners.map(|vertex| local[vertex]));
    }
    if !chunk.triangles.is_empty() {
        chunks.push(chunk);
    }
    chunks
}

fn add_vertex(chunk: &mut Chunk, solution: &Solution, vertex: usize, end: u32) {
    let position = solution.position[vertex].to_array();
    let radiance = solution.radiance[vertex].to_array();
    let offset = solution.distribution_offset[vertex];
    let is_glossy = offset != NO_DISTRIBUTION;
    let mut local_offset = NO_DISTRIBUTION;
    if is_glossy {
        local_offset = chunk.words.len() as u32;
        chunk.glossy.push(GlossyVertex {
            position,
            offset: local_offset,
            radiance,
            vertex: chunk.positions.len() as u32,
        });
        chunk
            .words
            .extend_from_slice(&solution.distribution_words[offset as usize..end as usize]);
    }
    chunk.shaded.push(ShadedVertex {
        normal: solution.normal[vertex].to_array(),
        offset: local_offset,
        radiance,
        padding: 0,
    });
    chunk.positions.push(position);
    chunk.colours.push([
        radiance[0],
        radiance[1],
        radiance[2],
        f32::from(u8::from(is_glossy)),
    ]);
}

/// Ends of the wireframe's lines, two a line: the edges of hierarchy elements.
pub fn wireframe(solution: &Solution) -> Vec<LineEnd> {
    let mut ends = Vec::new();
    for (corners, &edges) in solution.triangles.iter().zip(&solution.element_edges) {
        let corners: [Vec3; 3] = corners.map(|corner| solution.position[corner as usize]);
        // Unit, so that tiny and huge triangles keep a direction.
        let edge = |to: usize| (corners[to] - corners[0]).normalize_or_zero();
        let face_normal = edge(1).cross(edge(2)).to_array();
        for i in (0..3).filter(|i| edges >> i & 1 == 1) {
            for corner in [corners[i], corners[(i + 1) % 3]] {
                ends.push(LineEnd {
                    position: corner.to_array(),
                    face_normal,
                });
            }
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wireframe_has_the_edges_of_elements_only() {
        let solution = Solution {
            position: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            element_edges: vec![0b101],
            ..Solution::default()
        };
        let ends = wireframe(&solution);
        let positions: Vec<Vec3> = ends.iter().map(|end| end.position.into()).collect();
        assert_eq!(positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO]);
        assert!(ends.iter().all(|end| end.face_normal == [0.0, 0.0, 1.0]));
    }

    #[test]
    fn distributions_end_where_the_next_one_starts() {
        let solution = Solution {
            distribution_offset: vec![NO_DISTRIBUTION, 0, NO_DISTRIBUTION, 9, NO_DISTRIBUTION],
            distribution_words: vec![0; 20],
            ..Solution::default()
        };
        let ends = distribution_ends(&solution);
        assert_eq!((ends[1], ends[3]), (9, 20));
    }
}
