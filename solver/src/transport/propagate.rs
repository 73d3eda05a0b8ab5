//! Bounded propagation (§3.1): links are refined until their bounds are close, then leave illumination samples.
//!
//! Receivers are worked off level by level, all of one level in parallel. A receiver reads the exitant light of the
//! last iteration and writes only its own samples, so the result does not depend on the number of threads.
//! Cost: a bound per link visited, rays per link accepted.

use crate::brdf::Lobe;
use crate::config::{Strata, Visibility};
use crate::geometry::Polygon;
use crate::hierarchy::contact::Reach;
use crate::hierarchy::detail::Detail;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::transport::connect::{Connection, Link};
use crate::transport::exitant::Exitant;
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Bounds, Receiver, Sender, SenderId, bounds};
use crate::transport::region::PatchTree;
use crate::transport::sample::is_gap;
use crate::transport::stray::Pair;
use crate::transport::visibility::Occluders;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

/// What does not change during a solve.
pub struct Environment<'a> {
    /// All surfaces.
    pub occluders: &'a Occluders,
    /// All patches, for what may stand in between.
    pub tree: &'a PatchTree,
    /// Shape of each patch.
    pub shapes: &'a [Polygon],
    /// Where things stand.
    pub detail: Detail,
    /// Glossy lobe per material.
    pub lobes: &'a [Option<Lobe>],
    /// Point lights: position, intensity.
    pub point_lights: &'a [(Vec3, Rgb)],
    /// Diffuse reflectance per material.
    pub diffuse: &'a [Rgb],
    /// Where light can reach.
    pub reach: Reach<'a>,
}

/// When a link is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Largest (Emax - Emin) · area · reflectance of a link [mean over channels, normalised power].
    pub tolerance: f32,
    /// Largest Emax - Emin of a link, however small its receiver [mean over channels, normalised irradiance].
    pub most_irradiance: f32,
    /// Elements with a smaller radius are not split, times [`Detail::at`] their place.
    pub min_radius: f32,
    /// Visibility rays of a link.
    pub strata: Strata,
    /// How what stands in between is found.
    pub visibility: Visibility,
}

/// Counters of a propagation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkStats {
    /// Links accepted.
    pub links: u64,
    /// Of these, between two elements that are whole patches or parts of them.
    pub patch_links: u64,
    /// Samples that they left.
    pub samples: u64,
    /// Rays cast.
    pub rays: u64,
    /// Links found visible by an empty shaft.
    pub clear_shafts: u64,
    /// Thread time in visibility.
    pub visibility: Duration,
}

impl LinkStats {
    /// Adds another's counts.
    pub fn add(&mut self, other: &Self) {
        self.links += other.links;
        self.patch_links += other.patch_links;
        self.samples += other.samples;
        self.rays += other.rays;
        self.clear_shafts += other.clear_shafts;
        self.visibility += other.visibility;
    }
}

/// An accepted link with its bounds, for those who want to check them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkRecord {
    /// Receiving node.
    pub receiver: NodeId,
    /// Sender.
    pub sender: SenderId,
    /// Irradiance at any point of the receiver (normal irradiance on clusters) is not less [mean over channels].
    pub low: f32,
    /// And not more.
    pub high: f32,
}

/// How glossy the surfaces below a receiver are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gloss {
    /// Specular share of the reflectance.
    pub share: f32,
    /// Half-width of the sharpest lobe [rad].
    pub width: f32,
}

impl Gloss {
    /// Of a material.
    pub fn of(lobe: Option<&Lobe>, diffuse: Rgb) -> Self {
        lobe.map_or(Self::default(), |lobe| {
            let specular = lobe.specular.mean();
            Self {
                share: specular / (specular + diffuse.mean()),
                width: lobe.half_width,
            }
        })
    }
}

/// A cluster stands for what it holds only from further away than this many of its radii.
const CLUSTER_DISTANCE: f32 = 1.5;

/// True when an end of the link is a cluster that the other is too close to. However weak the link: intensity over
/// distance squared is without bound near a flat cluster, and light between such surfaces would grow.
pub(super) fn is_near(bounds: &Bounds, receiver: &Receiver, sender: &Sender) -> bool {
    let reach = |is_cluster: bool, radius: f32| {
        if is_cluster {
            radius * CLUSTER_DISTANCE
        } else {
            0.0
        }
    };
    let receiver_is_cluster = receiver.normal.is_none();
    let near = reach(receiver_is_cluster, receiver.radius)
        .max(reach(sender.polygon.is_none(), sender.radius));
    bounds.distance < near || is_gap(receiver, sender)
}

