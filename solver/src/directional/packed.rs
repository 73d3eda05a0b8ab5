//! Distributions as they are stored in files and read by shaders: one array of 32-bit words.
//!
//! A distribution is a slice of words that starts at an offset (multiple of 1 word):
//!
//! | words | content |
//! |---|---|
//! | 0 | scale, the bits of an f32 power of two; every colour is multiplied by it; negative: [`uniform`] has what follows |
//! | 1..9 | the node words of the eight octants (order of [`octahedron::octant`]) |
//! | 9..15 | the colours towards +x, +y, +z, -x, -y, -z, the corners of the octants |
//! | … | groups, one for each node that is split |
//!
//! A node word is 0 (black: no light, or below the horizon), or that of a node that is split into four children. Bit
//! 28 + i: child i is a leaf that holds light; bit 24 + i: child i is split itself; neither: it is black. Bit 21 + i: the
//! colour at the midpoint of the edge opposite to its corner i is stored; that of others is the mean of the edge's ends.
//! The bits below are the position of its group relative to the start of the distribution: first the node words of the
//! children that are split, then the colours that are stored, each in their order.
//! A colour is RGB9E5 (shared exponent, as in `EXT_texture_shared_exponent`). A cell's corners are corners and midpoints of
//! the one that it is part of, so each colour stands at the place where the way down needs it first.
//! Radiance towards a direction is the linear interpolation of the three colours of the leaf that holds it, with
//! [`octahedron::barycentric`] weights. Corners of neighbouring leaves agree, so the result is continuous.

use super::{cells, octahedron, uniform};
use crate::radiometry::Rgb;
use glam::Vec3;
use std::ops::{Add, Mul};

/// Words before the groups: scale, octants, and colours towards the axes.
const HEAD: usize = COLOURS + 6;
/// Where the colours towards the axes start.
const COLOURS: usize = 9;
/// Which of a node's colours, at its corners and at the midpoints opposite to them, stand at the corners of each child.
pub(super) const CORNERS: [[usize; 3]; 4] = [[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]];
/// Bits of a node word that are a position: half as many words again as a hemisphere takes that is split everywhere to
/// the deepest level.
const POSITION: u32 = 0x001f_ffff;

/// A node word, taken apart.
#[derive(Clone, Copy)]
pub(super) struct Node(pub(super) u32);

/// A child of a node.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Black,
    Leaf,
    /// Its node word stands at this position.
    Split(usize),
}

impl Node {
    fn split_mask(self) -> u32 {
        self.0 >> 24 & 15
    }

    fn leaf_mask(self) -> u32 {
        self.0 >> 28
    }

    /// Where its group starts.
    fn position(self) -> usize {
        (self.0 & POSITION) as usize
    }

    fn stored_mask(self) -> u32 {
        self.0 >> 21 & 7
    }

    /// Where the colours of its group start.
    fn colours(self) -> usize {
        self.position() + self.split_mask().count_ones() as usize
    }

    /// Words of its group.
    fn size(self) -> usize {
        (self.split_mask().count_ones() + self.stored_mask().count_ones()) as usize
    }

    /// Where the colour at a midpoint stands, if it is stored.
    fn stored(self, midpoint: usize) -> Option<usize> {
        let before = self.stored_mask() & ((1 << midpoint) - 1);
        let is_stored = self.stored_mask() >> midpoint & 1 != 0;
        is_stored.then(|| self.colours() + before.count_ones() as usize)
    }

    /// What stands at its corners and midpoints, from what stands at the corners; `value`: of a colour in `words`.
    pub(super) fn with_midpoints<T>(
        self,
        words: &[u32],
        corners: [T; 3],
        value: impl Fn(u32) -> T,
    ) -> [T; 6]
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        let [a, b, c] = corners;
        let midpoint = |midpoint: usize, a: T, b: T| match self.stored(midpoint) {
            Some(position) => value(words[position]),
            None => (a + b) * 0.5,
        };
        [
            a,
            b,
            c,
            midpoint(0, b, c),
            midpoint(1, c, a),
            midpoint(2, a, b),
        ]
    }

    pub(super) fn child(self, child: usize) -> Child {
        if self.leaf_mask() >> child & 1 != 0 {
            Child::Leaf
        } else if self.split_mask() >> child & 1 != 0 {
            let before = self.split_mask() & ((1 << child) - 1);
            Child::Split(self.position() + before.count_ones() as usize)
        } else {
            Child::Black
        }
    }
}

