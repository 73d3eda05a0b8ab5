//! Illumination samples as they are kept: 24 bytes instead of 64.
//!
//! The direction is a point of the unfolded octahedron with 16 bits an axis (Meyer et al. 2010, "On floating-point normal
//! vectors"), the irradiance has 16 bits a channel and one exponent, the spread 16 bits, the scale the logarithm of one, and
//! shares 8 bits. What that costs is a test.

use crate::radiometry::Rgb;
use crate::transport::illumination::{IlluminationSample, Parallax};
use crate::transport::kernel::Kernel;
use crate::transport::link::SenderId;
use glam::{Vec2, Vec3};

/// Steps of a coordinate of a direction from 0 to 1.
const DIRECTION_STEPS: f32 = 32767.0;

/// Largest value of a channel, in steps.
const MOST_STEPS: u32 = 0xffff;
/// Exponents whose steps are normal numbers.
const LEAST_EXPONENT: i32 = -110;
/// Marks light that is not finite: it must be found, not lost.
const NOT_FINITE: i8 = i8::MIN;

/// Bits of [`Packed::flags`].
const HAS_PARALLAX: u8 = 1;
const IS_POLYGON: u8 = 2;
const IS_PLACED: u8 = 4;
/// The depth of the sender's part stands above them.
const DEPTH_SHIFT: u32 = 3;

/// Steps of the spread in a radian: no disc is wider than a half circle.
const SPREAD_STEPS: f32 = 16384.0;

/// Steps of the logarithm of a scale from one to two, and the number of that of one.
const SCALE_STEPS: f32 = 512.0;
const SCALE_ONE: f32 = 32768.0;

/// Steps of a share.
const SHARE_STEPS: f32 = 255.0;

/// An [`IlluminationSample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Packed {
    direction: [i16; 2],
    /// Channels in steps of 2^(exponent - 16).
    irradiance: [u16; 3],
    exponent: i8,
    flags: u8,
    spread: u16,
    path: u16,
    sender: u32,
    scale: u16,
    open: u8,
    least: u8,
}

impl Packed {
    pub(super) fn of(sample: &IlluminationSample) -> Self {
        let (irradiance, exponent) = shared_exponent(sample.irradiance);
        let mut packed = Self {
            direction: unfolded(sample.direction),
            irradiance,
            exponent,
            flags: 0,
            spread: (sample.spread * SPREAD_STEPS).round() as u16,
            path: 0,
            sender: 0,
            scale: 0,
            open: 0,
            least: 0,
        };
        if let Some(parallax) = sample.parallax {
            let (path, depth) = parallax.sender.below();
            packed.flags = HAS_PARALLAX | depth << DEPTH_SHIFT;
            if parallax.kernel == Kernel::Polygon {
                packed.flags |= IS_POLYGON;
            }
            (packed.sender, packed.path) = (parallax.sender.node, path);
            let steps = (parallax.scale.log2() * SCALE_STEPS).round() + SCALE_ONE;
            packed.scale = steps as u16;
            packed.place(&parallax);
        }
        packed
    }

    pub(super) fn sample(&self) -> IlluminationSample {
        let has_parallax = self.flags & HAS_PARALLAX != 0;
        let depth = self.flags >> DEPTH_SHIFT;
        IlluminationSample {
            direction: folded(self.direction),
            irradiance: self.irradiance(),
            spread: f32::from(self.spread) / SPREAD_STEPS,
            parallax: has_parallax.then(|| Parallax {
                sender: SenderId::of(self.sender, self.path, depth),
                kernel: if self.flags & IS_POLYGON != 0 {
                    Kernel::Polygon
                } else {
                    Kernel::Point
                },
                scale: ((f32::from(self.scale) - SCALE_ONE) / SCALE_STEPS).exp2(),
                open: f32::from(self.open) / SHARE_STEPS,
                least: (self.flags & IS_PLACED != 0).then(|| f32::from(self.least) / SHARE_STEPS),
            }),
        }
    }

    fn irradiance(&self) -> Rgb {
        if self.exponent == NOT_FINITE {
            return Rgb::WHITE * f32::NAN;
        }
        let step = step(i32::from(self.exponent));
        let [r, g, b] = self.irradiance.map(|channel| f32::from(channel) * step);
        Rgb::new(r, g, b)
    }

    /// True where its receiver sees a part of its sender, and all leaves get the same so far.
    pub(super) fn is_shadow(&self) -> bool {
        self.flags & IS_PLACED == 0 && self.open > 0 && f32::from(self.open) < SHARE_STEPS
    }

    /// Sets what leaves get.
    pub(super) fn place(&mut self, parallax: &Parallax) {
        self.open = share_steps(parallax.open);
        if let Some(least) = parallax.least {
            self.least = share_steps(least);
            self.flags |= IS_PLACED;
        }
    }

    /// Scales its light.
    pub(super) fn scale(&mut self, factor: Rgb) {
        (self.irradiance, self.exponent) = shared_exponent(self.irradiance() * factor);
    }
}

fn share_steps(share: f32) -> u8 {
    (share * SHARE_STEPS).round() as u8
}

/// 2^(exponent - 16).
fn step(exponent: i32) -> f32 {
    f32::from_bits(((exponent - 16 + 127) as u32) << 23)
}

