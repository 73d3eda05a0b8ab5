//! The error of a solution over all surfaces and directions, by unbiased paths, with intervals that hold it.
//!
//! At random points and directions the stored radiance S is held against independent path samples L₁, L₂ of the truth:
//! S − (L₁ + L₂)/2 is an unbiased sample of the error, (S − L₁)(S − L₂) one of its square, however noisy the paths.
//! Emission is left out: it is stored as it is.

use crate::ways::cpu::Looker;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use sheen_solver::geometry::sampling::cosine_direction;
use sheen_solver::path::{Aim, Probe, Probes, Sampler};
use sheen_solver::{Observer, PathTracer, Progress, Rgb, Solution};

/// Probes between two reports.
const BATCH: u32 = 1 << 12;
/// Standard deviations to either side of 95 % of a normal distribution.
const NORMAL_95: f64 = 1.959_964;

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

/// One probe, times its weight: error of the solution's radiance against two samples of the truth [mean over channels];
/// square errors are summed over channels before their mean.
#[derive(Clone, Copy, Debug)]
struct Met {
    material: u32,
    weight: f64,
    difference: f64,
    truth: f64,
    square: f64,
}

impl Met {
    fn nothing(material: u32) -> Self {
        Self {
            material,
            weight: 0.0,
            difference: 0.0,
            truth: 0.0,
            square: 0.0,
        }
    }
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
        if probe.weight <= 0.0 {
            return Some(Met::nothing(probe.material));
        }
        let stored = look(solution, &looker, probe);
        Some(hold(stored, tracer, probe, sampler))
    };
    let places = Probes::new(tracer, Aim::Highlights);
    hold_all(solution, &places, probes, seed, observer, &hold)
}

/// Directions in which a point of a furnace looks for dark sides.
const LOOKS: u32 = 256;
/// From a point nothing is looked for nearer than this share of the way to what stands opposite.
const NEAR: f32 = 1e-3;

/// Holds the `solution` of a furnace ([`sheen_solver::solve::solve_furnace`]) against the one `radiance` that it has
/// everywhere; `tracer`: of its scene. Sides that are dark, where none of the scene's lamps reaches, are left out, and so
/// are points that see them: a floor below a box receives less, as it should.
pub fn verify_furnace(
    solution: &Solution,
    radiance: f32,
    tracer: &PathTracer,
    probes: u32,
    seed: u32,
    observer: &mut dyn Observer,
) -> Option<Verification> {
    let looker = Looker::new(solution, &[]);
    let is_black = |eye: Vec3, direction: Vec3, near: f32| {
        looked(solution, &looker, eye, direction, near).is_black()
    };
    let sees_dark = |probe: &Probe, sampler: &mut Sampler| {
        let near = NEAR * probe.eye.distance(probe.point);
        (0..LOOKS / 2).any(|_| {
            let [x, y, z, w] = sampler.draw();
            [Vec2::new(x, y), Vec2::new(z, w)].into_iter().any(|at| {
                let direction = cosine_direction(probe.normal, at);
                is_black(probe.point, direction, near)
            })
        })
    };
    let hold = |probe: &Probe, sampler: &mut Sampler| {
        let stored = look(solution, &looker, probe);
        let error = (stored - Rgb::splat(radiance)).to_array().map(f64::from);
        let is_dark = stored.is_black()
            || is_black(probe.eye, -probe.direction, 0.0)
            || sees_dark(probe, sampler);
        (!is_dark).then(|| Met {
            material: probe.material,
            weight: 1.0,
            difference: error.iter().sum::<f64>() / 3.0,
            truth: f64::from(radiance),
            square: error.iter().map(|e| e * e).sum::<f64>() / 3.0,
        })
    };
    let places = Probes::new(tracer, Aim::Even);
    hold_all(solution, &places, probes, seed, observer, &hold)
}

fn hold_all(
    solution: &Solution,
    places: &Probes<'_>,
    probes: u32,
    seed: u32,
    observer: &mut dyn Observer,
    hold: &(impl Fn(&Probe, &mut Sampler) -> Option<Met> + Sync),
) -> Option<Verification> {
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
    looked(solution, looker, probe.eye, probe.direction, 0.0)
}

/// The solution's radiance from `eye` along `direction`, of what is not nearer than `near`.
fn looked(solution: &Solution, looker: &Looker<'_>, eye: Vec3, direction: Vec3, near: f32) -> Rgb {
    let seen = looker.look(
        eye,
        direction.as_dvec3(),
        f64::from(near),
        |vertex, meeting| meeting.shaded(solution, vertex),
    );
    Rgb::from(seen.map(|channel| channel as f32))
}

/// `stored` radiance against two paths.
fn hold(stored: Rgb, tracer: &PathTracer, probe: &Probe, sampler: &mut Sampler) -> Met {
    let Probe {
        eye,
        direction,
        material,
        weight,
        ..
    } = *probe;
    let stored = stored - tracer.emitted(eye, direction);
    let truth = [(); 2].map(|()| tracer.reflected(eye, direction, sampler));
    let [first, second] = truth.map(|sample| (stored - sample).to_array().map(f64::from));
    let square: f64 = first.iter().zip(second).map(|(a, b)| a * b).sum();
    let truth = 0.5 * f64::from(truth[0].mean() + truth[1].mean());
    let weight = f64::from(weight);
    Met {
        material,
        weight,
        difference: weight * (f64::from(stored.mean()) - truth),
        truth: weight * truth,
        square: weight * square / 3.0,
    }
}

/// Means over some probes, with their intervals: `None` below two.
fn errors<'a>(met: impl Iterator<Item = &'a Met> + Clone) -> Option<Errors> {
    let count = met.clone().count();
    let sum = |of: &dyn Fn(&Met) -> f64| met.clone().map(of).sum::<f64>();
    let weights = sum(&|one| one.weight);
    if count < 2 || weights <= 0.0 {
        return None;
    }
    let radiance = sum(&|one| one.truth) / weights;
    let per_radiance = if radiance > 0.0 { 1.0 / radiance } else { 0.0 };
    let bias = sum(&|one| one.difference) / weights * per_radiance;
    // Ratios of means, linearised.
    let unbiased = count as f64 / (count as f64 - 1.0);
    let spread = sum(&|one| (one.difference - bias * one.truth).powi(2));
    let margin = NORMAL_95 * (spread * unbiased).sqrt() / weights * per_radiance;
    let square = sum(&|one| one.square) / weights;
    let off = |one: &Met| one.square - square * one.weight;
    let squares = sum(&|one| off(one).powi(2)) * unbiased;
    let skewness = sum(&|one| off(one).powi(3)) / squares.powf(1.5);
    let ends = interval(square, squares.sqrt() / weights, skewness);
    let root = |square: f64| square.max(0.0).sqrt() * per_radiance;
    let [low, high] = ends.map(root);
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
            low,
            high,
        },
    })
}

/// The interval of a mean with this standard error, whose terms are skewed by few large ones: `skewness` is that of the
/// mean. Hall, *On the removal of skewness by transformation* (1992): t + γ t²/3 + γ² t³/27 + γ/6 is nearly normal.
fn interval(mean: f64, error: f64, skewness: f64) -> [f64; 2] {
    /// Below this the cubic is a straight line to double precision.
    const STRAIGHT: f64 = 1e-6;
    let inverse = |normal: f64| {
        if skewness.abs() > STRAIGHT {
            ((1.0 + skewness * (normal - skewness / 6.0)).cbrt() - 1.0) * 3.0 / skewness
        } else {
            normal
        }
    };
    [NORMAL_95, -NORMAL_95].map(|side| mean - error * inverse(side))
}
