//! Sums of distributions: cells are split wherever those of a summand are. Radiance clustering adds each reflection to
//! what a leaf has reflected already (§2.2); a sum of samples that is projected once needs none of this (§3.3).
//!
//! A linear function over a cell stays what it is over the cell's parts, but for the curvature of the sphere: an
//! eighth of the cell's width squared, at most 2 % for the largest.

use super::haar::Projector;
use super::packed::{self, CORNERS, Child, Node};
use super::tree::Tree;
use super::uniform;
use crate::radiometry::Rgb;
use glam::Vec3;

/// Adds up distributions; scratch memory, one per thread.
#[derive(Default)]
pub struct Sum {
    tree: Tree,
    /// The summand at each vertex.
    added: Vec<Rgb>,
    /// On the uniform basis: values at its vertices.
    even: Vec<Rgb>,
}

/// Part of a summand.
#[derive(Clone, Copy)]
enum Part<T> {
    Black,
    /// Linear between values at its corners.
    Leaf([Rgb; 3]),
    Split(T),
}

impl Sum {
    /// Back to no light. The horizon is that of all summands, and so is the basis.
    pub fn clear(&mut self, horizon: Option<Vec3>) {
        self.tree.clear(horizon);
        self.even.clear();
    }

    /// Adds what `projector` projected last.
    pub(crate) fn add(&mut self, projector: &Projector) {
        if !projector.even.is_empty() {
            return uniform::add(&mut self.even, &projector.even, Rgb::WHITE);
        }
        let tree = &projector.tree;
        let part = |index: u32| {
            let cell = &tree.cells[index as usize];
            if cell.first_child != 0 {
                Part::Split(cell.first_child)
            } else if cell.below_horizon {
                Part::Black
            } else {
                let value = |v: u32| tree.values[v as usize] * projector.factor;
                Part::Leaf(cell.vertices.map(value))
            }
        };
        let children = |first: u32| [0, 1, 2, 3].map(|child| part(first + child));
        self.add_parts([0, 1, 2, 3, 4, 5, 6, 7].map(part), children);
    }

    /// Adds the packed distribution `words`, times `factor`.
    pub fn add_packed(&mut self, words: &[u32], factor: Rgb) {
        if uniform::is_uniform(words) {
            return uniform::add(&mut self.even, words, factor);
        }
        let factor = factor * f32::from_bits(words[0]);
        let value = |word: u32| packed::decode(word) * factor;
        let of_word = |word: u32, corners: [Rgb; 3]| match word {
            0 => Part::Black,
            word => Part::Split((word, corners)),
        };
        let children = |(word, corners): (u32, [Rgb; 3])| {
            let node = Node(word);
            let values = node.with_midpoints(words, corners, value);
            [0, 1, 2, 3].map(|child| {
                let corners = || CORNERS[child].map(|corner| values[corner]);
                match node.child(child) {
                    Child::Black => Part::Black,
                    Child::Split(at) => of_word(words[at], corners()),
                    Child::Leaf => Part::Leaf(corners()),
                }
            })
        };
        let octants = [0, 1, 2, 3, 4, 5, 6, 7].map(|octant| {
            let corners = packed::axes_of(octant).map(|axis| value(words[axis]));
            of_word(words[1 + octant], corners)
        });
        self.add_parts(octants, children);
    }

    /// Appends the sum to `words`; returns the number of basis functions.
    pub fn pack(&self, words: &mut Vec<u32>) -> u64 {
        if !self.even.is_empty() {
            return uniform::pack(&self.even, words);
        }
        self.tree.pack(1.0, words)
    }

