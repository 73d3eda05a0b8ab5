//! Accepting a link: how much of the sender the receiver sees, and the sample that follows.

use crate::config::Visibility;
use crate::geometry::Polygon;
use crate::hierarchy::{Hierarchy, NodeId};
use crate::transport::illumination::IlluminationSample;
use crate::transport::link::{Bounds, Receiver, Sender};
use crate::transport::occlusion::{Geometry, MOST_CANDIDATES, Target};
use crate::transport::propagate::{LinkStats, Propagation};
use crate::transport::rays::Rays;
use crate::transport::sample::{SHIFTED, Seen, View, seen_sample, unoccluded_sample};
use crate::transport::shaft;
use glam::Vec3;
use std::time::Instant;

/// Links between elements with bounds below this share of what is accepted are weighed by rays.
const FAINT: f32 = 1.0 / 8.0;

/// Irradiance may vary over a receiver because of what hides a sender by this many times what is accepted.
const MIXED: f32 = 0.05;

/// Rays may differ on a link of this many times what is accepted.
const MIXED_RAYS: f32 = 4.0;

/// A partly hidden sender may be this share of what is accepted off because its radiance is uneven: such errors have
/// one sign and add up.
const UNEVEN: f32 = 0.03;

/// A link whose bounds are good enough.
pub(super) struct Link<'a> {
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) receiver_node: NodeId,
    pub(super) receiver: &'a Receiver,
    pub(super) sender: &'a Sender,
    pub(super) bounds: &'a Bounds,
    /// Accepted error of the irradiance [mean over channels].
    pub(super) limit: f32,
}

impl Link<'_> {
    /// No point of the receiver gets more than the bound, whatever is known of the part of it that light can reach.
    fn keep_below_bound(&self, sample: &mut IlluminationSample) {
        let cosine = self
            .receiver
            .normal
            .map_or(1.0, |normal| normal.dot(sample.direction));
        let irradiance = sample.irradiance.mean() * cosine;
        if irradiance > self.bounds.high {
            sample.irradiance *= self.bounds.high / irradiance;
        }
    }

    /// True when neither end is a cluster.
    pub(super) fn is_between_elements(&self) -> bool {
        self.sender.polygon.is_some() && self.receiver.polygon.is_some()
    }
}

/// What becomes of a link.
pub(super) enum Connection {
    /// It stays.
    Accepted {
        /// What arrives, if anything does.
        sample: Option<IlluminationSample>,
        /// Nothing stands between its ends.
        clear: bool,
    },
    /// Visibility varies more than a link as strong as this may hide.
    Mixed,
    /// The sender hides parts whose radiance is not like that of the others.
    Uneven,
}

