//! Visibility rays of links: stratified on both ends, on surfaces of clusters too.

use crate::geometry::hash;
use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::link::{Receiver, Sender};
use crate::transport::propagate::LinkStats;
use crate::transport::visibility::{NO_PATCH, Occluders};
use glam::{Vec2, Vec3};

/// Visibility rays of one link, stratified on both ends.
pub(super) struct Rays<'a> {
    pub(super) occluders: &'a Occluders,
    /// Its power chooses points on sending clusters.
    pub(super) exitant: &'a Exitant,
    pub(super) hierarchy: &'a Hierarchy,
    /// [`NONE`] for vertices.
    pub(super) receiver_node: NodeId,
    /// Tells this receiver from others: errors of neighbours shall not be alike, so that they cancel between them.
    pub(super) seed: u32,
    pub(super) receiver: &'a Receiver,
    pub(super) sender: &'a Sender,
}

impl Rays<'_> {
    /// What `side`² rays find.
    pub(super) fn strata(&self, side: u32, stats: &mut LinkStats) -> Passage {
        // Rays end on what light can reach of a sender, its form factor is that of all of it.
        let mut passage = Passage {
            share: self.sender.exposed_share(self.exitant),
            ..Passage::default()
        };
        for ray in (0..side * side).filter_map(|ray| self.ray(ray, side, stats)) {
            passage.blocker = ray.blocker.or(passage.blocker);
            passage.plain.add(ray.passed, ray.weight);
            passage.open += if ray.passed.is_black() {
                0.0
            } else {
                ray.weight
            };
            // The radiance on a link to a vertex is one.
            let weight = if side > 1 && self.receiver_node != NONE {
                ray.weight * self.brightness(ray.to, -ray.direction)
            } else {
                ray.weight
            };
            passage.mean.add(ray.passed, weight);
        }
        passage
    }

    /// What two rays to opposite quarters of the sender, or the one in its middle, agree on.
    pub(super) fn few(&self, count: Few, stats: &mut LinkStats) -> Agreement {
        let (side, rays) = match count {
            Few::One => (1, &[0][..]),
            Few::Two => (2, &[0, 3][..]),
        };
        let mut agreement = Agreement::default();
        let mut first = None;
        for ray in rays.iter().filter_map(|&ray| self.ray(ray, side, stats)) {
            agreement.blocker = ray.blocker.or(agreement.blocker);
            agreement.is_mixed |= first.is_some_and(|passed| passed != ray.passed);
            first = first.or(Some(ray.passed));
        }
        let passed = first.unwrap_or(Rgb::BLACK);
        let share = self.sender.exposed_share(self.exitant);
        agreement.transmittance = passed * share;
        agreement.open = if passed.is_black() { 0.0 } else { share };
        agreement
    }

    /// Casts one of `side`² rays. `None` where the surfaces that it was to join do not face each other.
    fn ray(&self, ray: u32, side: u32, stats: &mut LinkStats) -> Option<Cast> {
        let sender = self.sender.id;
        let seed = hash::mix(hash::mix(sender.node, sender.hash()), self.seed);
        let all = side * side;
        let at = |i: u32, salt: u32| {
            let jitter = |axis: u32| {
                // One ray goes through the middle of a receiver, anywhere to a vertex: there are many of those, and what the
                // middle sees is not what all see on average. More are spread within their strata.
                if all == 1 && self.receiver_node != NONE {
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
        let transposed = (ray % side) * side + ray / side;
        let uv = at((transposed + all / 2) % all, 20);
        let (from, to) = self.ends((uv, seed_of(0x5555)), (at(ray, 10), seed_of(0)))?;
        let offset = to.point - from.point;
        let squared = offset.length_squared();
        let direction = offset / squared.sqrt();
        // What is near counts for more, as it does in the form factor.
        let cosines = [from.normal.dot(direction), -to.normal.dot(direction)];
        if squared <= 0.0 || cosines.iter().any(|&cosine| cosine <= 0.0) {
            return None;
        }
        let ends = [from.patch, to.patch];
        let (passed, blocker) = self.occluders.passage(from.point, to.point, ends);
        stats.rays += 1;
        Some(Cast {
            to: to.node,
            direction,
            weight: cosines[0] * cosines[1] / squared,
            passed,
            blocker: (blocker != NO_PATCH).then_some(blocker),
        })
    }

    /// Radiance of an element towards `direction` over its mean: light passes where it is sent to.
    fn brightness(&self, id: NodeId, direction: Vec3) -> f32 {
        let at = id as usize;
        if self.exitant.distribution[at].is_none() || self.exitant.power[at] <= 0.0 {
            return 1.0;
        }
        self.exitant.towards(id, direction).mean() / self.exitant.mean_radiance(id)
    }

    /// Both ends of a ray, given where in its strata each lies and a seed: from, to. On clusters a surface is chosen
    /// that faces the other end; an element's point does not depend on the other.
    fn ends(
        &self,
        (from, from_seed): (Vec2, u32),
        (to, to_seed): (Vec2, u32),
    ) -> Option<(RayEnd, RayEnd)> {
        if let Some(from) = self.point_of_receiver(from) {
            return Some((from, self.sender_point(to, to_seed, from.point)?));
        }
        let to = self.sender_point(to, to_seed, self.receiver.centre)?;
        let area = |id: NodeId| self.hierarchy.node(id).area;
        let from = self.surface_point(self.receiver_node, from_seed, to.point, area)?;
        Some((from, to))
    }

    /// `None` for clusters.
    fn point_of_receiver(&self, uv: Vec2) -> Option<RayEnd> {
        Some(RayEnd {
            point: match &self.receiver.polygon {
                Some(polygon) => polygon.point(self.receiver.exposed.point(uv)),
                None => self.receiver.centre,
            },
            node: self.receiver_node,
            patch: self.receiver.patch,
            normal: self.receiver.normal?,
        })
    }

    fn sender_point(&self, uv: Vec2, seed: u32, seen_from: Vec3) -> Option<RayEnd> {
        if let Some(polygon) = &self.sender.polygon {
            // The brighter a part, the more it counts.
            let mut id = self.sender.id.node;
            let mut salt = 100;
            while let Some((child, _)) =
                self.exitant
                    .brighter_child(self.hierarchy, id, hash::unit(seed, salt))
            {
                (id, salt) = (child, salt + 1);
            }
            // A quarter of a leaf is no element, and has no children.
            let point = if self.sender.id.is_whole() {
                self.hierarchy.element_of(id)?.point(uv)
            } else {
                polygon.point(uv)
            };
            return Some(RayEnd {
                point,
                node: id,
                patch: self.sender.patch,
                normal: self.sender.normal,
            });
        }
        let power = &self.exitant.power;
        let weight = |id: NodeId| power.get(id as usize).copied().unwrap_or(0.0);
        self.surface_point(self.sender.id.node, seed, seen_from, weight)
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
                // What its children weigh together.
                let mut left = hash::unit(seed, salt) * weight(id);
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
            let point = element.point(uv);
            ((seen_from - point).dot(element.normal) > 0.0).then_some(RayEnd {
                point,
                node: id,
                patch: element.patch,
                normal: element.normal,
            })
        })
    }
}

