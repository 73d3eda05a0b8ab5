//! Entry to a solve: scene in, solution out, with an observer that may stop it.

mod escape;
mod furnace;
mod prepare;
mod series;
mod shooting;

use crate::config::{Quality, Settings};
use crate::error::SolveError;
use crate::export;
use crate::scene::Scene;
use crate::solution::Solution;
pub use furnace::{enclosed, solve_furnace};
pub use prepare::{Emission, Prepared};
pub(crate) use shooting::transport;
pub use shooting::{FirstLinks, Transported, first_links, transported};
use std::ops::ControlFlow;
use std::time::Instant;

/// Settings of a solve.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SolveConfig {
    /// The one knob.
    pub quality: Quality,
    /// Stop refining after this many seconds and keep what is there. `None`: no limit.
    pub time_limit_s: Option<f64>,
    /// Deepest subdivision of the directional basis, 1..=7. `None`: follows from quality and gloss.
    pub max_level: Option<u32>,
    /// Threads. `None`: all of the machine.
    pub threads: Option<usize>,
    /// Share of the emitted power that a link may be wrong by (§3.1). `None`: follows from quality.
    pub link_tolerance: Option<f32>,
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
        Ok(settings)
    }
}

/// How far a solve has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What is being done now.
    pub phase: &'static str,
    /// Estimated part of the whole that is done, 0..=1, never falling.
    pub done: f32,
}

/// Is told of the progress of a solve after each bounded piece of work, and may stop it.
pub trait Observer: Send {
    /// `Break` stops the solve with what it has.
    fn report(&mut self, progress: &Progress) -> ControlFlow<()>;
}

impl Observer for () {
    fn report(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Joins the caller's observer and the time limit; remembers that one of them said stop.
pub(crate) struct Watch<'a> {
    observer: &'a mut dyn Observer,
    started: Instant,
    time_limit_s: Option<f64>,
    stopped: bool,
    done: f32,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(observer: &'a mut dyn Observer, time_limit_s: Option<f64>) -> Self {
        Self {
            observer,
            started: Instant::now(),
            time_limit_s,
            stopped: false,
            done: 0.0,
        }
    }

    /// Reports; `Break` once stopped, and ever after.
    pub(crate) fn report(&mut self, phase: &'static str, done: f32) -> ControlFlow<()> {
        self.done = self.done.max(done.clamp(0.0, 1.0));
        let late = self
            .time_limit_s
            .is_some_and(|limit| self.started.elapsed().as_secs_f64() > limit);
        let stop = self
            .observer
            .report(&Progress {
                phase,
                done: self.done,
            })
            .is_break();
        self.stopped |= late || stop;
        if self.stopped {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// True when the rest is to be kept short.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped
    }
}

/// Solves `scene`: hierarchical radiance clustering with illumination samples (§3), shooting (§3.4), then export of
/// directional light per vertex (§5.2). Errors: settings out of range, materials without loss, light that grows
/// beyond numbers. When the observer stops it, the solution holds what was found until then.
pub fn solve(
    scene: &Scene,
    config: &SolveConfig,
    observer: &mut dyn Observer,
) -> Result<Solution, SolveError> {
    solve_prepared(scene, config, observer, |settings| {
        Prepared::new(scene, settings)
    })
}

/// The same of a scene that `prepare` makes ready.
fn solve_prepared(
    scene: &Scene,
    config: &SolveConfig,
    observer: &mut dyn Observer,
    prepare: impl Fn(&Settings) -> Prepared + Sync,
) -> Result<Solution, SolveError> {
    let settings = config.settings()?;
    check_loss(scene)?;
    let mut watch = Watch::new(observer, config.time_limit_s);
    let mut work = || -> Result<Solution, SolveError> {
        let prepared = prepare(&settings);
        let mut transported = transport(&prepared, &settings, &mut watch)?;
        let mut solution =
            export::export(scene, &prepared, &settings, &mut transported, &mut watch);
        solution.stats.solve.quality = f64::from(config.quality.value());
        Ok(solution)
    };
    let mut solution = match config.threads {
        None => work(),
        Some(threads) => match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(work),
            // A system that gives no threads still has the pool that exists.
            Err(_) => work(),
        },
    }?;
    solution.stats.solve.wall_s = watch.started.elapsed().as_secs_f64();
    Ok(solution)
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
