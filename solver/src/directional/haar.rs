//! Top-down projection on the adaptive, balanced octahedral basis (§4.2).
//!
//! A cell is split while the function deviates over it by more than ε of its centre value; the result is packed for
//! files and shaders. The paper compares the samples' range, because its display is piecewise constant while it
//! solves; ours is linear in solving and display, so what counts is how far the centre is from the corners' mean, and
//! the range only where it hides a fold. Neighbouring cells differ by at most one level, and a corner that hangs in the middle of a
//! larger neighbour's edge takes the mean of that edge's ends: linear interpolation is continuous. What the corners
//! hold in the end is `fit`'s.
//! Cost: one evaluation of the function per corner and per centre of a cell.

use super::octahedron::{self, Corners};
use super::packed::{self, Part};
use crate::radiometry::Rgb;
use glam::Vec3;
use rustc_hash::FxHashMap;

/// A function over directions that is to be projected.
pub trait Source {
    /// Radiance towards `direction`, given the candidates in `range` of the list that [`Self::narrow`] writes.
    fn eval(&mut self, candidates: &[u32], direction: Vec3) -> Rgb;

    /// Appends to `list` those of its entries in `range` that can matter in the triangle of `level` around `centre`. A
    /// source without candidates appends nothing.
    fn narrow(
        &self,
        list: &mut Vec<u32>,
        range: std::ops::Range<usize>,
        centre: Vec3,
        level: usize,
    );

    /// All candidates.
    fn candidate_count(&self) -> u32;

    /// A value that the function may reach in the cell around `centre` with these candidates although no sample shows it: cells much
    /// larger than the sharpest feature are split while this matters. Zero for sources that know no bound.
    fn hidden_peak(&self, candidates: &[u32], centre: Vec3, level: usize) -> f32;
}

/// How finely to project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Every cell above the horizon is split at least this often, and once in any case.
    pub min_level: u32,
    /// And at most this often.
    pub max_level: u32,
    /// Largest deviation within a cell, as a share of its centre value plus `floor`.
    pub epsilon: f32,
    /// Radiance that is added to the centre value before the comparison: what is far below it is not refined. With
    /// the centre value switched off (`relative` false) this makes the absolute refiner of figure 8.
    pub floor: f32,
    /// Compare with the centre value too.
    pub relative: bool,
    /// Cells wholly below the plane with this normal are not stored.
    pub horizon: Option<Vec3>,
    /// The integral that the result must have [mean over channels]: over the sphere, or cosine-weighted over the
    /// horizon's hemisphere if there is one. `None`: as sampled.
    pub integral: Option<f32>,
}

/// What a projection cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionCost {
    /// Leaf cells that hold light: basis functions.
    pub basis_functions: u64,
    /// Evaluations of the source.
    pub evaluations: u64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) vertices: [u32; 3],
    /// First of four children, 0 for none: the octants take 0..8, so no child has the number 0.
    pub(super) first_child: u32,
    candidates: (u32, u32),
    pub(super) level: u8,
    pub(super) below_horizon: bool,
    /// The source in the middle of a leaf, where that was evaluated.
    pub(super) centre: Option<Rgb>,
}

/// A range of samples counts this much against a deviation from the linear: of an S-shaped flank the centre shows
/// nothing.
const RANGE_WEIGHT: f32 = 0.15;

/// Scratch memory of projections; one per thread.
#[derive(Default)]
pub struct Projector {
    pub(super) cells: Vec<Cell>,
    directions: Vec<Vec3>,
    pub(super) values: Vec<Rgb>,
    midpoints: FxHashMap<(u32, u32), u32>,
    candidates: Vec<u32>,
    evaluations: u64,
}

/// Vertices 0..6 of every projection: +x, +y, +z, -x, -y, -z.
const AXES: [Vec3; 6] = [
    Vec3::X,
    Vec3::Y,
    Vec3::Z,
    Vec3::NEG_X,
    Vec3::NEG_Y,
    Vec3::NEG_Z,
];

impl Projector {
    /// Projects `source` and appends the packed distribution to `words`.
    pub fn project(
        &mut self,
        source: &mut impl Source,
        how: &Projection,
        words: &mut Vec<u32>,
    ) -> ProjectionCost {
        self.reset(source, how);
        let mut pending: Vec<u32> = (0..8).rev().collect();
        while let Some(cell) = pending.pop() {
            if self.wants_split(cell, source, how) {
                let first = self.split(cell, source, how);
                pending.extend((first..first + 4).rev());
            }
        }
        self.balance(source, how);
        let scale = self.fit(how);
        let basis_functions = self.pack(scale, words);
        ProjectionCost {
            basis_functions,
            evaluations: self.evaluations,
        }
    }

