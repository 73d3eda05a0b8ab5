//! What emits, and points on it.

use super::choice::Choice;
use super::surface::Surface;
use crate::geometry::sampling::{cosine_direction, sphere_direction};
use crate::hierarchy::NONE;
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::Triangle;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::ops::Range;

/// Lights are chosen among this many groups, at most.
const MOST_GROUPS: usize = 1024;
/// Share of the choice for a place that follows power alone: what its points do not see, others nearby may.
const BY_POWER: f32 = 0.1;

/// Where light comes from.
enum Shape {
    /// A side of the triangle with this number: a corner, and the edges from it in the order that makes the side the
    /// front.
    Side(u32, [Vec3; 3]),
    /// A point.
    Point(Vec3),
}

struct Light {
    shape: Shape,
    /// Radiance, or a point's intensity.
    emission: Rgb,
    /// Power [mean over channels].
    power: f64,
    /// Its group.
    group: u32,
    /// Share of its group's power, and of all before it in the group.
    share: f32,
    before: f32,
}

/// Everything that emits.
pub(super) struct Lights {
    lights: Vec<Light>,
    groups: Vec<Range<usize>>,
    by_power: Choice,
    /// Per triangle: the lights that its front and back are, or [`NONE`].
    sides: Vec<[u32; 2]>,
}

/// A point on a light as seen from a surface.
pub(super) struct Seen {
    /// Where.
    pub(super) point: Vec3,
    /// Towards it, unit.
    pub(super) direction: Vec3,
    /// Triangle, or [`NONE`].
    pub(super) triangle: u32,
    /// Radiance over density, of a point light normal irradiance over chance.
    pub(super) irradiance: Rgb,
    /// Density of the direction [sr⁻¹]; `None` for points.
    pub(super) density: Option<f32>,
}

impl Lights {
    pub(super) fn new(frame: &Normalised, triangles: &[Triangle]) -> Self {
        let mut lights: Vec<Light> = Vec::new();
        let mut sides = vec![[NONE; 2]; triangles.len()];
        let light = |shape: Shape, emission: Rgb, power: f64| Light {
            shape,
            emission,
            power,
            group: 0,
            share: 0.0,
            before: 0.0,
        };
        for (index, triangle) in triangles.iter().enumerate() {
            let material = &frame.materials[triangle.material as usize];
            let [a, b, c] = triangle.points.map(|p| frame.points[p as usize]);
            let area = f64::from(0.5 * (b - a).cross(c - a).length());
            let power = f64::from(PI * material.emission.mean()) * area;
            if power <= 0.0 {
                continue;
            }
            let shapes = [[a, b - a, c - a], [a, c - a, b - a]];
            let count = if material.emits_from_back { 2 } else { 1 };
            for (side, shape) in shapes.into_iter().enumerate().take(count) {
                sides[index][side] = lights.len() as u32;
                let shape = Shape::Side(index as u32, shape);
                lights.push(light(shape, material.emission, power));
            }
        }
        for &(position, intensity) in &frame.point_lights {
            let power = f64::from(4.0 * PI * intensity.mean());
            if power > 0.0 {
                lights.push(light(Shape::Point(position), intensity, power));
            }
        }
        let size = lights.len().div_ceil(MOST_GROUPS).max(1);
        let starts = (0..lights.len()).step_by(size);
        let groups: Vec<Range<usize>> = starts
            .map(|start| start..(start + size).min(lights.len()))
            .collect();
        let mut powers = Vec::with_capacity(groups.len());
        for (number, group) in groups.iter().enumerate() {
            let members = &mut lights[group.clone()];
            let whole: f64 = members.iter().map(|light| light.power).sum();
            let mut before = 0.0;
            for light in members {
                light.group = number as u32;
                light.share = (light.power / whole) as f32;
                light.before = (before / whole) as f32;
                before += light.power;
            }
            powers.push(whole as f32);
        }
        Self {
            lights,
            groups,
            by_power: Choice::new(powers),
            sides,
        }
    }

    /// The choice of groups by power.
    pub(super) fn by_power(&self) -> &Choice {
        &self.by_power
    }

    /// A choice of groups for a place, by what they give to some of its points, with normals, were nothing between.
    pub(super) fn choice_for(&self, points: &[(Vec3, Vec3)]) -> Choice {
        let given = |group: &Range<usize>| -> f32 {
            let members = self.lights[group.clone()].iter();
            members
                .map(|light| points.iter().map(|&at| light.given(at)).sum::<f32>())
                .sum()
        };
        let given: Vec<f32> = self.groups.iter().map(given).collect();
        let whole: f32 = given.iter().sum();
        if whole <= 0.0 || !whole.is_finite() {
            return self.by_power.clone();
        }
        let share = |(group, given): (usize, f32)| {
            BY_POWER * self.by_power.share(group) + (1.0 - BY_POWER) * given / whole
        };
        Choice::new(given.into_iter().enumerate().map(share).collect())
    }

