//! Small things that reflect much light: paths look at them from wherever they are.
//!
//! What [`super::directions`] learns holds for a place as a whole; nearby and sharp, a reflector is seen elsewhere from
//! each of its points. A cone around it is exact.

use super::PathTracer;
use crate::geometry::sampling::about;
use crate::scene::Gloss;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Half of the widest reflector, at most [normalised].
const MOST_RADIUS: f32 = 0.125;
/// Roughest reflector: half-width of its lobe [rad].
const ROUGHEST: f32 = 0.3;
/// Share of all scattered photons that a reflector sends, at least.
const LEAST_SHARE: f32 = 0.05;

/// A sphere around the surfaces of one material.
#[derive(Clone, Copy)]
struct Reflector {
    centre: Vec3,
    radius: f32,
}

/// The cone in which it is seen: its axis, and one minus the cosine of its half-angle.
struct Cone {
    axis: Vec3,
    height: f32,
}

impl Reflector {
    /// `None` from within.
    fn seen_from(self, point: Vec3) -> Option<Cone> {
        let offset = self.centre - point;
        let squared = offset.length_squared();
        let sine_squared = self.radius * self.radius / squared;
        (sine_squared < 1.0).then(|| Cone {
            axis: offset / squared.sqrt(),
            // Without the difference of near numbers.
            height: sine_squared / (1.0 + (1.0 - sine_squared).sqrt()),
        })
    }
}

/// All that matter.
#[derive(Default)]
pub(super) struct Reflectors {
    all: Vec<Reflector>,
}

impl Reflectors {
    /// Chosen by how many photons went on from each material.
    pub(super) fn of(tracer: &PathTracer, sent: &[u32]) -> Self {
        let whole: u32 = sent.iter().sum();
        let matters = |&(material, &sent): &(usize, &u32)| {
            sent as f32 >= LEAST_SHARE * whole as f32
                && sent > 0
                && match &tracer.scattering[material].lobe() {
                    Some(lobe) => lobe.half_width < ROUGHEST,
                    None => tracer.frame.materials[material].gloss != Gloss::None,
                }
        };
        let sphere = |(material, _): (usize, &u32)| {
            let own = tracer
                .triangles
                .iter()
                .filter(|t| t.material as usize == material);
            let points = own.flat_map(|t| t.points.map(|p| tracer.frame.points[p as usize]));
            let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
            Reflector {
                centre: (low + high) * 0.5,
                radius: (high - low).length() * 0.5,
            }
        };
        let all = sent.iter().enumerate().filter(matters).map(sphere);
        Self {
            all: all
                .filter(|reflector| reflector.radius <= MOST_RADIUS)
                .collect(),
        }
    }

    /// None of them is to be seen from `point`.
    pub(super) fn is_empty_from(&self, point: Vec3) -> bool {
        self.all.iter().all(|r| r.seen_from(point).is_none())
    }

    /// A direction from `point` to one of them.
    pub(super) fn sample(&self, point: Vec3, at: Vec2) -> Option<Vec3> {
        let scaled = at.x * self.all.len() as f32;
        let chosen = self.all.get(scaled as usize)?;
        let cone = chosen.seen_from(point)?;
        let fall = cone.height * scaled.fract();
        Some(about(
            cone.axis,
            ((fall * (2.0 - fall)).sqrt(), 1.0 - fall),
            at.y,
        ))
    }

    /// Density of [`Self::sample`] [sr⁻¹].
    pub(super) fn density(&self, point: Vec3, direction: Vec3) -> f32 {
        let one = |reflector: &Reflector| match reflector.seen_from(point) {
            Some(cone) if (cone.axis - direction).length_squared() * 0.5 <= cone.height => {
                1.0 / (TAU * cone.height)
            }
            _ => 0.0,
        };
        self.all.iter().map(one).sum::<f32>() / self.all.len().max(1) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sampling::spread;

    #[test]
    fn samples_lie_in_the_cone_and_have_its_density() {
        let reflector = |x, radius| Reflector {
            centre: Vec3::new(x, 0.2, 0.1),
            radius,
        };
        let both = Reflectors {
            all: vec![reflector(0.3, 0.1), reflector(-0.2, 1e-3)],
        };
        let point = Vec3::new(0.1, -0.3, 0.0);
        let mut shares = [0.0f64; 2];
        const COUNT: u32 = 4096;
        for i in 0..COUNT {
            let direction = both.sample(point, spread(i)).expect("outside of both");
            assert!((direction.length() - 1.0).abs() < 1e-5);
            let density = both.density(point, direction * (1.0 - 1e-6));
            let which = usize::from(direction.x < 0.0);
            let cone = both.all[which].seen_from(point).expect("outside");
            // Rounding may lead across the rim of the narrow one.
            if density > 0.0 {
                let solid_angle = TAU * cone.height;
                assert!((density * solid_angle - 0.5).abs() < 1e-3, "{density}");
                shares[which] += 1.0 / f64::from(COUNT);
            }
        }
        assert!(
            shares.iter().all(|share| (share - 0.5).abs() < 0.02),
            "{shares:?}"
        );
        assert!(both.sample(Vec3::new(0.3, 0.2, 0.1), Vec2::ZERO).is_none());
    }
}
