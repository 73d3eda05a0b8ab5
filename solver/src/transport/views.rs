//! What leaves see, coarsely: how far off the first thing stands in each of a hundred directions or so.
//!
//! A link to an element finds what share of the sender it sees on the whole, and part of a wall is behind a shelf: were
//! all its leaves given the same, what is behind would be bright and what is beside would be dark. Each leaf takes what
//! its own view shows of the sender, and their mean stays what the link found.
//! Cost: a ray and two bytes a direction, once a leaf; a few look-ups for each leaf and sample of a shadow.

use crate::geometry::{hash, sampling};
use crate::hierarchy::{Element, Hierarchy, NodeId};
use crate::transport::link::Sender;
use crate::transport::visibility::Occluders;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Cells along each axis of the square that the directions above a surface unfold to.
const SIDE: usize = 12;
const CELLS: usize = SIDE * SIDE;

/// What is met this far before the plane of a sender, as a share of the way, lies on it.
const ON_PLANE: f32 = 0.02;

/// Distance to what is first met, per cell: the upper half of an `f32`.
type View = [u16; CELLS];

/// Views of leaves that are part of a larger element.
#[derive(Clone, Debug, Default)]
pub(super) struct Views {
    /// Per node, if it has one.
    views: Vec<Option<Box<View>>>,
}

impl Views {
    /// Looks around from all leaves that have not done so yet.
    pub(super) fn look(&mut self, hierarchy: &Hierarchy, occluders: &Occluders) {
        self.views.resize_with(hierarchy.nodes.len(), || None);
        let is_new = |element: &&Element| {
            let parent = hierarchy.node(element.node).parent;
            hierarchy.is_leaf(element.node)
                && hierarchy.element_of(parent).is_some()
                && self.views[element.node as usize].is_none()
        };
        let new: Vec<&Element> = hierarchy.elements.iter().filter(is_new).collect();
        let seen: Vec<Box<View>> = new
            .par_iter()
            .with_max_len(64)
            .map(|element| Box::new(view(occluders, element)))
            .collect();
        for (element, view) in new.into_iter().zip(seen) {
            self.views[element.node as usize] = Some(view);
        }
        for (id, view) in (0..).zip(&mut self.views) {
            if !hierarchy.is_leaf(id) {
                *view = None;
            }
        }
    }

    /// The view of a leaf that is part of a larger element.
    pub(super) fn of(&self, hierarchy: &Hierarchy, leaf: NodeId) -> Option<Eye<'_>> {
        let view = self.views.get(leaf as usize)?.as_ref()?;
        let element = hierarchy.element_of(leaf)?;
        Some(Eye {
            frame: Frame::of(leaf, element.normal),
            from: hierarchy.node(leaf).centre,
            view,
        })
    }

    /// The views of all leaves that are part of an element.
    pub(super) fn below(&self, hierarchy: &Hierarchy, element: NodeId) -> Below<'_> {
        let mut eyes = Vec::new();
        let mut pending = vec![element];
        while let Some(id) = pending.pop() {
            pending.extend(hierarchy.children(id));
            let eye = self.of(hierarchy, id);
            eyes.extend(eye.map(|eye| (eye, hierarchy.node(id).area)));
        }
        Below { eyes }
    }

    /// Bytes that they take.
    pub(super) fn bytes(&self) -> usize {
        size_of_val::<[Option<Box<View>>]>(&self.views)
            + self.views.iter().flatten().count() * size_of::<View>()
    }
}

fn view(occluders: &Occluders, element: &Element) -> View {
    /// Points of the sequence that spreads them over leaves.
    const POINTS: u32 = 1 << 16;
    let frame = Frame::of(element.node, element.normal);
    std::array::from_fn(|cell| {
        let at = sampling::spread(hash::mix(element.node, cell as u32) % POINTS);
        let direction = frame.to_world(middle(cell));
        let hit = occluders.nearest_hit(element.point(at), direction, element.patch);
        let distance = hit.map_or(f32::INFINITY, |hit| hit.distance);
        (distance.to_bits() >> 16) as u16
    })
}

/// A leaf and its view.
pub(super) struct Eye<'a> {
    frame: Frame,
    from: Vec3,
    view: &'a View,
}

