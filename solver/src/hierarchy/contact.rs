//! Where surfaces touch: a floor is dark below a box that stands on it, bright beside it, and one patch.
//!
//! Where nothing touches an element, either light can reach all of it or none. Where something does, points are asked:
//! those whose rays all end on sides that light cannot reach are dark. Hoped, not proven, as in [`super::reach`].
//! Cost: a search for what touches an element, up to 16 rays for each of 64 points where something does.

use super::exposed::Exposed;
use super::reach::Side;
use super::targets::Lamps;
use super::{Element, Hierarchy, NodeId};
use crate::geometry::sampling::{cosine_direction, spread};
use crate::geometry::{Polygon, hash};
use crate::transport::link::COPLANAR;
use crate::transport::region::{PatchTree, Region};
use crate::transport::visibility::Occluders;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Rays that decide whether a point is dark.
const RAYS: u32 = 16;
/// Tells the numbers that choose lamps from those that choose directions.
const LAMPS: u32 = 0x006c_616d;
/// Light that comes along this many lit sides came from outside of what is closed.
const STEPS: u32 = 12;

/// Where patches are found, and which of their sides can be seen at all.
#[derive(Clone, Copy)]
pub struct Contacts<'a> {
    /// All patches.
    pub tree: &'a PatchTree,
    /// Shape of each.
    pub shapes: &'a [Polygon],
    /// All surfaces.
    pub occluders: &'a Occluders,
    /// Which sides, front and back, reflect or emit.
    pub usable: &'a [[bool; 2]],
}

/// A point that a ray met.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The point.
    pub point: Vec3,
    /// On this patch.
    pub patch: u32,
    /// On its back.
    pub back: bool,
}

impl Contacts<'_> {
    /// Which sides, front and back, of each patch something touches.
    pub fn touched_sides(&self) -> Vec<[bool; 2]> {
        let sides = |patch: usize| {
            let shape = &self.shapes[patch];
            let normal = shape.vector_area().normalize_or_zero();
            [normal, -normal].map(|normal| self.is_touched(shape, normal, patch as u32))
        };
        (0..self.shapes.len()).into_par_iter().map(sides).collect()
    }

    /// True when something touches the inside of a shape that is part of `patch`, on the side of `normal`.
    pub fn is_touched(&self, shape: &Polygon, normal: Vec3, patch: u32) -> bool {
        let region = around(shape);
        let is_apart =
            |other: u32| other == patch || !touches(&self.shapes[other as usize], shape, normal);
        !self.tree.visit_patches(&region, is_apart)
    }

    /// Surfaces in the plane of an element that are seen instead of it where they lie.
    fn covering(&self, element: &Element) -> Vec<&Polygon> {
        let (origin, normal) = (element.polygon.centre(), element.normal);
        let is_in_plane = |corner: &Vec3| (corner - origin).dot(normal).abs() <= COPLANAR;
        let first = |patch: u32, side: usize| (!self.usable[patch as usize][side], patch);
        let own = first(element.patch, usize::from(element.back));
        let mut found = Vec::new();
        self.tree.visit_patches(&around(&element.polygon), |other| {
            let shape = &self.shapes[other as usize];
            if other != element.patch && shape.corners().iter().all(is_in_plane) {
                let facing = usize::from(shape.vector_area().dot(normal) < 0.0);
                if first(other, facing) < own {
                    found.push(shape);
                }
            }
            true
        });
        found
    }

    /// What a ray from a point of `patch` meets.
    pub fn meeting(&self, from: Vec3, direction: Vec3, patch: u32) -> Option<Meeting> {
        let hit = self.occluders.nearest_hit(from, direction, patch)?;
        Some(Meeting {
            point: from + direction * hit.distance,
            patch: hit.patch,
            back: hit.back,
        })
    }

    /// Normal of the side of a patch.
    pub fn normal(&self, patch: u32, back: bool) -> Vec3 {
        let normal = self.shapes[patch as usize]
            .vector_area()
            .normalize_or_zero();
        if back { -normal } else { normal }
    }
}

/// Where light can reach.
#[derive(Clone, Copy)]
pub struct Reach<'a> {
    /// The patches.
    pub contacts: Contacts<'a>,
    /// What light does with the sides of each, front and back.
    pub sides: &'a [[Side; 2]],
    /// Where light comes from.
    pub lamps: &'a Lamps,
}

