//! Where the things of a scene stand: sizes that follow from the quality are shares of the scene's, but a table on a
//! square kilometre of ground is looked at as if it stood alone.

use crate::geometry::Polygon;
use glam::Vec3;

/// How fine surfaces may become, from place to place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    lower: Vec3,
    upper: Vec3,
    /// Share of the scene's size that the things take.
    size: f32,
    /// Share of the scene's size that one unit is.
    per_unit: f32,
}

/// Patches that are larger than this share of the scene are surroundings, such as grounds and walls.
const SURROUNDINGS: f32 = 0.25;
/// Share of the things on either side along each axis that may stand apart.
const APART: f32 = 0.05;
/// Things that take this share of the scene are looked at from all over it.
const WHOLE: f32 = 0.5;

impl Detail {
    /// Of a scene of patches with `shapes`, at least one.
    pub fn of(shapes: &[Polygon]) -> Self {
        let corners = || shapes.iter().flat_map(|shape| shape.corners());
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (lower, upper) = corners().fold(none, |(low, high), &corner| {
            (low.min(corner), high.max(corner))
        });
        let extent = (upper - lower).max_element();
        let everywhere = Self {
            lower,
            upper,
            size: 1.0,
            per_unit: 1.0 / extent,
        };
        let is_thing = |shape: &&Polygon| 2.0 * shape.radius() < SURROUNDINGS * extent;
        let things: Vec<Vec3> = shapes
            .iter()
            .filter(is_thing)
            .flat_map(|shape| shape.corners().iter().copied())
            .collect();
        if things.is_empty() {
            return everywhere;
        }
        let apart = (APART * things.len() as f32) as usize;
        let (mut lower, mut upper) = none;
        for axis in 0..3 {
            let mut along: Vec<f32> = things.iter().map(|point| point[axis]).collect();
            along.sort_unstable_by(f32::total_cmp);
            lower[axis] = along[apart];
            upper[axis] = along[along.len() - 1 - apart];
        }
        Self {
            lower,
            upper,
            size: (upper - lower).max_element() / extent,
            ..everywhere
        }
    }

    /// What sizes near a point are to be multiplied with: 1 where things stand all over the scene; otherwise the smaller
    /// the nearer it is to them.
    pub fn at(&self, point: Vec3) -> f32 {
        let away = point.distance(point.clamp(self.lower, self.upper)) * self.per_unit;
        (self.size.max(away) / WHOLE).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(centre: Vec3, half: f32) -> Polygon {
        let corner = |x: f32, z: f32| centre + Vec3::new(x, 0.0, z) * half;
        Polygon::new(&[
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
        ])
    }

    /// The least that [`Detail::at`] gives.
    fn least(detail: &Detail) -> f32 {
        (detail.size / WHOLE).min(1.0)
    }

    #[test]
    fn a_table_on_a_large_ground_stands_alone() {
        let ground = square(Vec3::ZERO, 0.5);
        let table = Vec3::new(0.2, 0.01, 0.1);
        let shapes = [ground, square(table, 0.01), square(table * 1.1, 0.005)];
        let detail = Detail::of(&shapes);
        assert!(detail.at(table) < 0.1, "{}", detail.at(table));
        assert_eq!(detail.at(table), least(&detail));
        let (near, far) = (Vec3::new(0.1, 0.0, 0.1), Vec3::new(-0.5, 0.0, -0.5));
        assert!(detail.at(near) > least(&detail) && detail.at(near) < 0.25);
        assert_eq!(detail.at(far), 1.0);
    }

    #[test]
    fn rooms_are_whole() {
        let ground = square(Vec3::ZERO, 0.5);
        assert_eq!(least(&Detail::of(&[ground])), 1.0);
        let place = |x: f32, z: f32| square(Vec3::new(x, 0.1, z), 0.05);
        let furnished = [ground, place(-0.4, 0.3), place(0.3, 0.1), place(0.0, -0.4)];
        assert_eq!(least(&Detail::of(&furnished)), 1.0);
    }
}
