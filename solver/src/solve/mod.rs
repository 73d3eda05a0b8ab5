//! Entry to a solve: scene in, solution out, with an observer that may stop it.

mod arrived;
mod collected;
mod escape;
mod furnace;
mod gathering;
mod iteration;
mod prepare;
mod reflecting;
mod series;
mod shooting;
mod watch;

use crate::config::{Basis, Method, Quality, Refiner, Scheme, Settings, Strata, Visibility};
use crate::error::SolveError;
use crate::export;
use crate::scene::Scene;
use crate::solution::Solution;
pub use arrived::Arrived;
pub use furnace::{enclosed, solve_furnace};
pub(crate) use iteration::transport;
pub use iteration::{FirstLinks, Transported, first_links, transported};
pub use prepare::{Emission, Prepared};
pub(crate) use watch::Watch;
pub use watch::{Observer, Progress};

/// Settings of a solve.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SolveConfig {
    /// The one knob.
    pub quality: Quality,
    /// Stop refining after this many seconds and keep what is there. `None`: no limit.
    pub time_limit_s: Option<f64>,
    /// Deepest subdivision of the directional basis, 1..=7. `None`: follows from quality and gloss.
    pub max_level: Option<u32>,
    /// Bytes that the data of a solve may take: quality is lowered until they fit. What the process needs besides is not
    /// counted. `None`: no limit.
    pub memory_limit: Option<u64>,
    /// ε of the directional refiner at vertices (§4.2), above 0, at most 10; that of transport keeps its ratio to it.
    /// `None`: follows from quality.
    pub epsilon: Option<f32>,
    /// Threads. `None`: all of the machine.
    pub threads: Option<usize>,
    /// Share of the emitted power that a link may be wrong by (§3.1). `None`: follows from quality.
    pub link_tolerance: Option<f32>,
    /// What becomes of light that arrives. Others than the default exist for comparison.
    pub method: Method,
    /// Which light an iteration moves. Others than the default exist for comparison.
    pub scheme: Scheme,
    /// When directions are refined. Others than the default exist for comparison.
    pub refiner: Refiner,
    /// What distributions are stored on. Others than the default exist for comparison.
    pub basis: Basis,
    /// How links find what stands between their ends. Others than the default exist for comparison.
    pub visibility: Visibility,
    /// Rays along each axis of the stratification of a link between nodes, however weak, and of a strong one to a vertex,
    /// 1..=16; their square is cast. `None`: follows from quality.
    pub strata: Option<u32>,
    /// Gather at vertices, instead of averaging what the elements around them show (§5.2). `None`: follows from quality.
    pub gather: Option<bool>,
    /// ε in transport, above 0, at most 10. `None`: follows from that at vertices.
    pub transport_epsilon: Option<f32>,
    /// Radiance whose direction transport forgets, as a share of the mean of the scene, at least 0. `None`: follows from
    /// quality.
    pub least_directional: Option<f32>,
}

impl SolveConfig {
    /// The settings that follow. Errors: a knob outside its range.
    pub fn settings(&self) -> Result<Settings, SolveError> {
        let mut settings = Settings::of(self.quality);
        let check = |ok: bool, setting, value: f64, expected| {
            if ok {
                Ok(())
            } else {
                Err(SolveError::Setting {
                    setting,
                    value,
                    expected,
                })
            }
        };
        if let Some(seconds) = self.time_limit_s {
            check(
                seconds > 0.0 && seconds.is_finite(),
                "time limit",
                seconds,
                "more than 0 s",
            )?;
        }
        if let Some(bytes) = self.memory_limit {
            check(bytes > 0, "memory limit", bytes as f64, "more than 0 bytes")?;
        }
        if let Some(level) = self.max_level {
            check(
                (1..=7).contains(&level),
                "levels",
                f64::from(level),
                "within 1..7",
            )?;
            settings.transport_level = level;
            settings.display_level = level;
        }
        if let Some(epsilon) = self.epsilon {
            let in_range = epsilon > 0.0 && epsilon <= 10.0;
            check(
                in_range,
                "epsilon",
                f64::from(epsilon),
                "above 0, at most 10",
            )?;
            settings.transport_epsilon *= epsilon / settings.epsilon;
            settings.cluster_epsilon *= epsilon / settings.epsilon;
            settings.epsilon = epsilon;
        }
        if let Some(epsilon) = self.transport_epsilon {
            let in_range = epsilon > 0.0 && epsilon <= 10.0;
            check(
                in_range,
                "transport epsilon",
                f64::from(epsilon),
                "above 0, at most 10",
            )?;
            settings.transport_epsilon = epsilon;
            settings.cluster_epsilon = epsilon;
        }
        if let Some(threads) = self.threads {
            check(
                (1..=1024).contains(&threads),
                "threads",
                threads as f64,
                "within 1..1024",
            )?;
        }
        if let Some(tolerance) = self.link_tolerance {
            let in_range = tolerance > 0.0 && tolerance <= 1.0;
            check(
                in_range,
                "link tolerance",
                f64::from(tolerance),
                "above 0, at most 1",
            )?;
            settings.link_tolerance = tolerance;
        }
        if let Some(share) = self.least_directional {
            check(
                share >= 0.0 && share.is_finite(),
                "least directional radiance",
                f64::from(share),
                "at least 0",
            )?;
            settings.least_directional = share;
        }
        if let Some(strata) = self.strata {
            check(
                (1..=16).contains(&strata),
                "strata",
                f64::from(strata),
                "within 1..16",
            )?;
            settings.strata = Strata::Even(strata);
            settings.vertex_strata = strata;
        }
        settings.gather = self.gather.unwrap_or(settings.gather);
        (settings.method, settings.scheme) = (self.method, self.scheme);
        (settings.refiner, settings.basis) = (self.refiner, self.basis);
        settings.visibility = self.visibility;
        Ok(settings)
    }
}

