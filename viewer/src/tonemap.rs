//! From radiance to display colours, and the exposure that an image gets when nobody asks for one.

use sheen_solver::Rgb;

/// The percentile of luminance that the default exposure maps to [`TARGET`]: lamps are brighter and do not count.
const PERCENTILE: f64 = 95.0;
/// Linear display value of that percentile.
const TARGET: f64 = 0.8;

/// sRGB encoding of a linear value, clamped to 0..1.
pub fn srgb(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Linear value of an sRGB-encoded one.
pub fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Display bytes of `pixels`, three a pixel.
pub fn display_bytes(pixels: &[Rgb], exposure: f64) -> Vec<u8> {
    let byte = |value: f32| (srgb(f64::from(value) * exposure) * 255.0 + 0.5) as u8;
    pixels.iter().flat_map(|p| p.to_array().map(byte)).collect()
}

/// Exposure that maps the 95th percentile of luminance to 0.8; 1 for a black image.
pub fn default_exposure(pixels: &[Rgb]) -> f64 {
    let mut luminance: Vec<f64> = pixels.iter().map(|&p| luminance(p)).collect();
    let value = percentile(&mut luminance, PERCENTILE);
    if value > 0.0 && value.is_finite() {
        TARGET / value
    } else {
        1.0
    }
}

/// `exposure` as a shader can take it: a normal number, since infinity times black is no colour.
pub fn for_shader(exposure: f64) -> f32 {
    exposure.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32
}

/// Rec. 709 luminance in f64.
pub fn luminance(p: Rgb) -> f64 {
    0.2126 * f64::from(p.r) + 0.7152 * f64::from(p.g) + 0.0722 * f64::from(p.b)
}

/// The `percent`-th percentile, linear between ranks; reorders `values`. 0 when there are none.
pub fn percentile(values: &mut [f64], percent: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = percent / 100.0 * (values.len() - 1) as f64;
    let index = rank.floor() as usize;
    let (_, &mut low, rest) = values.select_nth_unstable_by(index, f64::total_cmp);
    let high = rest.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    low + (high - low) * (rank - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_lie_between_ranks() {
        assert_eq!(percentile(&mut [5.0, 1.0, 2.0, 4.0, 3.0], 50.0), 3.0);
        assert!((percentile(&mut [1.0, 2.0, 4.0, 3.0], 95.0) - 3.85).abs() < 1e-12);
        assert_eq!(percentile(&mut [], 95.0), 0.0);
    }

    #[test]
    fn encoding_and_decoding_are_inverse() {
        for i in 0..=255 {
            let value = f64::from(i) / 255.0;
            // The two branches of the standard meet to seven digits.
            assert!((srgb(linear(value)) - value).abs() < 1e-6);
        }
        assert_eq!(
            display_bytes(&[Rgb::new(0.0, 10.0, 0.5)], 1.0),
            [0, 255, 188]
        );
    }

    #[test]
    fn a_black_image_keeps_exposure_one() {
        assert_eq!(default_exposure(&[Rgb::BLACK; 4]), 1.0);
        assert!((default_exposure(&[Rgb::splat(2.0); 10]) - 0.4).abs() < 1e-9);
    }
    #[test]
    fn exposures_of_the_faintest_and_the_brightest_images_are_numbers() {
        for value in [f32::from_bits(1), f32::MIN_POSITIVE, 1.0, f32::MAX] {
            let pixels = [Rgb::splat(value); 10];
            let exposure = default_exposure(&pixels);
            assert!(for_shader(exposure).is_normal(), "{value:e}: {exposure:e}");
            // 0.8 on the display, encoded.
            assert_eq!(display_bytes(&pixels[..1], exposure), [231; 3], "{value:e}");
        }
        assert_eq!(for_shader(2.5), 2.5);
        assert!(for_shader(f64::INFINITY).is_normal() && for_shader(0.0).is_normal());
    }
}