/// How many rays weigh a weak link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Few {
    One,
    Two,
}

/// What few rays found.
#[derive(Default)]
pub(super) struct Agreement {
    /// Of the first of them.
    pub(super) transmittance: Rgb,
    /// Share of the sender that nothing opaque hides, if it is the same everywhere.
    pub(super) open: f32,
    /// The rays differ.
    pub(super) is_mixed: bool,
    /// A patch that hid a ray.
    pub(super) blocker: Option<u32>,
}

/// A ray that was cast.
struct Cast {
    /// The element that it goes to.
    to: NodeId,
    /// Unit.
    direction: Vec3,
    /// Its share of the form factor, but for a constant.
    weight: f32,
    passed: Rgb,
    /// A patch that hid it.
    blocker: Option<u32>,
}

/// What rays between two ends found.
#[derive(Default)]
pub(super) struct Passage {
    /// What light can reach of the sender.
    share: f32,
    /// Weight of the rays that nothing opaque hid.
    open: f32,
    mean: RatioMean,
    /// The same without the directions of the sender's radiance.
    plain: RatioMean,
    /// A patch that hid a ray.
    pub(super) blocker: Option<u32>,
}

impl Passage {
    /// Mean transmittance. A cluster without a surface that faces the other end has nothing to see or to send from
    /// there.
    pub(super) fn transmittance(&self) -> Rgb {
        let mean = self.mean.get().or_else(|| self.plain.get());
        mean.unwrap_or(Rgb::BLACK) * self.share
    }

    /// Share of the sender that nothing opaque hides.
    pub(super) fn open(&self) -> f32 {
        self.open_of_exposed() * self.share
    }

    /// The same of what light can reach of it.
    pub(super) fn open_of_exposed(&self) -> f32 {
        if self.plain.weights > 0.0 {
            self.open / self.plain.weights
        } else {
            0.0
        }
    }

    /// True when rays differ.
    pub(super) fn is_mixed(&self) -> bool {
        let values = || self.plain.values().iter().map(|ray| ray.passed.mean());
        values().fold(0.0, f32::max) > values().fold(f32::INFINITY, f32::min)
    }
}

/// A ray of a mean.
#[derive(Clone, Copy, Default)]
struct Ray {
    passed: Rgb,
    weight: f32,
}

/// Rays whose leave-one-out means are kept: all that the most strata of a near link cast.
const MOST_RAYS: usize = 36;

/// A mean of few values with weights that go with them.
///
/// What is near passes more often and counts for more: the plain ratio Σ wt / Σ w of n rays is too small by O(1/n). The
/// jackknife (Quenouille 1956), n r - (n - 1) mean of the r without one ray, is left with O(1/n²).
struct RatioMean {
    rays: [Ray; MOST_RAYS],
    count: usize,
    sum: Rgb,
    weights: f32,
}

impl Default for RatioMean {
    fn default() -> Self {
        Self {
            rays: [Ray::default(); MOST_RAYS],
            count: 0,
            sum: Rgb::BLACK,
            weights: 0.0,
        }
    }
}

impl RatioMean {
    fn add(&mut self, passed: Rgb, weight: f32) {
        if weight <= 0.0 {
            return;
        }
        if self.count < MOST_RAYS {
            self.rays[self.count] = Ray { passed, weight };
        }
        self.count += 1;
        self.sum += passed * weight;
        self.weights += weight;
    }

    fn values(&self) -> &[Ray] {
        &self.rays[..self.count.min(MOST_RAYS)]
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
        for ray in self.values() {
            let left = self.weights - ray.weight;
            if left <= 0.0 {
                return Some(plain);
            }
            others += (self.sum - ray.passed * ray.weight) / left;
        }
        let corrected = plain * n - others * ((n - 1.0) / n);
        Some(corrected.max(Rgb::BLACK).min(Rgb::WHITE))
    }
}

/// A point that a ray starts or ends at.
#[derive(Clone, Copy)]
struct RayEnd {
    point: Vec3,
    /// The element that it lies on; of clusters, one of what they hold; [`NONE`] for vertices.
    node: NodeId,
    /// Whose surface does not block.
    patch: u32,
    /// Normal there.
    normal: Vec3,
}
