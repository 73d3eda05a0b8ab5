//! The reference: path tracing with next-event estimation and multiple importance sampling.
//!
//! Unbiased for every scene: light is what the conventions of the scene say, nothing is clamped, roulette divides by
//! the chance that it takes. Perfect mirrors and thin glass are followed exactly. It shares scene, BRDFs and visibility
//! with the solver and nothing else. What photons teach about light only chooses. Normalised coordinates; lengths and
//! lights scale by powers of two bitwise.
//! Kajiya 1986; Arvo and Kirk 1990 (roulette); Veach 1997, chapter 9 (multiple importance sampling).
//! Cost: two rays a bounce.

mod choice;
mod directions;
mod guide;
mod lights;
mod probe;
mod reflectors;
mod roulette;
mod sampler;
mod scatter;
mod surface;

pub use probe::{Aim, Probe, Probes};
pub use sampler::Sampler;

use crate::hierarchy::NONE;
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::{Scene, Triangle};
use crate::transport::visibility::{Occluder, Occluders};
use choice::Choice;
use glam::Vec3;
use guide::Guide;
use lights::Lights;
use roulette::Roulette;
use scatter::{Scatterer, Scattering};
use surface::Surface;

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
    guide: Guide,
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
        let mut tracer = Self {
            normals: scene.normals().to_vec(),
            frame,
            triangles,
            surfaces,
            shadows,
            lights,
            scattering,
            guide: Guide::empty(),
        };
        tracer.guide = Guide::learn(&tracer);
        tracer
    }

    /// Radiance that reaches `eye` [m] against the unit `direction`, by one path [W·sr⁻¹·m⁻²].
    pub fn radiance(&self, eye: Vec3, direction: Vec3, sampler: &mut Sampler) -> Rgb {
        let from = self.frame.normalised(eye);
        let radiance = self.follow(from, NONE, direction, sampler, true);
        self.frame.radiance(radiance)
    }

    /// Normalised radiance that reaches `from`, of triangle `origin`, against `direction`, by one path; `emitted`: with
    /// what the first surface emits.
    fn follow(
        &self,
        mut from: Vec3,
        mut origin: u32,
        mut direction: Vec3,
        sampler: &mut Sampler,
        emitted: bool,
    ) -> Rgb {
        let (mut sum, mut throughput) = (Rgb::BLACK, Rgb::WHITE);
        // Where the path scattered last, how lights were chosen there, and with which density it went on; emission is
        // seen in full without one.
        let mut scattered: Option<(Vec3, &Choice, f32)> = None;
        let mut bounce = 0;
        let mut roulette = Roulette::default();
        while let Some(hit) = self.surfaces.nearest_hit(from, direction, origin) {
            let surface = Surface::new(self, from, direction, &hit);
            let light = self.lights.at(&surface).filter(|_| emitted || bounce > 0);
            if let Some((light, emission)) = light {
                let share = scattered.map_or(1.0, |(at, choice, density)| {
                    let light = self.lights.density(light, choice, &surface, at);
                    power_heuristic(density, light)
                });
                sum += throughput * emission * share;
            }
            if surface.is_black {
                break;
            }
            let scatterer = Scatterer::new(self, &surface, -direction);
            let choices = sampler.draw();
            if scatterer.is_rough() {
                let direct = throughput * self.direct(&surface, &scatterer, sampler.draw());
                roulette.begin(direct.mean(), throughput.max_channel(), &scatterer);
                sum += direct;
            }
            let chance = roulette.chance(bounce, throughput.max_channel(), &scatterer);
            if choices[3] >= chance {
                break;
            }
            let Some(step) = scatterer.step(choices) else {
                break;
            };
            throughput = throughput * step.weight / chance;
            if !step.passed {
                scattered = step
                    .density
                    .map(|density| (surface.point, self.choice(&scatterer), density));
                bounce += 1;
            }
            (from, origin, direction) = (surface.point, surface.triangle, step.direction);
        }
        sum
    }

    /// How lights are chosen at a surface.
    fn choice<'a>(&'a self, scatterer: &Scatterer<'a>) -> &'a Choice {
        scatterer
            .place()
            .map_or(self.lights.by_power(), |place| &place.lights)
    }

    /// Irradiance from a point on a light [mean over channels].
    fn irradiance(
        &self,
        choice: &Choice,
        point: Vec3,
        normal: Vec3,
        triangle: u32,
        at: [f32; 4],
    ) -> f32 {
        let Some(light) = self.lights.sample(choice, point, at) else {
            return 0.0;
        };
        let cosine = normal.dot(light.direction).max(0.0);
        let passed =
            self.shadows
                .strict_transmittance(point, light.point, [triangle, light.triangle]);
        (passed * light.irradiance).mean() * cosine
    }

    /// Light from a point on a light and reflected.
    fn direct(&self, surface: &Surface, scatterer: &Scatterer<'_>, at: [f32; 4]) -> Rgb {
        let Some(light) = self
            .lights
            .sample(self.choice(scatterer), surface.point, at)
        else {
            return Rgb::BLACK;
        };
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 {
            return Rgb::BLACK;
        }
        let reflected = scatterer.eval(light.direction) * cosine;
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
            power_heuristic(density, scatterer.density(light.direction))
        });
        reflected * passed * light.irradiance * share
    }
}

/// Weight of a sample whose density is `own` when another way would have had `other` (Veach 1997, chapter 9: the power
/// heuristic, β = 2).
fn power_heuristic(own: f32, other: f32) -> f32 {
    if own == f32::INFINITY {
        return 1.0;
    }
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}
