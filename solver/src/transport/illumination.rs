//! Illumination samples (§3.2): where light comes from and the normal irradiance it carries.

use crate::radiometry::Rgb;
use glam::Vec3;

/// Light from one direction. The cosine at the receiver is not in it: the same sample means the same on a cluster,
/// an element and a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IlluminationSample {
    /// Towards the sender, unit.
    pub direction: Vec3,
    /// Normal irradiance E⊥ [W·m⁻²].
    pub irradiance: Rgb,
    /// Angular radius of a disc that fills the sender's solid angle [rad].
    pub spread: f32,
    /// How it changes over the receiver, if a point can stand for its sender.
    pub parallax: Option<Parallax>,
}

/// What a sample needs to be seen from elsewhere on the plane of its receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallax {
    /// Distance to the sender.
    pub distance: f32,
    /// Normal of the sender; zero for clusters, which send in all directions.
    pub sender_normal: Vec3,
    /// One over the mean over the receiver of what [`IlluminationSample::moved`] makes of irradiance 1: the mean
    /// stays what the link found.
    pub share: f32,
}

impl IlluminationSample {
    /// The same sender when only a part of it is seen: vector irradiance [sr] of the `whole` and of what is `seen`.
    pub fn seen_partly(&self, whole: Vec3, seen: Vec3) -> Self {
        let (whole, part) = (whole.length(), seen.length());
        if whole <= 0.0 || part <= 0.0 {
            return Self {
                irradiance: Rgb::BLACK,
                ..*self
            };
        }
        let share = part / whole;
        Self {
            direction: seen / part,
            irradiance: self.irradiance * share,
            spread: self.spread * share.sqrt(),
            parallax: None,
        }
    }

    /// The same sender as seen `offset` away on the receiver: other direction, distance and cosine at the sender.
    pub fn moved(&self, offset: Vec3) -> Self {
        let Some(parallax) = self.parallax else {
            return *self;
        };
        let to_sender = self.direction * parallax.distance - offset;
        let distance = to_sender.length();
        if distance == 0.0 {
            return *self;
        }
        let direction = to_sender / distance;
        let cosine = |d: Vec3| {
            if parallax.sender_normal == Vec3::ZERO {
                1.0
            } else {
                -parallax.sender_normal.dot(d)
            }
        };
        let (there, here) = (cosine(self.direction), cosine(direction).max(0.0));
        let nearer = parallax.distance / distance;
        let factor = here / there * nearer * nearer * parallax.share;
        Self {
            direction,
            irradiance: self.irradiance * factor,
            spread: self.spread * nearer,
            parallax: None,
        }
    }
}

/// Irradiance of `samples` on a surface with `normal` [W·m⁻²].
pub fn irradiance<'a>(
    samples: impl IntoIterator<Item = &'a IlluminationSample>,
    normal: Vec3,
) -> Rgb {
    samples.into_iter().fold(Rgb::BLACK, |sum, sample| {
        sum + sample.irradiance * sample.direction.dot(normal).max(0.0)
    })
}

/// Samples that nodes of the hierarchy received; the field of a leaf is the union along its path to the root.
#[derive(Clone, Debug, Default)]
pub struct SampleSets {
    sets: Vec<Vec<IlluminationSample>>,
}

impl SampleSets {
    /// The samples that node `id` itself received.
    pub fn of(&self, id: u32) -> &[IlluminationSample] {
        self.sets.get(id as usize).map_or(&[], Vec::as_slice)
    }

    /// Adds samples to node `id`.
    pub fn extend(&mut self, id: u32, samples: Vec<IlluminationSample>) {
        if samples.is_empty() {
            return;
        }
        if self.sets.len() <= id as usize {
            self.sets.resize_with(id as usize + 1, Vec::new);
        }
        let set = &mut self.sets[id as usize];
        if set.is_empty() {
            *set = samples;
        } else {
            set.extend(samples);
        }
    }

    /// Moves all samples of `other` into this one: what is new becomes accumulated (§3.4).
    pub fn absorb(&mut self, other: Self) {
        for (id, samples) in other.sets.into_iter().enumerate() {
            self.extend(id as u32, samples);
        }
    }

    /// "Push": appends the samples of `id` and its ancestors to `field`, each as seen from the middle of `id`.
    pub fn field(
        &self,
        nodes: &[crate::hierarchy::Node],
        id: u32,
        field: &mut Vec<IlluminationSample>,
    ) {
        let here = nodes[id as usize].centre;
        field.extend_from_slice(self.of(id));
        let mut at = nodes[id as usize].parent;
        while at != crate::hierarchy::NONE {
            let node = &nodes[at as usize];
            field.extend(
                self.of(at)
                    .iter()
                    .map(|sample| sample.moved(here - node.centre)),
            );
            at = node.parent;
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.sets.iter().map(Vec::len).sum()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.sets.iter().all(Vec::is_empty)
    }

    /// Bytes that the samples take.
    pub fn bytes(&self) -> usize {
        self.sets
            .iter()
            .map(|s| s.capacity() * size_of::<IlluminationSample>())
            .sum::<usize>()
            + self.sets.capacity() * size_of::<Vec<IlluminationSample>>()
    }
}