/// Where the colours at an octant's corners stand.
pub(super) fn axes_of(octant: usize) -> [usize; 3] {
    [0, 1, 2].map(|axis| COLOURS + axis + 3 * (octant >> axis & 1))
}

/// Part of a tree that is to be packed.
pub enum Part<T> {
    /// Without light.
    Black,
    /// Not split.
    Leaf,
    /// Split into `children`; `colours` stand at its corners and at the midpoints of the edges opposite to them.
    Split {
        /// Children in the order of [`octahedron::child_corners`].
        children: [T; 4],
        /// RGB9E5.
        colours: [u32; 6],
        /// Which of the midpoints have the mean of the ends of their edge.
        is_mean: [bool; 3],
    },
}

/// Appends to `words` the distribution that consists of `octants`, which are black or split, with the colours `axes`
/// between them; `part` takes each part apart. Returns the number of leaves that hold light: the others are left out.
pub fn pack<T>(
    scale: f32,
    axes: [u32; 6],
    octants: [T; 8],
    mut part: impl FnMut(T) -> Part<T>,
    words: &mut Vec<u32>,
) -> u64 {
    let start = words.len();
    words.push(scale.to_bits());
    words.extend([0; 8]);
    words.extend(axes);
    let mut leaves = 0;
    // A split part, position of its node word relative to the start.
    let mut pending = Vec::new();
    for (octant, slot) in octants.into_iter().zip(1..COLOURS).rev() {
        if let split @ Part::Split { .. } = part(octant) {
            pending.push((split, slot));
        }
    }
    while let Some((
        Part::Split {
            children,
            colours,
            is_mean,
        },
        slot,
    )) = pending.pop()
    {
        let position = words.len() - start;
        let (mut node, mut split) = (position as u32 & POSITION, 0);
        let first = pending.len();
        let mut wanted = [false; 6];
        let mut want = |child: usize| {
            for corner in CORNERS[child] {
                wanted[corner] = true;
            }
        };
        for (child, inner) in children.into_iter().enumerate() {
            match part(inner) {
                Part::Black => {}
                Part::Leaf => {
                    if CORNERS[child].iter().any(|&corner| colours[corner] != 0) {
                        node |= 1 << (28 + child);
                        leaves += 1;
                        want(child);
                    }
                }
                inner @ Part::Split { .. } => {
                    node |= 1 << (24 + child);
                    pending.push((inner, position + split));
                    split += 1;
                    want(child);
                }
            }
        }
        if node & !POSITION == 0 {
            continue;
        }
        pending[first..].reverse();
        words.extend(std::iter::repeat_n(0, split));
        for midpoint in 0..3 {
            if wanted[3 + midpoint] && !is_mean[midpoint] {
                node |= 1 << (21 + midpoint);
                words.push(colours[3 + midpoint]);
            }
        }
        words[start + slot] = node;
    }
    leaves
}

/// Radiance [W·sr⁻¹·m⁻²] of the distribution that starts at `words[0]`, towards `direction` (unit, leaving the
/// surface).
pub fn evaluate(words: &[u32], direction: Vec3) -> Rgb {
    if uniform::is_uniform(words) {
        return uniform::evaluate(words, direction);
    }
    let octant = octahedron::octant(direction);
    let mut path = Path {
        words,
        octant,
        nodes: [Node(0); MAX_DEPTH],
        children: [0; MAX_DEPTH],
    };
    let mut node = words[1 + octant];
    let direction = direction.abs();
    let cells = cells::cells();
    let (mut at, mut cell) = (0, &cells[0]);
    let mut deeper;
    for depth in 0..MAX_DEPTH {
        if node == 0 {
            break;
        }
        let child = cell.child_of(direction);
        at = cells::child(at, child).min(cells.len());
        cell = match cells.get(at) {
            Some(cell) => cell,
            None => {
                deeper = cell.child(child);
                &deeper
            }
        };
        (path.nodes[depth], path.children[depth]) = (Node(node), child);
        match Node(node).child(child) {
            Child::Black => break,
            Child::Split(position) => node = words[position],
            Child::Leaf => {
                let [a, b, c] = CORNERS[child].map(|corner| path.colour(depth, corner));
                let weights = cell.barycentric(direction);
                return (a * weights.x + b * weights.y + c * weights.z) * f32::from_bits(words[0]);
            }
        }
    }
    Rgb::BLACK
}

