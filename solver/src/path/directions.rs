//! A density of directions learned from some that were seen: a quadtree over the square that directions map to.
//!
//! Müller, Gross and Novák 2017, "Practical path guiding for efficient light-transport simulation", section 3.2.

use glam::{Vec2, Vec3};

/// A cell with more directions than this is split.
const MOST_IN_CELL: usize = 32;
/// Cells are split no further than this: 1e-6 of the sphere.
const MOST_DEPTH: u32 = 10;

/// No child: the density is even within the quadrant.
const EVEN: u32 = u32::MAX;

/// A cell's quadrants: bit 0 of their numbers is the right half, bit 1 the upper.
struct Cell {
    shares: [f32; 4],
    children: [u32; 4],
}

/// A density of directions. Some may be left out: mix it with one that is positive everywhere.
pub(super) struct Directions {
    cells: Vec<Cell>,
}

/// Solid angle per area of the square at the ends of a quarter turn [sr].
const SOLID_ANGLE: f32 = 8.0;

/// The point of the unit square of a unit direction: its turn around z, even along the sides of a diamond instead of a
/// circle, and its height.
pub(super) fn to_square(direction: Vec3) -> Vec2 {
    let Vec3 { x, y, z } = direction;
    let (quarter, along, across) = match (x > 0.0, y > 0.0) {
        (true, true) => (0.0, y, x),
        (false, true) => (1.0, -x, y),
        (false, false) => (2.0, -y, -x),
        (true, false) => (3.0, x, -y),
    };
    let whole = along + across;
    let part = if whole > 0.0 { along / whole } else { 0.0 };
    // Rounding must not leave the last cell.
    const LAST: f32 = 1.0 - f32::EPSILON;
    Vec2::new(
        ((quarter + part) * 0.25).clamp(0.0, LAST),
        (z * 0.5 + 0.5).clamp(0.0, LAST),
    )
}

/// The unit direction of a point of the square.
fn from_square(at: Vec2) -> Vec3 {
    let turn = at.x * 4.0;
    let part = turn.fract();
    let (along, across) = (part, 1.0 - part);
    let (x, y) = match turn as u32 {
        0 | 4 => (across, along),
        1 => (-along, across),
        2 => (-across, -along),
        _ => (along, -across),
    };
    let z = at.y * 2.0 - 1.0;
    let height = ((1.0 - z * z).max(0.0) / (along * along + across * across)).sqrt();
    Vec3::new(x * height, y * height, z)
}

/// Area of the square per solid angle at a point of it [sr⁻¹].
fn per_solid_angle(at: Vec2) -> f32 {
    let part = (at.x * 4.0).fract();
    (part * part + (1.0 - part) * (1.0 - part)) / SOLID_ANGLE
}

/// The quadrant that `at` lies in, and where in it.
fn enter(at: Vec2) -> (usize, Vec2) {
    let doubled = at * 2.0;
    let (right, upper) = (doubled.x >= 1.0, doubled.y >= 1.0);
    let corner = Vec2::new(f32::from(right), f32::from(upper));
    (
        usize::from(right) + 2 * usize::from(upper),
        doubled - corner,
    )
}

impl Directions {
    /// Learns from the points of directions in the square; `None` without any.
    pub(super) fn learn(points: Vec<Vec2>) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let mut cells = Vec::new();
        split(&mut cells, points, 0);
        Some(Self { cells })
    }

    /// A direction from a point of the unit square, and its [`Self::density`].
    pub(super) fn sample(&self, at: Vec2) -> (Vec3, f32) {
        let mut at = at;
        let (mut corner, mut side) = (Vec2::ZERO, 1.0);
        let mut density = 1.0;
        let mut index = 0;
        loop {
            let cell = &self.cells[index as usize];
            let [a, b, c, d] = cell.shares;
            let (lower, is_upper) = (a + b, at.y >= a + b);
            let (left, right) = if is_upper { (c, d) } else { (a, b) };
            at.y = if is_upper {
                (at.y - lower) / (1.0 - lower)
            } else {
                at.y / lower
            };
            let share = left / (left + right);
            let is_right = at.x >= share;
            at.x = if is_right {
                (at.x - share) / (1.0 - share)
            } else {
                at.x / share
            };
            side *= 0.5;
            corner += Vec2::new(f32::from(is_right), f32::from(is_upper)) * side;
            let quadrant = usize::from(is_right) + 2 * usize::from(is_upper);
            density *= 4.0 * cell.shares[quadrant];
            index = cell.children[quadrant];
            if index == EVEN {
                let within = corner + at.clamp(Vec2::ZERO, Vec2::ONE) * side;
                return (from_square(within), density * per_solid_angle(within));
            }
        }
    }

    /// Density of [`Self::sample`] [sr⁻¹].
    pub(super) fn density(&self, direction: Vec3) -> f32 {
        let mut at = to_square(direction);
        let mut density = per_solid_angle(at);
        let mut index = 0;
        while index != EVEN && density > 0.0 {
            let cell = &self.cells[index as usize];
            let (quadrant, within) = enter(at);
            density *= 4.0 * cell.shares[quadrant];
            at = within;
            index = cell.children[quadrant];
        }
        density
    }
}

