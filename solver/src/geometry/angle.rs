//! The angle between two vectors, by arithmetic alone: it takes most of the time of a form factor, and is the same on
//! every machine.

use std::f32::consts::{FRAC_PI_2, PI};

/// (atan √s - √s) / s^(3/2) for s in 0..1, its coefficients from the lowest power: the polynomial whose largest relative
/// error of the arc tangent is least, 1.7e-8 before rounding.
const ARC_TANGENT: [f32; 8] = [
    -0.333_331_53,
    0.199_937_73,
    -0.142_110_56,
    0.106_660_03,
    -0.075_522_1,
    0.043_211_814,
    -0.016_367_9,
    0.002_920_684_6,
];

/// Angle [rad], 0 to π, whose sine and cosine have this ratio: `sine.atan2(cosine)` for a sine above zero, to three units
/// in the last place.
#[inline]
pub(super) fn angle(sine: f32, cosine: f32) -> f32 {
    let across = cosine.abs();
    let is_steep = sine > across;
    let ratio = if is_steep {
        across / sine
    } else {
        sine / across
    };
    let squared = ratio * ratio;
    let rest = ARC_TANGENT
        .iter()
        .rev()
        .fold(0.0, |sum, &coefficient| sum * squared + coefficient);
    let folded = ratio + ratio * squared * rest;
    let upright = if is_steep { FRAC_PI_2 - folded } else { folded };
    if cosine < 0.0 { PI - upright } else { upright }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts;

    #[test]
    fn it_is_the_angle_of_the_library() {
        let mut largest = 0.0f64;
        for i in 0..200_000u32 {
            // From 1e-7 to nearly π, of vectors of any length.
            let exact = 10f64.powf(-7.0 + 7.0 * f64::from(i) / 200_000.0) * consts::PI;
            let length = 10f64.powi(i as i32 % 13 - 6);
            let (sine, cosine) = exact.sin_cos();
            let (sine, cosine) = ((length * sine) as f32, (length * cosine) as f32);
            let exact = f64::from(sine).atan2(f64::from(cosine));
            largest = largest.max((f64::from(angle(sine, cosine)) - exact).abs() / exact);
        }
        assert!(largest < 3.0 * f64::from(f32::EPSILON), "{largest:e}");
        for (sine, cosine, exact) in [(1.0, 0.0, FRAC_PI_2), (0.0, 1.0, 0.0), (0.0, -1.0, PI)] {
            assert_eq!(angle(sine, cosine), exact);
        }
    }
}
