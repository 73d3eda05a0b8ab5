//! What a surface does with light: the choice of where a path goes on, and its density.

use super::PathTracer;
use super::guide::{Directed, Place};
use super::surface::Surface;
use crate::brdf::{Lobe, reflect};
use crate::geometry::sampling::cosine_direction;
use crate::radiometry::Rgb;
use crate::scene::{Gloss, Material};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Share of the diffuse paths that go where light is known to come from.
const GUIDED: f32 = 0.6;

/// What a material does with light.
pub(super) struct Scattering {
    diffuse: Rgb,
    lobe: Option<Lobe>,
    /// Share that a perfect mirror reflects.
    mirror: Rgb,
    /// Share that passes straight.
    clear: Rgb,
}

impl Scattering {
    pub(super) fn of(material: &Material) -> Self {
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
}

impl Scattering {
    /// Its lobe, perfect mirrors aside.
    pub(super) fn lobe(&self) -> Option<&Lobe> {
        self.lobe.as_ref()
    }
}

/// Where a path goes on.
pub(super) struct Step {
    /// Unit direction.
    pub(super) direction: Vec3,
    /// BRDF times cosine over density.
    pub(super) weight: Rgb,
    /// Density of the direction [sr⁻¹]; `None` for mirrors.
    pub(super) density: Option<f32>,
    /// It passed straight: it left the surface on the other side, and is no scattering.
    pub(super) passed: bool,
}

/// Ways of scattering, by [`Scatterer::shares`].
const WAYS: usize = 5;

/// A point of a surface, seen along one direction.
pub(super) struct Scatterer<'a> {
    material: &'a Scattering,
    place: Option<&'a Place>,
    guide: Option<Directed<'a>>,
    normal: Vec3,
    wo: Vec3,
    /// How often each way is chosen: diffuse, guided, lobe, mirror, straight on. Their sum is 1, or 0 for black.
    shares: [f32; WAYS],
    albedo: f32,
}

impl<'a> Scatterer<'a> {
    /// `wo`: where the light goes, unit.
    pub(super) fn new(tracer: &'a PathTracer, surface: &Surface, wo: Vec3) -> Self {
        let material = &tracer.scattering[surface.material as usize];
        let lobe = material.lobe.as_ref().map_or(0.0, |lobe| {
            lobe.specular.mean() * lobe.albedo(surface.normal.dot(wo))
        });
        let diffuse = material.diffuse.mean();
        let place = tracer.guide.at(surface.point, surface.normal);
        let guided = if place.is_some() {
            GUIDED * diffuse
        } else {
            0.0
        };
        let (mirror, clear) = (material.mirror.mean(), material.clear.mean());
        let shares = [diffuse - guided, guided, lobe, mirror, clear];
        let whole: f32 = shares.iter().sum();
        let per_whole = if whole > 0.0 { 1.0 / whole } else { 0.0 };
        Self {
            material,
            place,
            guide: place
                .filter(|_| guided > 0.0)
                .map(|place| tracer.guide.directed(place, surface.point)),
            normal: surface.normal,
            wo,
            shares: shares.map(|share| share * per_whole),
            albedo: whole,
        }
    }

    /// Light from single points or directions is reflected: not by perfect mirrors alone.
    pub(super) fn is_rough(&self) -> bool {
        self.shares[..3].iter().any(|&share| share > 0.0)
    }

    /// Share of what it scatters that it scatters evenly.
    pub(super) fn diffuse_share(&self) -> f32 {
        self.shares[0] + self.shares[1]
    }

    /// Share of the light that it scatters [mean over channels].
    pub(super) fn albedo(&self) -> f32 {
        self.albedo
    }

    /// What is known about light here.
    pub(super) fn place(&self) -> Option<&'a Place> {
        self.place
    }

    /// BRDF for light from `wi`, which leaves the surface [sr⁻¹].
    pub(super) fn eval(&self, wi: Vec3) -> Rgb {
        let diffuse = self.material.diffuse * FRAC_1_PI;
        match &self.material.lobe {
            Some(lobe) => diffuse + lobe.specular * lobe.eval(self.normal, wi, self.wo),
            None => diffuse,
        }
    }

    /// Density with which [`Self::step`] gives `wi`, mirrors aside [sr⁻¹].
    pub(super) fn density(&self, wi: Vec3) -> f32 {
        let [diffuse, guided, lobe, ..] = self.shares;
        let mut density = diffuse * self.normal.dot(wi).max(0.0) * FRAC_1_PI;
        if let Some(guide) = &self.guide {
            density += guided * guide.density(wi);
        }
        if let Some(shape) = &self.material.lobe {
            density += lobe * shape.density(self.normal, self.wo, wi);
        }
        density
    }

    /// Chooses where the light came from by three numbers; `None` when it came from nowhere.
    pub(super) fn step(&self, choices: [f32; 4]) -> Option<Step> {
        let mut left = choices[0];
        let chosen = self.shares.iter().position(|&share| {
            let is_here = left < share;
            left -= share;
            is_here
        })?;
        let at = Vec2::new(choices[1], choices[2]);
        let straight = |direction: Vec3, colour: Rgb, passed: bool| Step {
            direction,
            weight: colour / self.shares[chosen],
            density: None,
            passed,
        };
        let direction = match chosen {
            0 => cosine_direction(self.normal, at),
            1 => self.guide.as_ref()?.sample(at)?,
            2 => self
                .material
                .lobe
                .as_ref()?
                .sample(self.normal, self.wo, at),
            3 => {
                let direction = reflect(self.normal, self.wo);
                return Some(straight(direction, self.material.mirror, false));
            }
            _ => return Some(straight(-self.wo, self.material.clear, true)),
        };
        let cosine = self.normal.dot(direction);
        if cosine <= 0.0 {
            return None;
        }
        let density = self.density(direction);
        (density > 0.0).then(|| Step {
            direction,
            weight: self.eval(direction) * (cosine / density),
            density: Some(density),
            passed: false,
        })
    }
}