impl Reach<'_> {
    /// Whether light can reach a point: where nothing touches a side, it is known. Where something does, it is what a
    /// walk from one lit side to the next finds, or the lamp that is seen where that leaves the scene. `None` when the
    /// walk takes more than so many `steps`.
    pub fn is_lit_at(&self, at: Meeting, seed: u32, steps: u32) -> Option<bool> {
        let mut at = at;
        for step in 0..steps {
            let side = self.sides[at.patch as usize][usize::from(at.back)];
            if !side.lit || !side.touched {
                return Some(side.lit);
            }
            let normal = self.contacts.normal(at.patch, at.back);
            let unit = |salt: u32| hash::unit(seed, 2 * step + salt);
            let direction = cosine_direction(normal, Vec2::new(unit(0), unit(1)));
            match self.contacts.meeting(at.point, direction, at.patch) {
                Some(next) => at = next,
                // Out of the scene, where there may be nothing to light it but a lamp.
                None => return Some(self.sees_lamp(at.point, normal, at.patch, seed, step)),
            }
        }
        None
    }

    /// True when nothing stands between a point of a patch and a lamp; `seed` and `ray` choose which.
    pub fn sees_lamp(&self, from: Vec3, normal: Vec3, patch: u32, seed: u32, ray: u32) -> bool {
        let seed = hash::mix(seed, LAMPS);
        let Some(aim) = self.lamps.aim(from, normal, seed, ray) else {
            return false;
        };
        let met = self.contacts.meeting(from, aim.direction, patch);
        match aim.distance {
            Some(distance) => met.is_none_or(|met| met.point.distance(from) >= distance),
            None => {
                met.is_some_and(|met| self.sides[met.patch as usize][usize::from(met.back)].emits)
            }
        }
    }

    /// True when light can reach a point of an element: a ray of it leaves the scene or gets to where light is. Where no
    /// walk ends, it is in a room with things on all of its walls; where many end in the dark and none in the light, it
    /// is in the dark.
    fn is_exposed(&self, point: Vec3, element: &Element) -> bool {
        let (normal, patch) = (element.normal, element.patch);
        let mut dark = 0;
        for ray in 0..RAYS {
            let direction = cosine_direction(normal, spread(ray));
            let Some(met) = self.contacts.meeting(point, direction, patch) else {
                return true;
            };
            match self.is_lit_at(met, hash::mix(patch, ray), STEPS) {
                Some(true) => return true,
                Some(false) => dark += 1,
                None => {}
            }
        }
        dark < RAYS / 2
    }

    /// Which part of an element light can reach, and whether something touches it at all.
    fn exposed(&self, element: &Element) -> (Exposed, bool) {
        let polygon = &element.polygon;
        let covering = self.contacts.covering(element);
        let is_exposed = |uv: Vec2| {
            let point = polygon.point(uv);
            !covering.iter().any(|shape| shape.holds(point)) && self.is_exposed(point, element)
        };
        let (normal, patch) = (element.normal, element.patch);
        if self.contacts.is_touched(polygon, normal, patch) {
            (Exposed::of(is_exposed), true)
        } else if Exposed::places().any(is_exposed) {
            (Exposed::ALL, false)
        } else {
            (Exposed::NONE, false)
        }
    }

    /// Finds which part of the elements from number `first` on light can reach, and makes areas those of that part.
    pub fn expose(&self, hierarchy: &mut Hierarchy, first: usize) {
        let shared = &*hierarchy;
        let found: Vec<Option<(Exposed, bool)>> = shared.elements[first..]
            .par_iter()
            .with_max_len(64)
            .map(|element| element.is_touched.then(|| self.exposed(element)))
            .collect();
        let mut changed: Vec<NodeId> = Vec::new();
        for (index, found) in (first..).zip(found) {
            let Some((exposed, is_touched)) = found else {
                continue;
            };
            let element = &mut hierarchy.elements[index];
            // Light that reaches a side gets to some place on it, however small.
            let is_lost = element.level == 0 && exposed.is_none();
            let exposed = if is_lost { Exposed::ALL } else { exposed };
            (element.exposed, element.is_touched) = (exposed, is_touched);
            let area = element.polygon.vector_area().length() * exposed.share();
            let node = &mut hierarchy.nodes[element.node as usize];
            if node.area != area {
                node.reflecting_area *= area / node.area;
                node.area = area;
                changed.push(node.parent);
            }
        }
        hierarchy.sum_areas(changed);
    }
}

