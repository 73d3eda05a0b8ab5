//! Visibility rays of links: stratified on both ends, on surfaces of clusters too.

use crate::geometry::hash;
use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::link::{Receiver, Sender};
use crate::transport::propagate::LinkStats;
use crate::transport::visibility::Occluders;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Visibility rays of one link, stratified on both ends.
pub(super) struct Rays<'a> {
    pub(super) occluders: &'a Occluders,
    /// Its power chooses points on sending clusters.
    pub(super) exitant: &'a Exitant,
    pub(super) hierarchy: &'a Hierarchy,
    /// [`NONE`] for vertices.
    pub(super) receiver_node: NodeId,
    pub(super) receiver: &'a Receiver,
    pub(super) sender: &'a Sender,
}

impl Rays<'_> {
    /// Mean transmittance over `side`² rays, and whether they differ.
    pub(super) fn strata(&self, side: u32, stats: &mut LinkStats) -> (Rgb, bool) {
        let seed = hash::mix(self.sender.id.node, self.receiver_node);
        let mut mean = RatioMean::default();
        // The same without the directions of the sender's radiance.
        let mut plain = RatioMean::default();
        let (mut least, mut most) = (f32::INFINITY, 0.0f32);
        let all = side * side;
        for ray in 0..all {
            let at = |i: u32, salt: u32| {
                let jitter = |axis: u32| {
                    // One ray goes through the middle; more are spread within their strata.
                    if all == 1 {
                        0.5
                    } else {
                        0.02 + 0.96 * hash::unit(seed.wrapping_add(ray), salt + axis)
                    }
                };
                Vec2::new(
                    ((i % side) as f32 + jitter(0)) / side as f32,
                    ((i / side) as f32 + jitter(1)) / side as f32,
                )
            };
            // A fixed permutation pairs strata of the two ends that are not alike.
            let seed_of = |salt: u32| hash::mix(seed, ray ^ salt);
            let Some(to) = self.sender_point(at(ray, 10), seed_of(0)) else {
                continue;
            };
            let transposed = (ray % side) * side + ray / side;
            let uv = at((transposed + all / 2) % all, 20);
            let Some(from) = self.receiver_point(uv, seed_of(0x5555), to.point) else {
                continue;
            };
            let passed = self
                .occluders
                .transmittance(from.point, to.point, [from.patch, to.patch]);
            stats.rays += 1;
            let offset = to.point - from.point;
            let squared = offset.length_squared();
            if squared <= 0.0 {
                continue;
            }
            // What is near counts for more, as it does in the form factor.
            let facing = |normal: Option<Vec3>, direction: Vec3| {
                normal.map_or(1.0, |n| n.dot(direction).max(0.0))
            };
            let direction = offset / squared.sqrt();
            let weight = from.cosine
                * to.cosine
                * facing(from.normal, direction)
                * facing(to.normal, -direction)
                / squared;
            plain.add(passed, weight);
            // The radiance on a link to a vertex is one.
            let weight = if all > 1 && self.receiver_node != NONE {
                weight * self.brightness(to.node, -direction)
            } else {
                weight
            };
            mean.add(passed, weight);
            least = least.min(passed.mean());
            most = most.max(passed.mean());
        }
        // A cluster without a surface that faces the other end has nothing to see or to send from there.
        match mean.get().or_else(|| plain.get()) {
            Some(passed) => (passed, most > least),
            None => (Rgb::BLACK, false),
        }
    }

    /// Radiance of an element towards `direction` over its mean: light passes where it is sent to.
    fn brightness(&self, id: NodeId, direction: Vec3) -> f32 {
        let at = id as usize;
        if self.exitant.distribution[at].is_none() || self.exitant.power[at] <= 0.0 {
            return 1.0;
        }
        let mean = self.exitant.power[at] / (PI * self.hierarchy.node(id).area);
        self.exitant.towards(id, direction).mean() / mean
    }

    fn sender_point(&self, uv: Vec2, seed: u32) -> Option<RayEnd> {
        if let Some(polygon) = &self.sender.polygon {
            // The brighter a part, the more it counts.
            let mut polygon = *polygon;
            let mut id = self.sender.id.node;
            let mut salt = 100;
            while let Some(child) =
                self.exitant
                    .brighter_child(self.hierarchy, id, hash::unit(seed, salt))
            {
                polygon = self.hierarchy.element_of(child)?.polygon;
                (id, salt) = (child, salt + 1);
            }
            return Some(RayEnd {
                point: polygon.point(uv),
                node: id,
                patch: self.sender.patch,
                cosine: 1.0,
                normal: Some(self.sender.normal),
            });
        }
        let power = &self.exitant.power;
        let weight = |id: NodeId| power.get(id as usize).copied().unwrap_or(0.0);
        self.surface_point(self.sender.id.node, seed, self.receiver.centre, weight)
    }

    fn receiver_point(&self, uv: Vec2, seed: u32, towards: Vec3) -> Option<RayEnd> {
        let patch = self.receiver.patch;
        if self.receiver.radius == 0.0 {
            return Some(RayEnd {
                point: self.receiver.centre,
                node: NONE,
                patch,
                cosine: 1.0,
                normal: self.receiver.normal,
            });
        }
        if let Some(polygon) = &self.receiver.polygon {
            return Some(RayEnd {
                point: polygon.point(uv),
                node: self.receiver_node,
                patch,
                cosine: 1.0,
                normal: self.receiver.normal,
            });
        }
        self.surface_point(self.receiver_node, seed, towards, |id| {
            self.hierarchy.node(id).area
        })
    }

    /// A point on a surface of a cluster that faces `seen_from`, if a few tries find one; nodes are chosen in
    /// proportion to `weight`.
    fn surface_point(
        &self,
        cluster: NodeId,
        seed: u32,
        seen_from: Vec3,
        weight: impl Fn(NodeId) -> f32,
    ) -> Option<RayEnd> {
        const TRIES: u32 = 12;
        (0..TRIES).find_map(|attempt| {
            let mut id = cluster;
            let mut salt = attempt * 64;
            while self.hierarchy.element_of(id).is_none() {
                let total: f32 = self.hierarchy.children(id).map(&weight).sum();
                let mut left = hash::unit(seed, salt) * total;
                salt += 1;
                let mut chosen = None;
                for child in self.hierarchy.children(id) {
                    let w = weight(child);
                    if w > 0.0 {
                        chosen = Some(child);
                        if left < w {
                            break;
                        }
                    }
                    left -= w;
                }
                id = chosen?;
            }
            let element = self.hierarchy.element_of(id)?;
            let uv = Vec2::new(hash::unit(seed, salt + 30), hash::unit(seed, salt + 31));
            let point = element.polygon.point(uv);
            let cosine = (seen_from - point).normalize_or_zero().dot(element.normal);
            (cosine > 0.0).then_some(RayEnd {
                point,
                node: id,
                patch: element.patch,
                cosine,
                normal: None,
            })
        })
    }
}

