//! Which part of an element light can reach: what stands on a surface leaves it dark below.

use glam::Vec2;

/// Cells along each side of an element.
const SIDE: u32 = 8;

/// A subset of the 8 × 8 cells of the unit square that [`crate::geometry::Polygon::point`] maps to an element, along
/// the Morton curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exposed(u64);

impl Exposed {
    /// All of it.
    pub const ALL: Self = Self(u64::MAX);
    /// Nothing of it.
    pub const NONE: Self = Self(0);
    /// Cells.
    const CELLS: u32 = SIDE * SIDE;

    /// A place in each cell.
    pub fn places() -> impl Iterator<Item = Vec2> {
        (0..Self::CELLS).map(place)
    }

    /// The cells that are exposed in a place. Every other one is asked; the rest where those beside it differ.
    pub fn of(is_exposed: impl Fn(Vec2) -> bool) -> Self {
        let coordinates = |cell: u32| (gather_bits(cell), gather_bits(cell >> 1));
        let is_asked = |cell: &u32| {
            let (x, y) = coordinates(*cell);
            (x + y).is_multiple_of(2)
        };
        let bit = |cell: u32| 1u64 << cell;
        let asked = (0..Self::CELLS).filter(is_asked);
        let lit = asked.filter(|&cell| is_exposed(place(cell)));
        let lit = Self(lit.fold(0, |sum, cell| sum | bit(cell)));
        let is_rest_lit = |cell: &u32| {
            let (x, y) = coordinates(*cell);
            let steps = [
                (x + 1, y),
                (x.wrapping_sub(1), y),
                (x, y + 1),
                (x, y.wrapping_sub(1)),
            ];
            let beside = steps.into_iter().filter(|&(x, y)| x < SIDE && y < SIDE);
            let (count, lit_count) = beside.fold((0, 0), |(count, lit_count), (x, y)| {
                (count + 1, lit_count + u32::from(lit.holds(cell_of(x, y))))
            });
            lit_count == count || lit_count > 0 && is_exposed(place(*cell))
        };
        let rest = (0..Self::CELLS).filter(|cell| !is_asked(cell));
        Self(
            rest.filter(is_rest_lit)
                .fold(lit.0, |sum, cell| sum | bit(cell)),
        )
    }

    /// Share of the area; half a cell where none is seen, as none is known to be hidden all over.
    pub fn share(self) -> f32 {
        match self.0.count_ones() {
            0 => 0.5 / Self::CELLS as f32,
            count => count as f32 / Self::CELLS as f32,
        }
    }

    /// `None` where light cannot reach. In cells beside such, whose other parts may be either, the place that is known.
    pub fn nearest(self, uv: Vec2) -> Option<Vec2> {
        if self.is_whole() {
            return Some(uv);
        }
        let within = (uv * SIDE as f32).clamp(Vec2::ZERO, Vec2::splat(SIDE as f32 - 1.0));
        let cell = cell_of(within.x as u32, within.y as u32);
        self.holds(cell)
            .then(|| if self.is_inner(cell) { uv } else { place(cell) })
    }

    /// Points of the unit square moved to where light can reach: evenly spread ones stay so.
    pub fn point(self, uv: Vec2) -> Vec2 {
        if self.is_whole() {
            return uv;
        }
        let count = self.0.count_ones();
        let along = uv.x.clamp(0.0, 1.0) * count as f32;
        let skipped = (along as u32).min(count - 1);
        let mut rest = self.0;
        for _ in 0..skipped {
            rest &= rest - 1;
        }
        let cell = rest.trailing_zeros();
        if self.is_inner(cell) {
            at(cell, Vec2::new(along - skipped as f32, uv.y))
        } else {
            place(cell)
        }
    }

    fn holds(self, cell: u32) -> bool {
        self.0 >> cell & 1 == 1
    }

    /// True when the cells beside `cell` are exposed.
    fn is_inner(self, cell: u32) -> bool {
        let (x, y) = (gather_bits(cell), gather_bits(cell >> 1));
        let beside = |x: u32, y: u32| x >= SIDE || y >= SIDE || self.holds(cell_of(x, y));
        beside(x + 1, y)
            && beside(x.wrapping_sub(1), y)
            && beside(x, y + 1)
            && beside(x, y.wrapping_sub(1))
    }

    /// True when no cell is.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// True where points are not told apart.
    fn is_whole(self) -> bool {
        self.is_none() || self == Self::ALL
    }
}

/// The cell of a column and a row.
fn cell_of(x: u32, y: u32) -> u32 {
    spread_bits(x) | spread_bits(y) << 1
}

/// The place in a cell that stands for it. Those of all cells are 64 columns and 64 rows: a strip along either holds its
/// share of them, however thin.
fn place(cell: u32) -> Vec2 {
    let reversed = |x: u32| (x & 1) << 2 | x & 2 | x >> 2 & 1;
    let (x, y) = (gather_bits(cell), gather_bits(cell >> 1));
    let within = Vec2::new(reversed(y) as f32, reversed(x) as f32);
    at(cell, (within + 0.5) / SIDE as f32)
}

/// A place within a cell.
fn at(cell: u32, within: Vec2) -> Vec2 {
    let corner = Vec2::new(gather_bits(cell) as f32, gather_bits(cell >> 1) as f32);
    (corner + within) / SIDE as f32
}

/// Bits 0, 1, 2 to places 0, 2, 4.
fn spread_bits(x: u32) -> u32 {
    x & 1 | (x & 2) << 1 | (x & 4) << 2
}

/// And back.
fn gather_bits(x: u32) -> u32 {
    x & 1 | x >> 1 & 2 | x >> 2 & 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sampling::spread;

    #[test]
    fn points_fill_what_is_exposed_evenly() {
        // Left of a slanted edge, in cells.
        let edge = |uv: Vec2| uv.x + 0.5 * uv.y < 0.7;
        let exposed = Exposed::of(edge);
        assert!((exposed.share() - 0.45).abs() < 0.02, "{}", exposed.share());
        let mut counts = [0u32; Exposed::CELLS as usize];
        for i in 0..64 * Exposed::CELLS {
            let uv = exposed.point(spread(i));
            assert_eq!(exposed.nearest(uv), Some(uv));
            assert!(edge(uv), "{uv}");
            counts[((uv.y * 8.0) as usize) * 8 + (uv.x * 8.0) as usize] += 1;
        }
        let most = f64::from(64 * Exposed::CELLS) / f64::from(exposed.0.count_ones());
        let is_even = |&n: &u32| n == 0 || (f64::from(n) / most - 1.0).abs() < 0.2;
        assert!(counts.iter().all(is_even), "{counts:?}");
        let filled = counts.iter().filter(|&&n| n > 0).count() as u32;
        assert_eq!(filled, exposed.0.count_ones());
    }

    #[test]
    fn all_and_nothing_leave_points_alone() {
        for exposed in [Exposed::ALL, Exposed::NONE] {
            let uv = Vec2::new(0.3, 0.8);
            assert_eq!(exposed.point(uv), uv);
            assert_eq!(exposed.nearest(uv), Some(uv));
        }
        assert_eq!(Exposed::of(|_| true), Exposed::ALL);
        assert_eq!(Exposed::of(|_| false), Exposed::NONE);
        assert_eq!(Exposed::ALL.share(), 1.0);
        assert_eq!(Exposed::NONE.share(), 1.0 / 128.0);
    }
}
