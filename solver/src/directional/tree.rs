//! A subdivided octahedron with a value at each vertex: what projections and sums build, and what is packed.
//!
//! Neighbouring cells that are stored differ by at most one level once it is balanced; a vertex belongs to every cell that
//! it is a corner of, so the function that is interpolated between them is continuous.

use super::octahedron::{self, Corners};
use super::packed::{self, Part};
use crate::radiometry::Rgb;
use glam::Vec3;
use rustc_hash::FxHashMap;

#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) vertices: [u32; 3],
    /// First of four children, 0 for none: the octants take 0..8, so no child has the number 0.
    pub(super) first_child: u32,
    pub(super) level: u8,
    pub(super) below_horizon: bool,
}

/// Cells 0..8 are the octants.
#[derive(Default)]
pub(super) struct Tree {
    pub(super) cells: Vec<Cell>,
    pub(super) directions: Vec<Vec3>,
    pub(super) values: Vec<Rgb>,
    midpoints: FxHashMap<(u32, u32), u32>,
    /// Cells wholly below the plane with this normal are not stored.
    horizon: Option<Vec3>,
}

/// Vertices 0..6 of every tree: +x, +y, +z, -x, -y, -z.
pub(super) const AXES: [Vec3; 6] = [
    Vec3::X,
    Vec3::Y,
    Vec3::Z,
    Vec3::NEG_X,
    Vec3::NEG_Y,
    Vec3::NEG_Z,
];

impl Tree {
    /// Back to the octants, without light.
    pub(super) fn clear(&mut self, horizon: Option<Vec3>) {
        self.cells.clear();
        self.midpoints.clear();
        self.directions.clear();
        self.directions.extend(AXES);
        self.values.clear();
        self.values.extend([Rgb::BLACK; AXES.len()]);
        self.horizon = horizon;
        for octant in 0..8u32 {
            let vertices = [0, 1, 2].map(|axis| axis + 3 * (octant >> axis & 1));
            self.push_cell(vertices, 0);
        }
    }

    pub(super) fn corners(&self, cell: &Cell) -> Corners {
        cell.vertices.map(|v| self.directions[v as usize])
    }

    fn push_cell(&mut self, vertices: [u32; 3], level: u8) {
        let mut cell = Cell {
            vertices,
            first_child: 0,
            level,
            below_horizon: false,
        };
        let radius = octahedron::radius(usize::from(level));
        cell.below_horizon = self.horizon.is_some_and(|normal| {
            normal.dot(octahedron::centre(self.corners(&cell))) < -radius.sin()
        });
        self.cells.push(cell);
    }

    /// Splits a leaf; returns its first child. `value`: of a new vertex, by its direction and the ends of its edge.
    pub(super) fn split(
        &mut self,
        index: u32,
        mut value: impl FnMut(Vec3, [Rgb; 2]) -> Rgb,
    ) -> u32 {
        let cell = self.cells[index as usize];
        let [a, b, c] = cell.vertices;
        let [m12, m20, m01] = [(b, c), (c, a), (a, b)].map(|(a, b)| {
            let key = (a.min(b), a.max(b));
            if let Some(&vertex) = self.midpoints.get(&key) {
                return vertex;
            }
            let ends = [a, b].map(|end| self.directions[end as usize]);
            let direction = (ends[0] + ends[1]).normalize();
            let of_ends = [a, b].map(|end| self.values[end as usize]);
            let vertex = self.directions.len() as u32;
            self.directions.push(direction);
            self.values.push(value(direction, of_ends));
            self.midpoints.insert(key, vertex);
            vertex
        });
        let first = self.cells.len() as u32;
        for vertices in [[a, m01, m20], [m01, b, m12], [m20, m12, c], [m12, m20, m01]] {
            self.push_cell(vertices, cell.level + 1);
        }
        self.cells[index as usize].first_child = first;
        first
    }

    pub(super) fn midpoint_of(&self, a: u32, b: u32) -> Option<u32> {
        self.midpoints.get(&(a.min(b), a.max(b))).copied()
    }

    pub(super) fn edges(cell: &Cell) -> [(u32, u32); 3] {
        let [a, b, c] = cell.vertices;
        [(a, b), (b, c), (c, a)]
    }

    /// True when a neighbour across an edge of a leaf is more than one level deeper.
    pub(super) fn has_deep_edge(&self, cell: &Cell) -> bool {
        Self::edges(cell).into_iter().any(|(a, b)| {
            self.midpoint_of(a, b).is_some_and(|m| {
                self.midpoint_of(a, m).is_some() || self.midpoint_of(m, b).is_some()
            })
        })
    }

    /// Leaves that are stored, with their numbers.
    pub(super) fn leaves(&self) -> impl Iterator<Item = (usize, &Cell)> {
        let is_stored = |(_, cell): &(usize, &Cell)| cell.first_child == 0 && !cell.below_horizon;
        self.cells.iter().enumerate().filter(is_stored)
    }

    /// Appends what it holds times `factor` to `words`; returns the number of leaves that hold light.
    pub(super) fn pack(&self, factor: f32, words: &mut Vec<u32>) -> u64 {
        let largest = self
            .values
            .iter()
            .fold(0.0f32, |m, v| m.max(v.max_channel()))
            * factor;
        let scale = packed::scale_for(largest);
        let encoded = |vertex: u32| packed::encode(self.values[vertex as usize] * (factor / scale));
        let part = |index: u32| {
            let cell = self.cells[index as usize];
            if cell.first_child == 0 {
                return if cell.below_horizon {
                    Part::Black
                } else {
                    Part::Leaf
                };
            }
            let children = [0, 1, 2, 3].map(|child| cell.first_child + child);
            let [a, b, c] = cell.vertices;
            // The middle child's corners.
            let [m12, m20, m01] = self.cells[children[3] as usize].vertices;
            let is_mean = [(m12, b, c), (m20, c, a), (m01, a, b)].map(|(m, a, b)| {
                let value = |vertex: u32| self.values[vertex as usize];
                value(m) == (value(a) + value(b)) * 0.5
            });
            Part::Split {
                children,
                colours: [a, b, c, m12, m20, m01].map(encoded),
                is_mean,
            }
        };
        let axes = [0, 1, 2, 3, 4, 5].map(encoded);
        packed::pack(scale, axes, [0, 1, 2, 3, 4, 5, 6, 7], part, words)
    }
}
