//! Top-down projection on the adaptive, balanced octahedral basis (§4.2).
//!
//! A cell is split while the function deviates over it by more than ε of its centre value; the result is packed for
//! files and shaders. The paper compares the samples' range, because its display is piecewise constant while it
//! solves; ours is linear in solving and display, so what counts is how far the centre is from the corners' mean, and
//! the range only where it hides a fold. Neighbouring cells differ by at most one level, and a corner that hangs in the middle of a
//! larger neighbour's edge takes the mean of that edge's ends: linear interpolation is continuous. What the corners
//! hold in the end is `fit`'s.
//! Cost: one evaluation of the function per corner and per centre of a cell, and one where a peak may hide in it.

use super::octahedron;
use super::tree::{AXES, Tree};
use super::uniform;
use crate::radiometry::Rgb;
use glam::Vec3;

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

    /// A peak that may hide in the cell around `_centre` with these candidates, between its corners and its centre: cells
    /// much larger than the sharpest feature are split while it matters. `None` when none can be higher than `_least`
    /// [largest channel], and for sources that know of none.
    fn hidden_peak(
        &self,
        _candidates: &[u32],
        _centre: Vec3,
        _level: usize,
        _least: f32,
    ) -> Option<Peak> {
        None
    }
}

/// A peak that a source knows of.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Where it is, unit.
    pub direction: Vec3,
    /// The function is at least this high there [largest channel].
    pub height: f32,
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
    /// What it is projected on.
    pub basis: Basis,
}

/// A basis over directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// The octahedron, subdivided where the function varies (§4.2).
    #[default]
    Haar,
    /// The tetrahedron, subdivided evenly to the deepest level (§4.1).
    Uniform,
}

/// What a projection cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionCost {
    /// Leaf cells that hold light: basis functions.
    pub basis_functions: u64,
    /// Evaluations of the source.
    pub evaluations: u64,
}

/// A range of samples counts this much against a deviation from the linear: of an S-shaped flank the centre shows
/// nothing.
const RANGE_WEIGHT: f32 = 0.15;

/// Scratch memory of projections; one per thread.
#[derive(Default)]
pub struct Projector {
    pub(super) tree: Tree,
    /// What its values still have to be multiplied with.
    pub(super) factor: f32,
    /// Candidates of each cell, as a range of the list below.
    candidates_of: Vec<(u32, u32)>,
    candidates: Vec<u32>,
    /// The source in the middle of each cell, where that was evaluated.
    pub(super) centres: Vec<Option<Rgb>>,
    evaluations: u64,
    /// On the uniform basis: the packed distribution.
    pub(super) even: Vec<u32>,
}

impl Projector {
    /// Projects `source` and appends the packed distribution to `words`.
    pub fn project(
        &mut self,
        source: &mut impl Source,
        how: &Projection,
        words: &mut Vec<u32>,
    ) -> ProjectionCost {
        let evaluations = self.project_only(source, how);
        ProjectionCost {
            basis_functions: self.pack(words),
            evaluations,
        }
    }

    /// Appends what was projected last to `words`; returns the number of basis functions.
    pub(crate) fn pack(&self, words: &mut Vec<u32>) -> u64 {
        if !self.even.is_empty() {
            words.extend_from_slice(&self.even);
            return self.basis_functions();
        }
        self.tree.pack(self.factor, words)
    }

    /// The number of basis functions of what was projected last.
    pub(crate) fn basis_functions(&self) -> u64 {
        if !self.even.is_empty() {
            return uniform::vertex_count(self.even[1]) as u64;
        }
        let is_lit = |vertex: u32| !self.tree.values[vertex as usize].is_black();
        let leaves = self.tree.leaves();
        leaves
            .filter(|(_, cell)| cell.vertices.into_iter().any(is_lit))
            .count() as u64
    }

    /// The same as [`Self::project`], but nothing is packed; returns the evaluations.
    pub(crate) fn project_only(&mut self, source: &mut impl Source, how: &Projection) -> u64 {
        self.even.clear();
        if how.basis == Basis::Uniform {
            return uniform::project(source, how, &mut self.even);
        }
        self.reset(source, how);
        let mut pending: Vec<u32> = (0..8).rev().collect();
        while let Some(cell) = pending.pop() {
            if self.wants_split(cell, source, how) {
                let first = self.split(cell, source);
                pending.extend((first..first + 4).rev());
            }
        }
        self.balance(source);
        self.factor = self.fit(how);
        self.evaluations
    }

    fn reset(&mut self, source: &mut impl Source, how: &Projection) {
        self.tree.clear(how.horizon);
        self.candidates.clear();
        self.candidates.extend(0..source.candidate_count());
        self.tree.values.clear();
        let values = AXES.map(|axis| source.eval(&self.candidates, axis));
        self.tree.values.extend(values);
        self.evaluations = AXES.len() as u64;
        self.candidates_of.clear();
        self.centres.clear();
        let all = (0, self.candidates.len() as u32);
        self.narrow_new(all, source);
    }

