//! Light to come: what each iteration keeps of the light before it, and the sum of all iterations that are not made.

use super::escape::Escape;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::transport::exitant::Exitant;
use glam::DVec3;

/// The factor per channel that makes the light `received` what of the light `sent` did not escape. A difference within
/// three standard deviations of what is known to escape is none.
///
/// Links are right to a few tenths of a per cent: where surfaces take less than that, as in closed rooms with
/// reflectances near 1, the sum over thousands of iterations would be wrong by more than itself.
pub(super) fn conserving(sent: DVec3, escape: &Escape, received: DVec3) -> DVec3 {
    /// Links that are wrong by more have another fault, which no factor mends.
    const MOST: f64 = 0.1;
    let of_channel = |c: usize| {
        let kept = sent[c] * (1.0 - escape.share[c]);
        if received[c] <= 0.0 || (kept - received[c]).abs() <= 3.0 * escape.deviation[c] * sent[c] {
            return 1.0;
        }
        (kept / received[c]).clamp(1.0 - MOST, 1.0 + MOST)
    };
    DVec3::new(of_channel(0), of_channel(1), of_channel(2))
}

/// 1 + r + r² + …: what follows an iteration that sent `sent` and left `left` is it times this, if light goes on to
/// spread over the scene as it did. Light that does not weaken has no sum.
pub(super) fn geometric(sent: DVec3, left: DVec3) -> DVec3 {
    let of_channel = |c: usize| {
        let lost = sent[c] - left[c];
        if left[c] > 0.0 && lost > 0.0 {
            sent[c] / lost
        } else {
            1.0
        }
    };
    DVec3::new(of_channel(0), of_channel(1), of_channel(2))
}

/// How far the spread of light over the scene still is from the one that it keeps.
#[derive(Default)]
pub(super) struct Drift {
    /// Share of the light that the last iteration put elsewhere.
    moved: Option<f64>,
}

impl Drift {
    /// What share of the light is elsewhere in iterations to come than after this one, which made `after` of `before`
    /// (both pulled): a geometric series again. Infinite until two iterations can be compared.
    pub(super) fn left(&mut self, hierarchy: &Hierarchy, before: &Exitant, after: &Exitant) -> f64 {
        /// A slower fall of the differences is mostly rounding.
        const SLOWEST: f64 = 0.99;
        let total = |light: &Exitant| f64::from(light.power[0]);
        let (all_before, all_after) = (total(before), total(after));
        if all_before <= 0.0 || all_after <= 0.0 {
            return 0.0;
        }
        let was_leaf = |id: &NodeId| {
            (*id as usize) < before.len() && !hierarchy.has_children_among(*id, before.len())
        };
        let leaves = hierarchy.elements.iter().map(|element| element.node);
        let moved = leaves
            .filter(was_leaf)
            .map(|id| {
                let share = |light: &Exitant, all| f64::from(light.power[id as usize]) / all;
                (share(before, all_before) - share(after, all_after)).abs()
            })
            .sum::<f64>()
            * 0.5;
        let Some(last) = self.moved.replace(moved) else {
            return f64::INFINITY;
        };
        let ratio = if last > 0.0 { moved / last } else { 0.0 };
        let ratio = ratio.min(SLOWEST);
        moved * ratio / (1.0 - ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_links_lost_is_given_back_where_it_is_known() {
        let closed = Escape::default();
        let sent = DVec3::new(1.0, 2.0, 0.0);
        let factor = conserving(sent, &closed, DVec3::new(0.998, 2.004, 0.0));
        assert_eq!(factor, DVec3::new(1.0 / 0.998, 2.0 / 2.004, 1.0));
        let open = Escape {
            share: DVec3::splat(0.5),
            deviation: DVec3::splat(0.001),
        };
        // 0.2 % of what is sent is within three deviations, 1 % is not.
        let factor = conserving(DVec3::ONE, &open, DVec3::new(0.498, 0.49, 0.5));
        assert_eq!(factor, DVec3::new(1.0, 0.5 / 0.49, 1.0));
        let wrong = conserving(DVec3::ONE, &closed, DVec3::splat(0.5));
        assert_eq!(wrong, DVec3::splat(1.1));
    }

    #[test]
    fn the_tail_is_a_geometric_series() {
        let sum = geometric(DVec3::new(1.0, 2.0, 1.0), DVec3::new(0.999, 1.0, 1.0));
        assert!((sum.x - 1000.0).abs() < 1e-9 && sum.y == 2.0 && sum.z == 1.0);
    }
}
