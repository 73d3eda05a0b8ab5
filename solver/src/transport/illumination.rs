//! Illumination samples (§3.2): where light comes from and the normal irradiance it carries.

use crate::hierarchy::{Hierarchy, NONE, NodeId};
use crate::radiometry::Rgb;
use crate::transport::kernel::{Kernel, transfer};
use crate::transport::link::{Receiver, Sender, SenderId};
use crate::transport::openness::Openness;
use crate::transport::packed_sample::Packed;
use crate::transport::propagate::Arrivals;
use crate::transport::views::{Eye, Shares};
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::f32::consts::PI;

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
    /// Share of the sender that the whole receiver sees; once its leaves have been asked, not less than they say.
    pub open: f32,
    /// What leaves get whose view shows none of it, over what those get that see all of it; those that see none for
    /// certain get nothing. `None` where all get the same.
    pub least: Option<f32>,
}

impl Parallax {
    /// True where part of the sender is seen.
    pub(super) fn is_shadow(&self) -> bool {
        self.open > 0.0 && self.open < 1.0
    }

    /// Shares out by what the leaves of the receiver see, and their mean stays what it is. None gets more than if
    /// nothing stood in between.
    pub(super) fn place(&mut self, seen: Shares) {
        if seen.missed >= 1.0 {
            return;
        }
        let rest = 1.0 - seen.missed - seen.shown;
        let over = self.open - seen.shown;
        self.least = Some(if over <= 0.0 {
            0.0
        } else {
            over / rest.max(over)
        });
        self.open = self.open.max(seen.shown);
    }

    /// What a leaf gets over what all leaves get on average.
    fn times(&self, sender: &Sender, eye: &Eye<'_>) -> f32 {
        let Some(least) = self.least else {
            return 1.0;
        };
        let share = eye.share(sender);
        if share <= 0.0 && eye.misses(sender) {
            return 0.0;
        }
        (least + (1.0 - least) * share) / self.open
    }
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

    /// Solid angle of what sends it [sr].
    pub(super) fn solid_angle(&self) -> f32 {
        PI * self.spread * self.spread
    }

    /// What of it arrives through what stands in between, if anything does; nothing opaque hides the share `open`.
    pub(super) fn through(mut self, transmittance: Rgb, open: f32) -> Option<Self> {
        self.irradiance = self.irradiance * transmittance;
        self.spread *= open.sqrt();
        (!self.irradiance.is_black()).then_some(self)
    }

    /// What of it arrives on average of its receiver, which sees the share `open` of the sender.
    pub(super) fn partly(mut self, transmittance: Rgb, open: f32) -> Self {
        self.irradiance = self.irradiance * transmittance;
        if let Some(parallax) = &mut self.parallax {
            parallax.open = open;
        }
        self
    }

    fn scaled(mut self, factor: f32) -> Self {
        self.irradiance *= factor;
        self
    }