/// Appends the cell of `points`, which are relative to it, and those below; gives its number.
fn split(cells: &mut Vec<Cell>, points: Vec<Vec2>, depth: u32) -> u32 {
    let index = cells.len();
    let mut quadrants: [Vec<Vec2>; 4] = std::array::from_fn(|_| Vec::new());
    let count = points.len();
    for point in points {
        let (quadrant, within) = enter(point);
        quadrants[quadrant].push(within);
    }
    cells.push(Cell {
        shares: quadrants.each_ref().map(|q| q.len() as f32 / count as f32),
        children: [EVEN; 4],
    });
    for (i, quadrant) in quadrants.into_iter().enumerate() {
        if quadrant.len() > MOST_IN_CELL && depth + 1 < MOST_DEPTH {
            cells[index].children[i] = split(cells, quadrant, depth + 1);
        }
    }
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sampling::{cosine_direction, spread};
    use glam::UVec2;

    /// Learned from a cosine lobe and a narrow one.
    fn learned() -> Directions {
        let narrow = Vec3::new(0.6, -0.48, 0.64);
        let directions = (0..4000).map(|i| {
            let direction = cosine_direction(Vec3::Y, spread(i));
            if i % 3 == 0 {
                (narrow + direction * 0.02).normalize()
            } else {
                direction
            }
        });
        Directions::learn(directions.map(to_square).collect()).expect("some")
    }

    #[test]
    fn directions_return_from_the_square() {
        for i in 0..1000 {
            let at = spread(i);
            assert!((to_square(from_square(at)) - at).length() < 1e-5, "{at}");
        }
    }

    #[test]
    fn the_square_covers_the_sphere() {
        const SIDE: u32 = 512;
        let mut whole = 0.0;
        for i in 0..SIDE * SIDE {
            let at = (UVec2::new(i % SIDE, i / SIDE).as_vec2() + 0.5) / SIDE as f32;
            assert!((from_square(at).length() - 1.0).abs() < 1e-6);
            whole += f64::from(1.0 / per_solid_angle(at)) / f64::from(SIDE * SIDE);
        }
        assert!(
            (whole / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4,
            "{whole}"
        );
    }

    #[test]
    fn samples_have_their_density() {
        let learned = learned();
        const COUNT: u32 = 1 << 16;
        // The share of samples in each of 16 × 16 parts of the sphere against the integral of the density.
        let part = |at: Vec2| (at * 16.0).floor().as_usizevec2();
        let (mut found, mut expected) = ([[0.0f64; 16]; 16], [[0.0f64; 16]; 16]);
        let mut differing = 0;
        for i in 0..COUNT {
            let (direction, density) = learned.sample(spread(i));
            let again = learned.density(direction);
            // Rounding may lead across the edge of a cell.
            differing += u32::from((density - again).abs() > 1e-3 * again);
            let sampled = part(to_square(direction));
            found[sampled.y][sampled.x] += 1.0 / f64::from(COUNT);
        }
        // Finer than the smallest cells.
        const ROWS: u32 = 2 << MOST_DEPTH;
        for i in 0..ROWS * ROWS {
            let even = (UVec2::new(i % ROWS, i / ROWS).as_vec2() + 0.5) / ROWS as f32;
            let there = part(even);
            let share = learned.density(from_square(even)) / per_solid_angle(even);
            expected[there.y][there.x] += f64::from(share) / f64::from(ROWS * ROWS);
        }
        assert!(differing < COUNT / 1000, "{differing}");
        let whole: f64 = expected.iter().flatten().sum();
        assert!((whole - 1.0).abs() < 1e-3, "{whole}");
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 0.01, "{found} {expected}");
        }
        // The narrow lobe was found: a third of all in 2 % of a turn.
        let narrow = learned.density(Vec3::new(0.6, -0.48, 0.64));
        assert!(narrow > 10.0, "{narrow}");
    }

    #[test]
    fn no_directions_teach_nothing() {
        assert!(Directions::learn(Vec::new()).is_none());
    }
}
