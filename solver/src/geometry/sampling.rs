//! Points that fill a square evenly, and directions made from them.

use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Point `index` of a sequence that fills the unit square evenly: multiples of powers of an irrational number (Roberts
/// 2018, "The unreasonable effectiveness of quasirandom sequences").
pub fn spread(index: u32) -> Vec2 {
    // The inverse of the plastic number, and its square.
    let along = |step: f64| (0.5 + step * f64::from(index)).fract() as f32;
    Vec2::new(along(0.754_877_666_246_693), along(0.569_840_290_998_053))
}

/// The same in five dimensions.
pub fn spread5(index: u32) -> [f32; 5] {
    // Inverse powers of the root of x⁶ = x + 1.
    const STEPS: [f64; 5] = [
        0.881_271_461_633_570,
        0.776_639_389_089_768,
        0.684_430_129_585_343,
        0.603_168_740_685_728,
        0.531_555_397_715_791,
    ];
    STEPS.map(|step| (0.5 + step * f64::from(index)).fract() as f32)
}

/// The direction about a unit `normal` that belongs to a point of the unit square: evenly spread points make
/// directions with a density of cosine over π.
pub fn cosine_direction(normal: Vec3, at: Vec2) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sine, cosine) = (TAU * at.y).sin_cos();
    let radius = at.x.sqrt();
    tangent * (radius * cosine) + bitangent * (radius * sine) + normal * (1.0 - at.x).sqrt()
}

/// The direction that belongs to a point of the unit square; areas are solid angles over 4π.
pub fn sphere_direction(at: Vec2) -> Vec3 {
    let z = at.y * 2.0 - 1.0;
    let (sine, cosine) = (TAU * at.x).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cosine, radius * sine, z)
}

/// The direction at an angle with this sine and cosine from unit `axis`, a share `turn` of a turn about it.
pub fn about(axis: Vec3, (sine, cosine): (f32, f32), turn: f32) -> Vec3 {
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    let (y, x) = (TAU * turn).sin_cos();
    (tangent * x + bitangent * y) * sine + axis * cosine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_weighted_by_the_cosine() {
        let normal = Vec3::new(0.36, -0.48, 0.8);
        let count = 4096;
        let mean = |f: &dyn Fn(Vec3) -> f32| {
            let values = (0..count).map(|i| f(cosine_direction(normal, spread(i))));
            values.sum::<f32>() / count as f32
        };
        // ∫ cos²/π = 2/3 and ∫ cos³/π = 1/2 over the hemisphere; nothing to one side.
        assert!((mean(&|d| d.dot(normal)) - 2.0 / 3.0).abs() < 1e-3);
        assert!((mean(&|d| d.dot(normal).powi(2)) - 0.5).abs() < 1e-3);
        assert!(mean(&|d| d.dot(normal.any_orthonormal_vector())).abs() < 1e-3);
        assert!(mean(&|d| (d.length() - 1.0).abs()) < 1e-5);
    }
}