/// Rays whose leave-one-out means are kept: all that the most strata of a near link cast.
const MOST_RAYS: usize = 36;

/// A mean of few values with weights that go with them.
///
/// What is near passes more often and counts for more: the plain ratio Σ wt / Σ w of n rays is too small by O(1/n). The
/// jackknife (Quenouille 1956), n r - (n - 1) mean of the r without one ray, is left with O(1/n²).
struct RatioMean {
    values: [(Rgb, f32); MOST_RAYS],
    count: usize,
    sum: Rgb,
    weights: f32,
}

impl Default for RatioMean {
    fn default() -> Self {
        Self {
            values: [(Rgb::BLACK, 0.0); MOST_RAYS],
            count: 0,
            sum: Rgb::BLACK,
            weights: 0.0,
        }
    }
}

impl RatioMean {
    fn add(&mut self, value: Rgb, weight: f32) {
        if weight <= 0.0 {
            return;
        }
        if self.count < MOST_RAYS {
            self.values[self.count] = (value * weight, weight);
        }
        self.count += 1;
        self.sum += value * weight;
        self.weights += weight;
    }

    /// `None` without values.
    fn get(&self) -> Option<Rgb> {
        if self.weights <= 0.0 {
            return None;
        }
        let plain = self.sum / self.weights;
        if self.count < 2 || self.count > MOST_RAYS {
            return Some(plain);
        }
        let n = self.count as f32;
        let mut others = Rgb::BLACK;
        for &(value, weight) in &self.values[..self.count] {
            let left = self.weights - weight;
            if left <= 0.0 {
                return Some(plain);
            }
            others += (self.sum - value) / left;
        }
        let corrected = plain * n - others * ((n - 1.0) / n);
        Some(corrected.max(Rgb::BLACK).min(Rgb::WHITE))
    }
}

/// A point that a ray starts or ends at.
struct RayEnd {
    point: Vec3,
    /// The element that it lies on; [`NONE`] for vertices.
    node: NodeId,
    /// Whose surface does not block.
    patch: u32,
    /// Normal of an element or a vertex.
    normal: Option<Vec3>,
    /// Cosine to the other end on clusters, where the sample does not hold it.
    cosine: f32,
}
