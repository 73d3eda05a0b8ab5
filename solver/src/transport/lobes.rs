//! The light that one lobe reflects from many directions, as a function over outgoing directions.
//!
//! Structure of arrays: a cell's samples are evaluated together as vector code.

use crate::brdf::{self, Cosines, Lobe};
use crate::directional::{Peak, Source, octahedron};
use crate::radiometry::Rgb;
use crate::transport::closure::{Closure, Dark};
use crate::transport::merge::Merged;
use glam::Vec3;
use std::f32::consts::PI;
use std::ops::Range;

/// Samples that are evaluated together.
const LANES: usize = 32;

/// Below this cosine to the surface the value at it is taken: nothing is reflected below the surface, but the basis
/// wants a continuous function at the horizon.
const GRAZING: f32 = 0.02;

/// Samples reflected at one place.
pub(super) struct Lobes<'a> {
    lobe: &'a Lobe,
    normal: Vec3,
    /// Emission that compensates for the lobe, and the lobe's largest albedo.
    compensating: (Rgb, f32),
    mirrors: Vec<Mirror>,
    /// Irradiance on the surface times specular colour times the lobe's factor.
    weights: Vec<Rgb>,
    /// What closes the lobe, if it is to be closed: of each, times the lobe's factor.
    closures: Option<Vec<Closure>>,
    extents: Vec<Extent>,
    /// Evaluations of the BRDF.
    pub(super) evaluations: u64,
}

/// Where a lobe points.
#[derive(Clone, Copy)]
struct Mirror {
    direction: Vec3,
    sharpness: f32,
}

/// How far a lobe reaches: cosines and sines of angles from its mirror direction.
struct Extent {
    /// Beyond it is nothing.
    cutoff: (f32, f32),
    /// Half of the half-width.
    core: (f32, f32),
    /// Cosine of the half-width.
    half: f32,
    /// Its value where it points.
    peak: f32,
}

impl<'a> Lobes<'a> {
    /// `samples` at a surface with `normal`, above its horizon; the lobe is widened by each sample's size and by `bend`,
    /// and closed where all that is `dark` is known.
    pub(super) fn new(
        lobe: &'a Lobe,
        normal: Vec3,
        samples: &[Merged],
        dark: Option<&Dark>,
        bend: f32,
        compensating: Rgb,
    ) -> Self {
        let mut lobes = Self {
            lobe,
            normal,
            compensating: (compensating, lobe.albedo_range().0),
            mirrors: Vec::with_capacity(samples.len()),
            weights: Vec::with_capacity(samples.len()),
            closures: dark.is_some().then(Vec::new),
            extents: Vec::with_capacity(samples.len()),
            evaluations: 0,
        };
        for &Merged { sample, angle } in samples {
            let irradiance = sample.irradiance * sample.direction.dot(normal);
            let closure = Closure::of_sender(angle, irradiance);
            lobes.add(
                sample.direction,
                sample.spread.hypot(bend),
                irradiance,
                &closure,
            );
        }
        if let Some(dark) = dark {
            let angle = dark.solid_angle();
            let spread = (angle / PI).sqrt().hypot(bend);
            for &direction in &dark.directions {
                let closure = Closure::of_dark(angle * direction.dot(normal));
                lobes.add(direction, spread, Rgb::BLACK, &closure);
            }
        }
        lobes
    }

    /// Adds what comes from a disc of angular radius `spread` around a direction.
    fn add(&mut self, direction: Vec3, spread: f32, irradiance: Rgb, closure: &Closure) {
        let spread = self.lobe.spread(spread);
        let weight = irradiance * self.lobe.specular * spread.factor;
        let sine = |cosine: f32| (1.0 - cosine * cosine).max(0.0).sqrt();
        let cosine = direction.dot(self.normal).max(GRAZING);
        let cosines = Cosines {
            mirror: &[1.0],
            incoming: &[cosine],
            sharpness: &[spread.sharpness],
            outgoing: cosine,
        };
        let mut value = [0.0];
        self.lobe.eval_many(&cosines, &mut value);
        self.mirrors.push(Mirror {
            direction: brdf::reflect(self.normal, direction),
            sharpness: spread.sharpness,
        });
        self.weights.push(weight);
        if let Some(closures) = &mut self.closures {
            closures.push(closure.times(spread.factor));
        }
        self.extents.push(Extent {
            cutoff: (spread.cutoff, sine(spread.cutoff)),
            core: (
                (0.5 * (1.0 + spread.half)).sqrt(),
                (0.5 * (1.0 - spread.half)).sqrt(),
            ),
            half: spread.half,
            peak: weight.max_channel() * value[0],
        });
    }
}

