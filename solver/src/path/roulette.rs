//! Whether a path goes on: by what it may still bring, over what its pixel shows.
//!
//! Vorba and Křivánek 2016, "Adjoint-driven Russian roulette and splitting in light transport simulation", section 4,
//! without splitting. A path that was sent where much light comes from has a small throughput and must live.

use super::scatter::Scatterer;
use std::f32::consts::FRAC_1_PI;

/// A path surely goes on while it may bring more than one over this of its pixel's radiance.
const WORTH: f32 = 5.0;
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
    /// How likely a path that has this throughput goes on from its bounce with this number.
    pub(super) fn chance(
        &mut self,
        bounce: u32,
        throughput: f32,
        scatterer: &Scatterer<'_>,
    ) -> f32 {
        let reflected = throughput * scatterer.albedo();
        let known = scatterer.place().map(|place| place.light);
        if self.pixel.is_none() && scatterer.is_rough() {
            self.pixel = Some(known.map_or(0.0, |light| reflected * FRAC_1_PI * light.whole));
        }
        let chance = match (known, self.pixel) {
            (Some(light), Some(pixel)) if pixel > 0.0 => {
                WORTH * reflected * FRAC_1_PI * light.indirect / pixel
            }
            _ if bounce < SURE => 1.0,
            _ => reflected,
        };
        chance.min(if bounce < LONG { 1.0 } else { MOST_CHANCE })
    }
}
