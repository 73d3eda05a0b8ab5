//! Pull: exitant light of inner nodes from their children, bottom-up. A cluster stores intensity, an element radiance.

use crate::directional::{Basis, Projection, Projector, Source, packed};
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Sum of what the children of a node send towards a direction: intensity for clusters, mean radiance for elements.
struct Children<'a> {
    hierarchy: &'a Hierarchy,
    exitant: &'a Exitant,
    children: Vec<NodeId>,
    /// One over the parent's area for elements.
    per_area: Option<f32>,
}

impl Source for Children<'_> {
    fn eval(&mut self, _: &[u32], direction: Vec3) -> Rgb {
        let mut sum = Rgb::BLACK;
        for &child in &self.children {
            let weight = match (self.hierarchy.element_of(child), self.per_area) {
                (Some(_), Some(per_area)) => self.hierarchy.node(child).area * per_area,
                (Some(element), None) => {
                    let cosine = element.normal.dot(direction);
                    if cosine <= 0.0 {
                        continue;
                    }
                    self.hierarchy.node(child).area * cosine
                }
                (None, _) => 1.0,
            };
            sum += match (self.per_area, &self.exitant.distribution[child as usize]) {
                // Inner elements: the diffuse part is averaged on its own.
                (Some(_), Some(words)) => packed::evaluate(words, direction) * weight,
                (Some(_), None) => Rgb::BLACK,
                (None, _) => self.exitant.towards(child, direction) * weight,
            };
        }
        sum
    }
    fn narrow(&self, _: &mut Vec<u32>, _: std::ops::Range<usize>, _: Vec3, _: usize) {}
    fn candidate_count(&self) -> u32 {
        0
    }
}

/// Deepest level of the basis for inner nodes: they send to far receivers only, in wide cones.
const INNER_LEVEL: u32 = 4;
const CLUSTER_LEVEL: u32 = 3;

struct Pulled {
    diffuse: Rgb,
    distribution: Option<Box<[u32]>>,
    peak: f32,
    power: f32,
    brightest: f32,
    centre: Vec3,
}

/// How finely to pull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PullConfig {
    /// ε of the refiner for elements.
    pub epsilon: f32,
    /// And for clusters.
    pub cluster_epsilon: f32,
    /// Radiance that carries no direction.
    pub least: f32,
    /// What is projected on.
    pub basis: Basis,
}

/// Fills `exitant` for every inner node from its leaves, whose own is known.
pub fn pull(hierarchy: &Hierarchy, exitant: &mut Exitant, config: &PullConfig) {
    // Nodes by height above their leaves: all of one height are independent.
    let mut height = vec![0u16; hierarchy.nodes.len()];
    let mut by_height: Vec<Vec<NodeId>> = Vec::new();
    for id in bottom_up(hierarchy) {
        let h = hierarchy
            .children(id)
            .map(|c| height[c as usize] + 1)
            .max()
            .unwrap_or(0);
        height[id as usize] = h;
        if h > 0 {
            if by_height.len() < usize::from(h) {
                by_height.resize_with(usize::from(h), Vec::new);
            }
            by_height[usize::from(h) - 1].push(id);
        }
    }
    for element in &hierarchy.elements {
        if hierarchy.is_leaf(element.node) {
            let at = element.node as usize;
            let node = hierarchy.node(element.node);
            exitant.brightest[at] = exitant.power[at] / node.area;
            exitant.centre[at] = node.centre;
        }
    }
    for ids in by_height {
        let shared = &*exitant;
        let pulled: Vec<Pulled> = ids
            .par_iter()
            .with_max_len(16)
            .map_init(Projector::default, |projector, &id| {
                pull_node(hierarchy, shared, id, config, projector)
            })
            .collect();
        for (id, pulled) in ids.into_iter().zip(pulled) {
            let id = id as usize;
            exitant.diffuse[id] = pulled.diffuse;
            exitant.distribution[id] = pulled.distribution;
            exitant.peak[id] = pulled.peak;
            exitant.power[id] = pulled.power;
            exitant.brightest[id] = pulled.brightest;
            exitant.centre[id] = pulled.centre;
        }
    }
}

/// All nodes, children before parents. Elements are appended after their parents, so descending ids do.
pub fn bottom_up(hierarchy: &Hierarchy) -> impl Iterator<Item = NodeId> + use<> {
    (0..hierarchy.nodes.len() as NodeId).rev()
}

fn pull_node(
    hierarchy: &Hierarchy,
    exitant: &Exitant,
    id: NodeId,
    config: &PullConfig,
    projector: &mut Projector,
) -> Pulled {
    let lit: Vec<NodeId> = hierarchy
        .children(id)
        .filter(|&c| exitant.peak[c as usize] > 0.0)
        .collect();
    let power: f32 = lit.iter().map(|&c| exitant.power[c as usize]).sum();
    let dark = Pulled {
        diffuse: Rgb::BLACK,
        distribution: None,
        peak: 0.0,
        power: 0.0,
        brightest: 0.0,
        centre: hierarchy.node(id).centre,
    };
    if lit.is_empty() {
        return dark;
    }
    let element = hierarchy.element_of(id);
    let area = hierarchy.node(id).area;
    let diffuse = if element.is_some() {
        lit.iter().fold(Rgb::BLACK, |sum, &c| {
            sum + exitant.diffuse[c as usize] * (hierarchy.node(c).area / area)
        })
    } else {
        Rgb::BLACK
    };
    let weighted = |&c: &NodeId| exitant.centre[c as usize] * exitant.power[c as usize];
    let centre = lit.iter().map(weighted).sum::<Vec3>() / power;
    let brightest = match element {
        Some(_) => lit
            .iter()
            .map(|&c| exitant.brightest[c as usize])
            .fold(0.0, f32::max),
        None => 0.0,
    };
    let directional = element.is_none()
        || lit
            .iter()
            .any(|&c| exitant.distribution[c as usize].is_some());
    let mut distribution = None;
    let mut peak = diffuse.mean();
    if directional {
        // Half the mean over the sphere is small; of what carries no direction a cluster shows a quarter of its area.
        let floor = match element {
            Some(_) => 0.25 * power / (PI * area) + config.least,
            None => 0.5 * power / (4.0 * PI) + 0.25 * config.least * area,
        };
        let is_bright = power > PI * area * config.least;
        let how = Projection {
            min_level: if element.is_none() && is_bright { 2 } else { 1 },
            max_level: if element.is_some() {
                INNER_LEVEL
            } else {
                CLUSTER_LEVEL
            },
            epsilon: if element.is_some() {
                config.epsilon
            } else {
                config.cluster_epsilon
            },
            floor,
            relative: true,
            basis: config.basis,
            horizon: element.map(|e| e.normal),
            integral: Some(match element {
                Some(_) => power - PI * area * diffuse.mean(),
                None => power,
            })
            .filter(|&target| target > 0.0)
            .map(|target| {
                if element.is_some() {
                    target / area
                } else {
                    target
                }
            }),
        };
        let per_area = element.map(|_| 1.0 / area);
        let mut source = Children {
            hierarchy,
            exitant,
            children: lit,
            per_area,
        };
        let mut words = Vec::new();
        if projector
            .project(&mut source, &how, &mut words)
            .basis_functions
            > 0
        {
            peak += packed::peak(&words);
            distribution = Some(words.into_boxed_slice());
        }
    }
    Pulled {
        diffuse,
        distribution,
        peak,
        power,
        brightest,
        centre,
    }
}
