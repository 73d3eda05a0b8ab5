//! Which parts of a cluster or an element the light that it receives reaches.
//!
//! The rays of a link tell how much of a sender a cluster sees on average, and that is all a sample holds. What hides
//! the parts of a cluster from each other is always the same: rays from each patch tell once how open it is to what lies
//! outside of every cluster that holds it, a table top more than the seat below it. Each takes its own share of what
//! the cluster receives, and their mean stays what it is. The leaves of an element have views for that.
//! Cost: a few dozen rays a patch side, a number for each of the clusters around it.

use crate::geometry::{hash, sampling};
use crate::hierarchy::{Element, Hierarchy, NONE, NodeId};
use crate::transport::views::{Below, Views};
use crate::transport::visibility::Occluders;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Rays of each side of a patch.
const RAYS: u32 = 32;

/// A surface this close outside of a cluster's box, as a share of the way, is taken for one on it.
const ON_BOX: f32 = 1e-4;

/// How open the patches are to what lies outside of their clusters.
#[derive(Clone, Debug, Default)]
pub struct Openness {
    /// Share of the rays of an element that leave the clusters that hold it, from its parent to the root.
    shares: Vec<f32>,
    /// Where those of an element begin; of a cluster, its number in `means`.
    first: Vec<u32>,
    /// Per cluster: means over what it holds, as seen along each half-axis.
    means: Vec<[Mean; 6]>,
    /// What leaves see.
    pub(super) views: Views,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    area: f64,
}

impl Openness {
    /// Of clusters and whole patches; no element of `hierarchy` is subdivided yet.
    pub fn new(hierarchy: &Hierarchy, occluders: &Occluders) -> Self {
        let found: Vec<Vec<f32>> = hierarchy
            .elements
            .par_iter()
            .with_max_len(64)
            .map(|element| shares(hierarchy, occluders, element))
            .collect();
        let mut openness = Self {
            shares: Vec::new(),
            first: vec![NONE; hierarchy.nodes.len()],
            means: vec![[Mean::default(); 6]; hierarchy.cluster_count()],
            views: Views::default(),
        };
        let clusters = hierarchy.nodes.iter().zip(&mut openness.first);
        let clusters = clusters.filter(|(node, _)| node.element == NONE);
        for ((_, first), number) in clusters.zip(0..) {
            *first = number;
        }
        for (element, shares) in hierarchy.elements.iter().zip(found) {
            let area = f64::from(hierarchy.node(element.node).area);
            openness.first[element.node as usize] = openness.shares.len() as u32;
            let above = ancestors(hierarchy, element.node);
            for (cluster, &share) in above.zip(&shares) {
                for (axis, cosine) in half_axes(element.normal) {
                    let number = openness.first[cluster as usize];
                    let mean = &mut openness.means[number as usize][axis];
                    mean.area += area * cosine;
                    mean.sum += area * cosine * f64::from(share);
                }
            }
            openness.shares.extend(shares);
        }
        openness
    }

    /// Share of the rays of the whole patch `element` that leave the cluster `levels` above its parent.
    pub fn share(&self, element: NodeId, levels: usize) -> f32 {
        self.shares[self.first[element as usize] as usize + levels]
    }

    /// What a patch of a `cluster` gets of light from `direction` over the mean of the cluster, for each unit of its share.
    /// `None` where nothing in the cluster faces that way: a patch may still see the rim of a wide sender there.
    pub fn per_share(&self, cluster: NodeId, direction: Vec3) -> Option<f32> {
        let means = &self.means[self.first[cluster as usize] as usize];
        let (mut sum, mut area) = (0.0, 0.0);
        for (axis, cosine) in half_axes(direction) {
            sum += cosine * means[axis].sum;
            area += cosine * means[axis].area;
        }
        (sum > 0.0).then(|| (area / sum) as f32)
    }

    /// What the leaves of an element see, if it has several.
    pub(super) fn below(&self, hierarchy: &Hierarchy, receiver: NodeId) -> Option<Below<'_>> {
        let is_inner = hierarchy.element_of(receiver).is_some() && !hierarchy.is_leaf(receiver);
        is_inner.then(|| self.views.below(hierarchy, receiver))
    }

    /// Leaves that have been split since look around.
    pub fn look(&mut self, hierarchy: &Hierarchy, occluders: &Occluders) {
        self.views.look(hierarchy, occluders);
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val::<[f32]>(&self.shares)
            + size_of_val::<[u32]>(&self.first)
            + size_of_val::<[[Mean; 6]]>(&self.means)
            + self.views.bytes()
    }
}

/// Clusters above a node, from its parent to the root.
fn ancestors(hierarchy: &Hierarchy, id: NodeId) -> impl Iterator<Item = NodeId> {
    let parent = |id: NodeId| Some(hierarchy.node(id).parent).filter(|&parent| parent != NONE);
    std::iter::successors(parent(id), move |&id| parent(id))
}

/// Of each cluster around a whole patch: the share of the rays of the patch that leave it.
fn shares(hierarchy: &Hierarchy, occluders: &Occluders, element: &Element) -> Vec<f32> {
    let mut left = vec![0u32; ancestors(hierarchy, element.node).count()];
    for ray in 0..RAYS {
        let seed = hash::mix(element.node, ray);
        let at = Vec2::new(hash::unit(seed, 0), hash::unit(seed, 1));
        let from = element.point(at);
        let direction = sampling::cosine_direction(element.normal, sampling::spread(ray));
        let hit = occluders.first_hit(from, direction, element.patch);
        let reached = hit.map_or(f32::INFINITY, |hit| hit.distance);
        for (count, cluster) in left.iter_mut().zip(ancestors(hierarchy, element.node)) {
            let node = hierarchy.node(cluster);
            let end = (node.lower - from).max(node.upper - from).max(Vec3::ZERO);
            let start = (node.lower - from).min(node.upper - from).min(Vec3::ZERO);
            // Where the ray leaves the box.
            let way = Vec3::select(direction.cmpgt(Vec3::ZERO), end, start) / direction;
            let leaves = [way.x, way.y, way.z]
                .into_iter()
                .filter(|way| !way.is_nan());
            let leaves = leaves.fold(f32::INFINITY, f32::min);
            // What is met further in is met in all larger ones too.
            if reached <= leaves * (1.0 + ON_BOX) {
                break;
            }
            *count += 1;
        }
    }
    // Half a ray more on either side: no patch is known to be closed.
    left.iter()
        .map(|&count| (count as f32 + 0.5) / (RAYS as f32 + 1.0))
        .collect()
}

/// The three half-axes that a vector points along, and its cosines to them.
fn half_axes(direction: Vec3) -> [(usize, f64); 3] {
    [0, 1, 2].map(|axis| {
        let cosine = direction[axis];
        (
            axis + 3 * usize::from(cosine < 0.0),
            f64::from(cosine.abs()),
        )
    })
}