    /// Finds the candidates of cells that have none yet, among those of what they are part of.
    fn narrow_new(&mut self, (start, end): (u32, u32), source: &impl Source) {
        for index in self.candidates_of.len()..self.tree.cells.len() {
            let cell = &self.tree.cells[index];
            let first = self.candidates.len();
            if !cell.below_horizon {
                let range = start as usize..end as usize;
                let centre = octahedron::centre(self.tree.corners(cell));
                source.narrow(&mut self.candidates, range, centre, usize::from(cell.level));
            }
            let range = (first as u32, self.candidates.len() as u32);
            self.candidates_of.push(range);
            self.centres.push(None);
        }
    }

    fn wants_split(&mut self, index: u32, source: &mut impl Source, how: &Projection) -> bool {
        let cell = self.tree.cells[index as usize];
        let level = u32::from(cell.level);
        if cell.below_horizon || level >= how.max_level {
            return false;
        }
        if level < how.min_level.max(1) {
            return true;
        }
        let values = cell.vertices.map(|v| self.tree.values[v as usize]);
        let (start, end) = self.candidates_of[index as usize];
        let middle = octahedron::centre(self.tree.corners(&cell));
        let candidates = &self.candidates[start as usize..end as usize];
        let centre = source.eval(candidates, middle);
        self.evaluations += 1;
        self.centres[index as usize] = Some(centre);
        let largest = values.iter().fold(centre, |m, &v| m.max(v));
        let smallest = values.iter().fold(centre, |m, &v| m.min(v));
        let mean = (values[0] + values[1] + values[2]) / 3.0;
        let deviation = (centre - mean).max(mean - centre).max_channel();
        let range = (largest - smallest).max_channel() * RANGE_WEIGHT;
        let reference = how.floor + if how.relative { centre.mean() } else { 0.0 };
        let most = how.epsilon * reference;
        if deviation.max(range) > most {
            return true;
        }
        let Some(peak) = source.hidden_peak(candidates, middle, level as usize, most) else {
            return false;
        };
        if peak.height > most {
            return true;
        }
        self.evaluations += 1;
        (source.eval(candidates, peak.direction) - mean).max_channel() > most
    }

    /// Splits a leaf; returns its first child.
    fn split(&mut self, index: u32, source: &mut impl Source) -> u32 {
        let (start, end) = self.candidates_of[index as usize];
        let candidates = &self.candidates[start as usize..end as usize];
        let evaluations = &mut self.evaluations;
        let first = self.tree.split(index, |direction, _| {
            *evaluations += 1;
            source.eval(candidates, direction)
        });
        self.narrow_new((start, end), source);
        first
    }

    /// Splits leaves until no neighbour across an edge is more than one level deeper.
    fn balance(&mut self, source: &mut impl Source) {
        let mut changed = true;
        while changed {
            changed = false;
            for index in 0..self.tree.cells.len() {
                let cell = self.tree.cells[index];
                let is_stored_leaf = cell.first_child == 0 && !cell.below_horizon;
                if is_stored_leaf && self.tree.has_deep_edge(&cell) {
                    self.split(index as u32, source);
                    changed = true;
                }
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::directional::packed;
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
        basis: Basis::Haar,
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
            for (_, cell) in projector.tree.leaves() {
                deepest = deepest.max(cell.level);
                for (a, b) in Tree::edges(cell) {
                    let Some(m) = projector.tree.midpoint_of(a, b) else {
                        continue;
                    };
                    assert!(
                        projector.tree.midpoint_of(a, m).is_none()
                            && projector.tree.midpoint_of(m, b).is_none(),
                        "{seed}"
                    );
                    let mean = (projector.tree.values[a as usize]
                        + projector.tree.values[b as usize])
                        * 0.5;
                    assert_eq!(projector.tree.values[m as usize], mean, "{seed}");
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
            let deepest = projector.tree.leaves().map(|(_, cell)| cell.level).max();
            assert_eq!(deepest, Some(depth as u8), "{seed}");
            let peak = projector.tree.values.iter().fold(0.0f32, |m, v| m.max(v.g));
            for i in 0..500 {
                let d = direction(1000 * seed + i);
                let mut cell = projector.tree.cells[octahedron::octant(d)];
                while cell.first_child != 0 {
                    let corners = projector.tree.corners(&cell);
                    let midpoints = octahedron::edge_midpoints(corners);
                    let child = octahedron::child_of(corners, midpoints, d);
                    cell = projector.tree.cells[cell.first_child as usize + child];
                }
                let values = cell.vertices.map(|v| projector.tree.values[v as usize].g);
                let weights = octahedron::barycentric(projector.tree.corners(&cell), d);
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
