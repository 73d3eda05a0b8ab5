//! The illumination sample of a link as if nothing stood between its ends.

use crate::geometry::Polygon;
use crate::hierarchy::exposed::Exposed;
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::illumination::{IlluminationSample, Parallax};
use crate::transport::kernel::{Kernel, is_close, is_reciprocal, over, transfer};
use crate::transport::link::{Receiver, Sender};
use crate::transport::sent::{mean_of_all, mean_radiance, most_sent};
use glam::Vec3;
use std::f32::consts::PI;

/// A point stands for a sending cluster while the radii of both ends together are this share of their distance.
const CLUSTER_LIKE: f32 = 0.9;
/// The light of a polygon may be said to leave from one point of it while the radii of both ends together are this
/// share of their distance.
pub(super) const SHIFTED: f32 = 0.5;
/// Two elements make a narrow gap when one rises above the other's plane by less than this share of its radius.
const NARROW: f32 = 0.25;
/// One point stands for a cluster while its radius is this share of the distance; wider ones take two along each axis.
const WIDE: f32 = 0.2;
/// Two points at this share of half a length integrate cubics over it (Gauss): 1/√3.
const GAUSS: f32 = 0.577_350_3;
/// Cosines below this change too fast to be told from one sample.
const GRAZING: f32 = 0.05;

/// The sample of a link as if nothing stood between.
///
/// Elements send by their exact form factor to a few points of the receiver; clusters by intensity over distance
/// squared. Where radiance has directions, its mean over pairs of points of both ends stands for the whole cone, and no
/// more than the sender's whole power arrives.
pub(super) fn unoccluded_sample(
    receiver: &Receiver,
    sender: &Sender,
    exitant: &Exitant,
) -> Option<IlluminationSample> {
    sample(receiver, sender, exitant, None)?.sample
}

/// What a point of one end sees of the other: its visible vector irradiance [sr], `None` when that is too costly to
/// know.
pub(super) type Eye<'a> = &'a dyn Fn(Vec3) -> Option<Vec3>;

/// What the ends of a link see of each other.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    /// From points of the receiver.
    pub(super) of_sender: Eye<'a>,
    /// From points of the sender, unless another surface in the same place sends instead of it.
    pub(super) of_receiver: Option<Eye<'a>>,
}

/// A sample of what is seen of a sender.
pub(super) struct Seen {
    /// `None` when nothing arrives.
    pub(super) sample: Option<IlluminationSample>,
    /// By how much irradiance differs over the receiver because of what hides the sender [W·m⁻², mean over channels].
    pub(super) contrast: f32,
}

