//! Gathering at vertices (design §4, Export): the bounded propagation with a point as receiver.
//!
//! The form factor from a polygon to a point is exact, and so is what hides of it, so a diffuse leaf needs no
//! refinement at all: links are split only where the sender's radiance differs over its parts or directions.
//! Cost: a bound and a pyramid per link, rays where much stands in between.

use crate::config::Visibility;
use crate::geometry::sampling::{about, spread};
use crate::geometry::{Cone, hash};
use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use crate::transport::blockers::Blockers;
use crate::transport::closure::Dark;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Bounds, Receiver, Sender, SenderId, bounds};
use crate::transport::occlusion::{Candidates, Geometry, Occlusion, Target};
use crate::transport::propagate::{Environment, Gloss, LinkStats, is_near};
use crate::transport::rays::{Few, Rays};
use crate::transport::sample::unoccluded_sample;
use glam::Vec3;

/// Links weaker than this share of the accuracy are weighed by one ray.
const FAINT: f32 = 1.0 / 8.0;

/// A partly hidden sender may be this share of the accuracy off because its radiance is uneven: such errors have one
/// sign and add up.
const UNEVEN: f32 = 0.01;

/// Clusters stand for what they hold up to this share of the accuracy: their visibility is one ray's.
const FAINT_CLUSTER: f32 = 0.25;

/// Links from elements up to this share of the accuracy are searched for occluders only where rays differ.
const WEAK: f32 = 0.3;

/// Clusters up to this share of the accuracy are opened only where rays differ.
const WEAK_CLUSTER: f32 = 0.5;

/// Links from elements up to this share of the accuracy that much stands before are weighed by four rays.
const HALF: f32 = 0.5;

/// Links of this many times the accuracy are never weighed by rays as one: all of them may miss an opening.
const STRONG: f32 = 2.0;

/// Weight of how far radiance differs over the directions to a vertex: caustics have the shape of what differs.
const DIRECTIONS: f32 = 4.0;

/// Weight of how far the radiance of parts of a sender is from its mean: such errors have one sign and add up.
const PARTS: f32 = 5.0;

/// Weight of all that a cluster may be wrong by: intensity towards the dark side of surfaces is badly known.
const CLUSTER: f32 = 4.0;

/// Weight of the shape of a sender that a lobe shows.
const SHAPE: f32 = 2.0;

/// Rays of a vertex that search for what does not send.
const DARK_RAYS: u32 = 64;

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
    /// How what stands in between is found.
    pub visibility: Visibility,
}

/// A link to a vertex.
struct VertexLink<'a> {
    receiver: &'a Receiver,
    sender: &'a Sender,
    bounds: &'a Bounds,
    /// As if nothing stood between.
    sample: Option<IlluminationSample>,
}

