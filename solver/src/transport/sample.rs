//! The illumination sample of a link as if nothing stood between its ends.

use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::{IlluminationSample, Parallax};
use crate::transport::kernel::{Kernel, Place};
use crate::transport::link::{Receiver, Sender};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A point stands for a sending cluster while the radii of both ends together are this share of their distance.
const CLUSTER_LIKE: f32 = 0.9;
/// The light of a polygon may be said to leave from one point of it while the radii of both ends together are this
/// share of their distance.
pub(super) const SHIFTED: f32 = 0.5;
/// Cosines below this change too fast to be told from one sample.
const GRAZING: f32 = 0.05;

/// The sample of a link as if nothing stood between.
///
/// Elements send by their exact form factor to a few points of the receiver; clusters by intensity over distance
/// squared. The radiance of the one direction between the centres stands for the whole cone of directions, but no
/// cone can carry more than the sender's whole power: a sharp lobe does not fill the view of a close receiver.
pub(super) fn unoccluded_sample(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
) -> Option<IlluminationSample> {
    sample(receiver, sender, exitant, None)?.sample
}

/// What a point sees of the sender: its visible vector irradiance [sr], `None` when that is too costly to know.
pub(super) type View<'a> = &'a dyn Fn(Vec3) -> Option<Vec3>;

/// A sample of what is seen of a sender.
pub(super) struct Seen {
    /// `None` when nothing arrives.
    pub(super) sample: Option<IlluminationSample>,
    /// Smallest and largest share that a point of the receiver sees of it.
    pub(super) share: (f32, f32),
}

impl Seen {
    /// Nothing hides anything.
    pub(super) fn all(sample: Option<IlluminationSample>) -> Self {
        Self {
            sample,
            share: (1.0, 1.0),
        }
    }
}

/// The sample of what the points of an element see of a polygon; `None` when the view of some point is too costly.
pub(super) fn seen_sample(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
    view: View<'_>,
) -> Option<Seen> {
    sample(receiver, sender, exitant, Some(view))
}

fn sample(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
    view: Option<View<'_>>,
) -> Option<Seen> {
    let offset = sender.centre - receiver.centre;
    let distance = offset.length();
    let node = sender.id.node as usize;
    // Sine of the half-angle of the cone of directions from the sender to the receiver.
    let sine = ((receiver.radius + sender.radius) / distance).min(1.0);
    let limited = |value: Rgb, most: f32| {
        let mean = value.mean();
        if mean > most {
            value * (most / mean)
        } else {
            value
        }
    };
    // More light leaves from one side of it: to first order, it leaves from elsewhere.
    let is_uneven = sender.id.is_whole()
        && exitant.centre[node] != sender.centre
        && sender.radius + receiver.radius < SHIFTED * distance;
    let directional = exitant.distribution[node].is_some();
    // Unit radiance (intensity, of clusters) as a vector that points towards the sender, and what is sent.
    let from_one_point = |point: Vec3| -> (Vec3, Rgb) {
        let Some(polygon) = &sender.polygon else {
            let offset = exitant.centre[node] - point;
            let near = offset.length();
            let solid_angle = TAU * (1.0 - (1.0 - sine * sine).max(0.0).sqrt());
            let intensity = exitant.towards(sender.id.node, -offset / near);
            return (
                offset / (near * near * near),
                limited(intensity, exitant.power[node] / solid_angle),
            );
        };
        let mut vector = polygon.vector_irradiance(point, receiver.normal);
        if is_uneven {
            vector += shift(sender, exitant.centre[node], point);
        }
        if !directional {
            return (vector, exitant.diffuse[node]);
        }
        let towards = (point - sender.centre).normalize_or(sender.normal);
        let cosine = towards.dot(sender.normal).max(sine);
        let exitance = exitant.power[node] / sender.node_area;
        let most = exitance / (PI * sine * sine * cosine);
        (
            vector,
            limited(exitant.towards(sender.id.node, towards), most),
        )
    };
    let mut sum = Vec3::ZERO;
    let mut radiance = Rgb::BLACK;
    let mut weight = 0.0;
    let mut points = 0;
    let mut share = (1.0f32, 0.0f32);
    let mut is_known = true;
    let strength_of = |vector: Vec3| receiver.normal.map_or(vector.length(), |n| n.dot(vector));
    let mut from_point = |point: Vec3| {
        let (whole, sent) = from_one_point(point);
        points += 1;
        let mut strength = strength_of(whole);
        if strength <= 0.0 {
            return;
        }
        let mut vector = whole;
        if let Some(view) = view {
            let Some(visible) = view(point) else {
                is_known = false;
                return;
            };
            let part = strength_of(visible).clamp(0.0, strength);
            share = (share.0.min(part / strength), share.1.max(part / strength));
            (vector, strength) = (visible, part);
        }
        sum += vector;
        radiance += sent * strength;
        weight += strength;
    };
    match &receiver.polygon {
        None => from_point(receiver.centre),
        Some(receiving) => {
            // Far links see one distance; near ones are averaged by Gaussian quadrature, touching ones over quarters.
            if sine < 0.1 && view.is_none() {
                from_point(receiving.centre());
            } else if sine < 0.6 {
                receiving.quadrature(&mut from_point);
            } else {
                for child in 0..4 {
                    receiving.child(child).quadrature(&mut from_point);
                }
            }
        }
    }
    if !is_known {
        return None;
    }
    let nothing = Some(Seen {
        sample: None,
        share,
    });
    if weight <= 0.0 {
        return nothing;
    }
    let vector = sum / points as f32;
    let normal_irradiance = vector.length();
    let direction = vector / normal_irradiance;
    let irradiance = radiance / weight * normal_irradiance;
    let spread = match sender.polygon {
        Some(_) => (normal_irradiance / PI).sqrt(),
        // A cluster fills about half of the sphere around it.
        None => 0.7 * sine,
    };
    if irradiance.is_black() {
        return nothing;
    }
    let mut sample = IlluminationSample {
        direction,
        irradiance,
        spread,
        parallax: None,
    };
    sample.parallax = parallax(receiver, sender, &sample);
    Some(Seen {
        sample: Some(sample),
        share,
    })
}

/// What a far polygon adds to its vector irradiance [sr] when its light leaves around `from` instead of its middle.
fn shift(sender: &Sender, from: Vec3, point: Vec3) -> Vec3 {
    let kernel = |at: Vec3| {
        let offset = at - point;
        let squared = offset.length_squared();
        offset * (-sender.normal.dot(offset)).max(0.0) / (squared * squared)
    };
    (kernel(from) - kernel(sender.centre)) * sender.area
}

/// How the sample changes over an element; `None` where nothing is known of that.
fn parallax(receiver: &Receiver, sender: &Sender, sample: &IlluminationSample) -> Option<Parallax> {
    let (shape, normal) = (receiver.polygon?, receiver.normal?);
    let cosine = sample.direction.dot(normal);
    let kernel = Kernel::new(sender, receiver.centre, receiver.radius);
    if cosine < GRAZING
        || sender.polygon.is_none()
            && receiver.radius + sender.radius
                > CLUSTER_LIKE * receiver.centre.distance(sender.centre)
    {
        return None;
    }
    let (mut sum, mut count) = (0.0, 0.0);
    shape.quadrature(|position| {
        let place = Place { position, normal };
        sum += kernel.at(sender, &place).dot(normal).max(0.0);
        count += 1.0;
    });
    let scale = cosine * count / sum;
    (sum > 0.0 && scale.is_finite()).then_some(Parallax {
        sender: sender.id,
        scale,
    })
}
