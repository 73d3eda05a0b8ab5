//! Light at the vertices of the mesh: gathered there with the bounded propagation, or averaged from the elements
//! around (§5.2).

use super::lit::Lit;
use super::mesh::{Mesh, Vertex, leaves};
use super::place::Place;
use super::pockets::pockets;
use crate::config::{Refiner, Settings};
use crate::directional::{Projection, Projector, Source, packed};
use crate::hierarchy::{Element, Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::solve::{Emission, Prepared, Transported, Watch};
use crate::transport::exitant::Exitant;
use crate::transport::gather::Gather;
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::Receiver;
use crate::transport::propagate::{Environment, Gloss, LinkStats};
use crate::transport::reflect::{ReflectConfig, Surface, reflect};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI};
use std::ops::Range;

/// What a vertex shows.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexLight {
    /// Irradiance.
    pub irradiance: Rgb,
    /// Direction-independent radiance, emission included.
    pub radiance: Rgb,
    /// Packed distribution of glossily reflected light.
    pub distribution: Option<Box<[u32]>>,
    /// What it took.
    pub cost: Cost,
}

/// What the light at vertices took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cost {
    /// Links and rays.
    pub links: LinkStats,
    /// Of the reflection.
    pub brdf_evaluations: u64,
    /// Cells of the distributions.
    pub basis_functions: u64,
}

impl Cost {
    /// Adds another's.
    pub(super) fn add(&mut self, other: &Self) {
        self.links.add(&other.links);
        self.brdf_evaluations += other.brdf_evaluations;
        self.basis_functions += other.basis_functions;
    }
}

/// Everything that lights a vertex.
pub(super) struct Light<'a> {
    prepared: &'a Prepared,
    settings: &'a Settings,
    gather: Gather<'a>,
    total: &'a Exitant,
    /// Irradiance per node of the transport.
    irradiance: &'a [Rgb],
    /// Bytes of what it was made of.
    held: usize,
    /// Typical irradiance of lit surfaces [mean over channels]: the square of the mean root, so that a few surfaces
    /// right beside lamps do not set the scale for all others.
    typical_irradiance: f32,
    /// Which sides of patches, front and back, are in pockets.
    pockets: Vec<[bool; 2]>,
}

/// Neighbouring vertices are twice as far apart as a corner is from the middle; a triangular filter that wide has the
/// variance of a disc of this share.
const BEND_WEIGHT: f32 = 0.5;

/// Vertices that are gathered between two reports.
const BATCH: usize = 4096;

impl<'a> Light<'a> {
    pub(super) fn new(
        prepared: &'a Prepared,
        settings: &'a Settings,
        transported: &'a Transported,
        environment: &'a Environment<'a>,
        hierarchy: &Hierarchy,
    ) -> Self {
        let (mut sum, mut area) = (0.0f64, 0.0f64);
        for (id, irradiance) in transported.irradiance.iter().enumerate() {
            if !irradiance.is_black() {
                let leaf = transported.leaf_area[id];
                sum += f64::from(irradiance.mean()).sqrt() * f64::from(leaf);
                area += f64::from(leaf);
            }
        }
        let gather = Gather {
            environment,
            exitant: &transported.total,
            node_count: hierarchy.nodes.len(),
            strata: settings.vertex_strata,
            visibility: settings.visibility,
        };
        let typical_irradiance = if area > 0.0 {
            (sum / area).powi(2) as f32
        } else {
            0.0
        };
        let dark = settings.dark_share * typical_irradiance;
        // Averages show what transport found everywhere.
        let pockets = if settings.gather {
            pockets(prepared, hierarchy, &transported.irradiance, dark)
        } else {
            vec![[false; 2]; prepared.patches.len()]
        };
        Self {
            prepared,
            settings,
            gather,
            held: prepared.bytes() + transported.total.bytes(),
            total: &transported.total,
            irradiance: &transported.irradiance,
            typical_irradiance,
            pockets,
        }
    }

    /// Irradiance below which differences on a material do not matter: a share of the mean, more on dark materials
    /// and on lamps, which outshine what they reflect.
    pub(super) fn visible_difference(&self, material: u32) -> f32 {
        let emission = self.prepared.emission[material as usize].even.mean();
        0.13 * self.typical_irradiance + 0.15 * PI * emission
    }

    /// Finds which part of the elements from number `first` on light can reach.
    pub(super) fn expose(&self, hierarchy: &mut Hierarchy, first: usize) {
        self.prepared.reach().expose(hierarchy, first);
    }

    /// Irradiance that the transport found at a leaf or, if it has been split since, at what it was part of.
    fn known_irradiance(&self, hierarchy: &Hierarchy, leaf: NodeId) -> f32 {
        let mut at = leaf;
        while at as usize >= self.irradiance.len() {
            at = hierarchy.node(at).parent;
        }
        self.irradiance[at as usize].mean()
    }

