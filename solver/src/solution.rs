//! The result of a solve: a conforming triangle mesh with directional radiance per vertex.

use crate::directional::packed;
use crate::radiometry::Rgb;
use crate::scene::{Camera, Material};
use crate::stats::Stats;
use glam::Vec3;

/// Stands in [`Solution::distribution_offset`] for a vertex without a directional distribution.
pub const NO_DISTRIBUTION: u32 = u32::MAX;

/// A view-independent, directional global illumination solution. Structure of arrays over vertices and triangles.
///
/// Triangles are one-sided: what can be seen from both sides stands in the mesh twice, with opposite winding.
/// Radiance of vertex v towards direction ω is `radiance[v]` plus, if it has one, its distribution at ω.
/// Glass (clear, `ts`) is not part of `triangles`; it stands in `glass`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solution {
    /// Positions [m].
    pub position: Vec<Vec3>,
    /// Shading normals, unit, on the side that the triangle is seen from.
    pub normal: Vec<Vec3>,
    /// Direction-independent part of the outgoing radiance, emission included [W·sr⁻¹·m⁻²].
    pub radiance: Vec<Rgb>,
    /// Index into `materials`.
    pub material: Vec<u32>,
    /// Where in `distribution_words` the vertex's distribution starts (see [`packed`]), or [`NO_DISTRIBUTION`].
    pub distribution_offset: Vec<u32>,
    /// All distributions, one after the other, in the order of the vertices that own them.
    pub distribution_words: Vec<u32>,
    /// Corners, counter-clockwise seen from the side that this triangle shows.
    pub triangles: Vec<[u32; 3]>,
    /// Bit i set: the edge from corner i to corner i+1 is an edge of a hierarchy element (for wireframes).
    pub element_edges: Vec<u8>,
    /// Clear surfaces, drawn after everything else: three corners [m] each.
    pub glass_corners: Vec<[Vec3; 3]>,
    /// Material of each clear surface.
    pub glass_material: Vec<u32>,
    /// Materials of the scene.
    pub materials: Vec<Material>,
    /// Cameras of the scene; never empty.
    pub cameras: Vec<Camera>,
    /// What the solve did and what it cost.
    pub stats: Stats,
}

impl Solution {
    /// Radiance that leaves vertex `vertex` towards `direction` (unit, leaving the surface) [W·sr⁻¹·m⁻²].
    pub fn evaluate(&self, vertex: usize, direction: Vec3) -> Rgb {
        let diffuse = self.radiance[vertex];
        match self.distribution_offset[vertex] {
            NO_DISTRIBUTION => diffuse,
            offset => {
                diffuse + packed::evaluate(&self.distribution_words[offset as usize..], direction)
            }
        }
    }

    /// The words of vertex `vertex`'s distribution, if it has one: up to where the next one starts.
    pub fn distribution(&self, vertex: usize) -> Option<&[u32]> {
        let start = self.distribution_offset[vertex];
        if start == NO_DISTRIBUTION {
            return None;
        }
        let end = self.distribution_offset[vertex + 1..]
            .iter()
            .copied()
            .find(|&next| next != NO_DISTRIBUTION)
            .unwrap_or(self.distribution_words.len() as u32);
        Some(&self.distribution_words[start as usize..end as usize])
    }

    /// Smallest and largest corner of the box around all triangles [m].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.position
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            })
    }
}