/// Solves `scene`: hierarchical radiance clustering with illumination samples (§3), shooting (§3.4), then export of
/// directional light per vertex (§5.2). Errors: settings out of range, materials without loss, light that grows
/// beyond numbers, data that does not fit into the memory limit at any quality. When the observer stops it, the solution holds what was found until then.
pub fn solve(
    scene: &Scene,
    config: &SolveConfig,
    observer: &mut dyn Observer,
) -> Result<Solution, SolveError> {
    solve_prepared(scene, config, observer, |settings, watch| {
        Prepared::watched(scene, settings, watch)
    })
}

/// The same of a scene that `prepare` makes ready.
fn solve_prepared(
    scene: &Scene,
    config: &SolveConfig,
    observer: &mut dyn Observer,
    prepare: impl Fn(&Settings, &mut Watch<'_>) -> Prepared + Sync,
) -> Result<Solution, SolveError> {
    config.settings()?;
    check_loss(scene)?;
    check_memory(scene, config)?;
    let mut watch = Watch::new(observer, config.time_limit_s, config.memory_limit);
    let mut work = || {
        let mut config = config.clone();
        loop {
            let settings = config.settings()?;
            let prepared = prepare(&settings, &mut watch);
            let solved = solve_once(scene, &prepared, &settings, &mut watch);
            let Some(needed) = watch.take_exceeded() else {
                let mut solution = solved?;
                solution.stats.solve.quality = f64::from(config.quality.value());
                return Ok(solution);
            };
            let quality = config.quality.value();
            if quality <= 0.0 {
                return Err(SolveError::Memory {
                    limit: config.memory_limit.unwrap_or(0),
                    needed,
                });
            }
            config.quality = Quality::new((quality - QUALITY_STEP).max(0.0))?;
        }
    };
    let mut solution: Solution = match config.threads {
        None => work(),
        Some(threads) => match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(work),
            // A system that gives no threads still has the pool that exists.
            Err(_) => work(),
        },
    }?;
    solution.stats.solve.wall_s = watch.seconds();
    Ok(solution)
}

/// By how much the quality is lowered when a solve does not fit into memory.
const QUALITY_STEP: f32 = 0.5;

fn solve_once(
    scene: &Scene,
    prepared: &Prepared,
    settings: &Settings,
    watch: &mut Watch<'_>,
) -> Result<Solution, SolveError> {
    let mut transported = transport(prepared, settings, watch)?;
    Ok(export::export(
        scene,
        prepared,
        settings,
        &mut transported,
        watch,
    ))
}

/// Refuses scenes whose data cannot fit into the memory limit at any quality.
fn check_memory(scene: &Scene, config: &SolveConfig) -> Result<(), SolveError> {
    /// A large plane of triangles, one side lit, takes this much at draft.
    const LEAST_PER_TRIANGLE: u64 = 400;
    let needed = LEAST_PER_TRIANGLE * scene.triangles().len() as u64;
    match config.memory_limit {
        Some(limit) if needed > limit => Err(SolveError::Memory { limit, needed }),
        _ => Ok(()),
    }
}

/// Refuses diffuse reflectances of 1: in a closed scene the light would never end. Glossy lobes lose light at grazing
/// angles, so a sum of 1 has a limit.
fn check_loss(scene: &Scene) -> Result<(), SolveError> {
    for material in scene.materials() {
        let albedo = material.diffuse.max_channel();
        if albedo >= 1.0 {
            return Err(SolveError::NoLoss {
                material: material.name.clone(),
                albedo,
            });
        }
    }
    Ok(())
}
