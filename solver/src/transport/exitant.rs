//! Light that leaves the nodes of the hierarchy: what links carry.

use crate::directional::packed;
use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use glam::Vec3;
use std::f32::consts::PI;

/// Exitant light per node. An element has radiance L(ω), a cluster radiant intensity I(ω).
#[derive(Clone, Debug, Default)]
pub struct Exitant {
    /// Direction-independent radiance of elements [W·sr⁻¹·m⁻²]; zero for clusters.
    pub diffuse: Vec<Rgb>,
    /// Packed distribution: radiance of a glossy element, intensity of a cluster.
    pub distribution: Vec<Option<Box<[u32]>>>,
    /// Largest value over directions [mean over channels]: radiance of an element, intensity of a cluster.
    pub peak: Vec<f32>,
    /// Power that leaves the node [mean over channels].
    pub power: Vec<f32>,
    /// Largest exitance of a leaf of an element [mean over channels, W·m⁻²]; zero for clusters.
    pub brightest: Vec<f32>,
    /// Area of what light can reach of the node, which refinement tells better later on.
    pub area: Vec<f32>,
    /// Where the light leaves: the mean of the centres of its leaves, weighted by power.
    pub centre: Vec<Vec3>,
}

impl Exitant {
    /// No light from the nodes of `hierarchy`.
    pub fn dark(hierarchy: &Hierarchy) -> Self {
        let count = hierarchy.nodes.len();
        Self {
            area: hierarchy.nodes.iter().map(|node| node.area).collect(),
            diffuse: vec![Rgb::BLACK; count],
            distribution: vec![None; count],
            peak: vec![0.0; count],
            power: vec![0.0; count],
            brightest: vec![0.0; count],
            centre: vec![Vec3::ZERO; count],
        }
    }

    /// Frees the distributions of clusters, when nothing will be propagated any more.
    pub fn forget_clusters(&mut self, hierarchy: &Hierarchy) {
        for (node, distribution) in hierarchy.nodes.iter().zip(&mut self.distribution) {
            if node.element == NONE {
                *distribution = None;
            }
        }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.peak.len()
    }

    /// True without nodes.
    pub fn is_empty(&self) -> bool {
        self.peak.is_empty()
    }

    /// Radiance of an element, or intensity of a cluster, towards `direction`.
    pub fn towards(&self, id: NodeId, direction: Vec3) -> Rgb {
        let diffuse = self.diffuse[id as usize];
        match &self.distribution[id as usize] {
            Some(words) => diffuse + packed::evaluate(words, direction),
            None => diffuse,
        }
    }

    /// Mean radiance of an element over the cosine-weighted hemisphere [mean over channels, W·sr⁻¹·m⁻²].
    pub fn mean_radiance(&self, id: NodeId) -> f32 {
        self.power[id as usize] / (PI * self.area[id as usize])
    }

    /// Bounds on [`Self::towards`] within `half_angle` of `axis` [mean over channels].
    pub fn bounds(&self, id: NodeId, axis: Vec3, half_angle: f32) -> (f32, f32) {
        let diffuse = self.diffuse[id as usize].mean();
        match &self.distribution[id as usize] {
            Some(_) if half_angle > 1.0 => (diffuse, self.peak[id as usize]),
            Some(words) => {
                let (low, high) = packed::bounds_in_cone(words, axis, half_angle);
                (diffuse + low, diffuse + high)
            }
            None => (diffuse, diffuse),
        }
    }

    /// The same from five directions in the cone: hoped bounds at a fixed cost.
    pub fn sampled_bounds(&self, id: NodeId, axis: Vec3, half_angle: f32) -> (f32, f32) {
        if half_angle > 1.0 {
            return self.bounds(id, axis, half_angle);
        }
        let (tangent, bitangent) = axis.any_orthonormal_pair();
        let out = half_angle.tan();
        let middle = self.towards(id, axis).mean();
        [tangent, bitangent, -tangent, -bitangent].into_iter().fold(
            (middle, middle),
            |(low, high), side| {
                let value = self.towards(id, (axis + side * out).normalize()).mean();
                (low.min(value), high.max(value))
            },
        )
    }

    /// How wrong the mean radiance of an element may be for the `share` of it that is seen, as a share of
    /// what all of it sends: what stands on a surface hides it just where it is dark.
    pub fn unevenness(&self, id: NodeId, share: f32) -> f32 {
        let (seen, hidden) = (share.min(1.0), (1.0 - share).max(0.0));
        // All light in one part, or no part brighter than the brightest.
        seen.max(hidden)
            .min(self.brightest_excess(id) * seen.min(hidden))
    }

    /// By what share of its mean the brightest part of an element is brighter than that.
    pub fn brightest_excess(&self, id: NodeId) -> f32 {
        let area = self.area[id as usize];
        let (power, most) = (self.power[id as usize], self.brightest[id as usize] * area);
        if power > 0.0 {
            (most / power - 1.0).max(0.0)
        } else {
            0.0
        }
    }

    /// A child of `id` that sends, chosen in proportion to its power by `chance` in [0, 1), and the chance that is left for
    /// what is below it: evenly spread chances make evenly spread choices.
    pub fn brighter_child(
        &self,
        hierarchy: &Hierarchy,
        id: NodeId,
        chance: f32,
    ) -> Option<(NodeId, f32)> {
        /// The largest number below one.
        const MOST: f32 = 1.0 - f32::EPSILON / 2.0;
        let power = |child: NodeId| self.power.get(child as usize).copied().unwrap_or(0.0);
        let children = hierarchy.children(id);
        let mut left = chance * children.clone().map(power).sum::<f32>();
        let mut chosen = None;
        for child in children.filter(|&child| power(child) > 0.0) {
            chosen = Some((child, (left / power(child)).min(MOST)));
            if left < power(child) {
                break;
            }
            left -= power(child);
        }
        chosen
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.distribution
            .iter()
            .flatten()
            .map(|d| size_of_val::<[u32]>(d))
            .sum::<usize>()
            + self.len() * 56
    }
}
