//! Light that leaves the nodes of the hierarchy: what links carry.

use crate::directional::packed;
use crate::hierarchy::NodeId;
use crate::radiometry::Rgb;
use glam::Vec3;

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
}

impl Exitant {
    /// No light for `count` nodes.
    pub fn dark(count: usize) -> Self {
        Self {
            diffuse: vec![Rgb::BLACK; count],
            distribution: vec![None; count],
            peak: vec![0.0; count],
            power: vec![0.0; count],
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

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.distribution
            .iter()
            .flatten()
            .map(|d| size_of_val::<[u32]>(d))
            .sum::<usize>()
            + self.len() * 36
    }
}