    fn add_parts<T: Copy>(&mut self, octants: [Part<T>; 8], children: impl Fn(T) -> [Part<T>; 4]) {
        let tree = &mut self.tree;
        self.added.clear();
        self.added.resize(tree.values.len(), Rgb::BLACK);
        let mut pending: Vec<(u32, Part<T>)> = (0..).zip(octants).collect();
        while let Some((index, part)) = pending.pop() {
            let cell = tree.cells[index as usize];
            let parts = match part {
                Part::Black => continue,
                Part::Leaf(values) if cell.first_child == 0 => {
                    for (vertex, value) in cell.vertices.into_iter().zip(values) {
                        self.added[vertex as usize] = value;
                    }
                    continue;
                }
                Part::Leaf([a, b, c]) => {
                    let [m12, m20, m01] = [(b + c) * 0.5, (c + a) * 0.5, (a + b) * 0.5];
                    [[a, m01, m20], [m01, b, m12], [m20, m12, c], [m12, m20, m01]].map(Part::Leaf)
                }
                Part::Split(inner) => children(inner),
            };
            let mut first = cell.first_child;
            if first == 0 {
                first = tree.split(index, |_, [a, b]| (a + b) * 0.5);
                self.added.resize(tree.values.len(), Rgb::BLACK);
            }
            pending.extend((first..).zip(parts));
        }
        for (value, &added) in tree.values.iter_mut().zip(&self.added) {
            *value += added;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::haar::tests::{HOW, Plain};
    use super::*;
    use crate::directional::Projection;
    use crate::geometry::hash::unit;

    fn direction(i: u32) -> Vec3 {
        let z = 2.0 * unit(i, 3) - 1.0;
        let (sine, cosine) = (unit(i, 4) * std::f32::consts::TAU).sin_cos();
        let out = (1.0 - z * z).sqrt();
        Vec3::new(out * cosine, out * sine, z)
    }

    #[test]
    fn a_sum_is_the_sum_of_its_summands() {
        let normal = direction(77);
        let horizon = Some(normal);
        let how = Projection { horizon, ..HOW };
        let mut projector = Projector::default();
        let (mut sum, mut twin) = (Sum::default(), Sum::default());
        sum.clear(horizon);
        twin.clear(horizon);
        let mut summands = Vec::new();
        for i in 0..24 {
            let (axis, sharpness) = (direction(i), 2f32.powf(8.0 * unit(i, 5)));
            let lobe = |d: Vec3| ((axis.dot(d) - 1.0) * sharpness).exp();
            let mut words = Vec::new();
            projector.project(&mut Plain(lobe), &how, &mut words);
            sum.add(&projector);
            twin.add_packed(&words, Rgb::splat(2.0));
            summands.push(words);
        }
        let (mut words, mut twice) = (Vec::new(), Vec::new());
        sum.pack(&mut words);
        twin.pack(&mut twice);
        assert!(packed::is_well_formed(&words) && packed::is_well_formed(&twice));
        let (_, deepest) = packed::leaves_and_depth(&words);
        let depth = |words: &Vec<u32>| packed::leaves_and_depth(words).1;
        assert_eq!(Some(deepest), summands.iter().map(depth).max());
        let (mut wrong, mut all) = (0.0, 0.0);
        for i in 0..20_000 {
            let d = direction(1000 + i);
            // Below the horizon coarse cells reach further than fine ones.
            let d = d * d.dot(normal).signum();
            let of_summand = |words: &Vec<u32>| packed::evaluate(words, d).g;
            let expected: f32 = summands.iter().map(of_summand).sum();
            let found = packed::evaluate(&words, d).g;
            // Curvature of the sphere, where a summand is coarse.
            assert!(
                (found - expected).abs() <= 0.02 * expected + 1e-3,
                "{d}: {found} {expected}"
            );
            let doubled = packed::evaluate(&twice, d).g;
            assert!(
                (doubled - 2.0 * found).abs() <= 0.01 * doubled + 1e-3,
                "{d}"
            );
            wrong += f64::from(found - expected);
            all += f64::from(expected);
        }
        assert!((wrong / all).abs() < 2e-3, "{}", wrong / all);
    }

    #[test]
    fn parts_of_one_distribution_add_up_to_it() {
        let lobe = |d: Vec3| ((direction(5).dot(d) - 1.0) * 40.0).exp();
        let mut projector = Projector::default();
        let mut words = Vec::new();
        projector.project(&mut Plain(lobe), &HOW, &mut words);
        let mut sum = Sum::default();
        sum.clear(None);
        for _ in 0..4 {
            sum.add_packed(&words, Rgb::splat(0.25));
        }
        let mut back = Vec::new();
        sum.pack(&mut back);
        for i in 0..5000 {
            let [once, again] = [&words, &back].map(|w| packed::evaluate(w, direction(i)).g);
            // Nine bits of mantissa.
            assert!((once - again).abs() <= once / 500.0, "{once} {again}");
        }
    }
}