/// What is known without rays.
enum Exact {
    /// What arrives.
    Seen(IlluminationSample),
    /// The sender hides parts whose radiance is not like that of the others.
    Uneven,
    /// Too much stands in between, or it is a cluster.
    Unknown,
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
        let mut blockers = Blockers::new(receiver.centre, self.environment.shapes);
        let seed = hash::of_point(receiver.centre);
        let mut stack = vec![(SenderId::whole(0), Candidates::Unknown)];
        while let Some((id, candidates)) = stack.pop() {
            if self.exitant.peak[id.node as usize] <= 0.0 {
                continue;
            }
            let sender = Sender::new(hierarchy, id);
            if sender.patch == receiver.patch && sender.patch != NONE {
                continue;
            }
            let bounds = bounds(receiver, &sender, self.exitant, |_| true);
            if bounds.high <= 0.0 || blockers.hide(sender.lower, sender.upper) {
                continue;
            }
            let link = VertexLink {
                receiver,
                sender: &sender,
                bounds: &bounds,
                sample: self.unoccluded(receiver, &sender),
            };
            let can_refine = sender.can_refine();
            let mut candidates = candidates;
            if can_refine && self.error(hierarchy, &link, gloss, limit) > limit {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            let Some(sample) = link.sample else {
                continue;
            };
            let strength = sample.irradiance.mean();
            let rays = Rays {
                occluders: self.environment.occluders,
                exitant: self.exitant,
                hierarchy,
                receiver_node: NONE,
                seed,
                receiver,
                sender: &sender,
            };
            // A few rays that agree are enough for the weaker ones, and cheaper than a search.
            let weak = match sender.polygon {
                Some(_) => FAINT..WEAK,
                None => FAINT_CLUSTER..WEAK_CLUSTER,
            };
            if strength > weak.start * limit && strength <= weak.end * limit {
                let seen = rays.few(Few::Two, &mut stats);
                blockers.add(seen.blocker);
                if !seen.is_mixed {
                    stats.links += 1;
                    samples.extend(sample.through(seen.transmittance, seen.open));
                    continue;
                }
            }
            if strength > FAINT * limit && self.visibility == Visibility::Shafts {
                match self.exactly(
                    hierarchy,
                    &link,
                    sample,
                    limit,
                    &mut occlusion,
                    &mut candidates,
                ) {
                    Exact::Seen(sample) => {
                        stats.links += 1;
                        stats.clear_shafts += u64::from(candidates.is_none());
                        samples.extend(sample.through(Rgb::WHITE, 1.0));
                        continue;
                    }
                    Exact::Uneven => {
                        sender.parts(hierarchy, self.node_count, |part| {
                            stack.push((part, candidates))
                        });
                        continue;
                    }
                    Exact::Unknown => {}
                }
            }
            if sender.polygon.is_none() && strength > FAINT_CLUSTER * limit {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            // Clusters that are left are faint.
            if sender.polygon.is_none() || strength <= FAINT * limit {
                let seen = rays.few(Few::One, &mut stats);
                blockers.add(seen.blocker);
                stats.links += 1;
                samples.extend(sample.through(seen.transmittance, seen.open));
                continue;
            }
            // Much stands in between. One ray would be right on average, but there are dozens of such links.
            let strata = if strength <= HALF * limit {
                2
            } else {
                self.strata
            };
            let seen = rays.strata(strata, &mut stats);
            blockers.add(seen.blocker);
            let is_rough = strength > limit && seen.is_mixed() || strength > STRONG * limit;
            if is_rough && can_refine {
                sender.parts(hierarchy, self.node_count, |part| {
                    stack.push((part, candidates))
                });
                continue;
            }
            stats.links += 1;
            samples.extend(sample.through(seen.transmittance(), seen.open()));
        }
        self.point_lights(receiver, samples, &mut stats);
        stats
    }

    /// The sample as if nothing stood between; that of a cluster as wide as what it holds seems to be.
    fn unoccluded(&self, receiver: &Receiver, sender: &Sender) -> Option<IlluminationSample> {
        let mut sample = unoccluded_sample(receiver, sender, self.exitant)?;
        if sender.polygon.is_none() {
            let at = sender.id.node as usize;
            // Irradiance over the mean radiance of all surfaces is solid angle, π times the square of the spread.
            let area_per_power = self.exitant.area[at] / self.exitant.power[at];
            sample.spread = (sample.irradiance.mean() * area_per_power).sqrt().min(1.0);
        }
        Some(sample)
    }

    /// Where a vertex sees nothing that sends: out of the scene, or the side of a patch that light does not reach.
    pub fn dark(&self, hierarchy: &Hierarchy, receiver: &Receiver, normal: Vec3) -> Dark {
        let turn = hash::unit(hash::of_point(receiver.centre), DARK_RAYS);
        let is_dark = |&direction: &Vec3| {
            let occluders = self.environment.occluders;
            let hit = occluders.nearest_hit(receiver.centre, direction, receiver.patch);
            let node = hit.map_or(NONE, |hit| hierarchy.whole(hit.patch, hit.back));
            node == NONE || self.exitant.peak[node as usize] <= 0.0
        };
        let direction = |i: u32| {
            // The cosine is uniform over a hemisphere.
            let at = spread(i);
            about(normal, ((1.0 - at.x * at.x).sqrt(), at.x), at.y + turn)
        };
        let directions = (0..DARK_RAYS).map(direction);
        Dark {
            directions: directions.filter(is_dark).collect(),
            tried: DARK_RAYS,
        }
    }

    /// What a vertex sees of an element past what stands before it: `sample`, or a part of it.
    fn exactly(
        &self,
        hierarchy: &Hierarchy,
        link: &VertexLink<'_>,
        sample: IlluminationSample,
        limit: f32,
        occlusion: &mut Occlusion<'_>,
        candidates: &mut Candidates,
    ) -> Exact {
        let (receiver, sender) = (link.receiver, link.sender);
        let Some(polygon) = &sender.polygon else {
            return Exact::Unknown;
        };
        let (eye, horizon) = (receiver.centre, receiver.normal);
        let Some(target) = Target::new(polygon, sender.normal, sender.patch, eye, horizon) else {
            return Exact::Unknown;
        };
        *candidates = occlusion.candidates(&target.pyramid(horizon), sender.patch, *candidates);
        let Candidates::List(from, to) = *candidates else {
            return Exact::Unknown;
        };
        if from == to && !target.is_cut {
            return Exact::Seen(sample);
        }
        let Some(visible) = occlusion.visible(&target, from, to) else {
            return Exact::Unknown;
        };
        let above = target.vector();
        let whole = Cone::new(polygon, eye).vector_irradiance();
        let (above_length, whole_length) = (above.length(), whole.length());
        let exposed = whole_length * sender.exposed_share(self.exitant);
        let id = sender.id.node;
        let uneven = self.exitant.unevenness(id, visible.length() / exposed);
        let strength = sample.irradiance.mean();
        if sender.can_refine()
            && hierarchy.has_children_among(id, self.node_count)
            && strength * whole_length * uneven > UNEVEN * limit * above_length
        {
            return Exact::Uneven;
        }
        Exact::Seen(sample.seen_partly(above, visible))
    }

    /// How far the sample of a link may be from the truth [W·m⁻²], apart from visibility: hoped, not proven, unlike
    /// the bounds of links between nodes. The form factors of elements are exact, clusters have errors of second order.
    fn error(&self, hierarchy: &Hierarchy, link: &VertexLink<'_>, gloss: Gloss, limit: f32) -> f32 {
        let (receiver, sender, bounds) = (link.receiver, link.sender, link.bounds);
        if is_near(bounds, receiver, sender) || bounds.distance <= 0.0 {
            return f32::INFINITY;
        }
        let has_gloss = gloss.share > 0.0;
        let offset = receiver.centre - sender.centre;
        let is_cluster = sender.polygon.is_none();
        // What lies within a near cluster may be seen far more steeply than its middle.
        let faint = if is_cluster { FAINT_CLUSTER } else { 1.0 };
        let id = sender.id.node;
        let uneven = if !is_cluster && hierarchy.has_children_among(id, self.node_count) {
            self.exitant.brightest_excess(id)
        } else {
            0.0
        };
        // Were it all as bright as its brightest part.
        let high = bounds.high * (1.0 + uneven);
        if high <= faint * limit && !has_gloss {
            return high;
        }
        let sinks = |normal: Vec3| normal.dot(offset) > -sender.radius;
        if is_cluster && receiver.normal.is_some_and(sinks) {
            return bounds.high;
        }
        let Some(sample) = &link.sample else {
            return bounds.high;
        };
        let across = sender.radius / bounds.distance;
        let mut strength = sample.irradiance.mean();
        let mut share = 0.0;
        if self.exitant.distribution[id as usize].is_some() {
            let axis = offset / bounds.distance;
            let half_angle = across.min(1.0).asin();
            let (low, high) = self.exitant.sampled_bounds(id, axis, half_angle);
            let middle = self.exitant.towards(id, axis).mean();
            if middle <= 0.0 {
                return bounds.high;
            }
            share += DIRECTIONS * (high - low) / middle;
            if !is_cluster && hierarchy.has_children_among(id, self.node_count) {
                let parts = self.mean_of_parts(hierarchy, id, receiver.centre);
                share += DIRECTIONS * (parts - middle).abs() / middle;
            }
            if is_cluster {
                // The sample comes from the middle of the light, and may just miss it all.
                strength = strength.max(middle / (bounds.distance * bounds.distance));
            }
        }
        if is_cluster {
            share = CLUSTER * (share + across * across);
        }
        share += PARTS * uneven * (2.0 * across).min(1.0);
        if has_gloss {
            // The lobe of a sample is as wide as its sender: only the sender's shape is lost.
            let seen = 0.5 * across / gloss.width;
            share += SHAPE * gloss.share * (seen * seen).min(1.0);
        }
        strength * share
    }

    /// Mean radiance of the children of an element towards a point [mean over channels]. Each mirrors a near lamp elsewhere: the
    /// mean of their distributions is a wider lobe than theirs.
    fn mean_of_parts(&self, hierarchy: &Hierarchy, id: NodeId, point: Vec3) -> f32 {
        let (mut sum, mut areas) = (0.0, 0.0);
        for child in hierarchy.children(id) {
            let node = hierarchy.node(child);
            let area = self.exitant.area[child as usize];
            if let Some(direction) = (point - node.centre).try_normalize() {
                sum += self.exitant.towards(child, direction).mean() * area;
                areas += area;
            }
        }
        if areas > 0.0 { sum / areas } else { 0.0 }
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
