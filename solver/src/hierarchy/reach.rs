//! Which sides of the patches light can reach at all.
//!
//! Surfaces reflect on both sides, but most backs are inside solid things or outside of a closed room. Light is
//! flooded along rays: a side is lit when it emits, when a ray from where another is lit meets it, or when a ray of its
//! own meets such a place. What is left is dark and needs no element. A floor that a box stands on is one patch: rays go
//! on from the points that others met, not from all of it, and so the inside of the box stays dark. Hoped, not proven:
//! an opening that a few dozen rays from either side all miss is taken for closed. Cost: a few dozen rays per side.

use super::contact::{Contacts, Meeting, Reach};
use super::patch::Patch;
use crate::geometry::hash;
use crate::geometry::sampling::{cosine_direction, sphere_direction};
use crate::radiometry::Rgb;
use crate::scene::Material;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Rays that a lit side sends, and that a dark one casts for itself.
const RAYS: u32 = 24;
/// Of these, rays from one point.
const POINT_RAYS: u32 = 4;
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
    /// Something touches it: light may not reach all of it.
    pub touched: bool,
}

/// For each patch its front and its back: can light reach it, does it emit, does something touch it? `usable`: the sides
/// that can be seen at all.
pub fn lit_sides(
    contacts: &Contacts<'_>,
    patches: &[Patch],
    materials: &[Material],
    point_lights: &[(Vec3, Rgb)],
    usable: &[[bool; 2]],
) -> Vec<[Side; 2]> {
    let side = |touched: bool| Side {
        touched,
        ..Side::default()
    };
    let touched = contacts.touched_sides();
    let mut flood = Flood {
        contacts,
        usable,
        sides: touched.into_iter().map(|sides| sides.map(side)).collect(),
        left: vec![[RAYS; 2]; patches.len()],
        sources: Vec::new(),
    };
    for (patch, index) in patches.iter().zip(0..) {
        let m = &materials[patch.material as usize];
        if m.emission.is_black() {
            continue;
        }
        for back in [false, true] {
            // The inside of a lamp sees itself, and what holds the lamp: a rod, a wire.
            let sees_out = || {
                let inside = |met: &Meeting| {
                    met.back && patches[met.patch as usize].material == patch.material
                };
                let seen = contacts.seen_from_side(index, true, RAYS);
                let count = seen.iter().filter(|(_, met)| inside(met)).count();
                (count as f32) < INSIDE_SHARE * RAYS as f32
            };
            let may_emit =
                usable[index as usize][usize::from(back)] && (!back || m.emits_from_back);
            if may_emit && (!back || sees_out()) {
                let side = &mut flood.sides[index as usize][usize::from(back)];
                (side.lit, side.emits) = (true, true);
                flood.sources.push(Source::Lamp(index, back));
            }
        }
    }
    flood
        .sources
        .extend(point_lights.iter().map(|light| Source::Point(light.0)));
    loop {
        flood.spread();
        if !flood.reach_back() {
            return flood.sides;
        }
    }
}

/// Where light comes from that has not been followed yet.
#[derive(Clone, Copy)]
enum Source {
    /// All of the side of a patch.
    Lamp(u32, bool),
    /// A point light.
    Point(Vec3),
    /// This many rays from a place on a surface.
    Place(Meeting, u32),
}

struct Flood<'a> {
    contacts: &'a Contacts<'a>,
    usable: &'a [[bool; 2]],
    sides: Vec<[Side; 2]>,
    /// Rays that sides may still send.
    left: Vec<[u32; 2]>,
    sources: Vec<Source>,
}

