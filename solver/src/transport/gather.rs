//! Gathering at vertices (design §4, Export): the bounded propagation with a point as receiver.
//!
//! The form factor from a polygon to a point is exact, and so is what hides of it, so a diffuse leaf needs no
//! refinement at all: links are split only where the sender's radiance differs over its parts or directions.
//! Cost: a bound and a pyramid per link, rays where much stands in between.

use crate::geometry::Cone;
use crate::hierarchy::{Hierarchy, NONE};
use crate::transport::exitant::Exitant;
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Bounds, Receiver, Sender, SenderId, bounds};
use crate::transport::occlusion::{Candidates, Geometry, Occlusion, Target};
use crate::transport::propagate::{Environment, Gloss, LinkStats, is_near};
use crate::transport::rays::Rays;
use crate::transport::sample::unoccluded_sample;

/// Links weaker than this share of the accuracy are weighed by one ray.
const FAINT: f32 = 1.0 / 8.0;

/// A partly hidden sender may be this share of the accuracy off because its radiance is uneven: such errors have one
/// sign and add up.
const UNEVEN: f32 = 0.05;

/// Clusters stand for what they hold up to this share of the accuracy: their visibility is one ray's.
const CLUSTER: f32 = 0.25;

/// Links between elements up to this share of the accuracy are searched for occluders only where rays differ.
const WEAK: f32 = 0.3;

/// What a gathering reads.
pub struct Gather<'a> {
    /// What does not change.
    pub environment: &'a Environment<'a>,
    /// Light that leaves.
    pub exitant: &'a Exitant,
    /// Nodes when the exitant light was computed: later ones do not send.
    pub node_count: usize,
    /// Rays along each axis of the stratification of an important link; their square is cast.
    pub strata: u32,
}

impl Gather<'_> {
    /// All light that reaches a vertex, from the accuracy `limit` [W·m⁻², mean over channels].
    pub fn at(
        &self,
        hierarchy: &Hierarchy,
        receiver: &Receiver,
        gloss: Gloss,
        limit: f32,
        samples: &mut Vec<IlluminationSample>,
    ) -> LinkStats {
        let mut stats = LinkStats::default();
        let mut occlusion = Occlusion {
            geometry: Geometry {
                tree: self.environment.tree,
                shapes: self.environment.shapes,
            },
            eye: receiver.centre,
            own: receiver.patch,
            lists: Vec::new(),
        };
        let mut stack = vec![(SenderId::whole(0), Candidates::Unknown)];
        while let Some((id, candidates)) = stack.pop() {
            if self.exitant.peak[id.node as usize] <= 0.0 {
                continue;
            }
            let sender = Sender::new(hierarchy, id);
            if sender.patch == receiver.patch && sender.patch != NONE {
                continue;
            }
            let is_good =
                |bounds: &Bounds| self.error(hierarchy, bounds, receiver, &sender, gloss) <= limit;
            let bounds = bounds(receiver, &sender, self.exitant, is_good);
            if bounds.high <= 0.0 {
                continue;
            }
            let can_refine = sender.can_refine();
            let mut candidates = candidates;
            if can_refine && !is_good(&bounds) {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            let Some(mut sample) = unoccluded_sample(receiver, &sender, self.exitant) else {
                continue;
            };
            let strength = sample.irradiance.mean();
            let rays = Rays {
                occluders: self.environment.occluders,
                exitant: self.exitant,
                hierarchy,
                receiver_node: NONE,
                receiver,
                sender: &sender,
            };
            // A few rays that agree are enough for the weaker ones, and cheaper than a search.
            if sender.polygon.is_some() && strength > FAINT * limit && strength <= WEAK * limit {
                let (transmittance, mixed) = rays.strata(2, &mut stats);
                if !mixed {
                    stats.links += 1;
                    if !transmittance.is_black() {
                        sample.irradiance = sample.irradiance * transmittance;
                        samples.push(sample);
                    }
                    continue;
                }
            }
            if strength > FAINT * limit
                && let Some(polygon) = &sender.polygon
                && let Some(target) = Target::new(
                    polygon,
                    sender.normal,
                    sender.patch,
                    receiver.centre,
                    receiver.normal,
                )
            {
                candidates = occlusion.candidates(
                    &target.pyramid(receiver.normal),
                    sender.patch,
                    candidates,
                );
                if let Candidates::List(from, to) = candidates
                    && let Some(visible) = occlusion.visible(&target, from, to)
                {
                    if from < to || target.is_cut {
                        let above = target.vector();
                        let whole = Cone::new(polygon, receiver.centre).vector_irradiance();
                        let (above_length, whole_length) = (above.length(), whole.length());
                        let share = visible.length() / whole_length;
                        let uneven = self.exitant.unevenness(id.node, sender.node_area, share);
                        if can_refine
                            && hierarchy.has_children_among(id.node, self.node_count)
                            && strength * whole_length * uneven > UNEVEN * limit * above_length
                        {
                            sender.parts(hierarchy, self.node_count, |part| {
                                stack.push((part, candidates))
                            });
                            continue;
                        }
                        sample = sample.seen_partly(above, visible);
                    }
                    stats.links += 1;
                    stats.clear_shafts += u64::from(from == to);
                    if !sample.irradiance.is_black() {
                        samples.push(sample);
                    }
                    continue;
                }
            }
            if sender.polygon.is_none() && strength > CLUSTER * limit {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            let strata = if strength > limit { self.strata } else { 1 };
            let (transmittance, mixed) = rays.strata(strata, &mut stats);
            if mixed && can_refine && strength > limit {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            stats.links += 1;
            if !transmittance.is_black() {
                samples.push(IlluminationSample {
                    irradiance: sample.irradiance * transmittance,
                    ..sample
                });
            }
        }
        self.point_lights(receiver, samples, &mut stats);
        stats
    }

    /// How far the sample of a link may be from the truth [W·m⁻²].
    fn error(
        &self,
        hierarchy: &Hierarchy,
        bounds: &Bounds,
        receiver: &Receiver,
        sender: &Sender,
        gloss: Gloss,
    ) -> f32 {
        if is_near(bounds, receiver, sender) {
            return f32::INFINITY;
        }
        let node = sender.id.node as usize;
        let mut error = bounds.high - bounds.low;
        if sender.polygon.is_some() && self.exitant.distribution[node].is_none() {
            // The form factor is exact: what is left is how far the radiance of parts is from their mean.
            if !hierarchy.has_children_among(sender.id.node, self.node_count) {
                error = 0.0;
            }
        }
        if gloss.share > 0.0 && bounds.distance > 0.0 {
            // The lobe of a sample is as wide as its sender: only the sender's shape is lost.
            let seen = 0.5 * sender.radius / (bounds.distance * gloss.width);
            error += bounds.high * gloss.share * (seen * seen).min(1.0);
        }
        error
    }

    fn point_lights(
        &self,
        receiver: &Receiver,
        samples: &mut Vec<IlluminationSample>,
        stats: &mut LinkStats,
    ) {
        for &(position, intensity) in self.environment.point_lights {
            let offset = position - receiver.centre;
            let distance_squared = offset.length_squared();
            if distance_squared <= 0.0 || receiver.normal.is_some_and(|n| n.dot(offset) <= 0.0) {
                continue;
            }
            let passed = self.environment.occluders.transmittance(
                receiver.centre,
                position,
                [receiver.patch, NONE],
            );
            stats.rays += 1;
            if !passed.is_black() {
                samples.push(IlluminationSample {
                    direction: offset.normalize(),
                    irradiance: intensity * passed / distance_squared,
                    spread: 0.0,
                    parallax: None,
                });
            }
        }
    }
}
