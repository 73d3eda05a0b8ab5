//! What a directional sender sends towards a receiver: its mean radiance over the cone of directions between them, and
//! the most that it can be.

use crate::geometry::sampling::spread;
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::kernel::over;
use crate::transport::link::{Receiver, Sender};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Pairs of points that meet a lobe as wide as the cone of directions that it is integrated over.
const PAIRS: f32 = 4.0;
/// Points of a sender that one point of a receiver looks at.
const MOST_PARTS: u32 = 4;
/// Points of a cluster, where one does not do.
const LEAST_POINTS: u32 = 4;
/// And not more.
const MOST_POINTS: u32 = 16;
/// A plain quadrature of a receiver meets this many.
const QUADRATURE: f32 = 4.0;

/// Mean radiance of a directional element towards a receiver [W·sr⁻¹·m⁻²], weighted as its light arrives, over as many pairs of
/// points of both as it takes to meet a lobe that is narrow against the cone of directions between them.
pub(super) fn mean_radiance(receiver: &Receiver, sender: &Sender, exitant: &Exitant) -> Rgb {
    let id = sender.id.node;
    let offset = receiver.centre - sender.centre;
    let in_the_middle = || exitant.towards(id, offset.normalize_or(sender.normal));
    // Links to vertices are refined until their radiance is one.
    let (Some(sending), true) = (&sender.polygon, receiver.radius > 0.0) else {
        return in_the_middle();
    };
    let sharpness = exitant.peak[id as usize] / exitant.mean_radiance(id);
    let wanted = |reach: f32, squared: f32| PAIRS * sharpness * (reach * reach / squared).min(1.0);
    let pairs = wanted(receiver.radius + sender.radius, offset.length_squared());
    if pairs < 2.0 && offset.dot(sender.normal) > 0.0 {
        return in_the_middle();
    }
    let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
    let mut first = 0;
    let mut from_point = |point: Vec3| {
        let vector = sending.vector_irradiance(point, receiver.normal);
        let strength = receiver.normal.map_or(vector.length(), |n| n.dot(vector));
        if strength > 0.0 {
            let squared = point.distance_squared(sender.centre);
            let parts = (wanted(sender.radius, squared) as u32).clamp(1, MOST_PARTS);
            sum += radiance_towards(point, sender, exitant, first..first + parts) * strength;
            weights += strength;
            first += parts;
        }
    };
    if let Some(receiving) = &receiver.polygon {
        over(receiving, u32::from(pairs > QUADRATURE), &mut from_point);
    } else {
        // A cluster is the disc of its radius that faces the sender.
        let (tangent, bitangent) = offset.normalize_or(sender.normal).any_orthonormal_pair();
        for i in 0..(pairs as u32).clamp(LEAST_POINTS, MOST_POINTS) {
            let at = spread(i);
            let (sine, cosine) = (TAU * at.y).sin_cos();
            let across = tangent * cosine + bitangent * sine;
            from_point(receiver.centre + across * (receiver.radius * at.x.sqrt()));
        }
    }
    if weights > 0.0 {
        sum / weights
    } else {
        in_the_middle()
    }
}

/// Mean radiance of an element over the cosine-weighted hemisphere [W·sr⁻¹·m⁻²], of the colour that it has straight
/// ahead.
pub(super) fn mean_of_all(sender: &Sender, exitant: &Exitant) -> Rgb {
    let mean = exitant.mean_radiance(sender.id.node);
    let ahead = exitant.towards(sender.id.node, sender.normal);
    if ahead.is_black() {
        Rgb::splat(mean)
    } else {
        ahead * (mean / ahead.mean())
    }
}

/// Radiance of a directional element towards a point, weighted as it arrives from `parts` of it.
fn radiance_towards(
    point: Vec3,
    sender: &Sender,
    exitant: &Exitant,
    parts: std::ops::Range<u32>,
) -> Rgb {
    let id = sender.id.node;
    let in_the_middle = || exitant.towards(id, (point - sender.centre).normalize_or(sender.normal));
    let Some(polygon) = sender.polygon.as_ref().filter(|_| parts.len() > 1) else {
        return in_the_middle();
    };
    let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
    for part in parts {
        let offset = point - polygon.point(spread(part));
        let squared = offset.length_squared();
        let cosine = offset.dot(sender.normal);
        if cosine > 0.0 {
            let weight = cosine / (squared * squared);
            sum += exitant.towards(id, offset / squared.sqrt()) * weight;
            weights += weight;
        }
    }
    if weights > 0.0 {
        sum / weights
    } else {
        in_the_middle()
    }
}

/// The most radiance (intensity, of clusters) [mean over channels] that a sender can have on average towards the
/// receiver, which it would light by `unoccluded` were its radiance (intensity) one: all of its power arrives. `None`
/// where its radiance is the same everywhere.
pub(super) fn most_sent(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
    unoccluded: f32,
) -> Option<f32> {
    let node = sender.id.node as usize;
    exitant.distribution[node].as_ref()?;
    let power = exitant.power[node] * sender.share;
    let over = |area: f32| power / (unoccluded * area);
    Some(match (&receiver.polygon, &sender.polygon) {
        (Some(shape), _) => over(shape.vector_area().length()),
        // A cluster's cross-section.
        (None, Some(_)) if receiver.radius > 0.0 => over(PI * receiver.radius * receiver.radius),
        // A vertex: no lobe of what is as large as the sender is brighter over its whole cross-section. What has no
        // lobe is as bright to a vertex right beside it as it is from afar.
        (None, Some(_)) => {
            over(PI * sender.radius * sender.radius).max(exitant.mean_radiance(sender.id.node))
        }
        // A cluster of senders: its intensity is one for the whole cone of directions between the two.
        (None, None) => {
            let reach = receiver.radius + sender.radius;
            over(PI * reach * reach)
        }
    })
}