    /// What vertices of an element may be wrong by more than those of large ones: small things take up few pixels.
    fn relief(&self, element: &Element) -> f32 {
        const SMALL: f32 = 0.7;
        const MOST: f32 = 3.0;
        let size = element.polygon.vector_area().length().sqrt();
        (SMALL * self.settings.min_edge / size).clamp(1.0, MOST)
    }

    fn gather(
        &self,
        hierarchy: &Hierarchy,
        element: &Element,
        position: Vec3,
        normal: Vec3,
        gloss: Gloss,
        samples: &mut Vec<IlluminationSample>,
    ) -> LinkStats {
        samples.clear();
        let receiver = Receiver::vertex(position, normal, element.patch);
        let known = self.known_irradiance(hierarchy, element.node);
        let tolerance = self.settings.vertex_tolerance * self.relief(element);
        let limit = tolerance * (known + self.visible_difference(element.material));
        self.gather.at(hierarchy, &receiver, gloss, limit, samples)
    }

    /// Irradiance in the middle of a leaf.
    pub(super) fn irradiance_at_centre(&self, hierarchy: &Hierarchy, element: &Element) -> Rgb {
        let mut samples = Vec::new();
        let normal = hierarchy.shading_normal(element);
        let centre = hierarchy.node(element.node).centre;
        self.gather(
            hierarchy,
            element,
            centre,
            normal,
            Gloss::default(),
            &mut samples,
        );
        crate::transport::illumination::irradiance(&samples, normal)
    }

    /// Leaves whose light is shown in their middle too, of those where its irradiance is known: diffuse ones.
    pub(super) fn known_centres(
        &self,
        hierarchy: &Hierarchy,
        centres: &[Option<Rgb>],
    ) -> Vec<(Element, Rgb)> {
        leaves(hierarchy)
            .filter(|element| self.prepared.lobes[element.material as usize].is_none())
            .filter_map(|element| {
                let irradiance = centres.get(element.node as usize).copied().flatten()?;
                Some((*element, irradiance))
            })
            .collect()
    }

    /// What a diffuse element shows under an irradiance.
    pub(super) fn diffuse(&self, element: &Element, irradiance: Rgb) -> VertexLight {
        let reflected = irradiance * self.prepared.diffuse[element.material as usize];
        VertexLight {
            irradiance,
            radiance: reflected * FRAC_1_PI + self.emission(element).even,
            ..VertexLight::default()
        }
    }

    /// Gathers at every vertex of `mesh` that is not in `lit` yet; a stopped solve leaves some out. Its progress runs
    /// through the range `done` of the whole solve's.
    pub(super) fn gather_missing(
        &self,
        hierarchy: &Hierarchy,
        mesh: &Mesh,
        lit: &mut Lit,
        watch: &mut Watch<'_>,
        done: Range<f32>,
    ) {
        let first = lit.len();
        let around = mesh.leaves_around(hierarchy);
        while lit.len() < mesh.vertices.len() {
            let range = lit.len()..mesh.vertices.len().min(lit.len() + BATCH);
            let batch: Vec<VertexLight> = mesh.vertices[range.clone()]
                .par_iter()
                .zip(&around[range])
                .with_max_len(32)
                .map_init(
                    || (Projector::default(), Vec::new()),
                    |(projector, samples), (vertex, around)| {
                        let element = |&leaf: &NodeId| hierarchy.element_of(leaf);
                        if around
                            .iter()
                            .flat_map(element)
                            .all(|e| self.is_in_pocket(e))
                        {
                            return self.mean_of(hierarchy, around, projector);
                        }
                        let occluders = &self.prepared.occluders;
                        let place = Place::of(vertex, around, hierarchy, occluders);
                        self.vertex(hierarchy, vertex, &place, projector, samples)
                    },
                )
                .collect();
            lit.extend(batch);
            let share = (lit.len() - first) as f32 / (mesh.vertices.len() - first) as f32;
            let now = done.start + (done.end - done.start) * share;
            let held = self.held + hierarchy.bytes() + mesh.bytes() + lit.bytes();
            if watch.report("light at vertices", now, held).is_break() {
                return;
            }
        }
    }

