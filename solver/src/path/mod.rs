//! The reference: path tracing with next-event estimation and multiple importance sampling.
//!
//! Unbiased for every scene: light is what the conventions of the scene say, nothing is clamped, roulette divides by
//! the chance that it takes. Perfect mirrors and thin glass are followed exactly. It shares scene, BRDFs and visibility
//! with the solver and nothing else. Normalised coordinates; lengths and lights scale by powers of two bitwise.
//! Kajiya 1986; Arvo and Kirk 1990 (roulette); Veach 1997, chapter 9 (multiple importance sampling).
//! Cost: two rays a bounce.

mod lights;
mod sampler;
mod surface;

pub use sampler::Sampler;

use crate::brdf::{Lobe, reflect};
use crate::geometry::sampling::cosine_direction;
use crate::hierarchy::NONE;
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::{Gloss, Material, Scene, Triangle};
use crate::transport::visibility::{Occluder, Occluders};
use glam::{Vec2, Vec3};
use lights::Lights;
use std::f32::consts::FRAC_1_PI;
use surface::Surface;

/// Bounces before roulette starts.
const SURE: u32 = 3;

/// Roulette lets no path live with more than this chance: paths between white walls end too.
const MOST_CHANCE: f32 = 0.95;

/// Traces paths through one scene.
pub struct PathTracer {
    frame: Normalised,
    triangles: Vec<Triangle>,
    normals: Vec<Vec3>,
    /// Every triangle blocks, glass too; "patches" are triangles.
    surfaces: Occluders,
    /// Glass tints.
    shadows: Occluders,
    lights: Lights,
    scattering: Vec<Scattering>,
}

/// What a material does with light.
struct Scattering {
    diffuse: Rgb,
    lobe: Option<Lobe>,
    /// Share that a perfect mirror reflects.
    mirror: Rgb,
    /// Share that passes straight.
    clear: Rgb,
}

impl Scattering {
    fn of(material: &Material) -> Self {
        let (lobe, mirror) = match material.gloss {
            Gloss::Ward {
                specular,
                roughness,
            } if roughness <= 0.0 => (None, specular),
            _ => (Lobe::of(material, 0.0), Rgb::BLACK),
        };
        Self {
            diffuse: material.diffuse,
            lobe,
            mirror,
            clear: material.transmission,
        }
    }

    /// BRDF; directions leave the surface.
    fn eval(&self, normal: Vec3, wi: Vec3, wo: Vec3) -> Rgb {
        let diffuse = self.diffuse * FRAC_1_PI;
        match &self.lobe {
            Some(lobe) => diffuse + lobe.specular * lobe.eval(normal, wi, wo),
            None => diffuse,
        }
    }

    /// Shares of the light towards an angle with cosine `cos_o` that each way of scattering makes: diffuse, lobe,
    /// mirror, straight on.
    fn shares(&self, cos_o: f32) -> [f32; 4] {
        let lobe = self.lobe.as_ref();
        [
            self.diffuse.mean(),
            lobe.map_or(0.0, |lobe| lobe.specular.mean() * lobe.albedo(cos_o)),
            self.mirror.mean(),
            self.clear.mean(),
        ]
    }
}

/// Where a path goes on.
struct Step {
    direction: Vec3,
    /// BRDF times cosine over density.
    weight: Rgb,
    /// Density of the direction [sr⁻¹]; `None` for mirrors.
    density: Option<f32>,
    /// It passed straight: it left the surface on the other side, and is no scattering.
    passed: bool,
}

impl PathTracer {
    /// Makes `scene` ready.
    pub fn new(scene: &Scene) -> Self {
        let frame = Normalised::new(scene);
        let triangles = scene.triangles().to_vec();
        let occluder = |tinted: bool| {
            let of_triangle = |(index, t): (usize, &Triangle)| Occluder {
                corners: t.points.map(|p| frame.points[p as usize]),
                patch: index as u32,
                transmission: if tinted {
                    frame.materials[t.material as usize].transmission
                } else {
                    Rgb::BLACK
                },
            };
            let all: Vec<Occluder> = triangles.iter().enumerate().map(of_triangle).collect();
            Occluders::new(&all)
        };
        let (surfaces, shadows) = (occluder(false), occluder(true));
        let lights = Lights::new(&frame, &triangles);
        let scattering = frame.materials.iter().map(Scattering::of).collect();
        Self {
            normals: scene.normals().to_vec(),
            frame,
            triangles,
            surfaces,
            shadows,
            lights,
            scattering,
        }
    }

