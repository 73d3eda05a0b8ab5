//! Reflection at all leaves: what arrived becomes exitant light (§3.3).

use super::Emission;
use super::arrived::Arrived;
use super::collected::Collected;
use super::iteration::Iteration;
use crate::config::Method;
use crate::directional::{Projector, Sum};
use crate::hierarchy::NodeId;
use crate::radiometry::Rgb;
use crate::transport::clustering::Surfaces;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::{IlluminationSample, Unpacked};
use crate::transport::reflect::{ReflectConfig, Reflected, reflect, reflect_each};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Power that all surfaces receive and that they send on, per channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ledger {
    pub(super) received: DVec3,
    pub(super) exitance: DVec3,
}

/// Scratch memory of reflections; one per thread.
#[derive(Default)]
struct Scratch {
    projector: Projector,
    sum: Sum,
    unpacked: Unpacked,
    field: Vec<IlluminationSample>,
}

impl Iteration<'_> {
    /// Where light is reflected.
    pub(super) fn surfaces(&self) -> Surfaces<'_> {
        Surfaces {
            lobes: &self.prepared.lobes,
            diffuse: &self.prepared.diffuse,
            openness: &self.openness,
        }
    }

    pub(super) fn reflect_config(&self, emitted: f64) -> ReflectConfig {
        // The mean radiance of the scene were all its light spread evenly.
        let mean = (emitted / (PI * f64::from(self.hierarchy.node(0).area))) as f32;
        ReflectConfig {
            epsilon: self.settings.transport_epsilon,
            refiner: self.settings.refiner,
            basis: self.settings.basis,
            max_level: self.settings.transport_level,
            floor: 0.3,
            least: self.settings.least_directional * mean,
            typical: mean,
            conserve: true,
        }
    }

    /// Exitant light of all leaves in answer to what `arrived`, not pulled yet; irradiance per node; and the sums. Where
    /// irradiance is `known`, diffuse leaves need not ask for samples.
    pub(super) fn reflected(
        &mut self,
        arrived: &Arrived,
        known: &Collected,
        config: &ReflectConfig,
        emission: bool,
    ) -> (Exitant, Vec<Rgb>, Ledger) {
        let hierarchy = &self.hierarchy;
        let mut leaves: Vec<NodeId> = hierarchy
            .elements
            .iter()
            .map(|e| e.node)
            .filter(|&id| hierarchy.is_leaf(id))
            .collect();
        // Leaves below the same clusters follow each other.
        leaves.sort_unstable_by_key(|&id| {
            let patch = hierarchy.element_of(id).map(|e| (e.patch, e.back));
            let whole = patch.map_or(id, |(patch, back)| hierarchy.whole(patch, back));
            (hierarchy.node(whole).parent, whole, id)
        });
        let reflected: Vec<Reflected> = leaves
            .par_iter()
            .with_max_len(256)
            .map_init(Scratch::default, |scratch, &id| {
                self.at_leaf(id, arrived, known, config, emission, scratch)
            })
            .collect();
        let mut exitant = Exitant::dark(hierarchy);
        let mut irradiance = vec![Rgb::BLACK; hierarchy.nodes.len()];
        let mut ledger = Ledger::default();
        for (&id, reflected) in leaves.iter().zip(reflected) {
            let area = hierarchy.node(id).area;
            ledger.received += reflected.irradiance.to_dvec3() * f64::from(area);
            ledger.exitance += reflected.exitance.to_dvec3() * f64::from(area);
            irradiance[id as usize] = reflected.irradiance;
            let at = id as usize;
            exitant.diffuse[at] += reflected.diffuse;
            exitant.power[at] += reflected.exitance.mean() * area;
            exitant.peak[at] = exitant.diffuse[at].mean();
            if let Some(words) = &reflected.distribution {
                exitant.peak[at] += crate::directional::packed::peak(words);
                self.stats.solve.distributions += 1;
            }
            exitant.distribution[at] = reflected.distribution;
            self.stats.solve.basis_functions += reflected.cost.basis_functions;
            self.stats.solve.brdf_evaluations += reflected.brdf_evaluations;
        }
        (exitant, irradiance, ledger)
    }

    /// Exitant light of a leaf.
    fn at_leaf(
        &self,
        id: NodeId,
        arrived: &Arrived,
        known: &Collected,
        config: &ReflectConfig,
        emission: bool,
        scratch: &mut Scratch,
    ) -> Reflected {
        let hierarchy = &self.hierarchy;
        let surfaces = self.surfaces();
        let (Some(element), Some(mut surface)) =
            (hierarchy.element_of(id), surfaces.of_leaf(hierarchy, id))
        else {
            return Reflected::default();
        };
        let emission = if emission {
            self.prepared.emission(element.patch, element.back)
        } else {
            Emission::default()
        };
        let Scratch {
            projector,
            sum,
            unpacked,
            field,
        } = scratch;
        surface.compensating = emission.compensating;
        let known = known.at(id).filter(|_| surface.lobe.is_none());
        let mut reflected = match (known, arrived) {
            (Some(irradiance), _) => {
                // Of what it was part of, light may have reached the rest alone.
                let irradiance = irradiance * f32::from(!element.exposed.is_none());
                Reflected::diffusely(irradiance, surface.diffuse)
            }
            (None, Arrived::Samples(samples)) => {
                field.clear();
                // Moved directions leave gaps in the lobes that links were refined for.
                let glossy = surface.lobe.is_some();
                samples.field(hierarchy, id, glossy, &self.openness, unpacked, field);
                // What light cannot reach has its share of what larger parts received; it is next to nothing.
                let is_dark = field.is_empty() || element.exposed.is_none();
                if is_dark && emission == Emission::default() {
                    return Reflected::default();
                }
                match self.settings.method {
                    Method::SummedReflections => {
                        reflect_each(field, &surface, config, projector, sum)
                    }
                    _ => reflect(field, &surface, config, projector),
                }
            }
            (None, Arrived::Reflected(reflections)) => {
                let emitted = reflect(&[], &surface, config, projector);
                reflections.with(hierarchy, id, emitted, sum)
            }
        };
        reflected.diffuse += emission.even;
        reflected.exitance += emission.even * PI as f32;
        reflected
    }
}
