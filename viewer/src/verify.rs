//! The error of a solution over all surfaces and directions, by unbiased paths, with intervals that hold it.
//!
//! At random points and directions the stored radiance S is held against independent path samples L₁, L₂ of the truth:
//! S − (L₁ + L₂)/2 is an unbiased sample of the error, (S − L₁)(S − L₂) one of its square, however noisy the paths.
//! Emission is left out: it is stored as it is.

use crate::ways::cpu::{Looker, towards};
use rayon::prelude::*;
use sheen_solver::path::{Probe, Probes, Sampler};
use sheen_solver::{Observer, PathTracer, Progress, Rgb, Solution};

/// Probes between two reports.
const BATCH: u32 = 1 << 12;
/// Standard deviations to either side of 95 % of a normal distribution.
const NORMAL_95: f64 = 1.959_964;

/// A mean of squares is well above its noise when that is below this share of it.
const CLEAR: f64 = 0.4;

/// A figure, and the ends of the interval that holds the true one in 95 of 100 runs.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Error of a part of the scene. Radiance is the mean over channels.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Errors {
    /// Probes that met it.
    pub probes: usize,
    /// Mean reflected radiance by the paths [W·sr⁻¹·m⁻²].
    pub radiance: f64,
    /// Mean of the solution minus the truth, over the mean radiance.
    pub bias: Estimate,
    /// Root of the mean square of the solution minus the truth, over the mean radiance.
    pub rms: Estimate,
}

/// Error of one material.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OfMaterial {
    /// Its name.
    pub material: String,
    /// Its share of the summed square error of all.
    pub share: f64,
    /// Its error.
    pub errors: Errors,
}

/// What [`verify`] found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Over all surfaces.
    pub all: Errors,
    /// By material, the largest part of the square error first.
    pub materials: Vec<OfMaterial>,
}

/// One probe: the solution's radiance, and two samples of the truth [mean over channels]; square errors are summed
/// over channels before their mean.
#[derive(Clone, Copy, Debug)]
struct Met {
    material: u32,
    difference: f64,
    truth: f64,
    square: f64,
}

/// Holds `solution` against paths through its scene at `probes` random places; stopped by the observer, at those that
/// it came to. `None` where nothing was met.
pub fn verify(
    solution: &Solution,
    tracer: &PathTracer,
    probes: u32,
    seed: u32,
    observer: &mut dyn Observer,
) -> Option<Verification> {
    let looker = Looker::new(solution, &[]);
    let hold = |probe: &Probe, sampler: &mut Sampler| {
        let stored = look(solution, &looker, probe);
        Some(hold(stored, tracer, probe, sampler))
    };
    hold_all(solution, tracer, probes, seed, observer, &hold)
}

/// Holds the `solution` of a furnace ([`sheen_solver::solve::solve_furnace`]) against the one `radiance` that it has
/// everywhere; `tracer`: of its scene. Sides that are dark, where none of the scene's lamps reaches, are left out, and so
/// is what sees them: a floor below a box.
pub fn verify_furnace(
    solution: &Solution,
    radiance: f32,
    tracer: &PathTracer,
    probes: u32,
    seed: u32,
    observer: &mut dyn Observer,
) -> Option<Verification> {
    let looker = Looker::new(solution, &[]);
    let hold = |probe: &Probe, _: &mut Sampler| {
        let stored = look(solution, &looker, probe);
        let error = (stored - Rgb::splat(radiance)).to_array().map(f64::from);
        let opposite = Probe {
            direction: -probe.direction,
            ..*probe
        };
        let is_dark = stored.is_black() || look(solution, &looker, &opposite).is_black();
        (!is_dark).then(|| Met {
            material: probe.material,
            difference: error.iter().sum::<f64>() / 3.0,
            truth: f64::from(radiance),
            square: error.iter().map(|e| e * e).sum::<f64>() / 3.0,
        })
    };
    hold_all(solution, tracer, probes, seed, observer, &hold)
}

