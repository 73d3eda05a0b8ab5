//! Illumination samples (§3.2): where light comes from and the normal irradiance it carries.

use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use crate::transport::kernel::{Kernel, transfer};
use crate::transport::link::{Receiver, Sender, SenderId};
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
    /// How it changes over the receiver, if it does so in a known way.
    pub parallax: Option<Parallax>,
}

/// What a sample needs to be seen from elsewhere on its receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parallax {
    /// The sender.
    pub sender: SenderId,
    /// How its light varies.
    pub kernel: Kernel,
    /// What the link found over what `transfer` gives the whole receiver: the mean stays what it is.
    pub scale: f32,
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
}

/// A sample of `receiver` as seen from a place on it: other direction, distance and cosine at the sender.
fn moved(
    hierarchy: &Hierarchy,
    sample: &IlluminationSample,
    parallax: &Parallax,
    here: &Receiver,
    keep_direction: bool,
) -> IlluminationSample {
    let Some(normal) = here.normal else {
        return *sample;
    };
    let sender = Sender::new(hierarchy, parallax.sender);
    let vector = transfer(&sender, here, parallax.kernel) * parallax.scale;
    let irradiance = vector.dot(normal);
    let mut moved = IlluminationSample {
        parallax: None,
        ..*sample
    };
    if irradiance <= 0.0 {
        moved.irradiance = Rgb::BLACK;
    } else if keep_direction {
        moved.irradiance = sample.irradiance * (irradiance / sample.direction.dot(normal));
    } else {
        let length = vector.length();
        moved.direction = vector / length;
        moved.irradiance = sample.irradiance * length;
        moved.spread = sample.spread * length.sqrt();
    }
    moved
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

    /// "Push": appends the samples of `id` and its ancestors to `field`, each as seen from the middle of `id`. With
    /// `keep_directions` they change their strength only.
    pub fn field(
        &self,
        hierarchy: &Hierarchy,
        id: NodeId,
        keep_directions: bool,
        field: &mut Vec<IlluminationSample>,
    ) {
        let here = Receiver::node(hierarchy, id);
        field.extend_from_slice(self.of(id));
        let mut at = hierarchy.node(id).parent;
        while at != NONE {
            let receiver = hierarchy.node(at);
            field.extend(self.of(at).iter().map(|sample| match sample.parallax {
                Some(parallax) => moved(hierarchy, sample, &parallax, &here, keep_directions),
                None => *sample,
            }));
            at = receiver.parent;
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
