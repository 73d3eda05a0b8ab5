//! Weak light between surfaces that are too close for clusters to stand for them: rays carry it.
//!
//! A link's bounds are refined until each end is small against its distance. Within a chair that takes thousands of
//! links for light that is next to nothing, but left out it adds up. Rays from the sender that meet the receiver carry
//! their share of the sender's power from leaf to leaf: the mean is exact, a narrow gap stays uneven, and what noise
//! there is stays within a small thing.
//! Cost: a few rays per pair.

use crate::geometry::{hash, sampling};
use crate::hierarchy::{Element, Hierarchy, NONE, NodeId};
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Receiver, Sender};
use crate::transport::propagate::{LinkStats, Propagation};
use crate::transport::visibility::Hit;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Rays of a pair whose sender is next to nothing.
const LEAST_RAYS: f32 = 16.0;

/// Rays of a sender as strong as the tolerance.
const MOST_RAYS: f32 = 256.0;

/// Tells the random number that chooses senders from those of their rays.
const PICK: u32 = 100;

/// Light from below this cosine is taken to come from straight ahead.
const GRAZING: f32 = 0.1;

/// Two ends of a pair.
pub(super) struct Pair<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) receiver_node: NodeId,
    pub(super) receiver: &'a Receiver,
    pub(super) sender: &'a Sender,
}

impl Propagation<'_> {
    /// Sends the light of a pair; appends what elements of the receiver get.
    pub(super) fn stray(
        &self,
        pair: &Pair<'_>,
        deposits: &mut Vec<(NodeId, IlluminationSample)>,
        stats: &mut LinkStats,
    ) {
        let (hierarchy, sender) = (pair.hierarchy, pair.sender);
        let id = sender.id.node;
        let seed = hash::mix(id, pair.receiver_node) ^ hash::mix(sender.id.hash(), self.seed);
        let power = self.exitant.power[id as usize] * sender.share;
        let rays =
            (MOST_RAYS * power / self.accuracy.tolerance).clamp(LEAST_RAYS, MOST_RAYS) as u32;
        for ray in 0..rays {
            // The rays of a pair are spread evenly over both.
            let even = sampling::spread5(ray);
            let chance = (even[4] + hash::unit(seed, PICK)).fract();
            let Some(source) = self.pick(hierarchy, id, chance) else {
                continue;
            };
            let Some(element) = hierarchy.element_of(source) else {
                continue;
            };
            let Some((from, direction, hit)) = self.ray(pair, element, seed, even, stats) else {
                continue;
            };
            let met = hierarchy.whole(hit.patch, hit.back);
            let at = from + direction * hit.distance;
            let Some(node) = self.below(pair, met, at) else {
                continue;
            };
            // Radiance over its mean over the cosine-weighted hemisphere.
            let mean = self.exitant.mean_radiance(source);
            let radiance = self.exitant.towards(source, direction);
            let carried = radiance * (power / (rays as f32 * mean));
            if carried.is_black() {
                continue;
            }
            // No more than would come from all around: one ray stands for the light of all that are near.
            let least = 1.0 / (PI * rays as f32) * power / mean;
            let (met, facing) = facing(pair, node, -direction, least);
            let spread = (sender.radius / hit.distance).atan();
            for (node, cosine) in met {
                let (direction, irradiance) = if cosine > GRAZING {
                    (-direction, carried / facing)
                } else {
                    let normal = hierarchy
                        .element_of(node)
                        .map_or(-direction, |e| hierarchy.shading_normal(e));
                    (normal, carried * (GRAZING / facing))
                };
                deposits.push((
                    node,
                    IlluminationSample {
                        direction,
                        irradiance,
                        spread,
                        parallax: None,
                    },
                ));
            }
        }
    }

    /// A ray from what light can reach of a sender, and what it meets. Cells of what is exposed are coarse: places that
    /// see the inside of something closed are passed over.
    fn ray(
        &self,
        pair: &Pair<'_>,
        element: &Element,
        seed: u32,
        even: [f32; 5],
        stats: &mut LinkStats,
    ) -> Option<(Vec3, Vec3, Hit)> {
        const TRIES: u32 = 4;
        let part = pair.sender.polygon.filter(|_| !pair.sender.id.is_whole());
        for attempt in 0..TRIES {
            let unit = |i: usize| (even[i] + hash::unit(seed, i as u32 + 4 * attempt)).fract();
            let at = Vec2::new(unit(0), unit(1));
            let from = part.map_or_else(|| element.point(at), |part| part.point(at));
            let direction = sampling::cosine_direction(element.normal, Vec2::new(unit(2), unit(3)));
            stats.rays += 1;
            let occluders = self.environment.occluders;
            let hit = occluders.first_hit(from, direction, element.patch)?;
            if pair.hierarchy.whole(hit.patch, hit.back) != NONE {
                return Some((from, direction, hit));
            }
        }
        None
    }

    /// The leaf at or below `id` that a `chance` in [0, 1) chooses in proportion to power.
    fn pick(&self, hierarchy: &Hierarchy, id: NodeId, mut chance: f32) -> Option<NodeId> {
        let mut at = id;
        while hierarchy.has_children_among(at, self.node_count) {
            (at, chance) = self.exitant.brighter_child(hierarchy, at, chance)?;
        }
        Some(at)
    }

    /// The leaf of the receiver that a ray met at a point of the patch side `met`.
    fn below(&self, pair: &Pair<'_>, met: NodeId, point: Vec3) -> Option<NodeId> {
        if met == NONE {
            return None;
        }
        let hierarchy = pair.hierarchy;
        let Some(polygon) = &pair.receiver.polygon else {
            let mut at = met;
            while at != pair.receiver_node {
                at = hierarchy.node(at).parent;
                if at == NONE {
                    return None;
                }
            }
            return Some(leaf_at(hierarchy, met, point));
        };
        let element = hierarchy.element_of(pair.receiver_node)?;
        let root = hierarchy.element_of(met)?;
        let is_same_side = element.patch == root.patch && element.back == root.back;
        (is_same_side && polygon.holds(point))
            .then(|| leaf_at(hierarchy, pair.receiver_node, point))
    }
}

