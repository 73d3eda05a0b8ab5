//! Splitting of leaves for display: large ones, unbalanced ones, and those whose light is not what their corners
//! predict: error control after the fact, where the eye will look.

use super::light::Light;
use super::lit::Lit;
use super::mesh::{Mesh, leaves};
use crate::config::Settings;
use crate::hierarchy::detail::Detail;
use crate::hierarchy::{Element, Hierarchy, Node};
use crate::radiometry::Rgb;
use crate::solve::{Prepared, Watch};
use crate::transport::propagate::Gloss;
use rayon::prelude::*;

/// Splits leaves above the largest size; glossy ones until they are small against their lobe, and flat against it.
/// Pockets stay as they are.
pub(super) fn split_large(
    prepared: &Prepared,
    settings: &Settings,
    light: &Light<'_>,
    hierarchy: &mut Hierarchy,
) {
    // What a lobe mirrors changes over a surface with the distance to that. Samples of a picture ask the corners for what
    // they mirror themselves, so only near things want more corners: half the scene away, a half-width covers this.
    const DISTANCE: f32 = 0.5;
    // Shading normals may turn by so many half-widths between corners.
    const TURN: f32 = 2.0;
    let mut next = 0;
    // Children are appended, so the loop meets them too.
    while next < hierarchy.elements.len() {
        let element = hierarchy.elements[next];
        next += 1;
        if !hierarchy.is_leaf(element.node) || light.is_in_pocket(&element) {
            continue;
        }
        let edge = hierarchy.node(element.node).radius * std::f32::consts::SQRT_2;
        let lobe = prepared.lobes[element.material as usize].as_ref();
        let gloss = Gloss::of(lobe, prepared.diffuse[element.material as usize]);
        let most = if gloss.share > 0.0 {
            // A faint lobe over a bright surface may be coarser.
            let size = gloss.width * DISTANCE / gloss.share.sqrt();
            settings.max_edge.min(size.max(settings.min_edge * 2.0))
        } else {
            settings.max_edge
        };
        // On curved surfaces a lobe also moves as far as mirror directions turn; again, a faint one may do so further.
        let turns = hierarchy.bend(&element) * gloss.share.sqrt() > TURN * gloss.width;
        if edge > most || (turns && edge > settings.min_edge) {
            hierarchy.subdivide(element.node);
        }
    }
}

/// Splits leaves until no edge has more than one hanging point (2:1 balance).
pub(super) fn balance(hierarchy: &mut Hierarchy) {
    let mut changed = true;
    while changed {
        changed = false;
        for index in 0..hierarchy.elements.len() {
            let element = hierarchy.elements[index];
            if hierarchy.is_leaf(element.node) && has_deep_edge(hierarchy, &element) {
                hierarchy.subdivide(element.node);
                changed = true;
            }
        }
    }
}

fn has_deep_edge(hierarchy: &Hierarchy, element: &Element) -> bool {
    let count = element.corner_count();
    (0..count).any(|i| {
        let (a, b) = (element.points[i], element.points[(i + 1) % count]);
        hierarchy.midpoint(a, b).is_some_and(|m| {
            hierarchy.midpoint(a, m).is_some() || hierarchy.midpoint(m, b).is_some()
        })
    })
}

/// Gathers at all vertices, splits leaves whose centre is mispredicted, and so on down to the smallest size: unless
/// stopped, every vertex of `mesh` is in `lit` then. Returns the irradiance in the middle of nodes, where it was looked
/// at.
pub(super) fn gather_and_split(
    hierarchy: &mut Hierarchy,
    mesh: &mut Mesh,
    light: &Light<'_>,
    lit: &mut Lit,
    settings: &Settings,
    detail: &Detail,
    watch: &mut Watch<'_>,
) -> Vec<Option<Rgb>> {
    let is_large = |node: &Node| {
        node.radius * std::f32::consts::SQRT_2 > settings.min_edge * detail.at(node.centre)
    };
    let mut tested = vec![false; hierarchy.nodes.len()];
    let mut centres: Vec<Option<Rgb>> = vec![None; hierarchy.nodes.len()];
    // Every pass but the last splits large leaves, so passes end; balancing splits others, which the next one looks at.
    let mut pass = 0;
    loop {
        let done = |pass: i32| 0.5 + 0.45 * (1.0 - 0.6f32.powi(pass));
        light.gather_missing(hierarchy, mesh, lit, watch, done(pass)..done(pass + 1));
        if watch.is_stopped() {
            return centres;
        }
        let candidates: Vec<Element> = leaves(hierarchy)
            .filter(|e| {
                !tested.get(e.node as usize).copied().unwrap_or(false)
                    && is_large(hierarchy.node(e.node))
                    && !light.is_in_pocket(e)
            })
            .copied()
            .collect();
        let (shared, lit) = (&*hierarchy, &*lit);
        let looked: Vec<(bool, Option<Rgb>)> = candidates
            .par_iter()
            .with_max_len(32)
            .map(|element| {
                let corners: Vec<Rgb> = mesh
                    .corners(shared, element)
                    .map(|v| lit.irradiance(v))
                    .collect();
                let sum = corners.iter().fold(Rgb::BLACK, |sum, &corner| sum + corner);
                let mean = sum / corners.len() as f32;
                let spread = corners
                    .iter()
                    .fold(0.0f32, |m, &corner| m.max((corner - mean).mean().abs()));
                let visible = light.visible_difference(element.material);
                // Flat and dark surroundings need no look at their centre once they are fairly small.
                if mean.mean() + spread < visible {
                    return (false, None);
                }
                let centre = light.irradiance_at_centre(shared, element);
                let difference = (centre - mean).max(mean - centre).max_channel();
                let most = settings.mesh_tolerance * (centre.mean().max(mean.mean()) + visible);
                (difference > most, Some(centre))
            })
            .collect();
        tested.resize(hierarchy.nodes.len(), false);
        centres.resize(hierarchy.nodes.len(), None);
        let known = hierarchy.elements.len();
        let mut any = false;
        for (element, (split, centre)) in candidates.iter().zip(looked) {
            tested[element.node as usize] = true;
            centres[element.node as usize] = centre;
            if split && hierarchy.is_leaf(element.node) {
                hierarchy.subdivide(element.node);
                any = true;
            }
        }
        if !any {
            return centres;
        }
        balance(hierarchy);
        light.expose(hierarchy, known);
        mesh.add_corners(hierarchy);
        pass += 1;
    }
}
