//! Random places and directions of a scene: where a solution can be held against the truth.

use super::lights::on_triangle;
use super::{PathTracer, Sampler};
use crate::geometry::sampling::cosine_direction;
use crate::radiometry::Rgb;
use glam::{Vec2, Vec3};

/// A point of a surface as seen along one direction, with nothing in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where it is seen from [m].
    pub eye: Vec3,
    /// From there to it, unit.
    pub direction: Vec3,
    /// Material at the point.
    pub material: u32,
}

/// Chooses probes: points evenly over all sides of surfaces that reflect, directions in proportion to the cosine.
pub struct Probes<'a> {
    tracer: &'a PathTracer,
    /// Triangle, whether its back, and the area of all sides up to this one.
    sides: Vec<(u32, bool, f64)>,
}

impl<'a> Probes<'a> {
    /// Of the tracer's scene.
    pub fn new(tracer: &'a PathTracer) -> Self {
        let mut area = 0.0;
        let mut sides = Vec::new();
        for (index, triangle) in tracer.triangles.iter().enumerate() {
            let material = &tracer.frame.materials[triangle.material as usize];
            let [a, b, c] = triangle.points.map(|p| tracer.frame.points[p as usize]);
            let own = f64::from((b - a).cross(c - a).length());
            let backs: &[bool] = if material.two_sided {
                &[false, true]
            } else {
                &[false]
            };
            // Clear panes are looked through.
            if own > 0.0 && !material.is_glass() {
                for &back in backs {
                    area += own;
                    sides.push((index as u32, back, area));
                }
            }
        }
        Self { tracer, sides }
    }

    /// One probe; `None` in a scene where nothing reflects.
    pub fn choose(&self, sampler: &mut Sampler) -> Option<Probe> {
        let [chosen, u, v, _] = sampler.draw();
        let [x, y, ..] = sampler.draw();
        let at = f64::from(chosen) * self.sides.last()?.2;
        let number = self.sides.partition_point(|side| side.2 <= at);
        let &(index, back, _) = self.sides.get(number).or(self.sides.last())?;
        let triangle = &self.tracer.triangles[index as usize];
        let frame = &self.tracer.frame;
        let [a, b, c] = triangle.points.map(|p| frame.points[p as usize]);
        let point = on_triangle([a, b - a, c - a], u, v);
        let front = (b - a).cross(c - a).normalize();
        let normal = if back { -front } else { front };
        let out = cosine_direction(normal, Vec2::new(x, y));
        // Half way to what stands opposite; out of an open scene, from outside of it.
        let opposite = self.tracer.surfaces.nearest_hit(point, out, index);
        let distance = opposite.map_or(1.0, |hit| 0.5 * hit.distance);
        Some(Probe {
            eye: frame.position(point + out * distance),
            direction: -out,
            material: triangle.material,
        })
    }
}

impl PathTracer {
    /// What the first surface from `eye` [m] along unit `direction` emits towards it [W·sr⁻¹·m⁻²].
    pub fn emitted(&self, eye: Vec3, direction: Vec3) -> Rgb {
        let from = self.frame.normalised(eye);
        let hit = self
            .surfaces
            .nearest_hit(from, direction, crate::hierarchy::NONE);
        let light = hit.and_then(|hit| {
            let surface = super::Surface::new(self, from, direction, &hit);
            self.lights.at(&surface)
        });
        light.map_or(Rgb::BLACK, |(_, emission)| self.frame.radiance(emission))
    }

    /// The same of what it reflects, by one path.
    pub fn reflected(&self, eye: Vec3, direction: Vec3, sampler: &mut Sampler) -> Rgb {
        let from = self.frame.normalised(eye);
        let radiance = self.follow(from, crate::hierarchy::NONE, direction, sampler, false);
        self.frame.radiance(radiance)
    }
}