/// The nodes around a leaf.
struct Path<'a> {
    words: &'a [u32],
    octant: usize,
    nodes: [Node; MAX_DEPTH],
    /// Which child of each is the next.
    children: [usize; MAX_DEPTH],
}

impl Path<'_> {
    /// One of the colours at the corners and midpoints of the node at a depth: where the way down needs it first.
    fn colour(&self, mut depth: usize, mut corner: usize) -> Rgb {
        loop {
            let Some(midpoint) = corner.checked_sub(3) else {
                if depth == 0 {
                    return decode(self.words[axes_of(self.octant)[corner]]);
                }
                depth -= 1;
                corner = CORNERS[self.children[depth]][corner];
                continue;
            };
            return match self.nodes[depth].stored(midpoint) {
                Some(position) => decode(self.words[position]),
                None => {
                    let end = |turn: usize| self.colour(depth, (midpoint + turn) % 3);
                    (end(1) + end(2)) * 0.5
                }
            };
        }
    }
}

/// Smallest and largest value [mean over channels] that [`evaluate`] can give within `half_angle` [rad] of `axis`.
///
/// Proven for the stored function: it is linear in each leaf, so its extremes stand at corners.
pub fn bounds_in_cone(words: &[u32], axis: Vec3, half_angle: f32) -> (f32, f32) {
    if uniform::is_uniform(words) {
        return uniform::bounds_in_cone(words, axis, half_angle);
    }
    let mut reach = [f32::NEG_INFINITY; octahedron::MAX_LEVEL + 1];
    for (level, cosine) in reach.iter_mut().enumerate() {
        let angle = half_angle + octahedron::radius(level);
        if angle < std::f32::consts::PI {
            *cosine = angle.cos();
        }
    }
    let is_outside = |corners, level: usize| {
        octahedron::centre(corners).dot(axis) < reach[level.min(octahedron::MAX_LEVEL)]
    };
    let (mut low, mut high) = (f32::INFINITY, 0.0f32);
    let value = |word: u32| decode(word).mean();
    // Depth first: three waiting siblings a level, and the octants.
    let mut pending = [(0, [Vec3::ZERO; 3], [0.0; 3], 0); 8 + 3 * MAX_DEPTH];
    for (octant, slot) in pending[..8].iter_mut().enumerate() {
        let values = axes_of(octant).map(|axis| value(words[axis]));
        *slot = (
            words[1 + octant],
            octahedron::octant_corners(octant),
            values,
            0,
        );
    }
    let mut waiting = 8;
    while waiting > 0 {
        waiting -= 1;
        let (node, corners, values, level) = pending[waiting];
        if is_outside(corners, level) {
            continue;
        }
        if node == 0 {
            low = 0.0;
            continue;
        }
        let midpoints = octahedron::edge_midpoints(corners);
        let values = Node(node).with_midpoints(words, values, value);
        for (child, at) in CORNERS.iter().enumerate() {
            let inner = octahedron::child_corners(corners, midpoints, child);
            match Node(node).child(child) {
                Child::Split(position) => {
                    let values = at.map(|corner| values[corner]);
                    pending[waiting] = (words[position], inner, values, level + 1);
                    waiting += 1;
                }
                _ if is_outside(inner, level + 1) => {}
                Child::Black => low = 0.0,
                Child::Leaf => {
                    for &corner in at {
                        low = low.min(values[corner]);
                        high = high.max(values[corner]);
                    }
                }
            }
        }
    }
    let scale = f32::from_bits(words[0]);
    (low.min(high) * scale, high * scale)
}

/// Largest stored value [mean over channels].
pub fn peak(words: &[u32]) -> f32 {
    if uniform::is_uniform(words) {
        return uniform::peak(words);
    }
    bounds_in_cone(words, Vec3::Z, std::f32::consts::PI).1
}

/// Number of leaves that hold colours, and the largest depth, of the distribution that starts at `words[0]`.
pub fn leaves_and_depth(words: &[u32]) -> (usize, usize) {
    if uniform::is_uniform(words) {
        return uniform::leaves_and_depth(words);
    }
    fn visit(words: &[u32], node: u32, depth: usize) -> (usize, usize) {
        let mut sum = (0, depth);
        for child in 0..4 {
            let (leaves, deepest) = match Node(node).child(child) {
                Child::Black => (0, depth),
                Child::Leaf => (1, depth + 1),
                Child::Split(position) => visit(words, words[position], depth + 1),
            };
            sum = (sum.0 + leaves, sum.1.max(deepest));
        }
        sum
    }
    (1..COLOURS).fold((0, 0), |(leaves, deepest), octant| {
        let (l, d) = visit(words, words[octant], 0);
        (leaves + l, deepest.max(d))
    })
}