    fn reset(&mut self, source: &mut impl Source, how: &Projection) {
        self.cells.clear();
        self.midpoints.clear();
        self.candidates.clear();
        self.candidates.extend(0..source.candidate_count());
        self.directions.clear();
        self.directions.extend(AXES);
        self.values.clear();
        let all = 0..self.candidates.len();
        self.values
            .extend(AXES.map(|axis| source.eval(&self.candidates[all.clone()], axis)));
        self.evaluations = 6;
        for octant in 0..8u32 {
            let vertices = [0, 1, 2].map(|axis| axis + 3 * (octant >> axis & 1));
            self.push_cell(vertices, (0, all.end as u32), 0, source, how);
        }
    }

    pub(super) fn corners(&self, cell: &Cell) -> Corners {
        cell.vertices.map(|v| self.directions[v as usize])
    }

    fn push_cell(
        &mut self,
        vertices: [u32; 3],
        (start, end): (u32, u32),
        level: u8,
        source: &impl Source,
        how: &Projection,
    ) {
        let mut cell = Cell {
            vertices,
            first_child: 0,
            candidates: (0, 0),
            level,
            below_horizon: false,
            centre: None,
        };
        let centre = octahedron::centre(self.corners(&cell));
        let radius = octahedron::radius(usize::from(level));
        cell.below_horizon = how
            .horizon
            .is_some_and(|normal| normal.dot(centre) < -radius.sin());
        let first = self.candidates.len();
        if !cell.below_horizon {
            let range = start as usize..end as usize;
            source.narrow(&mut self.candidates, range, centre, usize::from(level));
        }
        cell.candidates = (first as u32, self.candidates.len() as u32);
        self.cells.push(cell);
    }

    fn eval(&mut self, cell: u32, source: &mut impl Source, direction: Vec3) -> Rgb {
        let (start, end) = self.cells[cell as usize].candidates;
        self.evaluations += 1;
        source.eval(&self.candidates[start as usize..end as usize], direction)
    }

    fn wants_split(&mut self, index: u32, source: &mut impl Source, how: &Projection) -> bool {
        let cell = self.cells[index as usize];
        let level = u32::from(cell.level);
        if cell.below_horizon || level >= how.max_level {
            return false;
        }
        if level < how.min_level.max(1) {
            return true;
        }
        let values = cell.vertices.map(|v| self.values[v as usize]);
        let (start, end) = cell.candidates;
        let middle = octahedron::centre(self.corners(&cell));
        let candidates = &self.candidates[start as usize..end as usize];
        let hidden = source.hidden_peak(candidates, middle, level as usize);
        let centre = self.eval(index, source, middle);
        self.cells[index as usize].centre = Some(centre);
        let largest = values.iter().fold(centre, |m, &v| m.max(v));
        let smallest = values.iter().fold(centre, |m, &v| m.min(v));
        let mean = (values[0] + values[1] + values[2]) / 3.0;
        let deviation = (centre - mean).max(mean - centre).max_channel();
        let range = (largest - smallest).max_channel() * RANGE_WEIGHT;
        let reference = how.floor + if how.relative { centre.mean() } else { 0.0 };
        deviation.max(range).max(hidden) > how.epsilon * reference
    }

    /// Splits a leaf; returns its first child.
    fn split(&mut self, index: u32, source: &mut impl Source, how: &Projection) -> u32 {
        let cell = self.cells[index as usize];
        let [a, b, c] = cell.vertices;
        let m12 = self.midpoint(index, b, c, source);
        let m20 = self.midpoint(index, c, a, source);
        let m01 = self.midpoint(index, a, b, source);
        let first = self.cells.len() as u32;
        for vertices in [[a, m01, m20], [m01, b, m12], [m20, m12, c], [m12, m20, m01]] {
            self.push_cell(vertices, cell.candidates, cell.level + 1, source, how);
        }
        self.cells[index as usize].first_child = first;
        first
    }

    fn midpoint(&mut self, cell: u32, a: u32, b: u32, source: &mut impl Source) -> u32 {
        let key = (a.min(b), a.max(b));
        if let Some(&vertex) = self.midpoints.get(&key) {
            return vertex;
        }
        let direction = (self.directions[a as usize] + self.directions[b as usize]).normalize();
        let value = self.eval(cell, source, direction);
        let vertex = self.directions.len() as u32;
        self.directions.push(direction);
        self.values.push(value);
        self.midpoints.insert(key, vertex);
        vertex
    }

