//! Closure: a lobe reflects its whole albedo of light that is the same everywhere.
//!
//! Samples are discs in place of what sends, and their lobes add up to the albedo only nearly: where everything is
//! equally bright, a glossy surface would be mottled. How far they miss it is known, as the solid angle of every sample
//! is. The sum is corrected by that times the harmonic mean of the radiance in the lobe, which a lamp does not raise: a
//! control variate, exact where light is even. Nothing is filled where a lobe sees what does not send.

use crate::brdf::Lobe;
use crate::radiometry::Rgb;
use glam::Vec3;
use std::f32::consts::TAU;

/// Where nothing is filled: lobes that see what is dark by more than this share of their albedo.
const MOST_DARK: f32 = 0.05;

/// Directions over the hemisphere of a place in which nothing sends.
#[derive(Clone, Debug, Default)]
pub struct Dark {
    /// Unit.
    pub directions: Vec<Vec3>,
    /// How many directions were tried, spread evenly.
    pub tried: u32,
}

impl Dark {
    /// Solid angle that each direction stands for [sr].
    pub(super) fn solid_angle(&self) -> f32 {
        TAU / self.tried as f32
    }
}

/// Sums over the samples in a lobe: what is needed to close it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Closure {
    /// Projected solid angle of what sends [sr].
    angle: f32,
    /// The same over radiance, per channel.
    over_radiance: [f32; 3],
    /// Projected solid angle of what does not send [sr].
    dark: f32,
}

impl Closure {
    /// Of a sender of projected solid angle `angle` [sr] with an irradiance on the surface.
    pub(super) fn of_sender(angle: f32, irradiance: Rgb) -> Self {
        // A light without extent takes up nothing.
        if angle <= 0.0 {
            return Self::default();
        }
        // A black channel closes nothing, whatever the others in the lobe are.
        let over = |irradiance: f32| (angle * (angle / irradiance)).min(f32::MAX.sqrt());
        Self {
            angle,
            over_radiance: irradiance.to_array().map(over),
            dark: 0.0,
        }
    }

    /// Of what does not send.
    pub(super) fn of_dark(angle: f32) -> Self {
        Self {
            dark: angle,
            ..Self::default()
        }
    }

    /// The same of a lobe with a factor.
    pub(super) fn times(mut self, factor: f32) -> Self {
        self.angle *= factor;
        self.over_radiance = self.over_radiance.map(|over| over * factor);
        self.dark *= factor;
        self
    }

    /// Adds another, as much as a lobe shows of it.
    pub(super) fn add(&mut self, other: &Self, value: f32) {
        self.angle += other.angle * value;
        for (sum, part) in self.over_radiance.iter_mut().zip(other.over_radiance) {
            *sum += part * value;
        }
        self.dark += other.dark * value;
    }