    fn vertex(
        &self,
        hierarchy: &Hierarchy,
        vertex: &Vertex,
        place: &Place<'_>,
        projector: &mut Projector,
        samples: &mut Vec<IlluminationSample>,
    ) -> VertexLight {
        let element = place.element;
        let material = vertex.material as usize;
        let lobe = self.prepared.lobes[material].as_ref();
        // Between vertices light is interpolated: directions that differ less than their normals do not count.
        let bend = BEND_WEIGHT * hierarchy.bend(element);
        let mut gloss = Gloss::of(lobe, self.prepared.diffuse[material]);
        gloss.width = gloss.width.hypot(bend);
        let links = self.gather(
            hierarchy,
            element,
            place.position,
            vertex.normal,
            gloss,
            samples,
        );
        let config = ReflectConfig {
            epsilon: self.settings.epsilon,
            refiner: self.settings.refiner,
            basis: self.settings.basis,
            max_level: self.settings.display_level,
            floor: 0.4,
            least: 0.04 * self.typical_irradiance,
            typical: FRAC_1_PI * self.typical_irradiance,
            conserve: false,
        };
        let dark = lobe.map(|_| {
            let receiver = Receiver::vertex(place.position, vertex.normal, element.patch);
            self.gather.dark(hierarchy, &receiver, vertex.normal)
        });
        let surface = Surface {
            normal: vertex.normal,
            diffuse: self.prepared.diffuse[material],
            lobe,
            compensating: self.emission(element).compensating,
            bend,
            dark: dark.as_ref(),
        };
        let reflected = reflect(samples, &surface, &config, projector);
        VertexLight {
            irradiance: reflected.irradiance,
            radiance: reflected.diffuse + self.emission(element).even,
            distribution: reflected.distribution,
            cost: Cost {
                links,
                brdf_evaluations: reflected.brdf_evaluations,
                basis_functions: reflected.cost.basis_functions,
            },
        }
    }

    /// True for a part of a patch whose side is in a pocket.
    pub(super) fn is_in_pocket(&self, element: &Element) -> bool {
        self.pockets[element.patch as usize][usize::from(element.back)]
    }

    fn emission(&self, element: &Element) -> Emission {
        self.prepared.emission(element.patch, element.back)
    }

    /// Gives every vertex that is not in `lit` yet the mean of the leaves around it, weighted by area (§5.2).
    pub(super) fn average(&self, hierarchy: &Hierarchy, mesh: &Mesh, lit: &mut Lit) {
        let around = mesh.leaves_around(hierarchy);
        for around in around[lit.len()..].chunks(BATCH) {
            let batch: Vec<VertexLight> = around
                .par_iter()
                .with_max_len(64)
                .map_init(Projector::default, |projector, around| {
                    self.mean_of(hierarchy, around, projector)
                })
                .collect();
            lit.extend(batch);
        }
    }

    fn mean_of(
        &self,
        hierarchy: &Hierarchy,
        around: &[NodeId],
        projector: &mut Projector,
    ) -> VertexLight {
        // A leaf that was split for balance has the light of what it was part of.
        let lit: Vec<(NodeId, f32)> = around
            .iter()
            .map(|&leaf| {
                let mut at = leaf;
                while at as usize >= self.total.len() {
                    at = hierarchy.node(at).parent;
                }
                (at, hierarchy.node(leaf).area)
            })
            .collect();
        let area: f32 = lit.iter().map(|l| l.1).sum();
        let mut light = VertexLight::default();
        let mut mean_radiance = 0.0;
        for &(id, part) in &lit {
            let exitance = self.total.power[id as usize] / hierarchy.node(id).area;
            mean_radiance += exitance * FRAC_1_PI * (part / area);
            light.radiance += self.total.diffuse[id as usize] * (part / area);
            light.irradiance += self.irradiance[id as usize] * (part / area);
        }
        if lit
            .iter()
            .all(|l| self.total.distribution[l.0 as usize].is_none())
        {
            return light;
        }
        let how = Projection {
            min_level: 1,
            max_level: self.settings.transport_level,
            epsilon: self.settings.epsilon,
            floor: match self.settings.refiner {
                Refiner::Relative => 0.2 * mean_radiance + 0.04 * self.typical_irradiance,
                Refiner::Absolute => FRAC_1_PI * self.typical_irradiance,
            },
            relative: self.settings.refiner == Refiner::Relative,
            horizon: None,
            integral: None,
            basis: self.settings.basis,
        };
        let mut words = Vec::new();
        let mut source = Mean {
            total: self.total,
            parts: &lit,
            area,
        };
        let cost = projector.project(&mut source, &how, &mut words);
        light.cost.basis_functions = cost.basis_functions;
        if cost.basis_functions > 0 {
            light.distribution = Some(words.into_boxed_slice());
        }
        light
    }
}

/// Mean of several distributions.
struct Mean<'a> {
    total: &'a Exitant,
    parts: &'a [(NodeId, f32)],
    area: f32,
}

impl Source for Mean<'_> {
    fn eval(&mut self, _: &[u32], direction: Vec3) -> Rgb {
        self.parts.iter().fold(Rgb::BLACK, |sum, &(id, part)| {
            match &self.total.distribution[id as usize] {
                Some(words) => sum + packed::evaluate(words, direction) * (part / self.area),
                None => sum,
            }
        })
    }
    fn narrow(&self, _: &mut Vec<u32>, _: std::ops::Range<usize>, _: Vec3, _: usize) {}
    fn candidate_count(&self) -> u32 {
        0
    }
}
