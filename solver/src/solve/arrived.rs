//! Light that has arrived at the nodes of the hierarchy, by method.

use crate::config::Method;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::transport::clustering::Reflections;
use crate::transport::illumination::SampleSets;

/// Light that has arrived: incident (§3.2), or reflected at once (§2.2).
pub enum Arrived {
    /// Illumination samples, to be reflected as a sum.
    Samples(SampleSets),
    /// What they have become at the leaves.
    Reflected(Reflections),
}

impl Default for Arrived {
    fn default() -> Self {
        Self::Samples(SampleSets::default())
    }
}

impl Arrived {
    /// None yet.
    pub(super) fn none(method: Method) -> Self {
        match method {
            Method::RadianceClustering => Self::Reflected(Reflections::default()),
            Method::IlluminationSamples | Method::SummedReflections => Self::default(),
        }
    }

    pub(super) fn scale(&mut self, factor: Rgb) {
        match self {
            Self::Samples(samples) => samples.scale(factor),
            Self::Reflected(reflections) => reflections.scale(factor),
        }
    }

    /// Adds all light of `other`, which is of the same kind; of samples those that nodes `keep`.
    pub(super) fn absorb(
        &mut self,
        hierarchy: &Hierarchy,
        other: Self,
        keep: impl Fn(NodeId) -> bool,
    ) {
        match (self, other) {
            (Self::Samples(own), Self::Samples(new)) => own.absorb(new, keep),
            (Self::Reflected(own), Self::Reflected(new)) => own.absorb(hierarchy, new),
            (own, new) => *own = new,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Samples(samples) => samples.bytes(),
            Self::Reflected(reflections) => reflections.bytes(),
        }
    }
}
