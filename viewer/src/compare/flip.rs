//! LDR-FLIP: how different two display images look when they alternate.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild: *FLIP: A Difference Evaluator
//! for Alternating Images*, Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020.
//! Images are filtered by the eye's contrast sensitivity, compared in a perceptually uniform space (HyAB), and the
//! difference is amplified where edges or points differ.

use crate::tonemap::linear;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Pixels per degree of visual angle: a 0.7 m wide display of 3840 pixels at 0.7 m.
pub const DEFAULT_PPD: f64 = 3840.0 * PI / 180.0;

/// Exponent of the colour difference.
const COLOUR_EXPONENT: f64 = 0.7;
/// Share of the largest colour difference that maps to [`KNEE_OUT`].
const KNEE_IN: f64 = 0.4;
/// Where the linear compression bends.
const KNEE_OUT: f64 = 0.95;
/// Width of the feature detector [degrees].
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f64 = 0.5;

/// Contrast sensitivity of a channel as a sum of Gaussians: amplitude and width of each.
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];
/// The widest of them: it sets the radius of all filters.
const WIDEST: f64 = 0.04;

type Plane = Vec<f32>;

const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [
        10135552.0 / 24577794.0,
        8788810.0 / 24577794.0,
        4435075.0 / 24577794.0,
    ],
    [
        2613072.0 / 12288897.0,
        8788810.0 / 12288897.0,
        887015.0 / 12288897.0,
    ],
    [
        1425312.0 / 73733382.0,
        8788810.0 / 73733382.0,
        70074185.0 / 73733382.0,
    ],
];
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.241003275, -1.537398934, -0.498615861],
    [-0.969224334, 1.875930071, 0.041554224],
    [0.055639423, -0.204011202, 1.057148933],
];

fn transform(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

/// XYZ over the white point's.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let white = transform(&RGB_TO_XYZ, [1.0; 3]);
    let xyz = transform(&RGB_TO_XYZ, rgb);
    [0, 1, 2].map(|i| xyz[i] / white[i])
}

fn ycxcz_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn linear_from_ycxcz([luma, cx, cz]: [f64; 3]) -> [f64; 3] {
    let white = transform(&RGB_TO_XYZ, [1.0; 3]);
    let y = (luma + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    transform(&XYZ_TO_RGB, [0, 1, 2].map(|i| relative[i] * white[i]))
}

/// CIELab with the chroma shrunk in the dark (Hunt effect).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    [
        lightness,
        0.01 * lightness * 500.0 * (x - y),
        0.01 * lightness * 200.0 * (y - z),
    ]
}

fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Convolves rows with `across` and columns with `down`; the border pixel repeats.
fn convolve(plane: &[f32], width: usize, height: usize, across: &[f64], down: &[f64]) -> Vec<f64> {
    let radius = across.len() / 2;
    let mut rows = vec![0.0f64; plane.len()];
    rows.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let line = &plane[y * width..(y + 1) * width];
        for (x, value) in out.iter_mut().enumerate() {
            let tap = |(i, &k): (usize, &f64)| {
                k * f64::from(line[(x + i).saturating_sub(radius).min(width - 1)])
            };
            *value = across.iter().enumerate().map(tap).sum();
        }
    });
    let mut columns = vec![0.0f64; plane.len()];
    columns
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, out)| {
            for (i, &k) in down.iter().enumerate() {
                let line = (y + i).saturating_sub(radius).min(height - 1) * width;
                for (value, source) in out.iter_mut().zip(&rows[line..line + width]) {
                    *value += k * source;
                }
            }
        });
    columns
}

/// Filters a channel by the eye's contrast sensitivity.
fn sensitivity_filter(
    plane: &[f32],
    width: usize,
    height: usize,
    channel: usize,
    ppd: f64,
) -> Vec<f64> {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
    let mut sum = vec![0.0; plane.len()];
    let mut total = 0.0;
    for &(amplitude, spread) in SENSITIVITY[channel] {
        let kernel: Vec<f64> = (-radius..=radius)
            .map(|x| (-(PI * f64::from(x) / ppd).powi(2) / spread).exp())
            .collect();
        let weight = amplitude * (PI / spread).sqrt();
        total += weight * kernel.iter().sum::<f64>().powi(2);
        for (value, part) in sum
            .iter_mut()
            .zip(convolve(plane, width, height, &kernel, &kernel))
        {
            *value += weight * part;
        }
    }
    sum.iter_mut().for_each(|value| *value /= total);
    sum
}