/// The error of a link as a share of... irradiance [W·m⁻²]: how far a sample may be from the truth.
///
/// The bounds' width, plus what one direction instead of many costs: on clusters, through the cosine at surfaces
/// with unknown normals; on glossy surfaces, through the lobe. A sum of lobes a fraction x of their width apart is
/// smooth to O(x⁴), so senders only need to be small against the lobe.
fn error(bounds: &Bounds, receiver: &Receiver, sender: &Sender, gloss: Gloss) -> f32 {
    if is_near(bounds, receiver, sender) {
        return f32::INFINITY;
    }
    let mut error = bounds.high - bounds.low;
    if bounds.distance > 0.0 {
        if receiver.normal.is_none() {
            error += bounds.high * (receiver.radius / bounds.distance);
        }
        if gloss.share > 0.0 {
            let in_lobes = 1.0 / (bounds.distance * gloss.width);
            // The lobe of a sample is as wide as its sender: only the sender's shape is lost.
            let (across, seen) = (receiver.radius * in_lobes, 0.5 * sender.radius * in_lobes);
            let seen = seen * seen;
            error += bounds.high * gloss.share * (across * across + seen * seen).min(1.0);
        }
    }
    error
}

/// Takes what links bring.
pub trait Arrivals {
    /// Samples that nodes have received.
    fn take(&mut self, hierarchy: &Hierarchy, brought: Vec<(NodeId, Vec<IlluminationSample>)>);

    /// Bytes of what it has taken.
    fn bytes(&self) -> usize;
}

/// One propagation: what it reads.
pub struct Propagation<'a> {
    /// What does not change.
    pub environment: &'a Environment<'a>,
    /// Light that leaves.
    pub exitant: &'a Exitant,
    /// Nodes when the exitant light was computed: later ones do not send.
    pub node_count: usize,
    /// Gloss per cluster; elements follow from their material.
    pub cluster_gloss: &'a [Gloss],
    /// When to accept.
    pub accuracy: Accuracy,
    /// Include the point lights (first iteration only).
    pub with_point_lights: bool,
    /// Chooses rays of stray light: what some miss in one iteration, others meet in the next.
    pub seed: u32,
    /// Keep a record of every link.
    pub record: bool,
}

#[derive(Default)]
pub(super) struct Outcome {
    pub(super) samples: Vec<IlluminationSample>,
    pub(super) refined: Vec<SenderId>,
    /// Stray light of elements below the receiver.
    deposits: Vec<(NodeId, IlluminationSample)>,
    records: Vec<LinkRecord>,
    pub(super) stats: LinkStats,
}

/// Senders from this number on are point lights: no scene has as many nodes.
pub(super) const POINT_LIGHTS: NodeId = 1 << 31;

/// Receivers that are worked off between two reports.
const BATCH: usize = 8192;

