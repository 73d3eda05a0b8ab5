//! What emits, and points on it chosen by power.

use super::surface::Surface;
use crate::hierarchy::NONE;
use crate::normalise::Normalised;
use crate::radiometry::Rgb;
use crate::scene::Triangle;
use glam::Vec3;
use std::f32::consts::PI;

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
    /// Sum of the shares of all lights up to this one.
    up_to: f64,
    /// Its share of the power of all lights.
    share: f32,
}

/// Everything that emits.
pub(super) struct Lights {
    lights: Vec<Light>,
    /// Per triangle: radiance of front and back.
    emission: Vec<Option<[Rgb; 2]>>,
    /// One over the power of all lights [mean over channels].
    per_power: f32,
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
        let mut emission = vec![None; triangles.len()];
        let mut power = 0.0f64;
        let mut add = |shape: Shape, emission: Rgb, own: f64| {
            power += own;
            lights.push(Light {
                shape,
                emission,
                up_to: power,
                share: own as f32,
            });
        };
        for (index, triangle) in triangles.iter().enumerate() {
            let material = &frame.materials[triangle.material as usize];
            if material.emission.is_black() {
                continue;
            }
            let [a, b, c] = triangle.points.map(|p| frame.points[p as usize]);
            let area = f64::from(0.5 * (b - a).cross(c - a).length());
            let own = f64::from(PI * material.emission.mean()) * area;
            if own <= 0.0 {
                continue;
            }
            let back = if material.emits_from_back {
                material.emission
            } else {
                Rgb::BLACK
            };
            emission[index] = Some([material.emission, back]);
            let sides = [[a, b - a, c - a], [a, c - a, b - a]];
            let count = if material.emits_from_back { 2 } else { 1 };
            for side in sides.into_iter().take(count) {
                add(Shape::Side(index as u32, side), material.emission, own);
            }
        }
        for &(position, intensity) in &frame.point_lights {
            let own = f64::from(4.0 * PI * intensity.mean());
            if own > 0.0 {
                add(Shape::Point(position), intensity, own);
            }
        }
        let per_power = if power > 0.0 { 1.0 / power } else { 0.0 };
        for light in &mut lights {
            light.up_to *= per_power;
            light.share *= per_power as f32;
        }
        Self {
            lights,
            emission,
            per_power: per_power as f32,
        }
    }

    /// Radiance that a surface emits towards where it is seen from, if any.
    pub(super) fn emission(&self, surface: &Surface) -> Option<Rgb> {
        let sides = self.emission[surface.triangle as usize]?;
        Some(sides[usize::from(surface.back)]).filter(|radiance| !radiance.is_black())
    }

    /// Density with which [`Self::sample`] would have chosen the direction from `from` to a point on a light with this
    /// radiance [sr⁻¹].
    pub(super) fn density(&self, surface: &Surface, emission: Rgb, from: Vec3) -> f32 {
        let offset = surface.point - from;
        let squared = offset.length_squared();
        let cosine = surface.front.dot(offset).abs() / squared.sqrt();
        PI * emission.mean() * self.per_power * squared / cosine
    }

    /// A point on a light, both chosen in proportion to power; `None` when it does not emit towards `from`.
    pub(super) fn sample(&self, from: Vec3, at: [f32; 4]) -> Option<Seen> {
        let chosen = f64::from(at[0]);
        let index = self.lights.partition_point(|light| light.up_to <= chosen);
        let light = self.lights.get(index).or(self.lights.last())?;
        let (triangle, [corner, ab, ac]) = match light.shape {
            Shape::Side(triangle, side) => (triangle, side),
            Shape::Point(point) => {
                let offset = point - from;
                let squared = offset.length_squared();
                return (squared > 0.0).then(|| Seen {
                    point,
                    direction: offset / squared.sqrt(),
                    triangle: NONE,
                    irradiance: light.emission / (squared * light.share),
                    density: None,
                });
            }
        };
        let root = at[1].sqrt();
        let point = corner + ab * (root * (1.0 - at[2])) + ac * (root * at[2]);
        let offset = point - from;
        let squared = offset.length_squared();
        let distance = squared.sqrt();
        let normal = ab.cross(ac).normalize();
        let cosine = -normal.dot(offset) / distance;
        let density = PI * light.emission.mean() * self.per_power * squared / cosine;
        (cosine > 0.0 && density > 0.0).then(|| Seen {
            point,
            direction: offset / distance,
            triangle,
            irradiance: light.emission / density,
            density: Some(density),
        })
    }
}
