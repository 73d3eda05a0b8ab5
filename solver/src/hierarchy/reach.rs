//! Which sides of the patches light can reach at all.
//!
//! Surfaces reflect on both sides, but most backs are inside solid things or outside of a closed room. Light is
//! flooded along rays: a side is lit when it emits, when a ray from where another is lit meets it, or when a ray of its
//! own, random or aimed at lamps and lit sides, meets such a place. What is left is dark and needs no element. A floor
//! that a box stands on is one patch: rays go on from the points that others met, not from all of it, and so the inside
//! of the box stays dark. Hoped, not proven: an opening that a few dozen rays from either side all miss is taken for
//! closed. Cost: a few dozen rays per side and round.

use super::contact::{Contacts, Meeting, Reach};
use super::patch::Patch;
use super::targets::{Lamps, Targets};
use crate::geometry::Polygon;
use crate::geometry::hash;
use crate::geometry::sampling::{cosine_direction, sphere_direction};
use crate::radiometry::Rgb;
use crate::scene::Material;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Rays that a lit side sends, and that a dark one casts for itself.
const RAYS: u32 = 24;
/// Of these, rays from one point.
const POINT_RAYS: u32 = 4;
/// A lamp's back is its inside when this share of its rays ends on the lamp's own back: it does not emit.
const INSIDE_SHARE: f32 = 0.75;
/// Rays that a dark side aims at lamps, and as many at lit sides.
const AIMED_RAYS: u32 = 12;
/// Sides or places that are looked at between two reports.
const BATCH: usize = 1 << 15;
/// Light that comes along more lit sides than this may go around inside of what is closed.
const STEPS: u32 = 5;
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
/// that can be seen at all. `report` is called now and then; when it says stop, what is not known to be lit yet is dark.
pub fn lit_sides(
    contacts: &Contacts<'_>,
    patches: &[Patch],
    materials: &[Material],
    point_lights: &[(Vec3, Rgb)],
    usable: &[[bool; 2]],
    report: &mut dyn FnMut() -> ControlFlow<()>,
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
        lamps: Lamps::new(Vec::new(), Vec::new()),
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
    flood.lamps = lamps(contacts.shapes, &flood.sides, point_lights);
    flood
        .sources
        .extend(point_lights.iter().map(|light| Source::Point(light.0)));
    loop {
        let spread = flood.spread(report);
        if spread.is_break() || !flood.reach_back(report) {
            return flood.sides;
        }
    }
}

/// Where light comes from: sides of patches with `shapes`, and points.
pub fn lamps(shapes: &[Polygon], sides: &[[Side; 2]], point_lights: &[(Vec3, Rgb)]) -> Lamps {
    let emitting = |(shape, sides): (&Polygon, &[Side; 2])| {
        let is_lamp = |&back: &bool| sides[usize::from(back)].emits;
        let both = [false, true].into_iter().filter(is_lamp);
        both.map(|back| (*shape, back)).collect::<Vec<_>>()
    };
    let surfaces = shapes.iter().zip(sides).flat_map(emitting).collect();
    Lamps::new(surfaces, point_lights.iter().map(|light| light.0).collect())
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
    lamps: Lamps,
}

