//! Light to come: what each iteration keeps of the light before it, and the sum of all iterations that are not made.

use super::escape::Escape;
use crate::hierarchy::detail::Detail;
use crate::hierarchy::{Hierarchy, NodeId};
use glam::DVec3;

/// The factor per channel that makes the light `received` what of the light `sent` neither escaped nor was taken: a
/// difference within three standard deviations of what is known to escape is none.
///
/// Links are right to a few tenths of a per cent: where surfaces take less than that, as in closed rooms with
/// reflectances near 1, the sum over thousands of iterations would be wrong by more than itself.
pub(super) fn conserving(sent: DVec3, escape: &Escape, received: DVec3) -> DVec3 {
    /// Links that are wrong by more have another fault, which no factor mends.
    const MOST: f64 = 0.1;
    let of_channel = |c: usize| {
        let kept = sent[c] * (1.0 - escape.share[c] - escape.taken[c]);
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

/// How well a geometric series stands for the iterations to come, patch by patch: a room behind a small opening, or
/// the inside of a box, may keep its light longer than the rest of the scene.
pub(super) struct Drift {
    patches: Vec<Patch>,
    /// Of the light of the last two iterations; lossless before the first.
    last_ratio: f64,
}

struct Patch {
    node: NodeId,
    area: f64,
    /// How much its error counts: its area, or the part of it that is looked at with the things on it.
    weight: f64,
    /// All power that left it so far.
    sent: f64,
    /// Its share of the power of the last iteration.
    share: f64,
    /// By how much that differed from the one before.
    moved: Option<f64>,
}

impl Drift {
    /// Before the first iteration, from all elements and the power that nodes `emitted`.
    pub(super) fn new(hierarchy: &Hierarchy, emitted: &[f32], detail: &Detail) -> Self {
        let all = total(emitted);
        let patches = hierarchy.elements.iter().map(|element| {
            let sent = f64::from(emitted[element.node as usize]);
            let node = hierarchy.node(element.node);
            let area = f64::from(node.area);
            Patch {
                node: element.node,
                area,
                weight: area.min(f64::from(detail.at(node.centre)).powi(2)),
                sent,
                share: if all > 0.0 { sent / all } else { 0.0 },
                moved: None,
            }
        });
        Self {
            patches: patches.collect(),
            last_ratio: 1.0,
        }
    }

    /// What the sum would be wrong by if this were the last iteration, which made `light` (power of nodes, times `factor`) and a
    /// `ratio` of what was before: the root of the weighted mean square, as a share of the light of each patch.
    ///
    /// Shares of patches move by D, and are taken to go on moving by D q, D q², … with q as seen last. Weighted with
    /// the power rᵏ of the iterations, this sums to D q r / ((1 − r)(1 − q r)) of the power.
    pub(super) fn error(&mut self, light: &[f32], factor: f64, ratio: f64) -> f64 {
        /// Slower series have no sum, or are mostly rounding.
        const SLOWEST: f64 = 0.999_99;
        let all = total(light);
        if all <= 0.0 {
            return 0.0;
        }
        // What comes back from the underside of a table is little of all, but keeps half of itself from there on.
        let ratio = std::mem::replace(&mut self.last_ratio, ratio).max(ratio);
        let series = 1.0 / (1.0 - ratio.min(SLOWEST));
        let (mut squares, mut weight) = (0.0, 0.0);
        for patch in &mut self.patches {
            let power = f64::from(light[patch.node as usize]);
            let moved = power / all - patch.share;
            let falls = match patch.moved {
                Some(last) if last != 0.0 => (moved / last).abs(),
                Some(_) if moved == 0.0 => 0.0,
                // Light that has just come for the first time.
                _ => 1.0,
            };
            let goes_on = (falls * ratio).min(SLOWEST);
            let wrong = moved.abs() * all * series * goes_on / (1.0 - goes_on);
            patch.share = power / all;
            patch.moved = Some(moved);
            let sum = patch.sent + factor * power * series;
            patch.sent += factor * power;
            if sum > 0.0 {
                squares += patch.weight * (factor * wrong / sum).min(1.0).powi(2);
                weight += patch.weight;
            }
        }
        if weight > 0.0 {
            (squares / weight).sqrt()
        } else {
            0.0
        }
    }

    /// Adds `light` (power of nodes) to what left the patches so far.
    pub(super) fn add(&mut self, light: &[f32]) {
        for patch in &mut self.patches {
            patch.sent += f64::from(light[patch.node as usize]);
        }
    }

    /// Exitance of patches in `light` (power of nodes, times `factor`), the root of the weighted mean square, as a share of the
    /// typical exitance of all light so far: the square of the mean root. In the open little light of all is left after
    /// one reflection, but it is all that shadows have. Not that of the brightest patch: the inside of a lamp is small and
    /// lights itself.
    pub(super) fn glow(&self, light: &[f32], factor: f64) -> f64 {
        let (mut roots, mut area, mut squares, mut weight) = (0.0, 0.0, 0.0, 0.0);
        for patch in self.patches.iter().filter(|patch| patch.area > 0.0) {
            roots += (patch.sent * patch.area).sqrt();
            area += patch.area;
            let power = f64::from(light[patch.node as usize]);
            squares += patch.weight * (factor * power / patch.area).powi(2);
            weight += patch.weight;
        }
        if roots > 0.0 && weight > 0.0 {
            (squares / weight).sqrt() / (roots / area).powi(2)
        } else {
            0.0
        }
    }
}

fn total(light: &[f32]) -> f64 {
    f64::from(light[0])
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
            ..Escape::default()
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
