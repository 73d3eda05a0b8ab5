//! The cells of the first octant, tabulated: which child holds a direction, and where in a leaf it lies.
//!
//! [`octahedron`] finds the same without a table: the plain twin. The octants are mirror images of each other, so the
//! absolute values of a direction's coordinates find its cell.

use super::octahedron::{self, Corners};
use glam::Vec3;
use std::sync::LazyLock;

/// Levels below the octant.
const LEVELS: u32 = 6;

/// A cell of the first octant.
pub(super) struct Cell {
    /// Planes that cut off the children with the corners 0, 1, 2: normals towards them.
    cuts: [Vec3; 3],
    /// Planes of the sides opposite to the corners: normals inwards, lengths as barycentric coordinates want them.
    sides: [Vec3; 3],
    corners: Corners,
}

impl Cell {
    fn new(corners: Corners) -> Self {
        let [a, b, c] = corners;
        let [m12, m20, m01] = octahedron::edge_midpoints(corners);
        let towards = |normal: Vec3, corner: Vec3| {
            if normal.dot(corner) < 0.0 {
                -normal
            } else {
                normal
            }
        };
        Self {
            cuts: [
                towards(m01.cross(m20), a),
                towards(m01.cross(m12), b),
                towards(m20.cross(m12), c),
            ],
            sides: [
                towards(b.cross(c), a),
                towards(c.cross(a), b),
                towards(a.cross(b), c),
            ],
            corners,
        }
    }

    /// One of its four children.
    pub(super) fn child(&self, child: usize) -> Self {
        let midpoints = octahedron::edge_midpoints(self.corners);
        Self::new(octahedron::child_corners(self.corners, midpoints, child))
    }

    /// [`octahedron::child_of`].
    pub(super) fn child_of(&self, direction: Vec3) -> usize {
        let beyond = |cut: &Vec3| cut.dot(direction) > 0.0;
        self.cuts.iter().position(beyond).unwrap_or(3)
    }

    /// [`octahedron::barycentric`].
    pub(super) fn barycentric(&self, direction: Vec3) -> Vec3 {
        octahedron::clamped(self.sides.map(|side| side.dot(direction)).into())
    }
}

/// The child of a cell by their numbers in [`cells`], where cell 0 is the octant.
pub(super) fn child(cell: usize, child: usize) -> usize {
    4 * cell + 1 + child
}

/// All cells of the first octant down to a level; [`child`] of the deepest lies beyond the end.
pub(super) fn cells() -> &'static [Cell] {
    static CELLS: LazyLock<Vec<Cell>> = LazyLock::new(|| {
        let count = (4usize.pow(LEVELS + 1) - 1) / 3;
        let mut cells: Vec<Cell> = Vec::with_capacity(count);
        cells.push(Cell::new(octahedron::octant_corners(0)));
        for at in 1..count {
            let (parent, child) = ((at - 1) / 4, (at - 1) % 4);
            cells.push(cells[parent].child(child));
        }
        cells
    });
    &CELLS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;

    #[test]
    fn the_table_finds_what_subdivision_finds() {
        for i in 0..20_000 {
            let u = |k: u32| unit(i, k) - 0.5;
            let direction = Vec3::new(u(0), u(1), u(2)).normalize();
            let octant = octahedron::octant(direction);
            let mut corners = octahedron::octant_corners(octant);
            let mut at = 0;
            while at < cells().len() {
                let cell = &cells()[at];
                assert_eq!(
                    cell.barycentric(direction.abs()),
                    octahedron::barycentric(corners, direction)
                );
                let midpoints = octahedron::edge_midpoints(corners);
                let found = octahedron::child_of(corners, midpoints, direction);
                assert_eq!(cell.child_of(direction.abs()), found, "{direction}");
                corners = octahedron::child_corners(corners, midpoints, found);
                at = child(at, found);
            }
        }
    }
}