impl Eye<'_> {
    /// What share of the sender it sees.
    pub(super) fn share(&self, sender: &Sender) -> f32 {
        match &sender.polygon {
            None => f32::from(self.sees(sender, sender.centre, sender.radius)),
            Some(polygon) => {
                let quarters = polygon.quarter_centres();
                let sees = |&centre: &Vec3| self.sees(sender, centre, 0.5 * sender.radius);
                quarters.iter().filter(|centre| sees(centre)).count() as f32 / 4.0
            }
        }
    }

    /// True where something stands before all of the sender, and all around before it: behind what is close, whatever
    /// the link to all leaves has found. Asked only where it sees no share of it: there it is the wider question.
    pub(super) fn misses(&self, sender: &Sender) -> bool {
        // Most are seen at once.
        if sender.radius >= sender.centre.distance(self.from)
            || self.sees(sender, sender.centre, sender.radius)
        {
            return false;
        }
        let misses = |centre: Vec3, radius: f32| {
            let at = cell(self.frame.to_local(centre - self.from));
            around(at).all(|cell| !self.sees_in(cell, sender, centre, radius))
        };
        match &sender.polygon {
            None => misses(sender.centre, sender.radius),
            Some(polygon) => {
                let quarters = polygon.quarter_centres();
                let is_missed = |&centre: &Vec3| misses(centre, 0.5 * sender.radius);
                quarters.iter().all(is_missed)
            }
        }
    }

    /// True unless something stands before the part of the sender around a point, and before the sender's plane.
    fn sees(&self, sender: &Sender, centre: Vec3, radius: f32) -> bool {
        let cell = cell(self.frame.to_local(centre - self.from));
        self.sees_in(cell, sender, centre, radius)
    }

    /// The same by the view in some cell.
    fn sees_in(&self, cell: usize, sender: &Sender, centre: Vec3, radius: f32) -> bool {
        let reach = distance(self.view[cell]);
        if reach >= centre.distance(self.from) - radius {
            return true;
        }
        let met = self.from + self.frame.to_world(middle(cell)) * reach;
        let height = (met - sender.centre).dot(sender.normal);
        sender.polygon.is_some() && height < ON_PLANE * reach
    }
}

/// The distance of a cell.
fn distance(upper: u16) -> f32 {
    f32::from_bits(u32::from(upper) << 16)
}

/// A cell and those beside it.
fn around(cell: usize) -> impl Iterator<Item = usize> {
    let near = |at: usize| at.saturating_sub(1)..(at + 2).min(SIDE);
    let (x, y) = (cell % SIDE, cell / SIDE);
    near(y).flat_map(move |y| near(x).map(move |x| x + SIDE * y))
}

/// The leaves of an element.
pub(super) struct Below<'a> {
    /// With their areas.
    eyes: Vec<(Eye<'a>, f32)>,
}

impl Below<'_> {
    /// Means over them.
    pub(super) fn shares(&self, sender: &Sender) -> Shares {
        let (mut shown, mut missed, mut areas) = (0.0, 0.0, 0.0);
        for (eye, area) in &self.eyes {
            areas += area;
            let share = eye.share(sender);
            shown += share * area;
            if share <= 0.0 && eye.misses(sender) {
                missed += area;
            }
        }
        if areas > 0.0 {
            Shares {
                shown: shown / areas,
                missed: missed / areas,
            }
        } else {
            Shares::default()
        }
    }
}

/// What leaves see of a sender.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shares {
    /// The share that they see on average.
    pub(super) shown: f32,
    /// The share of them that see nothing of it for certain.
    pub(super) missed: f32,
}

/// Tangents and normal.
struct Frame([Vec3; 3]);

impl Frame {
    /// Turned from leaf to leaf: together they look in all directions.
    fn of(leaf: NodeId, normal: Vec3) -> Self {
        const TURN: u32 = 0x7475_726e;
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let (y, x) = (TAU * hash::unit(leaf, TURN)).sin_cos();
        Self([
            tangent * x + bitangent * y,
            bitangent * x - tangent * y,
            normal,
        ])
    }

    fn to_world(&self, v: Vec3) -> Vec3 {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }

    fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::from(self.0.map(|axis| axis.dot(v)))
    }
}

/// Direction to the middle of a cell: the upper half of an octahedron is a square.
fn middle(cell: usize) -> Vec3 {
    let along = |i: usize| 2.0 * (i as f32 + 0.5) / SIDE as f32 - 1.0;
    let at = Vec2::new(along(cell % SIDE), along(cell / SIDE));
    let (x, y) = (0.5 * (at.x + at.y), 0.5 * (at.x - at.y));
    Vec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

/// The cell of a direction of any length; of one from below, the nearest.
fn cell(direction: Vec3) -> usize {
    let sum = direction.x.abs() + direction.y.abs() + direction.z.max(0.0);
    let (x, y) = (direction.x / sum, direction.y / sum);
    let index = |at: f32| ((0.5 * (at + 1.0) * SIDE as f32) as usize).min(SIDE - 1);
    index(x + y) + SIDE * index(x - y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_lies_in_the_cell_that_it_is_the_middle_of() {
        for i in 0..CELLS {
            assert!(middle(i).z > 0.0);
            assert_eq!(cell(middle(i) * 3.0), i);
            let below = middle(i).with_z(-0.1);
            assert!(cell(below) < CELLS);
        }
    }
}
