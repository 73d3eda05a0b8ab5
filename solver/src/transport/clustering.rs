//! Radiance clustering (§2.2; Sillion, Drettakis, Soler 1995): the baseline that illumination samples are measured against.
//!
//! Whatever a link brings is pushed to the leaves at once and reflected there, contribution by contribution. No incident
//! light is kept, but two representations of the light that leaves: what is sent, and what it is becoming.
//! Cost: a projection and a sum of distributions for each sample and each glossy leaf below its receiver.

use crate::brdf::Lobe;
use crate::directional::{Projector, Sum};
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::transport::illumination::{Ascent, IlluminationSample};
use crate::transport::link::Sender;
use crate::transport::openness::Openness;
use crate::transport::propagate::Arrivals;
use crate::transport::reflect::{ReflectConfig, Reflected, Surface, reflect_each};
use rayon::prelude::*;

/// What light meets when it is pushed.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    /// Glossy lobe per material.
    pub lobes: &'a [Option<Lobe>],
    /// Diffuse reflectance per material.
    pub diffuse: &'a [Rgb],
    /// Shares out what clusters received.
    pub openness: &'a Openness,
}

impl Surfaces<'_> {
    /// The place in the middle of a leaf; clusters have no surface.
    pub(crate) fn of_leaf(&self, hierarchy: &Hierarchy, leaf: NodeId) -> Option<Surface<'_>> {
        let element = hierarchy.element_of(leaf)?;
        let material = element.material as usize;
        Some(Surface {
            normal: hierarchy.shading_normal(element),
            diffuse: self.diffuse[material],
            lobe: self.lobes[material].as_ref(),
            compensating: Rgb::BLACK,
            bend: hierarchy.bend(element),
            dark: None,
        })
    }
}

/// What a node has reflected, and the factor that its distribution still has to be multiplied with.
struct Part {
    light: Reflected,
    factor: Rgb,
}

impl Part {
    /// Adds another to it, which lies on a surface with the same horizon.
    fn add(&mut self, other: &Self, sum: &mut Sum, horizon: glam::Vec3) {
        self.light.irradiance += other.light.irradiance;
        self.light.diffuse += other.light.diffuse;
        self.light.exitance += other.light.exitance;
        let Some(words) = &other.light.distribution else {
            return;
        };
        sum.clear(Some(horizon));
        if let Some(own) = &self.light.distribution {
            sum.add_packed(own, self.factor);
        }
        sum.add_packed(words, other.factor);
        self.pack(sum);
    }

    fn pack(&mut self, sum: &Sum) {
        let mut words = Vec::new();
        sum.pack(&mut words);
        self.light.distribution = Some(words.into_boxed_slice());
        self.factor = Rgb::WHITE;
    }
}

/// Counts of the reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReflectionCost {
    /// Distributions made.
    pub distributions: u64,
    /// Basis functions in them.
    pub basis_functions: u64,
    /// BRDF evaluations.
    pub brdf_evaluations: u64,
}

/// Reflected light per node: that of leaves, and of what was a leaf when it arrived.
#[derive(Default)]
pub struct Reflections {
    parts: Vec<Option<Box<Part>>>,
    /// What it took.
    pub cost: ReflectionCost,
}

impl Reflections {
    /// Where the light of links goes that reach `surfaces`.
    pub fn pushing<'a>(&'a mut self, surfaces: Surfaces<'a>, config: ReflectConfig) -> Pushing<'a> {
        Pushing {
            reflections: self,
            surfaces,
            config,
        }
    }

    /// Scales all light.
    pub fn scale(&mut self, factor: Rgb) {
        for part in self.parts.iter_mut().flatten() {
            part.light.irradiance = part.light.irradiance * factor;
            part.light.diffuse = part.light.diffuse * factor;
            part.light.exitance = part.light.exitance * factor;
            part.factor = part.factor * factor;
        }
    }

    /// Adds all light of `other`.
    pub fn absorb(&mut self, hierarchy: &Hierarchy, mut other: Self) {
        let count = self.parts.len().max(other.parts.len());
        self.parts.resize_with(count, || None);
        other.parts.resize_with(count, || None);
        let pairs = self.parts.par_iter_mut().zip(other.parts);
        pairs
            .enumerate()
            .for_each_init(Sum::default, |sum, (id, (own, new))| {
                if let Some(new) = new {
                    join(own, *new, hierarchy, id as NodeId, sum);
                }
            });
        // Leaves that it had light of may have been split since.
        self.settle(hierarchy);
    }

    /// Moves light of what has been split since it arrived to the leaves; the second half of "push".
    pub fn settle(&mut self, hierarchy: &Hierarchy) {
        let mut sum = Sum::default();
        // Children have larger numbers than their parents, and new ones come at the end.
        let mut id = 0;
        while id < self.parts.len() {
            if !hierarchy.is_leaf(id as NodeId)
                && let Some(part) = self.parts[id].take()
            {
                for child in hierarchy.children(id as NodeId) {
                    let copy = Part {
                        light: part.light.clone(),
                        factor: part.factor,
                    };
                    join(self.slot(child), copy, hierarchy, child, &mut sum);
                }
            }
            id += 1;
        }
    }