fn hold_all(
    solution: &Solution,
    tracer: &PathTracer,
    probes: u32,
    seed: u32,
    observer: &mut dyn Observer,
    hold: &(impl Fn(&Probe, &mut Sampler) -> Option<Met> + Sync),
) -> Option<Verification> {
    let places = Probes::new(tracer);
    let mut met: Vec<Met> = Vec::new();
    for first in (0..probes).step_by(BATCH as usize) {
        let batch = first..probes.min(first + BATCH);
        met.par_extend(batch.into_par_iter().filter_map(|index| {
            let mut sampler = Sampler::new(index, 0, seed);
            let probe = places.choose(&mut sampler)?;
            hold(&probe, &mut sampler)
        }));
        let progress = Progress {
            phase: "verify",
            done: (first + BATCH).min(probes) as f32 / probes as f32,
        };
        if observer.report(&progress).is_break() {
            break;
        }
    }
    let all = errors(met.iter())?;
    let whole: f64 = met.iter().map(|one| one.square).sum();
    let of_material = |(index, material): (usize, &sheen_solver::Material)| {
        let own = met.iter().filter(|one| one.material as usize == index);
        let square: f64 = own.clone().map(|one| one.square).sum();
        Some(OfMaterial {
            material: material.name.clone(),
            share: if whole > 0.0 { square / whole } else { 0.0 },
            errors: errors(own)?,
        })
    };
    let materials = solution.materials.iter().enumerate();
    let mut materials: Vec<OfMaterial> = materials.filter_map(of_material).collect();
    materials.sort_by(|a, b| b.share.total_cmp(&a.share));
    Some(Verification { all, materials })
}

/// The solution's radiance at a probe, emission included.
fn look(solution: &Solution, looker: &Looker<'_>, probe: &Probe) -> Rgb {
    let direction = probe.direction.as_dvec3();
    let seen = looker.look(probe.eye, direction, 0.0, |vertex| {
        towards(solution, vertex, probe.eye)
    });
    Rgb::from(seen.map(|channel| channel as f32))
}

/// `stored` radiance against two paths.
fn hold(stored: Rgb, tracer: &PathTracer, probe: &Probe, sampler: &mut Sampler) -> Met {
    let Probe {
        eye,
        direction,
        material,
    } = *probe;
    let stored = stored - tracer.emitted(eye, direction);
    let truth = [(); 2].map(|()| tracer.reflected(eye, direction, sampler));
    let [first, second] = truth.map(|sample| (stored - sample).to_array().map(f64::from));
    let square: f64 = first.iter().zip(second).map(|(a, b)| a * b).sum();
    let truth = 0.5 * f64::from(truth[0].mean() + truth[1].mean());
    Met {
        material,
        difference: f64::from(stored.mean()) - truth,
        truth,
        square: square / 3.0,
    }
}

/// Means over some probes, with their intervals: `None` below two.
fn errors<'a>(met: impl Iterator<Item = &'a Met> + Clone) -> Option<Errors> {
    let count = met.clone().count();
    if count < 2 {
        return None;
    }
    let n = count as f64;
    let mean = |of: &dyn Fn(&Met) -> f64| met.clone().map(of).sum::<f64>() / n;
    let radiance = mean(&|one| one.truth);
    let per_radiance = if radiance > 0.0 { 1.0 / radiance } else { 0.0 };
    let bias = mean(&|one| one.difference) * per_radiance;
    // A ratio of means, linearised.
    let spread = mean(&|one| (one.difference - bias * one.truth).powi(2));
    let margin = NORMAL_95 * (spread / (n - 1.0)).sqrt() * per_radiance;
    let square = mean(&|one| one.square);
    let square_spread = mean(&|one| (one.square - square).powi(2));
    let [square_low, square_high] = interval(square, (square_spread / (n - 1.0)).sqrt());
    let root = |square: f64| square.max(0.0).sqrt() * per_radiance;
    Some(Errors {
        probes: count,
        radiance,
        bias: Estimate {
            value: bias,
            low: bias - margin,
            high: bias + margin,
        },
        rms: Estimate {
            value: root(square),
            low: root(square_low),
            high: root(square_high),
        },
    })
}

/// The interval of a mean of squares with this standard error. Few large squares make it skewed where it is well above
/// its noise: there its logarithm is nearer to normal.
fn interval(mean: f64, error: f64) -> [f64; 2] {
    let relative = error / mean;
    if mean > 0.0 && relative < CLEAR {
        [-NORMAL_95, NORMAL_95].map(|side| mean * (side * relative).exp())
    } else {
        [-NORMAL_95, NORMAL_95].map(|side| mean + side * error)
    }
}
