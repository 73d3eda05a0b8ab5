//! Irradiance of diffuse leaves, added up from iteration to iteration: what they have reflected needs no samples again.

use crate::hierarchy::NodeId;
use crate::radiometry::Rgb;

/// Irradiance per node that was there in the first iteration; those that came later are known to samples alone.
#[derive(Clone, Debug, Default)]
pub(super) struct Collected {
    irradiance: Vec<Rgb>,
}

impl Collected {
    /// Adds what one iteration brought, multiplied with `weight`.
    pub(super) fn add(&mut self, irradiance: Vec<Rgb>, weight: Rgb) {
        if self.irradiance.is_empty() {
            self.irradiance = irradiance;
            self.irradiance
                .iter_mut()
                .for_each(|own| *own = *own * weight);
        } else {
            let pairs = self.irradiance.iter_mut().zip(irradiance);
            pairs.for_each(|(own, new)| *own += new * weight);
        }
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
