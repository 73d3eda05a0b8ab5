//! Normalised coordinates: centred, scaled by powers of two to unit size and unit emission.
//!
//! Every step of the solver works on these, so no absolute length or radiance appears anywhere, and a scene or its
//! lights scaled by a power of two give bitwise the same numbers.

use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};
use glam::Vec3;

/// A scene in normalised coordinates, and the way back.
#[derive(Clone, Debug)]
pub struct Normalised {
    /// Positions, within ±0.5.
    pub points: Vec<Vec3>,
    /// Materials with normalised emission.
    pub materials: Vec<Material>,
    /// Point lights: position, intensity.
    pub point_lights: Vec<(Vec3, Rgb)>,
    centre: Vec3,
    /// Normalised length of one metre; a power of two.
    length: f32,
    /// Normalised radiance of one W/(sr m²); a power of two.
    radiance: f32,
}

/// The largest power of two not above `x`, for finite x > 0.
fn floor_power_of_two(x: f32) -> f32 {
    let exponent = x.to_bits() >> 23;
    if exponent == 0 {
        f32::MIN_POSITIVE
    } else {
        f32::from_bits(exponent << 23)
    }
}

impl Normalised {
    /// Normalises `scene`.
    pub fn new(scene: &Scene) -> Self {
        let (low, high) = scene.bounds();
        let centre = low * 0.5 + high * 0.5;
        let extent = (high - low).max_element();
        let length = 0.5 / floor_power_of_two(extent);
        let points = scene
            .points()
            .iter()
            .map(|&p| (p - centre) * length)
            .collect();
        let strongest = scene
            .materials()
            .iter()
            .map(|m| m.emission.max_channel())
            .chain(
                scene
                    .point_lights()
                    .iter()
                    .map(|l| (l.intensity * length * length).max_channel()),
            )
            .fold(0.0, f32::max);
        let radiance = if strongest > 0.0 {
            1.0 / floor_power_of_two(strongest)
        } else {
            1.0
        };
        let materials = scene
            .materials()
            .iter()
            .map(|m| Material {
                emission: m.emission * radiance,
                ..m.clone()
            })
            .collect();
        let point_lights = scene
            .point_lights()
            .iter()
            .map(|l| {
                (
                    (l.position - centre) * length,
                    l.intensity * (length * length) * radiance,
                )
            })
            .collect();
        Self {
            points,
            materials,
            point_lights,
            centre,
            length,
            radiance,
        }
    }

    /// The normalised coordinates of a position in metres.
    pub fn normalised(&self, position: Vec3) -> Vec3 {
        (position - self.centre) * self.length
    }

    /// A position in metres.
    pub fn position(&self, normalised: Vec3) -> Vec3 {
        normalised / self.length + self.centre
    }

    /// A radiance in W/(sr m²).
    pub fn radiance(&self, normalised: Rgb) -> Rgb {
        normalised / self.radiance
    }

    /// The factor from normalised radiance to W/(sr m²); a power of two.
    pub fn radiance_unit(&self) -> f32 {
        1.0 / self.radiance
    }

    /// A power in W.
    pub fn power(&self, normalised: f64) -> f64 {
        normalised / (f64::from(self.radiance) * f64::from(self.length) * f64::from(self.length))
    }
}
