//! Light at the vertices of the mesh, in their order, while it is found.

use super::light::{Cost, VertexLight};
use crate::radiometry::Rgb;
use crate::solution::NO_DISTRIBUTION;

/// Vertices that have their light. Distributions stand one after the other, as the solution wants them: copied together
/// at the end, they would be in memory twice.
#[derive(Debug, Default)]
pub(super) struct Lit {
    irradiance: Vec<Rgb>,
    radiance: Vec<Rgb>,
    /// Where each vertex's distribution starts, or [`NO_DISTRIBUTION`].
    offsets: Vec<u32>,
    words: Vec<u32>,
    cost: Cost,
}

impl Lit {
    /// Adds the next vertex.
    pub(super) fn push(&mut self, light: VertexLight) {
        self.irradiance.push(light.irradiance);
        self.radiance.push(light.radiance);
        self.offsets.push(match light.distribution {
            Some(words) => {
                let offset = self.words.len() as u32;
                self.words.extend_from_slice(&words);
                offset
            }
            None => NO_DISTRIBUTION,
        });
        self.cost.add(&light.cost);
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> usize {
        self.radiance.len()
    }

    /// Irradiance of a vertex.
    pub(super) fn irradiance(&self, vertex: u32) -> Rgb {
        self.irradiance[vertex as usize]
    }

    /// What all of them cost.
    pub(super) fn cost(&self) -> &Cost {
        &self.cost
    }

    /// Number of vertices that have a distribution.
    pub(super) fn distribution_count(&self) -> u64 {
        let is_one = |&&offset: &&u32| offset != NO_DISTRIBUTION;
        self.offsets.iter().filter(is_one).count() as u64
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.len() * (2 * size_of::<Rgb>() + size_of::<u32>()) + size_of_val(&self.words[..])
    }

    /// Radiance that has no direction, starts of the distributions, all distributions.
    pub(super) fn into_parts(self) -> (Vec<Rgb>, Vec<u32>, Vec<u32>) {
        let mut words = self.words;
        words.shrink_to_fit();
        (self.radiance, self.offsets, words)
    }
}

impl Extend<VertexLight> for Lit {
    fn extend<T: IntoIterator<Item = VertexLight>>(&mut self, lights: T) {
        lights.into_iter().for_each(|light| self.push(light));
    }
}