/// The box of a shape.
fn around(shape: &Polygon) -> Region<'static> {
    let origin = shape.centre();
    let corners = shape.corners().iter().map(|corner| corner - origin);
    let (lower, upper) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| {
        (low.min(at), high.max(at))
    });
    Region {
        origin,
        lower,
        upper,
        planes: &[],
    }
}

/// True when `other` reaches into the inside of `shape`: it stands on it, passes through it, or lies on it.
fn touches(other: &Polygon, shape: &Polygon, normal: Vec3) -> bool {
    let origin = shape.corners()[0];
    let corners = other.corners();
    let height = |corner: Vec3| (corner - origin).dot(normal);
    let highest = corners
        .iter()
        .map(|&c| height(c))
        .fold(f32::NEG_INFINITY, f32::max);
    let lowest = corners
        .iter()
        .map(|&c| height(c))
        .fold(f32::INFINITY, f32::min);
    // Below the side, or in front of it; what lies in its plane may cover it.
    if lowest > COPLANAR || highest < -COPLANAR || highest <= COPLANAR && lowest < -COPLANAR {
        return false;
    }
    // Where it meets the plane.
    let mut contact = Vec::with_capacity(8);
    for (i, &corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let (h, after) = (height(corner), height(next));
        if h.abs() <= COPLANAR {
            contact.push(corner);
        } else if (h > COPLANAR) != (after > COPLANAR) && after.abs() > COPLANAR {
            contact.push(corner.lerp(next, h / (h - after)));
        }
    }
    let (corners, front) = (shape.corners(), shape.vector_area());
    let is_beside = |i: usize| {
        let edge = corners[(i + 1) % corners.len()] - corners[i];
        let inward = front.cross(edge).normalize_or_zero();
        let inside = |point: &Vec3| (point - corners[i]).dot(inward) > COPLANAR;
        !contact.iter().any(inside)
    };
    !contact.is_empty() && !(0..corners.len()).any(is_beside)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(corners: [(f32, f32, f32); 4]) -> Polygon {
        Polygon::new(&corners.map(|(x, y, z)| Vec3::new(x, y, z)))
    }

    #[test]
    fn what_stands_on_a_floor_touches_it_from_above() {
        // Normal +y.
        let floor = quad([(0., 0., 0.), (0., 0., 1.), (1., 0., 1.), (1., 0., 0.)]);
        let wall = |x: f32, low: f32, high: f32, from: f32, to: f32| {
            quad([(x, low, from), (x, high, from), (x, high, to), (x, low, to)])
        };
        let cases = [
            ("stands on it", wall(0.5, 0.0, 0.5, 0.2, 0.8), [true, false]),
            ("hangs below", wall(0.5, -0.5, 0.0, 0.2, 0.8), [false, true]),
            ("passes through", wall(0.5, -0.5, 0.5, 0.2, 0.8), [true; 2]),
            ("ends beyond", wall(0.5, 0.0, 0.5, 0.2, 3.0), [true, false]),
            ("floats", wall(0.5, 0.1, 0.5, 0.2, 0.8), [false; 2]),
            ("a room's wall", wall(1.0, 0.0, 1.0, 0.0, 1.0), [false; 2]),
            ("beside", wall(1.5, -0.5, 0.5, 0.2, 0.8), [false; 2]),
            (
                "a rug",
                quad([
                    (0.2, 0., 0.2),
                    (0.2, 0., 0.4),
                    (0.4, 0., 0.4),
                    (0.4, 0., 0.2),
                ]),
                [true; 2],
            ),
            (
                "the next tile",
                quad([(1., 0., 0.), (1., 0., 1.), (2., 0., 1.), (2., 0., 0.)]),
                [false; 2],
            ),
        ];
        for (name, other, expected) in cases {
            let found = [Vec3::Y, -Vec3::Y].map(|normal| touches(&other, &floor, normal));
            assert_eq!(found, expected, "{name}");
        }
    }
}
