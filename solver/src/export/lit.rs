//! Light at the vertices of the mesh, in their order, while it is found.

use super::light::VertexLight;

/// Vertices that have their light. Distributions stand one after the other, as the solution wants them: copied together
/// at the end, they would be in memory twice.
#[derive(Debug, Default)]
pub(super) struct Lit {
    vertices: Vec<VertexLight>,
    /// Where each vertex's distribution starts, if it has one.
    offsets: Vec<Option<u32>>,
    words: Vec<u32>,
}

impl Lit {
    /// Adds the next vertex.
    pub(super) fn push(&mut self, mut light: VertexLight) {
        let offset = light.distribution.take().map(|words| {
            let offset = self.words.len() as u32;
            self.words.extend_from_slice(&words);
            offset
        });
        self.offsets.push(offset);
        self.vertices.push(light);
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// What vertex `vertex` shows, its distribution aside.
    pub(super) fn vertex(&self, vertex: u32) -> &VertexLight {
        &self.vertices[vertex as usize]
    }

    /// All of them, with where their distributions start.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (&VertexLight, Option<u32>)> {
        self.vertices.iter().zip(self.offsets.iter().copied())
    }

    /// All distributions.
    pub(super) fn into_words(self) -> Vec<u32> {
        let mut words = self.words;
        words.shrink_to_fit();
        words
    }
}

impl Extend<VertexLight> for Lit {
    fn extend<T: IntoIterator<Item = VertexLight>>(&mut self, lights: T) {
        lights.into_iter().for_each(|light| self.push(light));
    }
}