impl Propagation<'_> {
    /// Weighs visibility, exactly between elements with little between them, otherwise by rays.
    pub(super) fn connect(&self, link: &Link<'_>, stats: &mut LinkStats) -> Connection {
        let started = Instant::now();
        let is_worth_it = self.accuracy.visibility == Visibility::Shafts
            && link.is_between_elements()
            && link.bounds.high > FAINT * link.limit;
        let exact = match &link.sender.polygon {
            Some(polygon) if is_worth_it => self.connect_exactly(link, polygon, stats),
            _ => None,
        };
        let mut connection = exact.unwrap_or_else(|| self.connect_by_rays(link, stats));
        if let Connection::Accepted {
            sample: Some(sample),
            ..
        } = &mut connection
        {
            link.keep_below_bound(sample);
        }
        stats.visibility += started.elapsed();
        connection
    }

    /// `None` when there is too much in between.
    fn connect_exactly(
        &self,
        link: &Link<'_>,
        polygon: &Polygon,
        stats: &mut LinkStats,
    ) -> Option<Connection> {
        let (receiver, sender) = (link.receiver, link.sender);
        let geometry = Geometry {
            tree: self.environment.tree,
            shapes: self.environment.shapes,
        };
        let between = shaft::occluders(receiver, sender, &geometry, MOST_CANDIDATES)?;
        let clear = between.is_empty();
        stats.clear_shafts += u64::from(clear);
        let visible = |point: Vec3| {
            let (normal, patch) = (sender.normal, sender.patch);
            match Target::new(polygon, normal, patch, point, receiver.normal) {
                Some(target) => geometry.visible(point, &target, &between),
                None => Some(Vec3::ZERO),
            }
        };
        let seen = if clear {
            Seen::all(unoccluded_sample(receiver, sender, self.exitant))
        } else {
            let of_receiver = |point: Vec3| {
                let shape = receiver.polygon.as_ref()?;
                let (normal, patch) = (receiver.normal?, receiver.patch);
                match Target::new(shape, normal, patch, point, Some(sender.normal)) {
                    Some(target) => geometry.visible(point, &target, &between),
                    None => Some(Vec3::ZERO),
                }
            };
            let is_covered = between
                .iter()
                .any(|&patch| geometry.is_in_plane(patch, sender.centre, sender.normal));
            let view = View {
                of_sender: &visible,
                of_receiver: (!is_covered).then_some(&of_receiver),
            };
            seen_sample(receiver, sender, self.exitant, view)?
        };
        if seen.contrast > MIXED * link.limit && self.is_refinable(link) {
            return Some(Connection::Mixed);
        }
        if self.is_uneven(link, polygon, &visible)? {
            return Some(Connection::Uneven);
        }
        Some(Connection::Accepted {
            sample: seen.sample,
            clear,
        })
    }

    /// True when the parts of a sender that are hidden, by others or by the receiver's horizon, may differ too much
    /// from those that are seen.
    fn is_uneven(
        &self,
        link: &Link<'_>,
        polygon: &Polygon,
        visible: &dyn Fn(Vec3) -> Option<Vec3>,
    ) -> Option<bool> {
        let (receiver, sender) = (link.receiver, link.sender);
        let id = sender.id.node;
        if !link.hierarchy.has_children_among(id, self.node_count) {
            return Some(false);
        }
        let whole = polygon.vector_irradiance(receiver.centre, None).length();
        if whole <= 0.0 {
            return Some(false);
        }
        // What light cannot reach is dark and not seen.
        let mut share =
            visible(receiver.centre)?.length() / (whole * sender.exposed_share(self.exitant));
        let distance = receiver.centre.distance(sender.centre);
        if receiver.radius + sender.radius >= SHIFTED * distance {
            // Its near half counts most.
            share = share.min(0.5);
        }
        let strength = whole * self.exitant.power[id as usize] / self.exitant.area[id as usize]
            * std::f32::consts::FRAC_1_PI;
        let uneven = self.exitant.unevenness(id, share);
        Some(strength * uneven > UNEVEN * link.limit)
    }

    fn connect_by_rays(&self, link: &Link<'_>, stats: &mut LinkStats) -> Connection {
        let rays = Rays {
            occluders: self.environment.occluders,
            exitant: self.exitant,
            hierarchy: link.hierarchy,
            receiver_node: link.receiver_node,
            seed: link.receiver_node,
            receiver: link.receiver,
            sender: link.sender,
        };
        let side = self.accuracy.strata.along(link.bounds.high / link.limit);
        let seen = rays.strata(side, stats);
        if seen.is_mixed() && link.bounds.high > MIXED_RAYS * link.limit && self.is_refinable(link)
        {
            return Connection::Mixed;
        }
        let transmittance = seen.transmittance();
        let sample = if transmittance.is_black() {
            None
        } else {
            unoccluded_sample(link.receiver, link.sender, self.exitant)
        };
        Connection::Accepted {
            sample: sample.map(|sample| sample.partly(transmittance, seen.open_of_exposed())),
            clear: false,
        }
    }

    fn is_refinable(&self, link: &Link<'_>) -> bool {
        link.receiver.polygon.is_none()
            || link.receiver.radius > self.least_radius(link.receiver.centre)
            || link.sender.can_refine()
                && link.sender.radius > self.least_radius(link.sender.centre)
    }
}
