//! Whether a path goes on: by what it may still bring, over what its pixel shows.
//!
//! Vorba and Křivánek 2016, "Adjoint-driven Russian roulette and splitting in light transport simulation", section 4,
//! without splitting. A path that was sent where much light comes from has a small throughput and must live.

use super::scatter::Scatterer;
use std::f32::consts::FRAC_1_PI;

/// A path surely goes on while it may bring more than one over this of its pixel's radiance.
const WORTH: f32 = 5.0;
/// What is known about light is rough: a path goes on with at least this share of what it may carry.
const LEAST: f32 = 0.3;
/// Where nothing is known about light, bounces before roulette starts.
const SURE: u32 = 2;
/// From this bounce on no path lives with more than [`MOST_CHANCE`]: paths between mirrors end too.
const LONG: u32 = 16;
const MOST_CHANCE: f32 = 0.95;

/// Roulette of one path.
#[derive(Default)]
pub(super) struct Roulette {
    /// Radiance that the first rough surface is expected to have [mean over channels].
    pixel: Option<f32>,
}

impl Roulette {
    /// A path met a rough surface that `direct` light reaches its pixel from; the first one counts.
    pub(super) fn begin(&mut self, direct: f32, throughput: f32, scatterer: &Scatterer<'_>) {
        if self.pixel.is_none() {
            let indirect = scatterer.place().map_or(0.0, |place| place.light.indirect);
            self.pixel = Some(direct + throughput * scatterer.albedo() * FRAC_1_PI * indirect);
        }
    }

    /// How likely a path that has this throughput goes on from its bounce with this number.
    pub(super) fn chance(&self, bounce: u32, throughput: f32, scatterer: &Scatterer<'_>) -> f32 {
        let reflected = throughput * scatterer.albedo();
        let diffuse = scatterer.diffuse_share();
        let known = scatterer
            .place()
            .zip(self.pixel)
            .filter(|&(_, pixel)| pixel > 0.0);
        let chance = match known {
            Some((place, pixel)) => {
                // A lobe may lead to a lamp.
                let light = diffuse * place.light.indirect + (1.0 - diffuse) * place.light.whole;
                let worth = WORTH * reflected * FRAC_1_PI * light / pixel;
                let least = if bounce < SURE { 1.0 } else { reflected };
                worth.max((1.0 - diffuse).max(LEAST) * least)
            }
            None if bounce < SURE => 1.0,
            None => reflected,
        };
        chance.min(if bounce < LONG { 1.0 } else { MOST_CHANCE })
    }
}