impl Seen {
    /// Nothing hides anything.
    pub(super) fn all(sample: Option<IlluminationSample>) -> Self {
        Self {
            sample,
            contrast: 0.0,
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
    let directional = exitant.distribution[node].is_some();
    // More light leaves from one side of it: to first order, it leaves from elsewhere.
    let is_uneven = !directional
        && sender.id.is_whole()
        && exitant.centre[node] != sender.centre
        && sender.radius + receiver.radius < SHIFTED * distance;
    // Across a narrow gap each point sees what is opposite, from all around.
    let is_gap = is_gap(receiver, sender);
    let in_gap = if is_gap { 2 } else { 0 };
    let directed = match directional && sender.polygon.is_some() {
        true if is_gap => mean_of_all(sender, exitant),
        true => mean_radiance(receiver, sender, exitant),
        false => Rgb::BLACK,
    };
    // Unit radiance (intensity, of clusters) as a vector that points towards the sender, and what is sent.
    let from_one_point = |point: Vec3| -> (Vec3, Rgb) {
        let Some(polygon) = &sender.polygon else {
            let offset = exitant.centre[node] - point;
            let near = offset.length();
            let intensity = exitant.towards(sender.id.node, -offset / near);
            return (offset / (near * near * near), intensity);
        };
        let mut vector = polygon.vector_irradiance(point, receiver.normal);
        if is_uneven {
            vector += shift(sender, exitant.centre[node], point);
        }
        if !directional {
            return (vector, exitant.diffuse[node]);
        }
        (vector, directed)
    };
    let mut sum = Vec3::ZERO;
    let mut radiance = Rgb::BLACK;
    let mut weight = 0.0;
    let mut unoccluded = 0.0;
    let mut points = 0;
    let mut share = (1.0f32, 0.0f32);
    let mut strongest = 0.0f32;
    let mut is_known = true;
    let strength_of = |vector: Vec3| receiver.normal.map_or(vector.length(), |n| n.dot(vector));
    let mut from_point = |point: Vec3| {
        let (whole, sent) = from_one_point(point);
        points += 1;
        let mut strength = strength_of(whole);
        if strength <= 0.0 {
            return;
        }
        unoccluded += strength;
        let mut vector = whole;
        if let Some(view) = view {
            let Some(visible) = (view.of_sender)(point) else {
                is_known = false;
                return;
            };
            let part = strength_of(visible).clamp(0.0, strength);
            strongest = strongest.max(strength * sent.mean());
            share = (share.0.min(part / strength), share.1.max(part / strength));
            (vector, strength) = (visible, part);
        }
        sum += vector;
        radiance += sent * strength;
        weight += strength;
    };
    match (&receiver.polygon, &sender.polygon, receiver.normal) {
        (None, ..) if receiver.radius <= WIDE * distance => from_point(receiver.centre),
        (None, ..) => {
            let centre = 0.5 * (receiver.lower + receiver.upper);
            let half = 0.5 * (receiver.upper - receiver.lower) * GAUSS;
            for corner in 0..8 {
                let sign = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                from_point(centre + half * Vec3::new(sign(0), sign(1), sign(2)));
            }
        }
        (Some(receiving), Some(sending), Some(normal))
            if !directional
                && is_reciprocal(receiver, sender)
                && receiver.exposed == Exposed::ALL
                && view.is_none_or(|view| view.of_receiver.is_some()) =>
        {
            // The mean over the receiver by what a smaller sender sees of it: A_s F_sr = A_r F_rs.
            let per_area = sender.area / receiving.vector_area().length();
            let sent = from_one_point(receiver.centre).1;
            over(sending, in_gap, &mut |point| {
                points += 1;
                let whole = receiving.vector_irradiance(point, Some(sender.normal));
                let strength = whole.dot(sender.normal) * per_area;
                if strength <= 0.0 {
                    return;
                }
                unoccluded += strength;
                let mut part = strength;
                let mut direction = -whole;
                if let Some(eye) = view.and_then(|view| view.of_receiver) {
                    let Some(visible) = eye(point) else {
                        is_known = false;
                        return;
                    };
                    part = (visible.dot(sender.normal) * per_area).clamp(0.0, strength);
                    direction = -visible;
                    strongest = strongest.max(strength * sent.mean());
                    // Half hidden from here: a shadow runs through the receiver.
                    let seen = part / strength;
                    share = (share.0.min(seen), share.1.max(2.0 * seen.min(1.0 - seen)));
                }
                let cosine = direction.dot(normal);
                if part > 0.0 && cosine > 0.0 {
                    sum += direction * (part / cosine);
                    radiance += sent * part;
                    weight += part;
                }
            });
        }
        (Some(receiving), ..) => {
            // Far links see one distance, near ones are averaged.
            if sine < 0.1 && view.is_none() {
                from_point(receiving.centre());
            } else {
                let close = u32::from(is_close(receiver, sender));
                receiver.points(receiving, close + in_gap, from_point);
            }
        }
    }
    if !is_known {
        return None;
    }
    let contrast = strongest * (share.1 - share.0).max(0.0);
    let nothing = Some(Seen {
        sample: None,
        contrast,
    });
    if weight <= 0.0 {
        return nothing;
    }
    let vector = sum / points as f32;
    let normal_irradiance = vector.length();
    let direction = vector / normal_irradiance;
    let irradiance = match most_sent(receiver, sender, exitant, unoccluded / points as f32) {
        Some(most) => limited(radiance / weight, most),
        None => radiance / weight,
    } * normal_irradiance;
    let spread = match sender.polygon {
        Some(_) => (normal_irradiance / PI).sqrt(),
        // A cluster fills about half of the sphere around it.
        None if receiver.normal.is_some() => 0.7 * sine,
        None => 0.7 * (sender.radius / distance).min(1.0),
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
    if !is_gap {
        sample.parallax = parallax(receiver, sender, &sample, (weight / unoccluded).min(1.0));
    }
    Some(Seen {
        sample: Some(sample),
        contrast,
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

/// How the sample changes over an element that is not beside the sender across a narrow gap; `None` where nothing is
/// known of that; the receiver sees the share `open` of the sender.
fn parallax(
    receiver: &Receiver,
    sender: &Sender,
    sample: &IlluminationSample,
    open: f32,
) -> Option<Parallax> {
    let normal = receiver.normal?;
    receiver.polygon?;
    let cosine = sample.direction.dot(normal);
    let reach = receiver.radius + sender.radius;
    let is_near_cluster =
        sender.polygon.is_none() && reach > CLUSTER_LIKE * receiver.centre.distance(sender.centre);
    if cosine < GRAZING || is_near_cluster {
        return None;
    }
    let kernel = Kernel::of(sender, receiver);
    let mean = transfer(sender, receiver, kernel).dot(normal);
    if mean <= 0.0 {
        return None;
    }
    Some(Parallax {
        sender: sender.id,
        kernel,
        scale: cosine / mean,
        open,
        least: None,
    })
}

/// True when two close elements face each other across a narrow gap: what they exchange is all in a few places, which
/// the points of a link and their visibility may not stand for.
pub(super) fn is_gap(receiver: &Receiver, sender: &Sender) -> bool {
    let (Some(receiving), Some(sending), Some(normal)) =
        (&receiver.polygon, &sender.polygon, receiver.normal)
    else {
        return false;
    };
    if !is_close(receiver, sender) {
        return false;
    }
    let height = |polygon: &Polygon, origin: Vec3, normal: Vec3| {
        let heights = polygon.corners().iter().map(|&c| (c - origin).dot(normal));
        heights.fold(0.0, f32::max)
    };
    let smaller = receiver.radius.min(sender.radius);
    height(sending, receiver.centre, normal) < NARROW * smaller
        || height(receiving, sender.centre, sender.normal) < NARROW * smaller
}