    /// The light that a surface is where it is seen from, and its radiance.
    pub(super) fn at(&self, surface: &Surface) -> Option<(u32, Rgb)> {
        let light = self.sides[surface.triangle as usize][usize::from(surface.back)];
        (light != NONE).then(|| (light, self.lights[light as usize].emission))
    }

    /// Density with which [`Self::sample`] would have chosen the direction from `from` to a point on this light
    /// [sr⁻¹].
    pub(super) fn density(
        &self,
        light: u32,
        choice: &Choice,
        surface: &Surface,
        from: Vec3,
    ) -> f32 {
        let light = &self.lights[light as usize];
        let offset = surface.point - from;
        let squared = offset.length_squared();
        let cosine = surface.front.dot(offset).abs() / squared.sqrt();
        light.chance(choice) * squared / (cosine * surface.area)
    }

    /// Where light starts, chosen by power: a point, its triangle or [`NONE`], and a unit direction.
    pub(super) fn emit(&self, at: [f32; 4], towards: [f32; 4]) -> Option<(Vec3, u32, Vec3)> {
        let light = self.chosen(&self.by_power, at[0])?;
        let towards = Vec2::new(towards[0], towards[1]);
        Some(match light.shape {
            Shape::Side(triangle, side) => {
                let direction = cosine_direction(side[1].cross(side[2]).normalize(), towards);
                (on_triangle(side, at[1], at[2]), triangle, direction)
            }
            Shape::Point(point) => (point, NONE, sphere_direction(towards)),
        })
    }

    fn chosen(&self, choice: &Choice, at: f32) -> Option<&Light> {
        let (group, rest) = choice.choose(at)?;
        let members = &self.lights[self.groups[group].clone()];
        let number = members.partition_point(|light| light.before <= rest);
        members.get(number.saturating_sub(1))
    }

    /// A point on a light, which is chosen by `choice`; `None` when it does not emit towards `from`.
    pub(super) fn sample(&self, choice: &Choice, from: Vec3, at: [f32; 4]) -> Option<Seen> {
        let light = self.chosen(choice, at[0])?;
        let chance = light.chance(choice);
        let (triangle, side) = match light.shape {
            Shape::Side(triangle, side) => (triangle, side),
            Shape::Point(point) => {
                let offset = point - from;
                let squared = offset.length_squared();
                return (squared > 0.0).then(|| Seen {
                    point,
                    direction: offset / squared.sqrt(),
                    triangle: NONE,
                    irradiance: light.emission / (squared * chance),
                    density: None,
                });
            }
        };
        let point = on_triangle(side, at[1], at[2]);
        let offset = point - from;
        let squared = offset.length_squared();
        let distance = squared.sqrt();
        // Of twice the triangle's area; against it falls what the side emits towards `from`.
        let normal = side[1].cross(side[2]);
        let visible = -normal.dot(offset) / distance;
        let density = 2.0 * chance * squared / visible;
        (visible > 0.0 && density > 0.0).then(|| Seen {
            point,
            direction: offset / distance,
            triangle,
            irradiance: light.emission / density,
            density: Some(density),
        })
    }
}

impl Light {
    fn chance(&self, choice: &Choice) -> f32 {
        choice.share(self.group as usize) * self.share
    }

    /// Irradiance at a point with a normal, were all of it in its middle and nothing between [mean over channels].
    fn given(&self, (point, normal): (Vec3, Vec3)) -> f32 {
        let (middle, area) = match self.shape {
            Shape::Side(_, [corner, ab, ac]) => (corner + (ab + ac) / 3.0, ab.cross(ac) * 0.5),
            Shape::Point(middle) => (middle, Vec3::ZERO),
        };
        let offset = middle - point;
        let squared = offset.length_squared();
        let received = normal.dot(offset).max(0.0) / squared.sqrt();
        let sent = match self.shape {
            Shape::Side(..) => (-area.dot(offset)).max(0.0) / squared.sqrt(),
            Shape::Point(_) => 1.0,
        };
        if squared > 0.0 {
            self.emission.mean() * sent * received / squared
        } else {
            0.0
        }
    }
}

/// The point of a triangle, given by a corner and the edges from it, that belongs to a point of the unit square.
pub(super) fn on_triangle([corner, ab, ac]: [Vec3; 3], u: f32, v: f32) -> Vec3 {
    let root = u.sqrt();
    corner + ab * (root * (1.0 - v)) + ac * (root * v)
}
