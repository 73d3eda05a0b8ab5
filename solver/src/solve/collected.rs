//! Irradiance of diffuse leaves, added up from iteration to iteration: what they have reflected needs no samples again.

use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;

/// Irradiance per node. A leaf that is split leaves its own to its parts: links found that its light is as even as it has
/// to be.
#[derive(Clone, Debug, Default)]
pub(super) struct Collected {
    irradiance: Vec<Rgb>,
}

impl Collected {
    /// Adds what one iteration brought, multiplied with `weight`.
    pub(super) fn add(&mut self, hierarchy: &Hierarchy, irradiance: Vec<Rgb>, weight: Rgb) {
        // Children have larger numbers than their parents.
        for id in self.irradiance.len()..irradiance.len() {
            let parent = hierarchy.node(id as NodeId).parent;
            // The root has none, and no node has that number.
            let before = self.irradiance.get(parent as usize).copied();
            self.irradiance.push(before.unwrap_or(Rgb::BLACK));
        }
        let pairs = self.irradiance.iter_mut().zip(irradiance);
        pairs.for_each(|(own, new)| *own += new * weight);
    }

    /// Irradiance of a leaf, if all of it is known.
    pub(super) fn at(&self, leaf: NodeId) -> Option<Rgb> {
        self.irradiance.get(leaf as usize).copied()
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val::<[Rgb]>(&self.irradiance)
    }
}
