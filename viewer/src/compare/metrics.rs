//! RMSE, relMSE, energy ratio, PSNR and FLIP of a test image against a reference.

use super::flip;
use crate::tonemap;
use serde::{Serialize, Serializer};
use sheen_formats::image::Image;
use sheen_solver::Rgb;

/// What two images must have in common before they can be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// Sizes differ.
    #[error("sizes differ: the test image is {}x{}, the reference {}x{}", test.0, test.1, reference.0, reference.1)]
    Size {
        /// Width and height.
        test: (u32, u32),
        /// Width and height.
        reference: (u32, u32),
    },
    /// Pixels that are no numbers.
    #[error("the {which} holds NaN or infinity in {count} pixels")]
    NotFinite {
        /// `test image` or `reference`.
        which: &'static str,
        /// How many pixels.
        count: usize,
    },
    /// Downsampling leaves nothing.
    #[error("{width}x{height} pixels leave nothing after averaging {factor}x{factor} of them")]
    TooSmall {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Block size.
        factor: u32,
    },
}

/// The figures. Pixels are weighted alike, channels too.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Root mean square over pixels and channels [W·sr⁻¹·m⁻²].
    #[serde(serialize_with = "number_or_text")]
    pub rmse: f64,
    /// Mean of (t-r)² / (r² + ε), ε = 1 % of the squared mean luminance of the reference.
    #[serde(serialize_with = "number_or_text")]
    pub relmse: f64,
    /// The same without the worst 0.1 % of the pixels.
    #[serde(serialize_with = "number_or_text")]
    pub relmse_trim999: f64,
    /// Mean luminance of the test image over that of the reference.
    #[serde(serialize_with = "number_or_text")]
    pub mean_ratio: f64,
    /// Factor before display encoding, for PSNR and FLIP.
    pub exposure: f64,
    /// Peak signal to noise ratio of the display images [dB].
    #[serde(serialize_with = "number_or_text")]
    pub psnr_db: f64,
    /// Mean LDR-FLIP of the display images, 0..1.
    pub flip: f64,
    /// FLIP of every pixel.
    #[serde(skip)]
    pub flip_map: Vec<f32>,
    /// Pixels across `flip_map`.
    #[serde(skip)]
    pub width: u32,
    /// Pixels down `flip_map`.
    #[serde(skip)]
    pub height: u32,
}

// JSON has no infinity and no NaN.
fn number_or_text<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() {
        serializer.serialize_f64(*value)
    } else {
        serializer.collect_str(value)
    }
}

impl Comparison {
    /// Names and figures, in the order of the JSON.
    pub fn rows(&self) -> [(&'static str, f64); 7] {
        [
            ("rmse", self.rmse),
            ("relmse", self.relmse),
            ("relmse_trim999", self.relmse_trim999),
            ("mean_ratio", self.mean_ratio),
            ("exposure", self.exposure),
            ("psnr_db", self.psnr_db),
            ("flip", self.flip),
        ]
    }
}

/// Part of the pixels that `relmse_trim999` keeps.
const KEPT: f64 = 0.999;
/// ε of relMSE over the squared mean luminance.
const RELATIVE_FLOOR: f64 = 1e-2;

/// Compares `test` with `reference` after averaging blocks of `downsample` × `downsample` pixels. `exposure`: `None`
/// maps the 95th percentile of the reference's luminance to 0.8.
pub fn compare(
    test: &Image,
    reference: &Image,
    downsample: u32,
    exposure: Option<f64>,
) -> Result<Comparison, CompareError> {
    if (test.width, test.height) != (reference.width, reference.height) {
        return Err(CompareError::Size {
            test: (test.width, test.height),
            reference: (reference.width, reference.height),
        });
    }
    for (which, image) in [("reference", reference), ("test image", test)] {
        let count = image.pixels.iter().filter(|p| !p.is_finite()).count();
        if count > 0 {
            return Err(CompareError::NotFinite { which, count });
        }
    }
    let (width, height) = (
        test.width / downsample.max(1),
        test.height / downsample.max(1),
    );
    if width == 0 || height == 0 {
        return Err(CompareError::TooSmall {
            width: test.width,
            height: test.height,
            factor: downsample,
        });
    }
    let (test, reference) = (
        block_means(test, downsample.max(1)),
        block_means(reference, downsample.max(1)),
    );
    Ok(score(&test, &reference, width, height, exposure))
}

fn block_means(image: &Image, factor: u32) -> Vec<[f64; 3]> {
    let (width, height) = (image.width / factor, image.height / factor);
    let scale = 1.0 / (f64::from(factor) * f64::from(factor));
    let mut means = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0; 3];
            for row in y * factor..(y + 1) * factor {
                for column in x * factor..(x + 1) * factor {
                    let pixel = image.pixels[row as usize * image.width as usize + column as usize];
                    for (total, value) in sum.iter_mut().zip(pixel.to_array()) {
                        *total += f64::from(value);
                    }
                }
            }
            means.push(sum.map(|total: f64| total * scale));
        }
    }
    means
}

fn luminance(p: &[f64; 3]) -> f64 {
    0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]
}

fn score(
    test: &[[f64; 3]],
    reference: &[[f64; 3]],
    width: u32,
    height: u32,
    exposure: Option<f64>,
) -> Comparison {
    let count = test.len() as f64;
    let squares = |t: &[f64; 3], r: &[f64; 3]| [0, 1, 2].map(|i| (t[i] - r[i]) * (t[i] - r[i]));
    let pairs = || test.iter().zip(reference);
    let mean_luminance = reference.iter().map(luminance).sum::<f64>() / count;
    let floor = RELATIVE_FLOOR * mean_luminance * mean_luminance;
    let mut relative: Vec<f64> = pairs()
        .map(|(t, r)| {
            let square = squares(t, r);
            // Two black pixels of a black reference agree.
            let part = |i: usize| {
                if square[i] == 0.0 {
                    0.0
                } else {
                    square[i] / (r[i] * r[i] + floor)
                }
            };
            (part(0) + part(1) + part(2)) / 3.0
        })
        .collect();
    let relmse = relative.iter().sum::<f64>() / count;
    relative.sort_unstable_by(f64::total_cmp);
    let kept = ((KEPT * count) as usize).max(1);
    let exposure = exposure.unwrap_or_else(|| {
        let rgb: Vec<Rgb> = reference
            .iter()
            .map(|p| Rgb::from(p.map(|c| c as f32)))
            .collect();
        tonemap::default_exposure(&rgb)
    });
    let display = |p: &[f64; 3]| p.map(|c| tonemap::srgb(c * exposure));
    let shown_test: Vec<[f64; 3]> = test.iter().map(display).collect();
    let shown_reference: Vec<[f64; 3]> = reference.iter().map(display).collect();
    let mean_square = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        a.iter()
            .zip(b)
            .map(|(t, r)| squares(t, r).iter().sum::<f64>())
            .sum::<f64>()
            / (3.0 * count)
    };
    let shown_error = mean_square(&shown_test, &shown_reference);
    let flip_map = flip::ldr(
        &shown_reference,
        &shown_test,
        width as usize,
        height as usize,
        flip::DEFAULT_PPD,
    );
    Comparison {
        rmse: mean_square(test, reference).sqrt(),
        relmse,
        relmse_trim999: relative[..kept].iter().sum::<f64>() / kept as f64,
        mean_ratio: test.iter().map(luminance).sum::<f64>() / count / mean_luminance,
        exposure,
        psnr_db: -10.0 * shown_error.log10(),
        flip: flip_map.iter().map(|&e| f64::from(e)).sum::<f64>() / count,
        flip_map,
        width,
        height,
    }
}
