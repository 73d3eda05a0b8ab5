//! Distributions as they are stored in files and read by shaders: one array of 32-bit words.
//!
//! A distribution is a slice of words that starts at an offset (multiple of 1 word):
//!
//! | words | content |
//! |---|---|
//! | 0 | scale, the bits of an f32 power of two; every colour is multiplied by it |
//! | 1..9 | the node words of the eight octants (order of [`octahedron::octant`]) |
//! | … | groups of four node words (children 0..3) and groups of three colours (corners 0..2), mixed |
//!
//! A node word is 0 (black: no light, or below the horizon), or a position `p` relative to the start of the
//! distribution, with [`LEAF`] set when three colours stand at `p` and clear when four node words do.
//! A colour is RGB9E5 (shared exponent, as in `EXT_texture_shared_exponent`).
//! Radiance towards a direction is the linear interpolation of the three colours of the leaf that holds it, with
//! [`octahedron::barycentric`] weights. Corners of neighbouring leaves agree, so the result is continuous.

use super::{cells, octahedron};
use crate::radiometry::Rgb;
use glam::Vec3;

/// Set in a node word whose position is that of three colours.
pub const LEAF: u32 = 0x8000_0000;

/// Radiance [W·sr⁻¹·m⁻²] of the distribution that starts at `words[0]`, towards `direction` (unit, leaving the
/// surface).
pub fn evaluate(words: &[u32], direction: Vec3) -> Rgb {
    let mut node = words[1 + octahedron::octant(direction)];
    let direction = direction.abs();
    let cells = cells::cells();
    let (mut at, mut cell) = (0, &cells[0]);
    let mut deeper;
    while node != 0 {
        let position = (node & !LEAF) as usize;
        if node & LEAF != 0 {
            let weights = cell.barycentric(direction);
            let colour = |corner: usize| decode(words[position + corner]);
            let sum = colour(0) * weights.x + colour(1) * weights.y + colour(2) * weights.z;
            return sum * f32::from_bits(words[0]);
        }
        let child = cell.child_of(direction);
        node = words[position + child];
        at = cells::child(at, child).min(cells.len());
        cell = match cells.get(at) {
            Some(cell) => cell,
            None => {
                deeper = cell.child(child);
                &deeper
            }
        };
    }
    Rgb::BLACK
}

/// Smallest and largest value [mean over channels] that [`evaluate`] can give within `half_angle` [rad] of `axis`.
///
/// Proven for the stored function: it is linear in each leaf, so its extremes stand at corners.
pub fn bounds_in_cone(words: &[u32], axis: Vec3, half_angle: f32) -> (f32, f32) {
    let mut reach = [f32::NEG_INFINITY; octahedron::MAX_LEVEL + 1];
    for (level, cosine) in reach.iter_mut().enumerate() {
        let angle = half_angle + octahedron::radius(level);
        if angle < std::f32::consts::PI {
            *cosine = angle.cos();
        }
    }
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
        if octahedron::centre(corners).dot(axis) < reach[level.min(octahedron::MAX_LEVEL)] {
            continue;
        }
        if node == 0 {
            low = 0.0;
            continue;
        }
        let position = (node & !LEAF) as usize;
        if node & LEAF != 0 {
            for &word in &words[position..position + 3] {
                let value = decode(word).mean();
                low = low.min(value);
                high = high.max(value);
            }
            continue;
        }
        let midpoints = octahedron::edge_midpoints(corners);
        for child in 0..4 {
            let corners = octahedron::child_corners(corners, midpoints, child);
            pending[waiting] = (words[position + child], corners, level + 1);
            waiting += 1;
        }
    }
    let scale = f32::from_bits(words[0]);
    (low.min(high) * scale, high * scale)
}

/// Largest stored value [mean over channels].
pub fn peak(words: &[u32]) -> f32 {
    bounds_in_cone(words, Vec3::Z, std::f32::consts::PI).1
}

/// Number of leaves that hold colours, and the largest depth, of the distribution that starts at `words[0]`.
pub fn leaves_and_depth(words: &[u32]) -> (usize, usize) {
    fn visit(words: &[u32], node: u32, depth: usize) -> (usize, usize) {
        if node == 0 {
            return (0, depth);
        }
        if node & LEAF != 0 {
            return (1, depth);
        }
        let position = node as usize;
        words[position..position + 4]
            .iter()
            .fold((0, depth), |(leaves, deepest), &child| {
                let (l, d) = visit(words, child, depth + 1);
                (leaves + l, deepest.max(d))
            })
    }
    (1..9).fold((0, 0), |(leaves, deepest), octant| {
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
        if depth > MAX_DEPTH || *budget == 0 {
            return false;
        }
        *budget -= 1;
        let position = (node & !LEAF) as usize;
        if node & LEAF != 0 {
            return position >= 9 && position + 3 <= words.len();
        }
        position >= 9
            && position + 4 <= words.len()
            && words[position..position + 4]
                .iter()
                .all(|&child| visit(words, child, depth + 1, budget))
    }
    let mut budget = words.len();
    words.len() >= 9
        && f32::from_bits(words[0]).is_finite()
        && (1..9).all(|octant| visit(words, words[octant], 0, &mut budget))
}

const MANTISSA_BITS: i32 = 9;
const EXPONENT_BIAS: i32 = 15;
/// Largest value of a channel that RGB9E5 holds: 511/512 · 2¹⁶.
pub const LARGEST: f32 = 65408.0;

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
