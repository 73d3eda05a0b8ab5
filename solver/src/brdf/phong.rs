//! Normalised modified Phong, f = (n+2)/2π cosⁿα (Lafortune & Willems 1994).

use super::fast;
use std::f32::consts::TAU;

/// The exponent whose lobe is as wide as one of this Ward `roughness`: a Gaussian of the angle from the mirror direction
/// matched to one of the half angle.
pub(super) fn exponent_of_width(roughness: f32) -> f32 {
    0.5 / (roughness * roughness)
}

/// Value for the cosine of the angle to the mirror direction [sr⁻¹].
pub(super) fn eval(exponent: f32, mirror_dot: f32) -> f32 {
    (exponent + 2.0) / TAU * power(exponent, mirror_dot)
}

/// cosⁿα, zero below the horizon of the lobe; without a branch, so that loops over samples become vector code.
#[inline]
pub(super) fn power(exponent: f32, mirror_dot: f32) -> f32 {
    let power = fast::exp2(exponent * fast::log2(mirror_dot.clamp(f32::MIN_POSITIVE, 1.0)));
    if mirror_dot > 0.0 { power } else { 0.0 }
}

/// Sine and cosine of the angle to the mirror direction that belongs to `at` in [0, 1): density (n+1)/2π cosⁿα.
pub(super) fn sample_angle(exponent: f32, at: f32) -> (f32, f32) {
    let log = (1.0 - at).ln() / (exponent + 1.0);
    // 1 - cos²α without cancellation.
    ((-(2.0 * log).exp_m1()).max(0.0).sqrt(), log.exp())
}

/// Density of [`sample_angle`] for the cosine of the angle to the mirror direction [sr⁻¹].
pub(super) fn density(exponent: f32, mirror_dot: f32) -> f32 {
    (exponent + 1.0) / TAU * power(exponent, mirror_dot)
}

/// Cosine of the angle at which the lobe has `share` of its peak; at most a right angle.
pub(super) fn cosine_of(exponent: f32, share: f32) -> f32 {
    if exponent <= 0.0 {
        return 0.0;
    }
    (share.ln() / exponent).exp()
}

/// Directional albedo: ∫ f cos θo dωo, by stratified sampling of the lobe with density (n+1)/2π cosⁿα.
pub(super) fn albedo(exponent: f32, cosine: f32) -> f32 {
    const SIDE: usize = 64;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let mut sum = 0.0f64;
    for i in 0..SIDE {
        let u = (i as f32 + 0.5) / SIDE as f32;
        let cos_alpha = u.powf(1.0 / (exponent + 1.0));
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        for j in 0..SIDE {
            let phi = (j as f32 + 0.5) / SIDE as f32 * TAU;
            // Height above the surface of a direction at angle α, φ about a mirror direction of height `cosine`.
            sum += f64::from((cosine * cos_alpha + sine * sin_alpha * phi.cos()).max(0.0));
        }
    }
    (sum / (SIDE * SIDE) as f64) as f32 * (exponent + 2.0) / (exponent + 1.0)
}