/// Deepest subdivision that a distribution may have; a deeper one is damaged.
pub const MAX_DEPTH: usize = 16;

/// True when every position in the distribution `words` lies inside it and no path is deeper than [`MAX_DEPTH`].
pub fn is_well_formed(words: &[u32]) -> bool {
    // Each word is visited once at most in a tree; a cycle or a shared subtree would be visited more often.
    fn visit(words: &[u32], node: u32, depth: usize, budget: &mut usize) -> bool {
        if node == 0 {
            return true;
        }
        let node = Node(node);
        let (first, size) = (node.position(), node.size());
        let masks_agree = node.leaf_mask() & node.split_mask() == 0;
        let is_empty = node.leaf_mask() | node.split_mask() == 0;
        if depth >= MAX_DEPTH || is_empty || size > *budget || !masks_agree {
            return false;
        }
        *budget -= size;
        first >= HEAD
            && first + size <= words.len()
            && words[first..node.colours()]
                .iter()
                .all(|&child| visit(words, child, depth + 1, budget))
    }
    if words.first().is_some_and(|scale| scale >> 31 != 0) {
        return uniform::is_well_formed(words);
    }
    let mut budget = words.len();
    words.len() >= HEAD
        && f32::from_bits(words[0]).is_finite()
        && (1..COLOURS).all(|octant| visit(words, words[octant], 0, &mut budget))
}

const MANTISSA_BITS: i32 = 9;
const EXPONENT_BIAS: i32 = 15;
/// Largest value of a channel that RGB9E5 holds: 511/512 · 2¹⁶.
pub const LARGEST: f32 = 65408.0;

/// A power of two that brings the largest value near the top of RGB9E5's range.
pub(super) fn scale_for(largest: f32) -> f32 {
    let exponent = ((largest.to_bits() >> 23) as i32 - 127 - 15).clamp(-126, 127);
    if largest > 0.0 {
        f32::from_bits(((exponent + 127) as u32) << 23)
    } else {
        1.0
    }
}

/// RGB9E5 of a colour whose channels are within 0..=[`LARGEST`]; others are clamped.
pub fn encode(colour: Rgb) -> u32 {
    let clamp = |c: f32| c.clamp(0.0, LARGEST);
    let (r, g, b) = (clamp(colour.r), clamp(colour.g), clamp(colour.b));
    let largest = r.max(g).max(b);
    if largest == 0.0 {
        return 0;
    }
    // Exponent of the largest channel from its bits: floor(log2), exact.
    let floor_log2 = ((largest.to_bits() >> 23) as i32 - 127).max(-EXPONENT_BIAS - 1);
    let mut exponent = floor_log2 + 1 + EXPONENT_BIAS;
    let step = |e: i32| f32::from_bits(((e - EXPONENT_BIAS - MANTISSA_BITS + 127) as u32) << 23);
    // Casts cut off towards zero: floors of what is not negative.
    if (largest / step(exponent) + 0.5) as i32 == 1 << MANTISSA_BITS {
        exponent += 1;
    }
    let mantissa = |c: f32| ((c / step(exponent) + 0.5) as u32).min(511);
    mantissa(r) | mantissa(g) << 9 | mantissa(b) << 18 | (exponent as u32) << 27
}

/// The colour of an RGB9E5 word.
pub fn decode(word: u32) -> Rgb {
    let exponent = (word >> 27) as i32;
    let step = f32::from_bits(((exponent - EXPONENT_BIAS - MANTISSA_BITS + 127) as u32) << 23);
    let channel = |shift: u32| (word >> shift & 511) as f32 * step;
    Rgb::new(channel(0), channel(9), channel(18))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_within_the_mantissa() {
        for value in [1e-4f32, 0.1, 0.5, 1.0, 1.5, 511.0, 511.9, 60000.0] {
            let colour = Rgb::new(value, value * 0.5, value * 0.25);
            let back = decode(encode(colour));
            // Nine bits of mantissa: half a step is at most 2⁻⁹ of the largest channel; denormals add half a step.
            let bound = value / 512.0 + 2f32.powi(-25);
            assert!(
                (back.r - colour.r).abs() <= bound && (back.b - colour.b).abs() <= bound,
                "{value}: {back:?}"
            );
        }
    }
}