/// The leaf of an element that holds a point of it; where rounding puts it between two, what both are part of.
fn leaf_at(hierarchy: &Hierarchy, element: NodeId, point: Vec3) -> NodeId {
    let holds = |&part: &NodeId| {
        hierarchy
            .element_of(part)
            .is_some_and(|part| part.polygon.holds(point))
    };
    let mut at = element;
    while let Some(part) = hierarchy.children(at).find(holds) {
        at = part;
    }
    at
}

/// The element `met`, or those around it that are turned `towards` the light, with their cosines, until they are as
/// large as `least` [area] or all of the receiver; and the sum of their areas times cosines.
fn facing(pair: &Pair<'_>, met: NodeId, towards: Vec3, least: f32) -> (Vec<(NodeId, f32)>, f32) {
    let hierarchy = pair.hierarchy;
    let cosine = |id: NodeId| {
        let element = hierarchy.element_of(id)?;
        Some((id, towards.dot(hierarchy.shading_normal(element))))
    };
    // What was met, or the largest element that it is part of.
    let mut of_met = met;
    let (mut at, mut elements) = (met, vec![met]);
    loop {
        if hierarchy.element_of(at).is_some() {
            of_met = at;
        }
        let found: Vec<(NodeId, f32)> = elements
            .iter()
            .filter_map(|&id| cosine(id))
            .filter(|&(id, cosine)| id == of_met || cosine > GRAZING)
            .collect();
        let area = |&(id, cosine): &(NodeId, f32)| hierarchy.node(id).area * cosine.max(GRAZING);
        let sum: f32 = found.iter().map(area).sum();
        if sum >= least || at == pair.receiver_node {
            return (found, sum);
        }
        at = hierarchy.node(at).parent;
        elements = whole_elements(hierarchy, at);
    }
}

/// The patches below a cluster.
fn whole_elements(hierarchy: &Hierarchy, cluster: NodeId) -> Vec<NodeId> {
    let mut elements = Vec::new();
    let mut pending = vec![cluster];
    while let Some(id) = pending.pop() {
        match hierarchy.element_of(id) {
            Some(_) => elements.push(id),
            None => pending.extend(hierarchy.children(id)),
        }
    }
    elements
}
