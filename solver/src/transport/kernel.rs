//! How the light of a sender varies over a receiver: as from a point while it is far, by its exact form factor where it
//! is near.

use crate::transport::link::Sender;
use glam::Vec3;

/// A place on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
}

/// Which form a sender's kernel takes for a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kernel {
    /// cos θs / d², of clusters 1 / d².
    Point,
    /// Vector irradiance of the polygon.
    Polygon,
}

/// A point stands for a sender while the radii of both ends together are this share of their distance.
const POINT_LIKE: f32 = 0.5;

impl Kernel {
    /// Of `sender` over a receiver.
    pub(super) fn new(sender: &Sender, centre: Vec3, radius: f32) -> Self {
        let is_far = sender.radius + radius <= POINT_LIKE * centre.distance(sender.centre);
        if is_far || sender.polygon.is_none() {
            Self::Point
        } else {
            Self::Polygon
        }
    }

    /// Vector towards the sender; its length is in proportion to the normal irradiance at a place.
    pub(super) fn at(self, sender: &Sender, place: &Place) -> Vec3 {
        match (self, &sender.polygon) {
            (Self::Polygon, Some(polygon)) => {
                polygon.vector_irradiance(place.position, Some(place.normal))
            }
            _ => {
                let offset = sender.centre - place.position;
                let squared = offset.length_squared();
                if squared <= 0.0 {
                    return Vec3::ZERO;
                }
                let direction = offset / squared.sqrt();
                let cosine = if sender.polygon.is_some() {
                    -sender.normal.dot(direction)
                } else {
                    1.0
                };
                direction * (cosine.max(0.0) / squared)
            }
        }
    }
}
