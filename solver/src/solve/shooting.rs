//! Shooting (§3.4): iteration i moves only light that has been reflected exactly i times.
//!
//! New samples are reflected once, then appended to the accumulated ones where something glossy will reflect them once
//! more; distributions live for one iteration. At the end all accumulated samples are reflected together: that is the
//! exitant light that the export gathers.

use super::Watch;
use super::iteration::{Iteration, MAX_ITERATIONS, PHASE, mean};
use super::series::{Drift, conserving, geometric};
use crate::error::SolveError;
use crate::radiometry::Rgb;
use glam::DVec3;
use std::time::Instant;

/// Runs the iterations. Errors: light that is not finite.
pub(super) fn shoot(state: &mut Iteration<'_>, watch: &mut Watch<'_>) -> Result<(), SolveError> {
    // Unshot light as `sent` has it, and what it must be multiplied with.
    let mut sent = state.emitted + state.of_point_lights();
    let mut factor = DVec3::ONE;
    let emitted = mean(sent);
    let solve = &mut state.stats.solve;
    (solve.emitted_w, solve.unshot_w) = (emitted, emitted);
    if emitted <= 0.0 {
        return Ok(());
    }
    let goal = f64::from(state.settings.unshot_share);
    let mut drift = Drift::new(&state.hierarchy, &state.sent.power, &state.prepared.detail);
    let mut open = 1.0;
    for iteration in 0..MAX_ITERATIONS {
        // Each reflection weakens the light: progress goes with the logarithm of what is open.
        let done = 0.5 * (1.0 - (open / goal).ln() / (1.0 / goal).ln()) as f32;
        let escape = state.escape(iteration == 0, mean(sent * factor) / emitted);
        let mut new = state.propagated(iteration == 0, iteration as u32, emitted, watch, done);
        let (irradiance, reflected) = state.send(&new, false, emitted);
        let _ = watch.report(PHASE, done, state.held() + new.bytes());
        state.stats.solve.iterations = iteration + 1;
        state.check_finite(iteration)?;

        let stopped = watch.is_stopped();
        let correction = if stopped {
            DVec3::ONE
        } else {
            conserving(sent, &escape, reflected.received)
        };
        let shot = sent * factor;
        factor *= correction;
        let left = reflected.exitance * factor;
        state.stats.solve.reflected_w.push(mean(left));
        let tail = if stopped {
            DVec3::ONE
        } else {
            geometric(shot, left)
        };
        let ratio = mean(left) / mean(shot);
        let wrong = drift.error(&state.sent.power, mean(factor), ratio);
        let glow = drift.glow(&state.sent.power, mean(factor));
        open = wrong.min(glow.max(mean(left) / emitted));
        let is_last = stopped || open <= goal;

        // The last iteration stands for all that would follow.
        let weight = if is_last { factor * tail } else { factor };
        let weight = Rgb::from(weight.to_array().map(|c| c as f32));
        new.scale(weight);
        state.collected.add(&state.hierarchy, irradiance, weight);
        let started = Instant::now();
        state.accumulate(new);
        let solve = &mut state.stats.solve;
        solve.phases_s.push += started.elapsed().as_secs_f64();
        let weight = if is_last { tail } else { DVec3::ONE };
        solve.escaped_w += mean(escape.share * shot * weight);
        state.taken += mean(escape.taken * shot * weight);
        solve.corrected_w += mean(reflected.received * (factor - factor / correction) * weight);
        sent = reflected.exitance;
        if is_last {
            // Of an iteration that was stopped, some receivers had nothing yet.
            let arrived = reflected.received * factor;
            let on_its_way = shot * (1.0 - escape.share - escape.taken) - arrived;
            solve.unshot_w = if stopped {
                mean(left) + mean(on_its_way).max(0.0)
            } else {
                0.0
            };
            break;
        }
        solve.unshot_w = mean(left);
    }
    Ok(())
}
