//! Pockets: the insides of solid things that are not quite closed, where little light gets and nobody looks.
//!
//! Their surfaces see each other and, past small gaps, little of what lights the scene; to find out how little costs
//! more links than a surface in the open. They show the light that the transport found there (§5.2).

use super::mesh::leaves;
use crate::geometry::sampling::{cosine_direction, spread};
use crate::hierarchy::{Hierarchy, NONE};
use crate::radiometry::Rgb;
use crate::solve::Prepared;
use rayon::prelude::*;

/// No part of a pocket receives more than this many times what it may receive on average.
const UNEVEN: f32 = 2.0;

/// What a side of a pocket sees is nearer than this; scene size 1.
const NEAR: f32 = 1.0 / 16.0;

/// Rays from the middle of each side.
const RAYS: u32 = 64;

/// Of these, so many may go further.
const FAR: usize = 4;

/// For each patch its front and its back: is it dark, and does it see only what is near? Dark is what receives no more
/// than `dark` [W·m⁻², mean over channels] on average. `irradiance`: per node, of leaves.
pub(super) fn pockets(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    irradiance: &[Rgb],
    dark: f32,
) -> Vec<[bool; 2]> {
    #[derive(Clone, Copy, Default)]
    struct Received {
        power: f64,
        area: f64,
        most: f32,
    }
    let mut received = vec![[Received::default(); 2]; prepared.patches.len()];
    for element in leaves(hierarchy) {
        let here = irradiance[element.node as usize].mean();
        let area = f64::from(hierarchy.node(element.node).area);
        let side = &mut received[element.patch as usize][usize::from(element.back)];
        side.power += f64::from(here) * area;
        side.area += area;
        side.most = side.most.max(here);
    }
    let is_dark =
        |side: &Received| side.power <= f64::from(dark) * side.area && side.most <= UNEVEN * dark;
    received
        .par_iter()
        .enumerate()
        .with_max_len(64)
        .map(|(patch, sides)| {
            [false, true].map(|back| {
                is_dark(&sides[usize::from(back)])
                    && is_enclosed(prepared, hierarchy, patch as u32, back)
            })
        })
        .collect()
}

/// True when nearly all that a side of a patch sees is near.
fn is_enclosed(prepared: &Prepared, hierarchy: &Hierarchy, patch: u32, back: bool) -> bool {
    let whole = hierarchy.whole(patch, back);
    if whole == NONE {
        return false;
    }
    let Some(element) = hierarchy.element_of(whole) else {
        return false;
    };
    let from = hierarchy.node(element.node).centre;
    let goes_far = |ray: &u32| {
        let direction = cosine_direction(element.normal, spread(*ray));
        let hit = prepared.occluders.nearest_hit(from, direction, patch);
        hit.is_none_or(|hit| hit.distance >= NEAR)
    };
    (0..RAYS).filter(goes_far).nth(FAR).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Quality, Settings};
    use crate::scene::{Material, Scene, SceneParts, Triangle};
    use glam::Vec3;

    /// Adds the walls of a box, fronts inwards, the first `walls` of them.
    fn add_box(parts: &mut SceneParts, centre: Vec3, edge: f32, walls: usize, material: u32) {
        const WALLS: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [4, 5, 7, 6],
        ];
        let corner =
            |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32) - 0.5;
        for wall in &WALLS[..walls] {
            let corners = wall.map(|i| centre + corner(i) * edge);
            let middle = (corners[0] + corners[2]) * 0.5;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let mut order = [0, 1, 2, 3];
            if normal.dot(centre - middle) < 0.0 {
                order.reverse();
            }
            let first = parts.points.len() as u32;
            parts.points.extend(order.map(|i: usize| corners[i]));
            for points in [[0, 1, 2], [0, 2, 3]] {
                parts.triangles.push(Triangle {
                    points: points.map(|i| first + i),
                    normals: None,
                    material,
                });
            }
        }
    }

    #[test]
    fn the_dark_inside_of_a_small_box_is_a_pocket() {
        let grey = crate::Rgb::splat(0.5);
        let both = Material {
            two_sided: true,
            ..Material::lambert("both", grey)
        };
        let mut parts = SceneParts {
            materials: vec![Material::lambert("room", grey), both],
            ..SceneParts::default()
        };
        add_box(&mut parts, Vec3::ZERO, 1.0, 6, 0);
        parts.materials[0].emission = grey;
        // One closed but for its lid, which is a little off; one open.
        add_box(&mut parts, Vec3::new(0.2, 0.0, 0.0), 0.04, 5, 1);
        let lid = parts.triangles.len();
        add_box(&mut parts, Vec3::new(0.2, 0.0, 0.001), 0.04, 6, 1);
        parts.triangles.drain(lid..lid + 10);
        add_box(&mut parts, Vec3::new(-0.2, 0.0, 0.0), 0.04, 5, 1);
        let (scene, _) = Scene::new(parts, false).expect("a scene");
        let prepared = Prepared::new(&scene, &Settings::of(Quality::DEFAULT));
        let hierarchy = Hierarchy::new(
            prepared.frame.points.clone(),
            prepared.patches.clone(),
            &prepared.frame.materials,
            &[[crate::hierarchy::reach::Side {
                touched: false,
                lit: true,
                emits: false,
            }; 2]]
            .repeat(prepared.patches.len()),
        );
        // Patches in the order of the walls.
        let found = |light: f32| {
            let irradiance = vec![crate::Rgb::splat(light); hierarchy.nodes.len()];
            pockets(&prepared, &hierarchy, &irradiance, 0.1)
        };
        let dark = found(0.05);
        assert_eq!(dark.len(), 6 + 6 + 5);
        for (patch, sides) in dark.iter().enumerate() {
            // Fronts of the closed box; its backs see the room, so does the open one from inside, through its top.
            let expected = [(6..12).contains(&patch), false];
            assert_eq!(*sides, expected, "patch {patch}");
        }
        assert!(found(0.15).iter().flatten().all(|&pocket| !pocket));
    }
}
