//! How the light of a sender varies over its receiver: as from a point while it is far, by exact form factors where it
//! is near. Without visibility; only ratios of it are used.

use crate::geometry::Polygon;
use crate::hierarchy::exposed::Exposed;
use crate::transport::link::{Receiver, Sender};
use glam::Vec3;

/// A point stands for a sender while the radii of both ends together are this share of their distance.
const POINT_LIKE: f32 = 0.4;

/// Ends are close when their radii together are this share of their distance.
const CLOSE: f32 = 0.6;

/// One point of a receiver stands for all of it while its radius is this share of the distance.
const SMALL: f32 = 0.06;

/// Which form the transfer takes: one for a receiver and all its parts, or their sum would not be that of the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The sender is a point.
    Point,
    /// Exact form factors.
    Polygon,
}

impl Kernel {
    /// Of a link.
    pub(super) fn of(sender: &Sender, receiver: &Receiver) -> Self {
        let distance = receiver.centre.distance(sender.centre);
        if sender.polygon.is_none() || sender.radius + receiver.radius <= POINT_LIKE * distance {
            Self::Point
        } else {
            Self::Polygon
        }
    }
}

/// Mean vector irradiance of a whole element from a sender with radiance (clusters: intensity) one. Its component
/// along the receiver's normal is a mean over the receiver; its direction is that to the sender.
pub(super) fn transfer(sender: &Sender, receiver: &Receiver, kernel: Kernel) -> Vec3 {
    let (Some(shape), Some(normal)) = (&receiver.polygon, receiver.normal) else {
        return Vec3::ZERO;
    };
    let distance = receiver.centre.distance(sender.centre);
    let is_small = receiver.radius < SMALL * distance;
    let mean = |at: &dyn Fn(Vec3) -> Vec3| {
        if is_small {
            return at(receiver.centre);
        }
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        receiver.points(shape, u32::from(is_close(receiver, sender)), |point| {
            sum += at(point);
            count += 1.0;
        });
        sum / count
    };
    match &sender.polygon {
        None => mean(&|point| from_point(sender, point)),
        Some(_) if kernel == Kernel::Point => mean(&|point| from_point(sender, point)),
        Some(polygon) if is_reciprocal(receiver, sender) && receiver.exposed == Exposed::ALL => {
            let mut sum = Vec3::ZERO;
            let mut count = 0.0;
            polygon.quadrature(|point| {
                let seen = shape.vector_irradiance(point, Some(sender.normal));
                let cosine = -seen.dot(normal);
                if cosine > 0.0 {
                    sum -= seen * (seen.dot(sender.normal) / cosine);
                }
                count += 1.0;
            });
            sum * (sender.area / (shape.vector_area().length() * count))
        }
        Some(polygon) => mean(&|point| polygon.vector_irradiance(point, Some(normal))),
    }
}

/// True when ends are so close that what one of them sees differs much over it.
pub(super) fn is_close(receiver: &Receiver, sender: &Sender) -> bool {
    receiver.radius + sender.radius > CLOSE * receiver.centre.distance(sender.centre)
}

/// True when a small sender stands close to a large receiver: the sender's points see it whole, while its own points
/// would miss the sender.
pub(super) fn is_reciprocal(receiver: &Receiver, sender: &Sender) -> bool {
    sender.radius < receiver.radius && is_close(receiver, sender)
}

/// Visits the points whose mean stands for a shape that is quartered so many times.
pub(super) fn over(shape: &Polygon, quartered: u32, visit: &mut impl FnMut(Vec3)) {
    if quartered == 0 {
        shape.quadrature(&mut *visit);
        return;
    }
    for child in 0..4 {
        over(&shape.child(child), quartered - 1, visit);
    }
}

/// A cos θs / d² towards the sender; 1 / d² for clusters.
fn from_point(sender: &Sender, point: Vec3) -> Vec3 {
    let offset = sender.centre - point;
    let squared = offset.length_squared();
    if squared <= 0.0 {
        return Vec3::ZERO;
    }
    let direction = offset / squared.sqrt();
    let strength = match sender.polygon {
        Some(_) => -sender.normal.dot(direction) * sender.area,
        None => 1.0,
    };
    direction * (strength.max(0.0) / squared)
}