    pub(super) fn midpoint_of(&self, a: u32, b: u32) -> Option<u32> {
        self.midpoints.get(&(a.min(b), a.max(b))).copied()
    }

    pub(super) fn edges(cell: &Cell) -> [(u32, u32); 3] {
        let [a, b, c] = cell.vertices;
        [(a, b), (b, c), (c, a)]
    }

    /// Splits leaves until no neighbour across an edge is more than one level deeper.
    fn balance(&mut self, source: &mut impl Source, how: &Projection) {
        let mut changed = true;
        while changed {
            changed = false;
            for index in 0..self.cells.len() {
                let cell = self.cells[index];
                if cell.first_child != 0 || cell.below_horizon {
                    continue;
                }
                let too_deep = Self::edges(&cell).into_iter().any(|(a, b)| {
                    self.midpoint_of(a, b).is_some_and(|m| {
                        self.midpoint_of(a, m).is_some() || self.midpoint_of(m, b).is_some()
                    })
                });
                if too_deep {
                    self.split(index as u32, source, how);
                    changed = true;
                }
            }
        }
    }

    fn pack(&self, factor: f32, words: &mut Vec<u32>) -> u64 {
        let largest = self
            .values
            .iter()
            .fold(0.0f32, |m, v| m.max(v.max_channel()))
            * factor;
        // A power of two that brings the largest value near the top of RGB9E5's range.
        let exponent = ((largest.to_bits() >> 23) as i32 - 127 - 15).clamp(-126, 127);
        let scale = if largest > 0.0 {
            f32::from_bits(((exponent + 127) as u32) << 23)
        } else {
            1.0
        };
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
            Part::Split {
                children,
                colours: [a, b, c, m12, m20, m01].map(encoded),
            }
        };
        packed::pack(scale, [0, 1, 2, 3, 4, 5, 6, 7], part, words)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::hash;

    /// A function without candidates.
    pub(in crate::directional) struct Plain<F: Fn(Vec3) -> f32>(pub F);

    impl<F: Fn(Vec3) -> f32> Source for Plain<F> {
        fn eval(&mut self, _: &[u32], direction: Vec3) -> Rgb {
            Rgb::splat((self.0)(direction))
        }
        fn narrow(&self, _: &mut Vec<u32>, _: std::ops::Range<usize>, _: Vec3, _: usize) {}
        fn candidate_count(&self) -> u32 {
            0
        }
        fn hidden_peak(&self, _: &[u32], _: Vec3, _: usize) -> f32 {
            0.0
        }
    }

    fn direction(i: u32) -> Vec3 {
        let z = 2.0 * hash::unit(i, 11) - 1.0;
        let (s, phi) = (
            (1.0 - z * z).sqrt(),
            hash::unit(i, 12) * std::f32::consts::TAU,
        );
        Vec3::new(s * phi.cos(), s * phi.sin(), z)
    }

    pub(in crate::directional) const HOW: Projection = Projection {
        min_level: 2,
        max_level: 6,
        epsilon: 0.1,
        floor: 0.01,
        relative: true,
        horizon: None,
        integral: None,
    };

