//! Counter-based numbers: the same for any order of evaluation and any number of threads.

/// A well-mixed 32-bit hash of two words (PCG output permutation over a combined state).
pub fn mix(a: u32, b: u32) -> u32 {
    let state = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b).rotate_left(13);
    let state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A hash of where a point is.
pub fn of_point(point: glam::Vec3) -> u32 {
    let [x, y, z] = point.to_array().map(f32::to_bits);
    mix(mix(x, y), z)
}

/// A number in [0, 1) from two words.
pub fn unit(a: u32, b: u32) -> f32 {
    (mix(a, b) >> 8) as f32 * (1.0 / 16_777_216.0)
}
