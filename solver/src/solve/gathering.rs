//! Gathering (§3.4): every iteration moves all light that is known, and what arrives takes the place of what had arrived
//! before. Samples and the time to reflect them grow from iteration to iteration. The plain twin of shooting.

use super::Watch;
use super::arrived::Arrived;
use super::iteration::{Iteration, MAX_ITERATIONS, PHASE, mean};
use super::series::{Drift, conserving};
use crate::error::SolveError;
use crate::radiometry::Rgb;
use glam::DVec3;

/// Ratios of slower series are not told from 1.
const SLOWEST: f64 = 0.9999;

/// Runs the iterations, until what would follow is known to be next to nothing. Errors: light that is not finite.
pub(super) fn gather(state: &mut Iteration<'_>, watch: &mut Watch<'_>) -> Result<(), SolveError> {
    let of_lights = state.of_point_lights();
    let mut sent = state.emitted + of_lights;
    let emitted = mean(sent);
    let solve = &mut state.stats.solve;
    (solve.emitted_w, solve.unshot_w) = (emitted, emitted);
    if emitted <= 0.0 {
        return Ok(());
    }
    let goal = f64::from(state.settings.unshot_share);
    let mut drift = Drift::new(&state.hierarchy, &state.sent.power, &state.prepared.detail);
    // What links lose, as the iteration before found it.
    let mut correction = DVec3::ONE;
    let mut last_change = emitted;
    let mut open = 1.0f64;
    for iteration in 0..MAX_ITERATIONS {
        let done = 0.5 * (1.0 - (open.min(1.0) / goal).ln() / (1.0 / goal).ln()) as f32;
        let escape = state.escape(true, 1.0);
        // All of it arrives anew.
        state.arrived = Arrived::none(state.settings.method);
        let mut new = state.propagated(true, 0, emitted, watch, done);
        new.scale(Rgb::from(correction.to_array().map(|c| c as f32)));
        let before = std::mem::take(&mut state.sent.power);
        let (_, ledger) = state.send(&new, true, emitted);
        let _ = watch.report(PHASE, done, state.held() + new.bytes());
        state.arrived = new;
        state.check_finite(iteration)?;

        let change = mean(ledger.exitance + of_lights - sent);
        let solve = &mut state.stats.solve;
        solve.iterations = iteration + 1;
        solve
            .reflected_w
            .push(mean(ledger.exitance - state.emitted));
        solve.escaped_w = mean(escape.share * sent);
        solve.corrected_w = mean(ledger.received - ledger.received / correction);
        state.taken = mean(escape.taken * sent);
        // Light that has been reflected once more than before.
        let known = |node: usize| before.get(node).copied().unwrap_or(0.0);
        let powers = state.sent.power.iter().enumerate();
        let new_light: Vec<f32> = powers
            .map(|(node, power)| (power - known(node)).abs())
            .collect();
        let ratio = (change / last_change).clamp(0.0, SLOWEST);
        drift.add(&new_light);
        let glow = drift.glow(&new_light, 1.0);
        let follows = ratio / (1.0 - ratio);
        open = glow.max(change.abs() / emitted) * follows;
        solve.unshot_w = change.max(0.0) * follows;
        // The second iteration is the first whose losses are corrected.
        if watch.is_stopped() || (open <= goal && iteration > 0) {
            break;
        }
        correction = conserving(sent, &escape, ledger.received / correction);
        sent = ledger.exitance + of_lights;
        last_change = change;
    }
    Ok(())
}
