//! Illumination samples that a lobe cannot tell apart become one.
//!
//! The same sender lights a place once an iteration (§3.4), and small senders lie side by side: what comes from a small
//! part of a lobe's width is reflected like its sum, at the cost of one. Cost: a hash per sample.

use crate::radiometry::Rgb;
use crate::transport::illumination::IlluminationSample;
use glam::Vec3;
use rustc_hash::FxHashMap;

/// Samples within a cube of this share of the half-width are merged: its variance widens the lobe by a per cent.
const SHARE: f32 = 0.25;

/// A disc of angular radius s widens a lobe of half-width w to √(w² + this · s²).
const WIDENING: f32 = 0.35;

/// A sample for others that a lobe cannot tell from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merged {
    pub(super) sample: IlluminationSample,
    /// Projected solid angle of what sends it [sr].
    pub(super) angle: f32,
}

/// Adds up what lobes of `half_width` [rad] about their mirror directions cannot tell apart. What lies below the plane
/// with `normal` is left out; irradiance on that plane stays what it is.
pub(super) fn merged(samples: &[IlluminationSample], normal: Vec3, half_width: f32) -> Vec<Merged> {
    let mut sums: Vec<Sum> = Vec::new();
    let mut known: FxHashMap<[i32; 4], u32> = FxHashMap::default();
    for sample in samples {
        let cosine = sample.direction.dot(normal);
        if cosine <= 0.0 {
            continue;
        }
        // Widths within a factor of √2 may be merged.
        let squared = half_width * half_width + WIDENING * sample.spread * sample.spread;
        let octave = squared.log2().floor();
        let step = SHARE * (0.5 * octave).exp2();
        let [x, y, z] = (sample.direction / step).round().to_array();
        let key = [x as i32, y as i32, z as i32, octave as i32];
        let at = *known.entry(key).or_insert(sums.len() as u32);
        if at as usize == sums.len() {
            sums.push(Sum::default());
        }
        sums[at as usize].add(sample, cosine);
    }
    sums.iter().filter_map(|sum| sum.merged(normal)).collect()
}

#[derive(Clone, Copy, Default)]
struct Sum {
    /// Irradiance on the surface.
    irradiance: Rgb,
    /// Its mean over channels, times direction and squared spread.
    direction: Vec3,
    spread: f32,
    angle: f32,
}

impl Sum {
    fn add(&mut self, sample: &IlluminationSample, cosine: f32) {
        let irradiance = sample.irradiance * cosine;
        let weight = irradiance.mean();
        self.irradiance += irradiance;
        self.direction += sample.direction * weight;
        self.spread += sample.spread * sample.spread * weight;
        self.angle += sample.solid_angle() * cosine;
    }

    fn merged(&self, normal: Vec3) -> Option<Merged> {
        let direction = self.direction.try_normalize()?;
        let cosine = direction.dot(normal);
        let sample = || IlluminationSample {
            direction,
            irradiance: self.irradiance / cosine,
            spread: (self.spread / self.irradiance.mean()).sqrt(),
            parallax: None,
        };
        (cosine > 0.0).then(|| Merged {
            sample: sample(),
            angle: self.angle,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;
    use crate::transport::illumination::irradiance;

    fn samples(count: u32, seed: u32) -> Vec<IlluminationSample> {
        let sample = |i: u32| {
            let u = |k: u32| unit(i, seed + k);
            IlluminationSample {
                direction: Vec3::new(u(0) - 0.5, u(1) - 0.5, u(2) * 0.6 - 0.1).normalize(),
                irradiance: Rgb::new(u(3), u(4), u(5)),
                spread: 0.3 * u(6) * u(6),
                parallax: None,
            }
        };
        (0..count).map(sample).collect()
    }

    fn merged_samples(all: &[IlluminationSample], half_width: f32) -> Vec<IlluminationSample> {
        let few = merged(all, Vec3::Z, half_width).into_iter();
        few.map(|merged| merged.sample).collect()
    }

    #[test]
    fn solid_angles_stay_what_they_are() {
        let all = samples(3000, 50);
        let projected = |s: &IlluminationSample| s.solid_angle() * s.direction.z.max(0.0);
        let wanted: f32 = all.iter().map(projected).sum();
        let found: f32 = merged(&all, Vec3::Z, 0.1).iter().map(|m| m.angle).sum();
        assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
    }

    #[test]
    fn irradiance_stays_what_it_is() {
        for half_width in [0.01, 0.1, 0.5] {
            let all = samples(3000, 10);
            let few = merged_samples(&all, half_width);
            assert!(few.len() < all.len());
            let (found, wanted) = (irradiance(&few, Vec3::Z), irradiance(&all, Vec3::Z));
            for (found, wanted) in found.to_array().into_iter().zip(wanted.to_array()) {
                assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
            }
        }
    }

    #[test]
    fn a_lobe_reflects_the_same() {
        // cosⁿ of the angle, widened as the BRDFs widen theirs.
        let reflected = |samples: &[IlluminationSample], exponent: f32, towards: Vec3| -> f32 {
            let of = |sample: &IlluminationSample| {
                let n = exponent / (1.0 + exponent * sample.spread * sample.spread * 0.25);
                let power = sample.direction.dot(towards).max(0.0).powf(n);
                sample.irradiance.g * sample.direction.z * (n + 2.0) * power
            };
            samples.iter().filter(|s| s.direction.z > 0.0).map(of).sum()
        };
        for exponent in [5.0f32, 50.0, 500.0] {
            let half_width = 0.5f32.powf(1.0 / exponent).acos();
            let all = samples(4000, 20);
            let few = merged_samples(&all, half_width);
            for i in 0..50 {
                let u = |k: u32| unit(i, 40 + k) - 0.5;
                let towards = Vec3::new(u(0), u(1), 0.4).normalize();
                let wanted = reflected(&all, exponent, towards);
                let error = reflected(&few, exponent, towards) / wanted - 1.0;
                assert!(error.abs() < 0.01, "n = {exponent}: {error}");
            }
        }
    }

    #[test]
    fn one_sender_seen_often_is_one_sample() {
        let mut all = samples(1, 70);
        all[0].direction = Vec3::new(0.1, 0.2, 0.9).normalize();
        let few = merged_samples(&[all[0]; 13], 0.05);
        assert_eq!(few.len(), 1);
        assert!((few[0].irradiance.r / (13.0 * all[0].irradiance.r) - 1.0).abs() < 1e-5);
        assert!((few[0].spread - all[0].spread).abs() < 1e-5);
    }
}