impl Source for Lobes<'_> {
    fn eval(&mut self, candidates: &[u32], direction: Vec3) -> Rgb {
        let height = direction.dot(self.normal);
        let (wo, cos_o) = if height < GRAZING {
            (
                (direction + self.normal * (GRAZING - height)).normalize(),
                GRAZING,
            )
        } else {
            (direction, height)
        };
        self.evaluations += candidates.len() as u64;
        let (compensating, largest) = self.compensating;
        let mut sum = compensating * (largest - self.lobe.albedo(cos_o));
        let mut closure = Closure::default();
        let (mut mirror, mut incoming) = ([0.0; LANES], [0.0; LANES]);
        let mut sharpness = [0.0; LANES];
        let mut values = [0.0; LANES];
        for chunk in candidates.chunks(LANES) {
            for (lane, &candidate) in chunk.iter().enumerate() {
                let from = &self.mirrors[candidate as usize];
                mirror[lane] = from.direction.dot(wo);
                incoming[lane] = from.direction.dot(self.normal);
                sharpness[lane] = from.sharpness;
            }
            let count = chunk.len();
            let cosines = Cosines {
                mirror: &mirror[..count],
                incoming: &incoming[..count],
                sharpness: &sharpness[..count],
                outgoing: cos_o,
            };
            self.lobe.eval_many(&cosines, &mut values[..count]);
            for (&candidate, &value) in chunk.iter().zip(&values) {
                sum += self.weights[candidate as usize] * value;
            }
            if let Some(closures) = &self.closures {
                for (&candidate, &value) in chunk.iter().zip(&values) {
                    closure.add(&closures[candidate as usize], value);
                }
            }
        }
        if self.closures.is_some() {
            sum = (sum + closure.missing(self.lobe, cos_o)).max(Rgb::BLACK);
        }
        sum
    }

    fn narrow(&self, list: &mut Vec<u32>, range: Range<usize>, centre: Vec3, level: usize) {
        // A short list is not worth the test.
        if range.len() <= LANES / 4 {
            return list.extend_from_within(range);
        }
        let (sine, cosine) = octahedron::radius(level).sin_cos();
        // Written whether kept or not: no branch to predict.
        let first = list.len();
        list.resize(first + range.len(), 0);
        let mut kept = first;
        for i in range {
            let candidate = list[i];
            // Cosine of cutoff plus radius; both are below a right angle.
            let (cos_cutoff, sin_cutoff) = self.extents[candidate as usize].cutoff;
            let towards = self.mirrors[candidate as usize].direction.dot(centre);
            list[kept] = candidate;
            kept += usize::from(towards >= cos_cutoff * cosine - sin_cutoff * sine);
        }
        list.truncate(kept);
    }

    fn candidate_count(&self) -> u32 {
        self.mirrors.len() as u32
    }

    fn hidden_peak(
        &self,
        candidates: &[u32],
        centre: Vec3,
        level: usize,
        least: f32,
    ) -> Option<Peak> {
        // Where corners and centre are closer together than a lobe is wide, nothing of it can hide; and a peak
        // hides in the cell that it stands in. The parts of a round lamp are weak each: what counts is all that is
        // reflected where the strongest points.
        let radius = octahedron::radius(level);
        let (sine, cosine) = radius.sin_cos();
        let narrow = (radius / 1.2).cos();
        let (mut height, mut sum, mut direction) = (0.0f32, 0.0, None);
        for &candidate in candidates {
            let extent = &self.extents[candidate as usize];
            let (cos_core, sin_core) = extent.core;
            if extent.half >= narrow
                && extent.peak > 0.0
                && self.mirrors[candidate as usize].direction.dot(centre)
                    >= cos_core * cosine - sin_core * sine
            {
                sum += extent.peak;
                if extent.peak > height {
                    height = extent.peak;
                    direction = Some(self.mirrors[candidate as usize].direction);
                }
            }
        }
        let direction = direction.filter(|_| sum > least)?;
        Some(Peak { direction, height })
    }
}