    /// What is missing of the radiance that the lobe reflects towards an angle with cosine `cos_o`; below zero where there
    /// is too much. The radiance of the senders is their harmonic mean: a lamp in the lobe does not count.
    pub(super) fn missing(&self, lobe: &Lobe, cos_o: f32) -> Rgb {
        let albedo = lobe.albedo(cos_o);
        let trust = 1.0 - self.dark / (MOST_DARK * albedo);
        if self.angle <= 0.0 || trust <= 0.0 {
            return Rgb::BLACK;
        }
        let [r, g, b] = self.over_radiance.map(|over| self.angle / over);
        lobe.specular * Rgb::new(r, g, b) * ((albedo - self.angle) * trust)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directional::Source;
    use crate::geometry::hash::unit;
    use crate::geometry::sampling::{about, spread};
    use crate::scene::{Gloss, Material};
    use crate::transport::illumination::IlluminationSample;
    use crate::transport::lobes::Lobes;
    use crate::transport::merge::Merged;
    use std::f32::consts::PI;

    fn lobe() -> Lobe {
        let gloss = Gloss::Phong {
            specular: Rgb::new(0.5, 0.4, 0.3),
            exponent: 20.0,
        };
        let material = Material {
            gloss,
            ..Material::lambert("m", Rgb::BLACK)
        };
        Lobe::of(&material, 0.0).expect("glossy")
    }

    fn hemisphere(i: u32) -> Vec3 {
        let at = spread(i);
        about(Vec3::Z, ((1.0 - at.x * at.x).sqrt(), at.x), at.y)
    }

    /// Discs over the hemisphere, of solid angles that miss it by up to half, with radiances.
    fn samples(radiance: impl Fn(Vec3) -> f32) -> Vec<Merged> {
        const COUNT: u32 = 300;
        let sample = |i: u32| {
            let direction = hemisphere(i);
            let angle = TAU / COUNT as f32 * (0.5 + unit(i, 3));
            Merged {
                sample: IlluminationSample {
                    direction,
                    irradiance: Rgb::WHITE * (radiance(direction) * angle),
                    spread: (angle / PI).sqrt(),
                    parallax: None,
                },
                angle: angle * direction.z,
            }
        };
        (0..COUNT).map(sample).collect()
    }

    /// What a lobe reflects of samples towards a direction.
    fn reflected(samples: &[Merged], dark: Option<&Dark>, towards: Vec3) -> Rgb {
        let lobe = lobe();
        let mut lobes = Lobes::new(&lobe, Vec3::Z, samples, dark, 0.0, Rgb::BLACK);
        let all: Vec<u32> = (0..lobes.candidate_count()).collect();
        lobes.eval(&all, towards)
    }

    fn views() -> impl Iterator<Item = Vec3> {
        (0..40).map(|i| hemisphere(1000 + i)).filter(|v| v.z > 0.1)
    }

    #[test]
    fn even_light_is_reflected_by_the_albedo() {
        let even = samples(|_| 3.0);
        let dark = Dark {
            tried: 64,
            ..Dark::default()
        };
        let mut off = 0.0f32;
        for view in views() {
            let wanted = lobe().specular * (3.0 * lobe().albedo(view.z));
            let relative = |found: Rgb| found.g / wanted.g - 1.0;
            let closed = reflected(&even, Some(&dark), view);
            assert!(relative(closed).abs() < 1e-4, "{closed:?} {wanted:?}");
            off = off.max(relative(reflected(&even, None, view)).abs());
        }
        assert!(off > 0.03, "nothing to close: {off}");
    }

    #[test]
    fn a_lamp_is_no_measure_of_what_is_missing() {
        let lamp = Vec3::new(0.6, 0.0, 0.8);
        let is_lamp = |direction: Vec3| direction.dot(lamp) > 0.98;
        let lit = samples(|d| if is_lamp(d) { 1000.0 } else { 1.0 });
        let dark = Dark {
            tried: 64,
            ..Dark::default()
        };
        for view in views() {
            let change = reflected(&lit, Some(&dark), view) - reflected(&lit, None, view);
            // The samples miss the sphere by less than half, at a radiance not much above that of the surroundings.
            let most = lobe().specular.g * lobe().albedo(view.z);
            assert!(change.g.abs() < 0.6 * most, "{change:?} towards {view}");
        }
    }

    #[test]
    fn openings_stay_dark() {
        let half: Vec<Merged> = samples(|_| 1.0)
            .into_iter()
            .filter(|merged| merged.sample.direction.x > 0.0)
            .collect();
        let tried = 64;
        let dark = Dark {
            directions: (0..tried).map(hemisphere).filter(|d| d.x <= 0.0).collect(),
            tried,
        };
        for view in views() {
            let [closed, plain] = [Some(&dark), None].map(|dark| reflected(&half, dark, view));
            // The lobe reflects from the other side: what it sees of the opening changes nothing.
            if view.x > -0.2 {
                assert_eq!(closed, plain, "towards {view}");
            }
        }
    }
}