    /// What a surface sees of a disc as wide as the sender that its horizon cuts. Clusters hold surfaces that face
    /// every way: beside the cosine to the middle of a wide sender, on those that are turned away from it, there is
    /// the part of it that they still see (closed form for a sphere above a horizon: Snyder 1996, "Area light sources
    /// for real-time graphics").
    fn above_horizon(&self, normal: Vec3) -> Self {
        let cosine = self.direction.dot(normal);
        let sine = self.spread.min(1.0);
        if cosine >= sine {
            return *self;
        }
        let seen = Self {
            parallax: None,
            ..*self
        };
        let black = Self {
            irradiance: Rgb::BLACK,
            ..seen
        };
        if cosine <= -sine {
            return black;
        }
        let across = (1.0 - cosine * cosine).max(0.0).sqrt();
        let out = (1.0 / (sine * sine) - 1.0).max(0.0).sqrt();
        let cut = if across > 0.0 {
            (-out * cosine / across).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let chord = across * (1.0 - cut * cut).sqrt();
        let share = ((cosine * cut.acos() - out * chord) * sine * sine + chord.atan2(out))
            / (PI * sine * sine);
        // From the middle of what is above the horizon.
        let height = 0.5 * (cosine.asin() + sine.asin());
        let along = (self.direction - normal * cosine).normalize_or_zero();
        let (up, level) = height.sin_cos();
        if share <= 0.0 || up <= 0.0 {
            return black;
        }
        Self {
            direction: (along * level + normal * up).normalize(),
            irradiance: self.irradiance * (share / up),
            ..seen
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
    eye: Option<&Eye<'_>>,
) -> IlluminationSample {
    let Some(normal) = here.normal else {
        return *sample;
    };
    let sender = Sender::new(hierarchy, parallax.sender);
    let scale = parallax.scale * eye.map_or(1.0, |eye| parallax.times(&sender, eye));
    let vector = transfer(&sender, here, parallax.kernel) * scale;
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

/// The way from a leaf to the root, and how samples of each node on it are seen from the middle of the leaf.
pub(super) struct Ascent<'a> {
    hierarchy: &'a Hierarchy,
    openness: &'a Openness,
    keep_directions: bool,
    leaf: NodeId,
    eye: Option<Eye<'a>>,
    here: Receiver,
    normal: Vec3,
    /// The node that it has come to.
    pub(super) at: NodeId,
    /// The whole patch, and how many clusters above its parent `at` is.
    root: NodeId,
    levels: usize,
}

impl<'a> Ascent<'a> {
    pub(super) fn new(
        hierarchy: &'a Hierarchy,
        leaf: NodeId,
        keep_directions: bool,
        openness: &'a Openness,
    ) -> Self {
        let element = hierarchy.element_of(leaf);
        Self {
            hierarchy,
            openness,
            keep_directions,
            leaf,
            eye: openness.views.of(hierarchy, leaf),
            here: Receiver::node(hierarchy, leaf),
            normal: element.map_or(Vec3::ZERO, |element| hierarchy.shading_normal(element)),
            at: leaf,
            root: leaf,
            levels: 0,
        }
    }

    /// On to the parent; false at the root.
    pub(super) fn rise(&mut self) -> bool {
        let parent = self.hierarchy.node(self.at).parent;
        if parent == NONE {
            return false;
        }
        if self.hierarchy.element_of(self.at).is_some() {
            self.root = self.at;
        } else {
            self.levels += 1;
        }
        self.at = parent;
        true
    }

    /// A sample of the node that it has come to, as seen from the leaf.
    pub(super) fn seen(&self, sample: &IlluminationSample) -> IlluminationSample {
        let is_cluster = self.hierarchy.element_of(self.at).is_none();
        match sample.parallax {
            _ if self.at == self.leaf => *sample,
            Some(parallax) => moved(
                self.hierarchy,
                sample,
                &parallax,
                &self.here,
                self.keep_directions,
                self.eye.as_ref(),
            ),
            None if is_cluster => {
                let per_share = self.openness.per_share(self.at, sample.direction);
                self.shared_out(sample, per_share)
            }
            None => *sample,
        }
    }

    /// A sample without parallax of the cluster that it has come to, as seen from the leaf.
    fn shared_out(
        &self,
        sample: &IlluminationSample,
        per_share: Option<f32>,
    ) -> IlluminationSample {
        let share = || self.openness.share(self.root, self.levels);
        let factor = per_share.map_or(1.0, |per_share| share() * per_share);
        sample.above_horizon(self.normal).scaled(factor)
    }
}

/// Samples of clusters as the leaves below them ask for them, leaf after leaf.
#[derive(Default)]
pub struct Unpacked {
    of_cluster: FxHashMap<NodeId, Vec<FromCluster>>,
    count: usize,
}

struct FromCluster {
    sample: IlluminationSample,
    /// [`Openness::per_share`] of its direction.
    per_share: Option<f32>,
}

impl Unpacked {
    /// Samples that are kept at once.
    const MOST: usize = 1 << 13;

    fn of_cluster(&mut self, id: NodeId, sets: &SampleSets, openness: &Openness) -> &[FromCluster] {
        if self.count > Self::MOST {
            self.of_cluster.clear();
            self.count = 0;
        }
        let count = &mut self.count;
        self.of_cluster.entry(id).or_insert_with(|| {
            let unpacked = |sample: IlluminationSample| FromCluster {
                per_share: openness.per_share(id, sample.direction),
                sample,
            };
            let samples: Vec<FromCluster> = sets.of(id).map(unpacked).collect();
            *count += samples.len();
            samples
        })
    }
}

/// Samples that nodes of the hierarchy received; the field of a leaf is the union along its path to the root.
#[derive(Clone, Debug, Default)]
pub struct SampleSets {
    sets: Vec<Vec<Packed>>,
    /// Samples in all of them.
    count: usize,
}

impl SampleSets {
    /// The samples that node `id` itself received.
    pub fn of(&self, id: u32) -> impl ExactSizeIterator<Item = IlluminationSample> {
        let set = self.sets.get(id as usize).map_or(&[][..], Vec::as_slice);
        set.iter().map(Packed::sample)
    }

    /// Adds samples to node `id`.
    pub fn extend(&mut self, id: u32, samples: Vec<IlluminationSample>) {
        self.add(id, samples.iter().map(Packed::of).collect());
    }

    fn add(&mut self, id: u32, samples: Vec<Packed>) {
        if samples.is_empty() {
            return;
        }
        self.count += samples.len();
        if self.sets.len() <= id as usize {
            self.sets.resize_with(id as usize + 1, Vec::new);
        }
        let set = &mut self.sets[id as usize];
        if set.is_empty() {
            *set = samples;
        } else {
            // Sets are many and small: room for as much again would be half of all memory.
            set.reserve_exact(samples.len());
            set.extend(samples);
        }
    }

    /// Moves samples of `other` into this one: what is new becomes accumulated (§3.4), at nodes that `keep` it.
    pub fn absorb(&mut self, other: Self, keep: impl Fn(NodeId) -> bool) {
        for (id, samples) in (0..).zip(other.sets) {
            if keep(id) {
                self.add(id, samples);
            }
        }
    }

    /// Scales the light of all samples.
    pub fn scale(&mut self, factor: Rgb) {
        for sample in self.sets.iter_mut().flatten() {
            sample.scale(factor);
        }
    }

    /// Asks the leaves below all elements what they see of senders that these see partly.
    pub fn ask(&mut self, hierarchy: &Hierarchy, openness: &Openness) {
        let elements: Vec<_> = (0..).zip(&mut self.sets).collect();
        elements
            .into_par_iter()
            .with_max_len(64)
            .filter(|(_, set)| set.iter().any(Packed::is_shadow))
            .for_each(|(id, set)| {
                let Some(below) = openness.below(hierarchy, id) else {
                    return;
                };
                for packed in set.iter_mut().filter(|packed| packed.is_shadow()) {
                    if let Some(mut parallax) = packed.sample().parallax {
                        parallax.place(below.shares(&Sender::new(hierarchy, parallax.sender)));
                        packed.place(&parallax);
                    }
                }
            });
    }

    /// "Push": appends the samples of the leaf `id` and its ancestors to `field`, each as seen from its middle. With
    /// `keep_directions` they change their strength only. What clusters received is shared out by `openness`; `unpacked`
    /// is that of these sets, and helps when leaves below the same clusters follow each other.
    pub fn field(
        &self,
        hierarchy: &Hierarchy,
        id: NodeId,
        keep_directions: bool,
        openness: &Openness,
        unpacked: &mut Unpacked,
        field: &mut Vec<IlluminationSample>,
    ) {
        let mut ascent = Ascent::new(hierarchy, id, keep_directions, openness);
        loop {
            let at = ascent.at;
            if hierarchy.element_of(at).is_some() {
                field.extend(self.of(at).map(|sample| ascent.seen(&sample)));
            } else if self
                .sets
                .get(at as usize)
                .is_some_and(|set| !set.is_empty())
            {
                let samples = unpacked.of_cluster(at, self, openness).iter();
                field.extend(samples.map(|from| match from.sample.parallax {
                    None => ascent.shared_out(&from.sample, from.per_share),
                    Some(_) => ascent.seen(&from.sample),
                }));
            }
            if !ascent.rise() {
                return;
            }
        }
    }

    /// Bytes that the samples take.
    pub fn bytes(&self) -> usize {
        self.sets
            .iter()
            .map(|s| s.capacity() * size_of::<Packed>())
            .sum::<usize>()
            + self.sets.capacity() * size_of::<Vec<Packed>>()
    }
}

impl Arrivals for SampleSets {
    fn take(&mut self, _: &Hierarchy, brought: Vec<(NodeId, Vec<IlluminationSample>)>) {
        for (id, samples) in brought {
            self.extend(id, samples);
        }
    }

    fn bytes(&self) -> usize {
        // Asked for after every batch: not counted set by set.
        self.count * size_of::<Packed>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sampling::spread;
    use std::f32::consts::TAU;

    /// Irradiance of a disc of directions with radiance one, by the midpoints of many equal parts of it.
    fn seen_from(direction: Vec3, sine: f32, normal: Vec3) -> f32 {
        const POINTS: u32 = 20_000;
        let (tangent, bitangent) = direction.any_orthonormal_pair();
        let cap = 1.0 - (1.0 - sine * sine).sqrt();
        let of_point = |i: u32| {
            let at = spread(i);
            let cosine = 1.0 - at.x * cap;
            let (sin, cos) = (TAU * at.y).sin_cos();
            let out = (1.0 - cosine * cosine).sqrt();
            let towards = direction * cosine + (tangent * cos + bitangent * sin) * out;
            towards.dot(normal).max(0.0)
        };
        (0..POINTS).map(of_point).sum::<f32>() / POINTS as f32 * TAU * cap
    }

    #[test]
    fn leaves_share_out_what_the_link_found() {
        let steps = || (0..=20).map(|i| i as f32 / 20.0);
        let mut short = 0;
        for open in steps().skip(1) {
            for missed in steps().take(20) {
                for shown in steps().filter(|shown| shown + missed <= 1.0) {
                    let mut parallax = Parallax {
                        sender: SenderId::whole(0),
                        kernel: Kernel::Point,
                        scale: 1.0,
                        open,
                        least: None,
                    };
                    parallax.place(Shares { shown, missed });
                    let least = parallax.least.expect("shared out");
                    assert!((0.0..=1.0).contains(&least));
                    // Means over leaves, over what the link found; in the open a leaf gets 1 over its share.
                    let mean = (least * (1.0 - missed - shown) + shown) / parallax.open;
                    let most = (1.0 - missed) / open;
                    assert!(
                        (mean - most.min(1.0)).abs() < 1e-5,
                        "open {open}, missed {missed}, shown {shown}: {mean}"
                    );
                    assert!(1.0 / parallax.open <= 1.0 / open);
                    short += u32::from(most < 1.0);
                }
            }
        }
        assert!(
            short > 100,
            "{short} cases where the link saw more than there is"
        );
    }

    #[test]
    fn a_horizon_cuts_a_wide_sender() {
        let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        for sine in [0.1f32, 0.4, 0.8, 1.0] {
            for turned in [0.0f32, 0.7, 1.2, 1.5, 1.8, 2.4] {
                let (sin, cos) = turned.sin_cos();
                let direction = normal * cos + normal.any_orthonormal_vector() * sin;
                let sample = IlluminationSample {
                    direction,
                    irradiance: Rgb::splat(PI * sine * sine),
                    spread: sine,
                    parallax: None,
                };
                let cut = sample.above_horizon(normal);
                let got = irradiance([&cut], normal).mean();
                let expected = seen_from(direction, sine, normal);
                let whole = PI * sine * sine;
                assert!(
                    (got - expected).abs() < 2e-3 * whole,
                    "sine {sine}, turned by {turned}: {got}, not {expected}"
                );
                let above = cut.direction.dot(normal);
                assert!(got == 0.0 || above > 0.0, "{above}");
            }
        }
    }
}
