//! From the hierarchy to a mesh with directional light per vertex (§5.2 and design §4 "Export").

mod light;
mod lit;
mod mesh;
mod place;
mod pockets;
mod refine;

use crate::config::Settings;
use crate::hierarchy::Hierarchy;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::solution::{NO_DISTRIBUTION, Solution};
use crate::solve::{Arrived, Prepared, Transported, Watch};
use crate::transport::exitant::Exitant;
use glam::Vec3;
use light::Light;
use lit::Lit;
use mesh::{Mesh, Vertex};
use std::time::Instant;

/// Builds the solution. Leaves of the hierarchy are split further where the displayed light wants it.
pub(crate) fn export(
    scene: &Scene,
    prepared: &Prepared,
    settings: &Settings,
    transported: &mut Transported,
    watch: &mut Watch<'_>,
) -> Solution {
    let started = Instant::now();
    // What the elements show was found from them.
    transported.arrived = Arrived::default();
    let environment = prepared.environment();
    let mut hierarchy = std::mem::take(&mut transported.hierarchy);
    let gather = settings.gather && !watch.is_stopped();
    if !gather {
        transported.total.forget_clusters(&hierarchy);
    }
    let light = Light::new(prepared, settings, transported, &environment, &hierarchy);
    let known = hierarchy.elements.len();
    if gather {
        refine::split_large(prepared, settings, &light, &mut hierarchy);
    }
    refine::balance(&mut hierarchy);
    if gather {
        light.expose(&mut hierarchy, known);
    }
    let mut mesh = Mesh::default();
    mesh.add_corners(&hierarchy);
    let mut lit = Lit::default();
    if gather {
        let centres = refine::gather_and_split(
            &mut hierarchy,
            &mut mesh,
            &light,
            &mut lit,
            settings,
            &prepared.detail,
            watch,
        );
        if !watch.is_stopped() {
            // Centres come after all others, in both.
            debug_assert_eq!(lit.len(), mesh.vertices.len());
            for (element, irradiance) in light.known_centres(&hierarchy, &centres) {
                mesh.add_centre(&mut hierarchy, &element);
                lit.push(light.diffuse(&element, irradiance));
            }
        }
    }
    mesh.triangulate(&hierarchy);
    if gather && !watch.is_stopped() {
        light.gather_missing(&hierarchy, &mesh, &mut lit, watch, 0.95..1.0);
    }
    if lit.len() < mesh.vertices.len() {
        light.average(&hierarchy, &mesh, &mut lit);
    }
    let mut stats = transported.stats.clone();
    let cost = lit.cost();
    stats.solve.vertex_links += cost.links.links;
    stats.solve.rays += cost.links.rays;
    stats.solve.brdf_evaluations += cost.brdf_evaluations;
    stats.solve.basis_functions += cost.basis_functions;
    stats.solve.distributions += lit.distribution_count();
    stats.scene.triangles = scene.triangles().len() as u64;
    let shapes = prepared.bytes() + hierarchy.bytes() + mesh.bytes();
    // Those of the elements stand beside those of the vertices.
    let distributions = transported.total.bytes() + lit.bytes();
    let held = shapes + lit.bytes();
    transported.total = Exitant::default();
    let mut solution = assemble(scene, prepared, &hierarchy, mesh, lit);
    let _ = watch.report("export", 1.0, held);
    stats.solve.phases_s.export = started.elapsed().as_secs_f64();
    let bytes = &mut stats.solve.bytes;
    bytes.distributions = bytes.distributions.max(distributions as u64);
    bytes.hierarchy = bytes.hierarchy.max(shapes as u64);
    bytes.total = bytes.hierarchy + bytes.illumination_samples + bytes.distributions;
    solution.stats = stats;
    solution
}

fn assemble(
    scene: &Scene,
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    mesh: Mesh,
    lit: Lit,
) -> Solution {
    let frame = &prepared.frame;
    let (vertices, triangles, element_edges) = mesh.into_parts();
    let mut solution = Solution {
        materials: scene.materials().to_vec(),
        cameras: scene.cameras().to_vec(),
        glass_corners: prepared
            .glass
            .iter()
            .map(|t| t.map(|p| frame.position(p)))
            .collect(),
        glass_material: prepared.glass_material.clone(),
        triangles,
        element_edges,
        ..Solution::default()
    };
    let position = |vertex: &Vertex| frame.position(hierarchy.points[vertex.point as usize]);
    solution.position = vertices.iter().map(position).collect();
    solution.normal = vertices.iter().map(|v| v.normal).collect();
    solution.material = vertices.iter().map(|v| v.material).collect();
    (
        solution.radiance,
        solution.distribution_offset,
        solution.distribution_words,
    ) = lit.into_parts();
    for radiance in &mut solution.radiance {
        *radiance = frame.radiance(*radiance);
    }
    for &at in &solution.distribution_offset {
        if at != NO_DISTRIBUTION {
            // The first word of each is its scale.
            let word = &mut solution.distribution_words[at as usize];
            *word = (f32::from_bits(*word) * frame.radiance_unit()).to_bits();
        }
    }
    push_dark_sides(prepared, &mut solution);
    solution
}

/// Sides that light cannot reach are black, but they hide what is behind them.
fn push_dark_sides(prepared: &Prepared, solution: &mut Solution) {
    for ((patch, lit), covered) in prepared
        .patches
        .iter()
        .zip(&prepared.lit)
        .zip(&prepared.covered)
    {
        for back in [false, true] {
            if lit[usize::from(back)].lit || covered[usize::from(back)] {
                continue;
            }
            let mut corners: Vec<Vec3> = patch
                .corners(&prepared.frame.points)
                .into_iter()
                .map(|p| prepared.frame.position(p))
                .collect();
            if back {
                corners.reverse();
            }
            let normal = (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or(Vec3::Y);
            let first = solution.position.len() as u32;
            for &corner in &corners {
                solution.position.push(corner);
                solution.normal.push(normal);
                solution.radiance.push(Rgb::BLACK);
                solution.material.push(patch.material);
                solution.distribution_offset.push(NO_DISTRIBUTION);
            }
            solution.triangles.push([first, first + 1, first + 2]);
            if corners.len() == 4 {
                solution.triangles.push([first, first + 2, first + 3]);
                solution.element_edges.extend([0b011, 0b110]);
            } else {
                solution.element_edges.push(0b111);
            }
        }
    }
}
