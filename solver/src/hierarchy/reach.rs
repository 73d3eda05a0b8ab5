//! Which sides of the patches light can reach at all.
//!
//! Surfaces reflect on both sides, but most backs are inside solid things or outside of a closed room. Light is
//! flooded along rays: a side is lit when it emits, when a lit side's ray meets it, or when a ray of its own meets a
//! lit side. What is left is dark and needs no element. Hoped, not proven: an opening that a few dozen rays from
//! either side all miss is taken for closed. Cost: a few dozen rays per side.

use super::patch::Patch;
use crate::geometry::sampling::cosine_direction;
use crate::geometry::{Polygon, hash};
use crate::radiometry::Rgb;
use crate::scene::Material;
use crate::transport::visibility::Occluders;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Rays that a newly lit side sends, and that a dark one casts for itself.
const RAYS: u32 = 24;
/// A lamp's back is its inside when this share of its rays ends on the lamp's own back: it does not emit.
const INSIDE_SHARE: f32 = 0.75;
/// Rays from each point light and each emitter.
const LAMP_RAYS: u32 = 512;

/// What light does with the two sides, front and back, of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Side {
    /// Light can reach it.
    pub lit: bool,
    /// It emits, and not into the inside of its own lamp.
    pub emits: bool,
}

/// For each patch its front and its back: can light reach it, does it emit? `usable`: the sides that can be seen at all.
pub fn lit_sides(
    points: &[Vec3],
    patches: &[Patch],
    materials: &[Material],
    point_lights: &[(Vec3, Rgb)],
    occluders: &Occluders,
    usable: &[[bool; 2]],
) -> Vec<[Side; 2]> {
    let sides = Sides {
        points,
        patches,
        occluders,
    };
    let mut lit = vec![[Side::default(); 2]; patches.len()];
    let mut fresh: Vec<(u32, bool, u32)> = Vec::new();
    for (index, patch) in patches.iter().enumerate() {
        let m = &materials[patch.material as usize];
        if !m.emission.is_black() {
            for back in [false, true] {
                // The inside of a lamp sees itself, and what holds the lamp: a rod, a wire.
                let sees_out = || {
                    let seen = sides.seen_from(index as u32, true, RAYS);
                    let inside = |(p, b): &&(u32, bool)| {
                        *b && patches[*p as usize].material == patch.material
                    };
                    (seen.iter().filter(inside).count() as f32) < INSIDE_SHARE * RAYS as f32
                };
                let may_emit = usable[index][usize::from(back)] && (!back || m.emits_from_back);
                if may_emit && (!back || sees_out()) {
                    lit[index][usize::from(back)] = Side {
                        lit: true,
                        emits: true,
                    };
                    fresh.push((index as u32, back, LAMP_RAYS));
                }
            }
        }
    }
    let mut hits: Vec<(u32, bool)> = Vec::new();
    for &(position, _) in point_lights {
        for ray in 0..LAMP_RAYS * 8 {
            let z = 2.0 * hash::unit(ray, 1) - 1.0;
            let (s, phi) = ((1.0 - z * z).sqrt(), TAU * hash::unit(ray, 2));
            let direction = Vec3::new(s * phi.cos(), s * phi.sin(), z);
            let hit = occluders.first_hit(position, direction, super::NONE);
            hits.extend(hit.map(|hit| (hit.patch, hit.back)));
        }
    }
    loop {
        let found: Vec<Vec<(u32, bool)>> = fresh
            .par_iter()
            .map(|&(patch, back, rays)| sides.seen_from(patch, back, rays))
            .collect();
        hits.extend(found.into_iter().flatten());
        fresh.clear();
        for (patch, back) in hits.drain(..) {
            let side = usize::from(back);
            if usable[patch as usize][side] && !lit[patch as usize][side].lit {
                lit[patch as usize][side].lit = true;
                fresh.push((patch, back, RAYS));
            }
        }
        if !fresh.is_empty() {
            continue;
        }
        // Nobody's ray meets the rest: do theirs meet anything lit?
        let dark: Vec<(u32, bool)> = (0..patches.len() as u32)
            .flat_map(|patch| [(patch, false), (patch, true)])
            .filter(|&(p, back)| {
                usable[p as usize][usize::from(back)] && !lit[p as usize][usize::from(back)].lit
            })
            .collect();
        let shared = &lit;
        let reached: Vec<(u32, bool)> = dark
            .par_iter()
            .copied()
            .filter(|&(patch, back)| {
                sides
                    .seen_from(patch, back, RAYS)
                    .iter()
                    .any(|&(p, b)| shared[p as usize][usize::from(b)].lit)
            })
            .collect();
        if reached.is_empty() {
            return lit;
        }
        hits = reached;
    }
}

struct Sides<'a> {
    points: &'a [Vec3],
    patches: &'a [Patch],
    occluders: &'a Occluders,
}

impl Sides<'_> {
    /// The sides that `rays` cosine-distributed rays from a side of a patch meet.
    fn seen_from(&self, patch: u32, back: bool, rays: u32) -> Vec<(u32, bool)> {
        let polygon = Polygon::new(&self.patches[patch as usize].corners(self.points));
        let normal = polygon.vector_area().normalize_or_zero() * if back { -1.0 } else { 1.0 };
        (0..rays)
            .filter_map(|ray| {
                let u = |salt: u32| {
                    hash::unit(
                        patch.wrapping_mul(2) + u32::from(back),
                        ray.wrapping_mul(4) + salt,
                    )
                };
                let from = polygon.point(Vec2::new(0.02 + 0.96 * u(0), 0.02 + 0.96 * u(1)));
                let direction = cosine_direction(normal, Vec2::new(u(2), u(3)));
                let hit = self.occluders.first_hit(from, direction, patch)?;
                Some((hit.patch, hit.back))
            })
            .collect()
    }
}