    #[test]
    fn a_constant_takes_the_minimum_level_only() {
        for min_level in 1..4 {
            let mut words = Vec::new();
            let how = Projection { min_level, ..HOW };
            let cost = Projector::default().project(&mut Plain(|_| 3.0), &how, &mut words);
            assert_eq!(cost.basis_functions, 8 * 4u64.pow(min_level));
            assert!(packed::is_well_formed(&words));
            // Barycentric weights sum to 1 within rounding.
            assert!((packed::evaluate(&words, direction(5)).g - 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_error_falls_with_epsilon_and_costs_cells() {
        let f = |d: Vec3| (d.dot(Vec3::new(0.3, 0.5, 0.8).normalize()).max(0.0)).powi(20);
        let (mut last_error, mut last_cells) = (f64::INFINITY, 0);
        for epsilon in [0.8, 0.4, 0.2, 0.1] {
            let mut words = Vec::new();
            let cost = Projector::default().project(
                &mut Plain(f),
                &Projection { epsilon, ..HOW },
                &mut words,
            );
            let error = (0..4000)
                .map(|i| {
                    f64::from(packed::evaluate(&words, direction(i)).g - f(direction(i))).powi(2)
                })
                .sum::<f64>();
            assert!(
                error < last_error && cost.basis_functions > last_cells,
                "{epsilon}: {error} {last_error}"
            );
            (last_error, last_cells) = (error, cost.basis_functions);
        }
    }

    /// Up to six peaks of any width anywhere, over a constant.
    fn peaks(seed: u32) -> impl Fn(Vec3) -> f32 {
        let random = move |i: u32| hash::unit(seed, 100 + i);
        move |d: Vec3| {
            let peak = |i: u32| {
                let cosine = d.dot(direction(seed * 8 + i)).max(0.0);
                cosine.powf(10f32.powf(4.0 * random(2 * i))) * random(2 * i + 1)
            };
            (0..1 + seed % 6).map(peak).sum::<f32>() + 0.01
        }
    }

    #[test]
    fn neighbours_differ_by_one_level_at_most_and_agree_on_their_edge() {
        // One projector for all, as in a solve.
        let mut projector = Projector::default();
        let mut words = Vec::new();
        let mut deepest = 0;
        for seed in 0..200 {
            let how = Projection {
                min_level: seed % 4,
                horizon: (seed % 3 == 0).then(|| direction(seed)),
                ..HOW
            };
            projector.project(&mut Plain(peaks(seed)), &how, &mut words);
            for cell in projector.leaves() {
                deepest = deepest.max(cell.level);
                for (a, b) in Projector::edges(cell) {
                    let Some(m) = projector.midpoint_of(a, b) else {
                        continue;
                    };
                    assert!(
                        projector.midpoint_of(a, m).is_none()
                            && projector.midpoint_of(m, b).is_none(),
                        "{seed}"
                    );
                    let mean = (projector.values[a as usize] + projector.values[b as usize]) * 0.5;
                    assert_eq!(projector.values[m as usize], mean, "{seed}");
                }
            }
        }
        assert_eq!(deepest, 6);
    }

    #[test]
    fn what_is_packed_is_what_the_cells_hold() {
        let mut projector = Projector::default();
        for seed in 0..60 {
            let mut words = Vec::new();
            let how = Projection {
                min_level: seed % 3,
                horizon: (seed % 2 == 0).then(|| direction(seed)),
                ..HOW
            };
            let cost = projector.project(&mut Plain(peaks(seed)), &how, &mut words);
            assert!(packed::is_well_formed(&words), "{seed}");
            let (leaves, depth) = packed::leaves_and_depth(&words);
            assert_eq!(leaves as u64, cost.basis_functions, "{seed}");
            let deepest = projector.leaves().map(|cell| cell.level).max();
            assert_eq!(deepest, Some(depth as u8), "{seed}");
            let peak = projector.values.iter().fold(0.0f32, |m, v| m.max(v.g));
            for i in 0..500 {
                let d = direction(1000 * seed + i);
                let mut cell = projector.cells[octahedron::octant(d)];
                while cell.first_child != 0 {
                    let corners = projector.corners(&cell);
                    let midpoints = octahedron::edge_midpoints(corners);
                    let child = octahedron::child_of(corners, midpoints, d);
                    cell = projector.cells[cell.first_child as usize + child];
                }
                let values = cell.vertices.map(|v| projector.values[v as usize].g);
                let weights = octahedron::barycentric(projector.corners(&cell), d);
                let held = weights.dot(Vec3::from(values));
                let expected = if cell.below_horizon { 0.0 } else { held };
                let found = packed::evaluate(&words, d).g;
                // Nine bits of mantissa; 31 binary orders below the largest value.
                let rounding = expected / 500.0 + peak * 2f32.powi(-24);
                assert!(
                    (found - expected).abs() <= rounding,
                    "{seed}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn the_adaptive_basis_at_one_level_is_the_uniform_basis() {
        // The plain twin: every cell at level 3, interpolated between exact corner values.
        let f = |d: Vec3| 2.0 + d.x + d.y * d.z;
        let mut words = Vec::new();
        let how = Projection {
            min_level: 3,
            max_level: 3,
            ..HOW
        };
        Projector::default().project(&mut Plain(f), &how, &mut words);
        for i in 0..1000 {
            let d = direction(i);
            let mut corners = octahedron::octant_corners(octahedron::octant(d));
            for _ in 0..3 {
                let m = octahedron::edge_midpoints(corners);
                corners =
                    octahedron::child_corners(corners, m, octahedron::child_of(corners, m, d));
            }
            let expected = octahedron::barycentric(corners, d).dot(Vec3::from(corners.map(f)));
            let found = packed::evaluate(&words, d).r;
            // Nine bits of mantissa.
            assert!(
                (found - expected).abs() <= expected / 512.0,
                "{found} {expected}"
            );
        }
    }
}