fn shared_exponent(irradiance: Rgb) -> ([u16; 3], i8) {
    if !irradiance.is_finite() {
        return ([0; 3], NOT_FINITE);
    }
    let largest = irradiance.max_channel();
    let above = (largest.to_bits() >> 23) as i32 - 127 + 1;
    let exponent = above.clamp(LEAST_EXPONENT, i8::MAX.into());
    let steps = |channel: f32| ((channel / step(exponent) + 0.5) as u32).min(MOST_STEPS) as u16;
    (irradiance.to_array().map(steps), exponent as i8)
}

/// The lower half of the octahedron is folded outwards over the upper one.
fn turned_over(at: Vec2) -> Vec2 {
    (Vec2::ONE - Vec2::new(at.y, at.x).abs()) * Vec2::ONE.copysign(at)
}

fn unfolded(direction: Vec3) -> [i16; 2] {
    let at = direction / direction.abs().element_sum();
    let at = if at.z < 0.0 {
        turned_over(at.truncate())
    } else {
        at.truncate()
    };
    (at * DIRECTION_STEPS)
        .round()
        .to_array()
        .map(|steps| steps as i16)
}

fn folded(steps: [i16; 2]) -> Vec3 {
    let at = Vec2::from(steps.map(f32::from)) / DIRECTION_STEPS;
    let height = 1.0 - at.abs().element_sum();
    let across = if height < 0.0 { turned_over(at) } else { at };
    across.extend(height).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hash::unit;
    use std::f32::consts::{PI, TAU};

    fn sample(i: u32) -> IlluminationSample {
        let u = |salt: u32| unit(i, salt);
        let (z, turn) = (2.0 * u(0) - 1.0, u(1) * TAU);
        let across = (1.0 - z * z).sqrt();
        let strength = (60.0 * u(2) - 40.0).exp2();
        IlluminationSample {
            direction: Vec3::new(across * turn.cos(), across * turn.sin(), z),
            irradiance: Rgb::new(u(3), u(4), u(5)) * strength,
            spread: u(6) * PI,
            parallax: (u(7) > 0.5).then(|| Parallax {
                sender: SenderId::of(i * 77_777, (i * 31) as u16, (i % 9) as u8),
                kernel: if u(8) > 0.5 {
                    Kernel::Point
                } else {
                    Kernel::Polygon
                },
                scale: (100.0 * u(9) - 50.0).exp2(),
                open: u(10),
                least: (u(11) > 0.5).then(|| u(12)),
            }),
        }
    }

    #[test]
    fn what_is_kept_is_what_it_was() {
        assert_eq!(size_of::<Packed>(), 24);
        let (mut turned, mut dimmed, mut scaled) = (0.0f32, 0.0f32, 0.0f32);
        for i in 0..50_000 {
            let sample = sample(i);
            let kept = Packed::of(&sample).sample();
            turned = turned.max(kept.direction.cross(sample.direction).length());
            assert!((kept.direction.length() - 1.0).abs() < 1e-6);
            let off =
                (kept.irradiance - sample.irradiance).max(sample.irradiance - kept.irradiance);
            dimmed = dimmed.max(off.max_channel() / sample.irradiance.max_channel());
            assert!((kept.spread - sample.spread).abs() < 1.0 / SPREAD_STEPS);
            let (Some(kept), Some(given)) = (kept.parallax, sample.parallax) else {
                assert_eq!(kept.parallax, sample.parallax);
                continue;
            };
            assert_eq!((kept.sender, kept.kernel), (given.sender, given.kernel));
            scaled = scaled.max((kept.scale / given.scale).log2().abs());
            assert_eq!(kept.least.is_some(), given.least.is_some());
            let least = kept.least.zip(given.least);
            let shares = [
                kept.open - given.open,
                least.map_or(0.0, |(kept, given)| kept - given),
            ];
            assert!(shares.iter().all(|off| off.abs() < 0.51 / SHARE_STEPS));
        }
        // Half a step along both axes, three times as far on the sphere in the middle of a face; half a step of the half
        // that the largest channel is at least.
        let half = 0.5 / DIRECTION_STEPS;
        assert!(turned < 3.0 * half * 2f32.sqrt(), "{turned:e}");
        assert!(dimmed < 1.01 / MOST_STEPS as f32, "{dimmed:e}");
        assert!(scaled < 0.51 / SCALE_STEPS, "{scaled:e}");
    }

    #[test]
    fn axes_stay_axes_and_what_is_not_finite_is_seen() {
        for axis in [
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ] {
            assert_eq!(folded(unfolded(axis)), axis);
        }
        for wrong in [f32::NAN, f32::INFINITY] {
            let mut packed = Packed::of(&IlluminationSample {
                irradiance: Rgb::new(1.0, wrong, 0.0),
                ..sample(1)
            });
            assert!(!packed.sample().irradiance.is_finite());
            packed.scale(Rgb::WHITE);
            assert!(!packed.sample().irradiance.is_finite());
        }
        let black = Packed::of(&IlluminationSample {
            irradiance: Rgb::BLACK,
            ..sample(1)
        });
        assert!(black.sample().irradiance.is_black());
    }
}
