//! What rays are aimed at: sides of patches, chosen the more often the larger they look from a point.
//!
//! Random rays miss what is small: of 24, nearly all miss a lamp over a table. Cost of a choice: the depth of a tree.

use crate::geometry::{Polygon, hash};
use crate::transport::link::COPLANAR;
use glam::{Vec2, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use std::time::Duration;

/// Sides of patches in a tree.
pub(super) struct Targets {
    /// Shape, back.
    sides: Vec<(Polygon, bool)>,
    bvh: Bvh2,
    /// What lies below each node of the tree.
    areas: Vec<f32>,
}

impl Targets {
    /// Of these sides: shapes, and whether it is their back.
    pub(super) fn new(sides: Vec<(Polygon, bool)>) -> Self {
        let boxes: Vec<Aabb> = sides
            .iter()
            .map(|(shape, _)| {
                let corners = shape.corners().iter();
                let corners: Vec<Vec3A> = corners.map(|&corner| corner.into()).collect();
                Aabb::from_points(&corners)
            })
            .collect();
        let params = BvhBuildParams {
            pre_split: false,
            max_prims_per_leaf: 1,
            ..BvhBuildParams::medium_build()
        };
        let bvh = if boxes.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&boxes, params, &mut Duration::default())
        };
        let mut targets = Self {
            sides,
            areas: vec![0.0; bvh.nodes.len()],
            bvh,
        };
        // Depth first; areas are summed on the way back.
        let mut order: Vec<usize> = targets.bvh.nodes.first().map(|_| 0).into_iter().collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            next += 1;
            let node = &targets.bvh.nodes[node];
            if !node.is_leaf() {
                let first = node.first_index as usize;
                order.extend([first, first + 1]);
            }
        }
        for at in order.into_iter().rev() {
            let node = &targets.bvh.nodes[at];
            targets.areas[at] = if node.is_leaf() {
                targets.side_of(at).0.vector_area().length()
            } else {
                let first = node.first_index as usize;
                targets.areas[first] + targets.areas[first + 1]
            };
        }
        targets
    }

    fn side_of(&self, leaf: usize) -> &(Polygon, bool) {
        let index = self.bvh.nodes[leaf].first_index as usize;
        &self.sides[self.bvh.primitive_indices[index] as usize]
    }

    /// The direction from a point of a surface with `normal` to a point of a side that looks there; `seed` and `ray`
    /// choose. `None` where nothing is in front of the surface, or what was chosen looks elsewhere.
    pub(super) fn aim(&self, from: Vec3, normal: Vec3, seed: u32, ray: u32) -> Option<Vec3> {
        let seen = |node: usize| {
            let bounds = &self.bvh.nodes[node].aabb;
            let (low, high): (Vec3, Vec3) = (bounds.min.into(), bounds.max.into());
            let farthest = Vec3::select(normal.cmpgt(Vec3::ZERO), high, low);
            if (farthest - from).dot(normal) <= COPLANAR {
                return 0.0;
            }
            let squared = from.distance_squared((low + high) * 0.5);
            self.areas[node] / squared.max(0.25 * low.distance_squared(high))
        };
        let unit = |salt: u32| hash::unit(seed, ray.wrapping_mul(4) + salt);
        let mut chance = unit(0);
        let mut at = 0;
        while !self.bvh.nodes.get(at)?.is_leaf() {
            let first = self.bvh.nodes[at].first_index as usize;
            let (left, right) = (seen(first), seen(first + 1));
            let share = left / (left + right);
            if share.is_nan() {
                return None;
            }
            (at, chance) = if chance < share {
                (first, chance / share)
            } else {
                (first + 1, (chance - share) / (1.0 - share))
            };
        }
        let (shape, back) = self.side_of(at);
        let inset = |number: f32| 0.02 + 0.96 * number;
        let to = shape.point(Vec2::new(inset(unit(1)), inset(unit(2)))) - from;
        let facing = to.dot(shape.vector_area());
        let looks_here = if *back { facing > 0.0 } else { facing < 0.0 };
        (looks_here && to.dot(normal) > COPLANAR).then(|| to.normalize())
    }
}

/// Where light comes from.
pub struct Lamps {
    sides: Targets,
    points: Vec<Vec3>,
}

/// A ray towards a lamp.
pub(super) struct Aim {
    /// Unit.
    pub(super) direction: Vec3,
    /// How far away a point light is; `None` for lamps with a surface.
    pub(super) distance: Option<f32>,
}

impl Lamps {
    /// Sides that emit, and points.
    pub(super) fn new(sides: Vec<(Polygon, bool)>, points: Vec<Vec3>) -> Self {
        Self {
            sides: Targets::new(sides),
            points,
        }
    }

    /// As [`Targets::aim`]; points take turns with sides.
    pub(super) fn aim(&self, from: Vec3, normal: Vec3, seed: u32, ray: u32) -> Option<Aim> {
        let count = self.points.len() as u32;
        let takes_point = count > 0 && (self.sides.sides.is_empty() || ray.is_multiple_of(2));
        if !takes_point {
            let direction = self.sides.aim(from, normal, seed, ray)?;
            return Some(Aim {
                direction,
                distance: None,
            });
        }
        // Few are taken in turn; of many, others from every place.
        let light = self.points[(seed.wrapping_add(ray / 2) % count) as usize];
        let (direction, distance) = (light - from).normalize_and_length();
        (direction.dot(normal) > 0.0).then_some(Aim {
            direction,
            distance: Some(distance),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(centre: Vec3, side: f32) -> Polygon {
        // Looks down.
        let (x, z) = (Vec3::X * side * 0.5, Vec3::Z * side * 0.5);
        Polygon::new(&[
            centre - x - z,
            centre + x - z,
            centre + x + z,
            centre - x + z,
        ])
    }

    #[test]
    fn small_things_far_away_are_aimed_at() {
        let shapes = [
            square(Vec3::new(0.3, 0.4, 0.1), 1e-3),
            // In the plane of the surface, and behind it: never chosen.
            square(Vec3::ZERO, 1.0),
            square(Vec3::new(0.0, -0.5, 0.0), 1.0),
        ];
        let sides = shapes
            .iter()
            .flat_map(|&shape| [(shape, false), (shape, true)]);
        let targets = Targets::new(sides.collect());
        let from = Vec3::new(-0.4, 0.0, 0.2);
        let mut aimed = 0;
        for ray in 0..64 {
            let Some(direction) = targets.aim(from, Vec3::Y, 7, ray) else {
                continue;
            };
            aimed += 1;
            let to = (shapes[0].centre() - from).normalize();
            assert!(direction.dot(to) > 0.999_99, "{direction}");
        }
        // The other half chose its back.
        assert!((20..44).contains(&aimed), "{aimed}");
    }

    #[test]
    fn nothing_is_aimed_at_where_there_is_nothing() {
        let targets = Targets::new(Vec::new());
        assert!(targets.aim(Vec3::ZERO, Vec3::Y, 1, 1).is_none());
    }
}
