//! Links from point lights: exact but for what hides them.

use crate::hierarchy::NONE;
use crate::radiometry::Rgb;
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Receiver, SenderId};
use crate::transport::propagate::{Outcome, POINT_LIGHTS, Propagation};
use glam::{Vec2, Vec3};

impl Propagation<'_> {
    /// The link from a point light: E⊥ = I/d², split while distance or visibility vary over the receiver.
    pub(super) fn connect_point_light(
        &self,
        receiver: &Receiver,
        light: usize,
        limit: f32,
        can_split: bool,
        outcome: &mut Outcome,
    ) {
        let (position, intensity) = self.environment.point_lights[light];
        let offset = position - receiver.centre;
        let distance = offset.length();
        if let Some(normal) = receiver.normal
            && offset.dot(normal) <= 0.0
        {
            return;
        }
        let near = (distance - receiver.radius).max(0.0);
        let high = intensity.mean() / (near * near);
        let low = intensity.mean() / (distance + receiver.radius).powi(2);
        let turned = high * (receiver.radius / distance);
        let link = SenderId::whole(POINT_LIGHTS + light as u32);
        if (high - low + turned > limit || near == 0.0) && can_split {
            return outcome.refined.push(link);
        }
        if distance == 0.0 {
            return;
        }
        let side = self.accuracy.strata.along(1.0);
        let (mut sum, mut weights, mut vector) = (Rgb::BLACK, 0.0, Vec3::ZERO);
        let (mut least, mut most) = (f32::INFINITY, 0.0f32);
        for ray in 0..side * side {
            let (x, y) = ((ray % side) as f32 + 0.5, (ray / side) as f32 + 0.5);
            let from = match &receiver.polygon {
                Some(polygon) => {
                    let at = Vec2::new(x, y) / side as f32;
                    polygon.point(receiver.exposed.point(at))
                }
                None => receiver.centre,
            };
            let passed =
                self.environment
                    .occluders
                    .transmittance(from, position, [receiver.patch, NONE]);
            outcome.stats.rays += 1;
            least = least.min(passed.mean());
            most = most.max(passed.mean());
            // Distance and cosine differ over the receiver: their mean is what it gets.
            let towards = position - from;
            let squared = towards.length_squared();
            let direction = towards / squared.sqrt();
            let cosine = receiver.normal.map_or(1.0, |n| n.dot(direction));
            if squared > 0.0 && cosine > 0.0 {
                sum += passed * (cosine / squared);
                weights += cosine / squared;
                vector += direction * (passed.mean() / squared);
            }
        }
        if most > least && can_split && high > limit {
            return outcome.refined.push(link);
        }
        outcome.stats.links += 1;
        let direction = vector.normalize_or_zero();
        let cosine = receiver.normal.map_or(1.0, |n| n.dot(direction));
        if sum.is_black() || cosine <= 0.0 {
            return;
        }
        // However near: what a polygon gets is its solid angle.
        let mean = match &receiver.polygon {
            Some(polygon) => polygon.solid_angle(position) / polygon.vector_area().length(),
            None => weights / (side * side) as f32,
        };
        outcome.samples.push(IlluminationSample {
            direction,
            irradiance: intensity * sum * (mean / (weights * cosine)),
            spread: 0.0,
            parallax: None,
        });
    }
}
