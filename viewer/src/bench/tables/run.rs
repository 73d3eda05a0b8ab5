//! One solve that is measured.

use crate::camera::View;
use crate::memory::peak_during;
use sheen_solver::{Observer, Scene, Solution, SolveConfig, SolveError, solve};

/// A scene and how it is looked at.
pub struct Case {
    /// As tables name it.
    pub name: String,
    /// What is solved.
    pub scene: Scene,
    /// What pictures show.
    pub view: View,
}

/// What a solve gave and took.
pub(super) struct Run {
    pub(super) solution: Solution,
    /// Elapsed time of the fastest [s].
    pub(super) seconds: f64,
    /// Bytes allocated at most.
    pub(super) allocated: u64,
}

/// Short solves are repeated until they have taken this long [s].
const LONG_ENOUGH: f64 = 10.0;
/// But not more often than this.
const MOST: u32 = 7;

/// Solves, again and again if that is short: time is the shortest. Stopped by the observer: `None`.
pub(super) fn run(
    case: &Case,
    config: &SolveConfig,
    observer: &mut dyn Observer,
) -> Result<Option<Run>, SolveError> {
    let mut best: Option<Run> = None;
    let mut spent = 0.0;
    for _ in 0..MOST {
        let (solution, allocated) = peak_during(|| solve(&case.scene, config, observer));
        let solution = solution?;
        let seconds = solution.stats.solve.wall_s;
        let done = sheen_solver::Progress {
            phase: "tables",
            done: 1.0,
        };
        if observer.report(&done).is_break() {
            return Ok(None);
        }
        spent += seconds;
        if best.as_ref().is_none_or(|best| seconds < best.seconds) {
            best = Some(Run {
                solution,
                seconds,
                allocated,
            });
        }
        if spent > LONG_ENOUGH {
            break;
        }
    }
    Ok(best)
}