impl Flood<'_> {
    /// Follows the light of the sources, and of what they meet.
    fn spread(&mut self, report: &mut dyn FnMut() -> ControlFlow<()>) -> ControlFlow<()> {
        while !self.sources.is_empty() {
            let sources = std::mem::take(&mut self.sources);
            for batch in sources.chunks(BATCH) {
                let found: Vec<Vec<Meeting>> = batch
                    .par_iter()
                    .map(|&source| self.contacts.seen_from(source))
                    .collect();
                for met in found.into_iter().flatten() {
                    self.light(met);
                }
                report()?;
            }
        }
        ControlFlow::Continue(())
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

    /// Nobody's ray meets the rest: do theirs meet anything lit? False when none does, or `report` says stop.
    fn reach_back(&mut self, report: &mut dyn FnMut() -> ControlFlow<()>) -> bool {
        let sides = (0..self.sides.len() as u32).flat_map(|patch| [(patch, false), (patch, true)]);
        let is_dark = |&(patch, back): &(u32, bool)| {
            let (patch, side) = (patch as usize, usize::from(back));
            self.usable[patch][side] && !self.sides[patch][side].lit
        };
        let dark: Vec<(u32, bool)> = sides.clone().filter(is_dark).collect();
        let is_lit =
            |&(patch, back): &(u32, bool)| self.sides[patch as usize][usize::from(back)].lit;
        let shape = |(patch, back): (u32, bool)| (self.contacts.shapes[patch as usize], back);
        let targets = Targets::new(sides.filter(is_lit).map(shape).collect());
        let mut reached: Vec<Meeting> = Vec::new();
        for batch in dark.chunks(BATCH) {
            let of_side = |&(patch, back): &(u32, bool)| {
                let point = self
                    .sees_light_by_chance(patch, back)
                    .or_else(|| self.sees_light_aimed(&targets, patch, back))?;
                Some(Meeting { point, patch, back })
            };
            reached.par_extend(batch.par_iter().filter_map(of_side));
            if report().is_break() {
                return false;
            }
        }
        let is_any = !reached.is_empty();
        for place in reached {
            self.light(place);
        }
        is_any
    }

    /// What is known about light until now.
    fn reach(&self) -> Reach<'_> {
        Reach {
            contacts: *self.contacts,
            sides: &self.sides,
            lamps: &self.lamps,
        }
    }

    /// True when light is known to reach a point.
    fn is_lit_at(&self, at: Meeting, seed: u32) -> bool {
        self.reach().is_lit_at(at, seed, STEPS) == Some(true)
    }

    /// A place on a side of a patch from which a random ray meets light.
    fn sees_light_by_chance(&self, patch: u32, back: bool) -> Option<Vec3> {
        let seen = self.contacts.seen_from_side(patch, back, RAYS);
        let mut lit = seen.into_iter().zip(0..);
        let lit = lit.find(|&((_, met), ray)| self.is_lit_at(met, seed_of(patch, back, ray)));
        lit.map(|((from, _), _)| from)
    }

    /// A place on a side of a patch from which a ray that is aimed at a lamp or one of `targets` meets light.
    fn sees_light_aimed(&self, targets: &Targets, patch: u32, back: bool) -> Option<Vec3> {
        let reach = self.reach();
        let normal = self.contacts.normal(patch, back);
        (RAYS..RAYS + AIMED_RAYS).find_map(|ray| {
            let from = self.contacts.place_on_side(patch, back, ray);
            let seed = seed_of(patch, back, RAYS);
            let sees_target = || {
                let direction = targets.aim(from, normal, seed, ray)?;
                let met = self.contacts.meeting(from, direction, patch)?;
                self.is_lit_at(met, seed_of(patch, back, ray)).then_some(())
            };
            let is_lit = reach.sees_lamp(from, normal, patch, seed, ray) || sees_target().is_some();
            is_lit.then_some(from)
        })
    }
}

/// Of the random numbers of a side and a ray.
fn seed_of(patch: u32, back: bool, ray: u32) -> u32 {
    hash::mix(2 * patch + u32::from(back), ray)
}

impl Contacts<'_> {
    /// The random place on a side of a patch where its ray with this number starts.
    fn place_on_side(&self, patch: u32, back: bool, ray: u32) -> Vec3 {
        let seed = patch.wrapping_mul(2) + u32::from(back);
        let inset = |salt: u32| 0.02 + 0.96 * hash::unit(seed, ray.wrapping_mul(4) + salt);
        self.shapes[patch as usize].point(Vec2::new(inset(0), inset(1)))
    }

    /// What rays from random places on a side of a patch meet, and where they start.
    fn seen_from_side(&self, patch: u32, back: bool, rays: u32) -> Vec<(Vec3, Meeting)> {
        let normal = self.normal(patch, back);
        let seed = patch.wrapping_mul(2) + u32::from(back);
        let meeting = |ray: u32| {
            let unit = |salt: u32| hash::unit(seed, ray.wrapping_mul(4) + salt);
            let from = self.place_on_side(patch, back, ray);
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
                let seed = hash::of_point(at.point);
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
