//! Random places and directions of a scene: where a solution can be held against the truth.
//!
//! Highlights are small and bright: of evenly chosen directions few meet them, and those few hold most of the error.
//! More probes are on glossy surfaces near lamps, half of them look where a lamp is mirrored, and all are weighted for
//! that.

use super::lights::on_triangle;
use super::{PathTracer, Sampler};
use crate::brdf::Lobe;
use crate::geometry::sampling::{cosine_direction, spread};
use crate::radiometry::Rgb;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// A point of a surface as seen along one direction, with nothing in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where it is seen from [m].
    pub eye: Vec3,
    /// From there to it, unit.
    pub direction: Vec3,
    /// The point [m].
    pub point: Vec3,
    /// Of the side that is seen, unit.
    pub normal: Vec3,
    /// Material at the point.
    pub material: u32,
    /// What it counts for; of what cannot be seen, nothing. At most 4, 1 in the mean.
    pub weight: f32,
}

/// How probes are directed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// In proportion to the cosine: all weights are 1.
    Even,
    /// Half of them where lamps are mirrored.
    Highlights,
}

/// Lobes are aimed at as if they were not sharper than this Ward roughness: solutions show highlights wider than they
/// are.
const SHARPEST: f32 = 0.06;

/// Points of lamps that the highlights of a probe come from.
const LAMPS: u32 = 32;

/// Chooses probes: with their weights, points are evenly on all sides of surfaces that reflect, and directions in
/// proportion to the cosine.
pub struct Probes<'a> {
    tracer: &'a PathTracer,
    /// Of each material, those that are aimed at.
    lobes: Vec<Option<Lobe>>,
    sides: Vec<Side>,
}

/// A side of a triangle.
struct Side {
    triangle: u32,
    back: bool,
    /// Share of the probes that are on this one or on those before it.
    up_to: f64,
    /// Its share of all areas over its share of the probes.
    weight: f32,
}

impl<'a> Probes<'a> {
    /// Of the tracer's scene.
    pub fn new(tracer: &'a PathTracer, aim: Aim) -> Self {
        let lobe = |material| match aim {
            Aim::Even => None,
            Aim::Highlights => Lobe::of(material, SHARPEST),
        };
        let mut probes = Self {
            tracer,
            lobes: tracer.frame.materials.iter().map(lobe).collect(),
            sides: Vec::new(),
        };
        let known: Vec<(Side, f64, f64)> = (0..tracer.triangles.len() as u32)
            .into_par_iter()
            .flat_map_iter(|index| probes.sides_of(index))
            .collect();
        let sum = |of: fn(&(Side, f64, f64)) -> f64| known.iter().map(of).sum::<f64>();
        let (area, bright) = (sum(|side| side.1), sum(|side| side.2));
        let mut up_to = 0.0;
        for (side, own, shine) in known {
            let even = own / area;
            // A lamp within rounding of a surface has no finite brightness there.
            let share = if bright > 0.0 && bright.is_finite() {
                0.5 * (even + shine / bright)
            } else {
                even
            };
            up_to += share;
            probes.sides.push(Side {
                up_to,
                weight: (even / share) as f32,
                ..side
            });
        }
        probes
    }

    /// The sides of a triangle that reflect, the area of each, and what its lobe would reflect of the lamps' light, were
    /// nothing between.
    fn sides_of(&self, index: u32) -> Vec<(Side, f64, f64)> {
        let frame = &self.tracer.frame;
        let triangle = &self.tracer.triangles[index as usize];
        let material = &frame.materials[triangle.material as usize];
        let [a, b, c] = triangle.points.map(|p| frame.points[p as usize]);
        let cross = (b - a).cross(c - a);
        let area = f64::from(cross.length());
        // Clear panes are looked through.
        if area <= 0.0 || material.is_glass() {
            return Vec::new();
        }
        let middle = (a + b + c) / 3.0;
        let side = |back: bool| {
            let side = Side {
                triangle: index,
                back,
                up_to: 0.0,
                weight: 1.0,
            };
            let normal = if back { -cross } else { cross }.normalize();
            let shine = self.lobes[triangle.material as usize]
                .as_ref()
                .map_or(0.0, |lobe| {
                    let lamps = self.lamps(middle, normal, [0.5; 3]);
                    let received: f32 = lamps.iter().map(|lamp| lamp.1).sum();
                    f64::from(received * lobe.specular.mean()) * area
                });
            (side, area, shine)
        };
        let backs = if material.two_sided { 2 } else { 1 };
        [false, true][..backs]
            .iter()
            .map(|&back| side(back))
            .collect()
    }