    /// Light of a leaf together with what it `emitted`, ready to be sent. What it cost has been counted.
    pub fn with(
        &self,
        hierarchy: &Hierarchy,
        leaf: NodeId,
        emitted: Reflected,
        sum: &mut Sum,
    ) -> Reflected {
        let mut all = Part {
            light: emitted,
            factor: Rgb::WHITE,
        };
        if let (Some(part), Some(element)) = (self.at(leaf), hierarchy.element_of(leaf)) {
            all.add(part, sum, hierarchy.shading_normal(element));
        }
        all.light
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let of_part = |part: &Part| {
            let words = part.light.distribution.as_ref();
            size_of::<Part>() + words.map_or(0, |words| size_of_val::<[u32]>(words))
        };
        let parts = self.parts.iter().flatten();
        size_of_val(&self.parts[..]) + parts.map(|part| of_part(part)).sum::<usize>()
    }

    fn at(&self, id: NodeId) -> Option<&Part> {
        self.parts.get(id as usize)?.as_deref()
    }

    fn slot(&mut self, id: NodeId) -> &mut Option<Box<Part>> {
        if self.parts.len() <= id as usize {
            self.parts.resize_with(id as usize + 1, || None);
        }
        &mut self.parts[id as usize]
    }
}

/// Adds `new` to what the node `id` has.
fn join(own: &mut Option<Box<Part>>, new: Part, hierarchy: &Hierarchy, id: NodeId, sum: &mut Sum) {
    match (own, hierarchy.element_of(id)) {
        (Some(own), Some(element)) => own.add(&new, sum, hierarchy.shading_normal(element)),
        (own, _) => *own = Some(Box::new(new)),
    }
}

/// Pushes light as it arrives.
pub struct Pushing<'a> {
    reflections: &'a mut Reflections,
    surfaces: Surfaces<'a>,
    config: ReflectConfig,
}

impl Arrivals for Pushing<'_> {
    fn take(&mut self, hierarchy: &Hierarchy, mut brought: Vec<(NodeId, Vec<IlluminationSample>)>) {
        let openness = self.surfaces.openness;
        brought.par_iter_mut().for_each(|(receiver, samples)| {
            let Some(below) = openness.below(hierarchy, *receiver) else {
                return;
            };
            let parallaxes = samples.iter_mut().filter_map(|s| s.parallax.as_mut());
            for parallax in parallaxes.filter(|parallax| parallax.is_shadow()) {
                parallax.place(below.shares(&Sender::new(hierarchy, parallax.sender)));
            }
        });
        // Leaves below each receiver, in the order of leaves.
        let mut pushed: Vec<(NodeId, usize)> = Vec::new();
        for (index, (receiver, samples)) in brought.iter().enumerate() {
            let mut pending = vec![*receiver];
            while let (false, Some(id)) = (samples.is_empty(), pending.pop()) {
                if hierarchy.is_leaf(id) {
                    pushed.push((id, index));
                } else {
                    pending.extend(hierarchy.children(id));
                }
            }
        }
        pushed.sort_unstable();
        let groups: Vec<&[(NodeId, usize)]> = pushed.chunk_by(|a, b| a.0 == b.0).collect();
        let (surfaces, config, known) = (&self.surfaces, &self.config, &*self.reflections);
        let parts: Vec<Option<(NodeId, Part)>> = groups
            .par_iter()
            .with_max_len(16)
            .map_init(
                || (Projector::default(), Sum::default(), Vec::new()),
                |(projector, sum, seen), group| {
                    let leaf = group[0].0;
                    // What light cannot reach has its share of what larger parts received; it is next to nothing.
                    if hierarchy.element_of(leaf)?.exposed.is_none() {
                        return None;
                    }
                    let surface = surfaces.of_leaf(hierarchy, leaf)?;
                    seen.clear();
                    for &(_, index) in *group {
                        let (receiver, samples) = &brought[index];
                        let is_glossy = surface.lobe.is_some();
                        let mut ascent = Ascent::new(hierarchy, leaf, is_glossy, surfaces.openness);
                        while ascent.at != *receiver && ascent.rise() {}
                        seen.extend(samples.iter().map(|sample| ascent.seen(sample)));
                    }
                    let mut part = Part {
                        light: reflect_each(seen, &surface, config, projector, sum),
                        factor: Rgb::WHITE,
                    };
                    if let Some(before) = known.at(leaf) {
                        part.add(before, sum, surface.normal);
                    }
                    Some((leaf, part))
                },
            )
            .collect();
        for (leaf, part) in parts.into_iter().flatten() {
            let cost = &mut self.reflections.cost;
            cost.distributions += u64::from(part.light.distribution.is_some());
            cost.basis_functions += part.light.cost.basis_functions;
            cost.brdf_evaluations += part.light.brdf_evaluations;
            *self.reflections.slot(leaf) = Some(Box::new(part));
        }
    }

    fn bytes(&self) -> usize {
        self.reflections.bytes()
    }
}