/// Strength of edges and of points, from the luma in 0..1.
fn features(luma: &[f32], width: usize, height: usize, ppd: f64) -> [Vec<f64>; 2] {
    let deviation = 0.5 * FEATURE_WIDTH * ppd;
    let radius = (3.0 * deviation).ceil() as i32;
    let at = || (-radius..=radius).map(f64::from);
    let bell = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let sum: f64 = at().map(bell).sum();
    let smooth: Vec<f64> = at().map(|x| bell(x) / sum).collect();
    // Positive and negative weights sum to 1 each, so that a feature of full contrast answers with 1.
    let balanced = |weights: Vec<f64>| -> Vec<f64> {
        let positive: f64 = weights.iter().filter(|&&w| w > 0.0).sum();
        let negative: f64 = -weights.iter().filter(|&&w| w < 0.0).sum::<f64>();
        weights
            .into_iter()
            .map(|w| if w < 0.0 { w / negative } else { w / positive })
            .collect()
    };
    let edge = balanced(at().map(|x| -x * bell(x)).collect());
    let point = balanced(
        at().map(|x| (x * x / (deviation * deviation) - 1.0) * bell(x))
            .collect(),
    );
    [edge, point].map(|kernel| {
        let across = convolve(luma, width, height, &kernel, &smooth);
        let down = convolve(luma, width, height, &smooth, &kernel);
        across.iter().zip(&down).map(|(x, y)| x.hypot(*y)).collect()
    })
}

struct Prepared {
    lab: Vec<[f64; 3]>,
    features: [Vec<f64>; 2],
}

fn prepare(image: &[[f64; 3]], width: usize, height: usize, ppd: f64) -> Prepared {
    let opponent: Vec<[f64; 3]> = image
        .par_iter()
        .map(|p| ycxcz_from_linear(p.map(linear)))
        .collect();
    let plane = |channel: usize| -> Plane { opponent.iter().map(|p| p[channel] as f32).collect() };
    let [y, cx, cz] = [0, 1, 2].map(|c| sensitivity_filter(&plane(c), width, height, c, ppd));
    let lab = (0..image.len())
        .into_par_iter()
        .map(|i| hunt_lab(linear_from_ycxcz([y[i], cx[i], cz[i]]).map(|c| c.clamp(0.0, 1.0))))
        .collect();
    let luma: Plane = opponent
        .iter()
        .map(|p| ((p[0] + 16.0) / 116.0) as f32)
        .collect();
    Prepared {
        lab,
        features: features(&luma, width, height, ppd),
    }
}

/// FLIP of every pixel, 0..1, of two sRGB-encoded images with channels in 0..1.
pub fn ldr(
    reference: &[[f64; 3]],
    test: &[[f64; 3]],
    width: usize,
    height: usize,
    ppd: f64,
) -> Vec<f32> {
    let [r, t] = [reference, test].map(|image| prepare(image, width, height, ppd));
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(COLOUR_EXPONENT);
    let knee = KNEE_IN * largest;
    (0..reference.len())
        .into_par_iter()
        .map(|i| {
            let difference = hyab(r.lab[i], t.lab[i]).powf(COLOUR_EXPONENT);
            let colour = if difference < knee {
                KNEE_OUT / knee * difference
            } else {
                KNEE_OUT + (difference - knee) / (largest - knee) * (1.0 - KNEE_OUT)
            };
            let feature = |k: usize| (r.features[k][i] - t.features[k][i]).abs();
            let feature = (feature(0).max(feature(1)) * std::f64::consts::FRAC_1_SQRT_2)
                .powf(FEATURE_EXPONENT);
            // A power of zero stays zero, and no feature difference leaves the colour difference as it is.
            colour.powf(1.0 - feature.min(1.0)).clamp(0.0, 1.0) as f32
        })
        .collect()
}