    /// Radiance that reaches `eye` [m] against the unit `direction`, by one path [W·sr⁻¹·m⁻²].
    pub fn radiance(&self, eye: Vec3, direction: Vec3, sampler: &mut Sampler) -> Rgb {
        let mut from = self.frame.normalised(eye);
        let mut origin = NONE;
        let mut direction = direction;
        let (mut sum, mut throughput) = (Rgb::BLACK, Rgb::WHITE);
        // Where the path scattered last, and with which density it went on; emission is seen in full without one.
        let mut scattered: Option<(Vec3, f32)> = None;
        let mut bounce = 0;
        while let Some(hit) = self.surfaces.nearest_hit(from, direction, origin) {
            let surface = Surface::new(self, from, direction, &hit);
            if let Some(emission) = self.lights.emission(&surface) {
                let share = scattered.map_or(1.0, |(at, density)| {
                    let light = self.lights.density(&surface, emission, at);
                    power_heuristic(density, light)
                });
                sum += throughput * emission * share;
            }
            if surface.is_black {
                break;
            }
            let scattering = &self.scattering[surface.material as usize];
            let wo = -direction;
            let choices = sampler.draw();
            if scattering.diffuse != Rgb::BLACK || scattering.lobe.is_some() {
                sum += throughput * self.direct(&surface, scattering, wo, sampler.draw());
            }
            let Some(step) = step(scattering, surface.normal, wo, choices) else {
                break;
            };
            throughput = throughput * step.weight;
            if !step.passed {
                scattered = step.density.map(|density| (surface.point, density));
                bounce += 1;
            }
            let chance = throughput.max_channel().min(MOST_CHANCE);
            if bounce > SURE || step.passed {
                if choices[3] >= chance {
                    break;
                }
                throughput = throughput / chance;
            }
            (from, origin, direction) = (surface.point, surface.triangle, step.direction);
        }
        self.frame.radiance(sum)
    }

    /// Light from a point on a light that is chosen by its power, reflected towards `wo`.
    fn direct(&self, surface: &Surface, scattering: &Scattering, wo: Vec3, at: [f32; 4]) -> Rgb {
        let Some(light) = self.lights.sample(surface.point, at) else {
            return Rgb::BLACK;
        };
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 {
            return Rgb::BLACK;
        }
        let reflected = scattering.eval(surface.normal, light.direction, wo) * cosine;
        if reflected.is_black() {
            return Rgb::BLACK;
        }
        let ends = [surface.triangle, light.triangle];
        let passed = self
            .shadows
            .strict_transmittance(surface.point, light.point, ends);
        if passed.is_black() {
            return Rgb::BLACK;
        }
        let share = light.density.map_or(1.0, |density| {
            power_heuristic(
                density,
                density_of(scattering, surface.normal, light.direction, wo),
            )
        });
        reflected * passed * light.irradiance * share
    }
}

/// Weight of a sample whose density is `own` when another way would have had `other` (Veach 1997, chapter 9: the power heuristic, β = 2).
fn power_heuristic(own: f32, other: f32) -> f32 {
    if own == f32::INFINITY {
        return 1.0;
    }
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Density with which [`step`] scatters from `wo` to `wi` [sr⁻¹].
fn density_of(scattering: &Scattering, normal: Vec3, wi: Vec3, wo: Vec3) -> f32 {
    let shares = scattering.shares(normal.dot(wo));
    let whole: f32 = shares.iter().sum();
    let diffuse = shares[0] * normal.dot(wi).max(0.0) * FRAC_1_PI;
    let lobe = scattering.lobe.as_ref();
    let glossy = lobe.map_or(0.0, |lobe| shares[1] * lobe.density(normal, wo, wi));
    (diffuse + glossy) / whole
}

/// Chooses how light towards `wo` was scattered; `None` when it was not.
fn step(scattering: &Scattering, normal: Vec3, wo: Vec3, choices: [f32; 4]) -> Option<Step> {
    let shares = scattering.shares(normal.dot(wo));
    let whole: f32 = shares.iter().sum();
    let mut left = choices[0] * whole;
    let chosen = shares.iter().position(|&share| {
        let is_here = left < share;
        left -= share;
        is_here
    })?;
    let at = Vec2::new(choices[1], choices[2]);
    let straight = |direction: Vec3, colour: Rgb, passed: bool| Step {
        direction,
        weight: colour * (whole / shares[chosen]),
        density: None,
        passed,
    };
    let direction = match chosen {
        0 => cosine_direction(normal, at),
        1 => scattering.lobe.as_ref()?.sample(normal, wo, at),
        2 => return Some(straight(reflect(normal, wo), scattering.mirror, false)),
        _ => return Some(straight(-wo, scattering.clear, true)),
    };
    let cosine = normal.dot(direction);
    let density = density_of(scattering, normal, direction, wo);
    if cosine <= 0.0 || density <= 0.0 {
        return None;
    }
    Some(Step {
        direction,
        weight: scattering.eval(normal, direction, wo) * (cosine / density),
        density: Some(density),
        passed: false,
    })
}