impl Propagation<'_> {
    /// Propagates all light; `arrivals` has it in the end. `report` is called after each batch with the bytes of that,
    /// and may stop the work.
    pub fn run(
        &self,
        hierarchy: &mut Hierarchy,
        arrivals: &mut dyn Arrivals,
        records: &mut Vec<LinkRecord>,
        report: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> LinkStats {
        let mut stats = LinkStats::default();
        let lights = if self.with_point_lights {
            self.environment.point_lights.len() as u32
        } else {
            0
        };
        let first: Arc<[SenderId]> = std::iter::once(0)
            .chain((0..lights).map(|light| POINT_LIGHTS + light))
            .map(SenderId::whole)
            .collect();
        let mut front: Vec<(NodeId, Arc<[SenderId]>)> = vec![(0, first)];
        while !front.is_empty() {
            let mut next = Vec::new();
            let known = hierarchy.elements.len();
            for batch in front.chunks(BATCH) {
                let shared = &*hierarchy;
                let outcomes: Vec<Outcome> = batch
                    .par_iter()
                    .with_max_len(64)
                    .map(|(id, pending)| self.refine(shared, *id, pending))
                    .collect();
                let mut brought = Vec::new();
                let mut refined = Vec::new();
                for ((id, _), outcome) in batch.iter().zip(outcomes) {
                    stats.add(&outcome.stats);
                    stats.samples += (outcome.samples.len() + outcome.deposits.len()) as u64;
                    brought.push((*id, outcome.samples));
                    let alone = |(element, sample)| (element, vec![sample]);
                    brought.extend(outcome.deposits.into_iter().map(alone));
                    records.extend(outcome.records);
                    refined.push(outcome.refined);
                }
                arrivals.take(shared, brought);
                for ((id, _), refined) in batch.iter().zip(refined) {
                    if refined.is_empty() {
                        continue;
                    }
                    if hierarchy.is_leaf(*id) {
                        hierarchy.subdivide(*id);
                    }
                    let refined: Arc<[SenderId]> = refined.into();
                    next.extend(
                        hierarchy
                            .children(*id)
                            .map(|child| (child, Arc::clone(&refined))),
                    );
                }
                if report(arrivals.bytes()).is_break() {
                    return stats;
                }
            }
            self.environment.reach.expose(hierarchy, known);
            front = next;
        }
        stats
    }

    /// Elements at a place are not split when their radius is smaller.
    pub(super) fn least_radius(&self, place: Vec3) -> f32 {
        self.accuracy.min_radius * self.environment.detail.at(place)
    }

    fn gloss(&self, hierarchy: &Hierarchy, id: NodeId) -> Gloss {
        match hierarchy.element_of(id) {
            Some(element) => {
                let material = element.material as usize;
                Gloss::of(
                    self.environment.lobes[material].as_ref(),
                    self.environment.diffuse[material],
                )
            }
            None => self.cluster_gloss[id as usize],
        }
    }

    /// Works off all links that reach one receiver; links that need a smaller receiver are returned.
    fn refine(&self, hierarchy: &Hierarchy, id: NodeId, pending: &[SenderId]) -> Outcome {
        let mut outcome = Outcome::default();
        let reflecting_area = hierarchy.node(id).reflecting_area;
        let receiver = Receiver::node(hierarchy, id);
        let limit = (self.accuracy.tolerance / reflecting_area).min(self.accuracy.most_irradiance);
        let gloss = self.gloss(hierarchy, id);
        let can_split = match hierarchy.element_of(id) {
            Some(_) => {
                !hierarchy.is_leaf(id) || receiver.radius > self.least_radius(receiver.centre)
            }
            None => true,
        };
        let mut stack: Vec<SenderId> = pending.iter().rev().copied().collect();
        while let Some(link) = stack.pop() {
            if let Some(light) = link.node.checked_sub(POINT_LIGHTS) {
                self.connect_point_light(&receiver, light as usize, limit, can_split, &mut outcome);
                continue;
            }
            if self.exitant.peak[link.node as usize] <= 0.0 {
                continue;
            }
            let sender = Sender::new(hierarchy, link);
            let is_good = |bounds: &Bounds| error(bounds, &receiver, &sender, gloss) <= limit;
            let bounds = bounds(&receiver, &sender, self.exitant, is_good);
            if bounds.high <= 0.0 {
                continue;
            }
            let same = id == link.node;
            let power = self.exitant.power[link.node as usize];
            if (same || is_near(&bounds, &receiver, &sender)) && power < self.accuracy.tolerance {
                let pair = Pair {
                    hierarchy,
                    receiver_node: id,
                    receiver: &receiver,
                    sender: &sender,
                };
                self.stray(&pair, &mut outcome.deposits, &mut outcome.stats);
                continue;
            }
            let good = !same && is_good(&bounds);
            let can_refine_sender = sender.can_refine()
                && (sender.polygon.is_none()
                    || sender.radius > self.least_radius(sender.centre) * 0.5);
            if !good && (can_split || can_refine_sender) {
                // The larger end bounds less; a receiver never splits for a sender much smaller than itself would be.
                if can_split && (receiver.radius >= sender.radius || !can_refine_sender) {
                    outcome.refined.push(link);
                } else {
                    sender.parts(hierarchy, self.node_count, |part| stack.push(part));
                }
                continue;
            }
            if same {
                continue;
            }
            let found = Link {
                hierarchy,
                receiver_node: id,
                receiver: &receiver,
                sender: &sender,
                bounds: &bounds,
                limit,
            };
            match self.connect(&found, &mut outcome.stats) {
                Connection::Accepted { sample, clear } => {
                    outcome.stats.links += 1;
                    outcome.stats.patch_links += u64::from(found.is_between_elements());
                    if self.record {
                        let low = if clear { bounds.low } else { 0.0 };
                        outcome.records.push(LinkRecord {
                            receiver: id,
                            sender: link,
                            low,
                            high: bounds.high,
                        });
                    }
                    outcome.samples.extend(sample);
                }
                Connection::Mixed if can_split && receiver.radius >= sender.radius => {
                    outcome.refined.push(link)
                }
                Connection::Mixed | Connection::Uneven => {
                    sender.parts(hierarchy, self.node_count, |part| stack.push(part));
                }
            }
        }
        outcome
    }
}
