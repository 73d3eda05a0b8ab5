//! Distributions as they are stored in files and read by shaders: one array of 32-bit words.
//!
//! A distribution is a slice of words that starts at an offset (multiple of 1 word):
//!
//! | words | content |
//! |---|---|
//! | 0 | scale, the bits of an f32 power of two; every colour is multiplied by it; negative: [`uniform`] has what follows |
//! | 1..9 | the node words of the eight octants (order of [`octahedron::octant`]) |
//! | … | groups, one for each node that is split |
//!
//! A node word is 0 (black: no light, or below the horizon), or that of a node that is split into four children. Bit
//! 28 + i: child i is a leaf that holds light; bit 24 + i: child i is split itself; neither: it is black. The bits
//! below are the position of its group relative to the start of the distribution: first the node words of the children
//! that are split, in their order; then, if any child is a leaf, six colours: those at the node's corners 0..2 and at
//! the midpoints of the edges opposite to them, which four leaves share.
//! A colour is RGB9E5 (shared exponent, as in `EXT_texture_shared_exponent`).
//! Radiance towards a direction is the linear interpolation of the three colours of the leaf that holds it, with
//! [`octahedron::barycentric`] weights. Corners of neighbouring leaves agree, so the result is continuous.

use super::{cells, octahedron, uniform};
use crate::radiometry::Rgb;
use glam::Vec3;

/// Words before the groups: scale and octants.
const HEAD: usize = 9;
/// Colours of a group.
const COLOURS: usize = 6;
/// Which of a group's colours stand at the corners of each child.
pub const CORNERS: [[usize; 3]; 4] = [[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]];
/// Bits of a node word that are a position.
const POSITION: u32 = 0x00ff_ffff;

/// A node word, taken apart.
#[derive(Clone, Copy)]
pub(super) struct Node(pub(super) u32);

/// A child of a node.
#[derive(Clone, Copy)]
pub(super) enum Child {
    Black,
    /// Its three colours stand at [`CORNERS`] after this position.
    Leaf(usize),
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

    /// Where the colours of its group start.
    fn colours(self) -> usize {
        self.position() + self.split_mask().count_ones() as usize
    }

    /// Words of its group.
    fn size(self) -> usize {
        let colours = if self.leaf_mask() != 0 { COLOURS } else { 0 };
        self.split_mask().count_ones() as usize + colours
    }

    pub(super) fn child(self, child: usize) -> Child {
        if self.leaf_mask() >> child & 1 != 0 {
            Child::Leaf(self.colours())
        } else if self.split_mask() >> child & 1 != 0 {
            let before = self.split_mask() & ((1 << child) - 1);
            Child::Split(self.position() + before.count_ones() as usize)
        } else {
            Child::Black
        }
    }
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
        colours: [u32; COLOURS],
    },
}

/// Appends to `words` the distribution that consists of `octants`, which are black or split; `part` takes each part
/// apart. Returns the number of leaves that hold light: the others are left out.
pub fn pack<T>(
    scale: f32,
    octants: [T; 8],
    mut part: impl FnMut(T) -> Part<T>,
    words: &mut Vec<u32>,
) -> u64 {
    let start = words.len();
    words.push(scale.to_bits());
    words.extend([0; 8]);
    let mut leaves = 0;
    // A split part, position of its node word relative to the start.
    let mut pending = Vec::new();
    for (octant, slot) in octants.into_iter().zip(1..HEAD).rev() {
        if let Part::Split { children, colours } = part(octant) {
            pending.push((children, colours, slot));
        }
    }
    while let Some((children, colours, slot)) = pending.pop() {
        let position = words.len() - start;
        let (mut node, mut split) = (position as u32 & POSITION, 0);
        let first = pending.len();
        for (child, inner) in children.into_iter().enumerate() {
            match part(inner) {
                Part::Black => {}
                Part::Leaf => {
                    if CORNERS[child].iter().any(|&corner| colours[corner] != 0) {
                        node |= 1 << (28 + child);
                        leaves += 1;
                    }
                }
                Part::Split { children, colours } => {
                    node |= 1 << (24 + child);
                    pending.push((children, colours, position + split));
                    split += 1;
                }
            }
        }
        pending[first..].reverse();
        let node = Node(node);
        if node.size() == 0 {
            continue;
        }
        words[start + slot] = node.0;
        words.extend(std::iter::repeat_n(0, split));
        if node.leaf_mask() != 0 {
            words.extend(colours);
        }
    }
    leaves
}

/// Radiance [W·sr⁻¹·m⁻²] of the distribution that starts at `words[0]`, towards `direction` (unit, leaving the
/// surface).
pub fn evaluate(words: &[u32], direction: Vec3) -> Rgb {
    if uniform::is_uniform(words) {
        return uniform::evaluate(words, direction);
    }
    let mut node = words[1 + octahedron::octant(direction)];
    let direction = direction.abs();
    let cells = cells::cells();
    let (mut at, mut cell) = (0, &cells[0]);
    let mut deeper;
    while node != 0 {
        let child = cell.child_of(direction);
        at = cells::child(at, child).min(cells.len());
        cell = match cells.get(at) {
            Some(cell) => cell,
            None => {
                deeper = cell.child(child);
                &deeper
            }
        };
        node = match Node(node).child(child) {
            Child::Black => 0,
            Child::Split(position) => words[position],
            Child::Leaf(position) => {
                let weights = cell.barycentric(direction);
                let colour = |corner: usize| decode(words[position + CORNERS[child][corner]]);
                let sum = colour(0) * weights.x + colour(1) * weights.y + colour(2) * weights.z;
                return sum * f32::from_bits(words[0]);
            }
        };
    }
    Rgb::BLACK
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
    // Depth first: three waiting siblings a level, and the octants.
    let mut pending = [(0, [Vec3::ZERO; 3], 0); 8 + 3 * MAX_DEPTH];
    for (octant, slot) in pending[..8].iter_mut().enumerate() {
        *slot = (words[1 + octant], octahedron::octant_corners(octant), 0);
    }
    let mut waiting = 8;
    while waiting > 0 {
        waiting -= 1;
        let (node, corners, level) = pending[waiting];
        if is_outside(corners, level) {
            continue;
        }
        if node == 0 {
            low = 0.0;
            continue;
        }
        let midpoints = octahedron::edge_midpoints(corners);
        for (child, at) in CORNERS.iter().enumerate() {
            let inner = octahedron::child_corners(corners, midpoints, child);
            match Node(node).child(child) {
                Child::Split(position) => {
                    pending[waiting] = (words[position], inner, level + 1);
                    waiting += 1;
                }
                _ if is_outside(inner, level + 1) => {}
                Child::Black => low = 0.0,
                Child::Leaf(position) => {
                    for corner in at {
                        let value = decode(words[position + corner]).mean();
                        low = low.min(value);
                        high = high.max(value);
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
                Child::Leaf(_) => (1, depth + 1),
                Child::Split(position) => visit(words, words[position], depth + 1),
            };
            sum = (sum.0 + leaves, sum.1.max(deepest));
        }
        sum
    }
    (1..HEAD).fold((0, 0), |(leaves, deepest), octant| {
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
        if depth >= MAX_DEPTH || size == 0 || size > *budget || !masks_agree {
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
        && (1..HEAD).all(|octant| visit(words, words[octant], 0, &mut budget))
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