    /// Directions to points of lamps above the horizon of a point, and the irradiance that each stands for.
    fn lamps(&self, point: Vec3, normal: Vec3, [lamp, u, v]: [f32; 3]) -> Vec<(Vec3, f32)> {
        let lights = &self.tracer.lights;
        let towards = |i: u32| {
            // Evenly over all power, and over each lamp.
            let on_lamp = (spread(i) + Vec2::new(u, v)).fract();
            let at = [(i as f32 + lamp) / LAMPS as f32, on_lamp.x, on_lamp.y, 0.0];
            let seen = lights.sample(lights.by_power(), point, at)?;
            let cosine = seen.direction.dot(normal);
            (cosine > 0.0).then_some((seen.direction, seen.irradiance.mean() * cosine))
        };
        (0..LAMPS).filter_map(towards).collect()
    }

    /// One probe; `None` in a scene where nothing reflects.
    pub fn choose(&self, sampler: &mut Sampler) -> Option<Probe> {
        let [chosen, u, v, _] = sampler.draw();
        let [x, y, z, w] = sampler.draw();
        let at = f64::from(chosen) * self.sides.last()?.up_to;
        let number = self.sides.partition_point(|side| side.up_to <= at);
        let side = self.sides.get(number).or(self.sides.last())?;
        let index = side.triangle;
        let triangle = &self.tracer.triangles[index as usize];
        let frame = &self.tracer.frame;
        let [a, b, c] = triangle.points.map(|p| frame.points[p as usize]);
        let point = on_triangle([a, b - a, c - a], u, v);
        let front = (b - a).cross(c - a).normalize();
        let normal = if side.back { -front } else { front };
        let (out, weight) = self.look(point, normal, triangle.material, [x, y, z, w], sampler);
        // Half way to what stands opposite; out of an open scene, from outside of it.
        let opposite = self.tracer.surfaces.nearest_hit(point, out, index);
        let distance = opposite.map_or(1.0, |hit| 0.5 * hit.distance);
        Some(Probe {
            eye: frame.position(point + out * distance),
            direction: -out,
            point: frame.position(point),
            normal,
            material: triangle.material,
            weight: weight * side.weight,
        })
    }

    /// A direction that leaves a surface, and its weight.
    ///
    /// Points of lamps are chosen too. Given them, two ways lead to a direction, and the weight is that of the cosine
    /// against the mean of both densities: in the space of directions and points together, so that no integral over
    /// lamps is needed.
    fn look(
        &self,
        point: Vec3,
        normal: Vec3,
        material: u32,
        [x, y, way, lamp]: [f32; 4],
        sampler: &mut Sampler,
    ) -> (Vec3, f32) {
        let even = || cosine_direction(normal, Vec2::new(x, y));
        let Some(lobe) = &self.lobes[material as usize] else {
            return (even(), 1.0);
        };
        let [u, v, chosen, _] = sampler.draw();
        let lamps = self.lamps(point, normal, [lamp, u, v]);
        if lamps.is_empty() {
            return (even(), 1.0);
        }
        let out = if way < 0.5 {
            let (lamp, _) = lamps[(chosen * lamps.len() as f32) as usize % lamps.len()];
            lobe.sample(normal, lamp, Vec2::new(x, y))
        } else {
            even()
        };
        let cosine = out.dot(normal);
        if cosine <= 0.0 {
            return (even(), 0.0);
        }
        let densities = lamps.iter().map(|lamp| lobe.density(normal, lamp.0, out));
        let aimed = densities.sum::<f32>() / lamps.len() as f32;
        (out, 1.0 / (0.5 + 0.5 * aimed / (cosine * FRAC_1_PI)))
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