impl Flood<'_> {
    /// Follows the light of the sources, and of what they meet.
    fn spread(&mut self) {
        while !self.sources.is_empty() {
            let sources = std::mem::take(&mut self.sources);
            let found: Vec<Vec<Meeting>> = sources
                .par_iter()
                .map(|&source| self.contacts.seen_from(source))
                .collect();
            for met in found.into_iter().flatten() {
                self.light(met);
            }
        }
    }

    /// Light reaches a place.
    fn light(&mut self, at: Meeting) {
        let (patch, side) = (at.patch as usize, usize::from(at.back));
        if !self.usable[patch][side] {
            return;
        }
        self.sides[patch][side].lit = true;
        let rays = self.left[patch][side].min(POINT_RAYS);
        if rays > 0 {
            self.left[patch][side] -= rays;
            self.sources.push(Source::Place(at, rays));
        }
    }

    /// Nobody's ray meets the rest: do theirs meet anything lit? False when none does.
    fn reach_back(&mut self) -> bool {
        let sides = (0..self.sides.len() as u32).flat_map(|patch| [(patch, false), (patch, true)]);
        let is_dark = |&(patch, back): &(u32, bool)| {
            let (patch, side) = (patch as usize, usize::from(back));
            self.usable[patch][side] && !self.sides[patch][side].lit
        };
        let dark: Vec<(u32, bool)> = sides.filter(is_dark).collect();
        let reach = Reach {
            contacts: *self.contacts,
            sides: &self.sides,
        };
        let reached: Vec<Meeting> = dark
            .par_iter()
            .filter_map(|&(patch, back)| {
                let seen = self.contacts.seen_from_side(patch, back, RAYS);
                let lit = seen.iter().zip(0..).find(|((_, met), ray)| {
                    reach.is_lit_at(*met, hash::mix(2 * patch + u32::from(back), *ray))
                });
                lit.map(|((from, _), _)| Meeting {
                    point: *from,
                    patch,
                    back,
                })
            })
            .collect();
        let is_any = !reached.is_empty();
        for place in reached {
            self.light(place);
        }
        is_any
    }
}

impl Contacts<'_> {
    /// What rays from random places on a side of a patch meet, and where they start.
    fn seen_from_side(&self, patch: u32, back: bool, rays: u32) -> Vec<(Vec3, Meeting)> {
        let (shape, normal) = (&self.shapes[patch as usize], self.normal(patch, back));
        let seed = patch.wrapping_mul(2) + u32::from(back);
        let meeting = |ray: u32| {
            let unit = |salt: u32| hash::unit(seed, ray.wrapping_mul(4) + salt);
            let from = shape.point(Vec2::new(0.02 + 0.96 * unit(0), 0.02 + 0.96 * unit(1)));
            let direction = cosine_direction(normal, Vec2::new(unit(2), unit(3)));
            Some((from, self.meeting(from, direction, patch)?))
        };
        (0..rays).filter_map(meeting).collect()
    }

    /// What rays from a source meet.
    fn seen_from(&self, source: Source) -> Vec<Meeting> {
        match source {
            Source::Lamp(patch, back) => {
                let seen = self.seen_from_side(patch, back, LAMP_RAYS);
                seen.into_iter().map(|(_, met)| met).collect()
            }
            Source::Point(from) => {
                let meeting = |ray: u32| {
                    let at = Vec2::new(hash::unit(ray, 2), hash::unit(ray, 1));
                    self.meeting(from, sphere_direction(at), super::NONE)
                };
                (0..LAMP_RAYS * 8).filter_map(meeting).collect()
            }
            Source::Place(at, rays) => {
                let normal = self.normal(at.patch, at.back);
                let seed = at.point.to_array().map(f32::to_bits);
                let seed = hash::mix(hash::mix(seed[0], seed[1]), seed[2]);
                let meeting = |ray: u32| {
                    let unit = |salt: u32| hash::unit(seed, ray.wrapping_mul(2) + salt);
                    let direction = cosine_direction(normal, Vec2::new(unit(0), unit(1)));
                    self.meeting(at.point, direction, at.patch)
                };
                (0..rays).filter_map(meeting).collect()
            }
        }
    }
}
