//! What part of the light that leaves surfaces leaves the scene as well, by rays of its own.

use super::Prepared;
use crate::geometry::sampling::{cosine_direction, sphere_direction};
use crate::hierarchy::{Hierarchy, NodeId};
use crate::radiometry::Rgb;
use crate::transport::exitant::Exitant;
use crate::transport::visibility::NO_PATCH;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Parts of some light, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Escape {
    /// The part that leaves the scene.
    pub share: DVec3,
    /// Its standard deviation.
    pub deviation: DVec3,
    /// The part that clear glass absorbs, or a side that light is taken not to reach.
    pub taken: DVec3,
}

/// Rays that are summed on one thread.
const CHUNK: u32 = 4096;

/// Rays slip through edges where faces meet, about one in a million: one that escapes is confirmed by another that
/// goes this far beside it [rad].
const BESIDE: f32 = 1e-4;

/// Follows `rays` rays, chosen in proportion to power, from all leaves that `exitant` has light for, and from
/// `point_lights`.
pub(super) fn escape(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    exitant: &Exitant,
    point_lights: &[(Vec3, Rgb)],
    rays: u32,
) -> Escape {
    let is_sender = |id: &NodeId| {
        hierarchy.is_leaf(*id) && exitant.power.get(*id as usize).is_some_and(|&p| p > 0.0)
    };
    let leaves: Vec<NodeId> = hierarchy
        .elements
        .iter()
        .map(|e| e.node)
        .filter(is_sender)
        .collect();
    let of_leaf = leaves
        .iter()
        .map(|&id| f64::from(exitant.power[id as usize]));
    let of_light = point_lights
        .iter()
        .map(|light| 4.0 * PI * f64::from(light.1.mean()));
    let mut total = 0.0;
    let until: Vec<f64> = of_leaf
        .chain(of_light)
        .map(|power| {
            total += power;
            total
        })
        .collect();
    if total <= 0.0 {
        return Escape::default();
    }
    // Light of one ray, what of it escapes, and what is taken.
    let follow = |ray: u32| -> [Rgb; 3] {
        // Roberts' sequence: multiples of the powers of a root of x⁵ = x + 1.
        let u = |step: f64| (0.5 + f64::from(ray) * step).fract() as f32;
        let at = (f64::from(ray) + 0.5) / f64::from(rays) * total;
        let source = until.partition_point(|&end| end <= at).min(until.len() - 1);
        let own = until[source] - source.checked_sub(1).map_or(0.0, |before| until[before]);
        let direction = Vec2::new(u(0.628_706_7), u(0.538_597_3));
        match leaves.get(source) {
            Some(&id) => {
                let node = hierarchy.node(id);
                let element = &hierarchy.elements[node.element as usize];
                let point = Vec2::new(u(0.856_674_9), u(0.733_891_9));
                let from = element.point(point);
                let direction = cosine_direction(element.normal, direction);
                let mean = own / (PI * f64::from(node.area));
                let light = exitant.towards(id, direction) / mean as f32;
                let escaped = passed(prepared, from, direction, element.patch);
                let left = left(prepared, from, direction, element.patch, escaped);
                [light, light * escaped, light * (Rgb::WHITE - left)]
            }
            None => {
                let (from, intensity) = point_lights[source - leaves.len()];
                let direction = sphere_direction(direction);
                let light = intensity / intensity.mean();
                let escaped = passed(prepared, from, direction, NO_PATCH);
                let left = left(prepared, from, direction, NO_PATCH, escaped);
                [light, light * escaped, light * (Rgb::WHITE - left)]
            }
        }
    };
    let add = |a: [DVec3; 3], b: [DVec3; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let sums: Vec<[DVec3; 3]> = (0..rays.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK..rays.min((chunk + 1) * CHUNK);
            range
                .map(|ray| follow(ray).map(|light| light.to_dvec3()))
                .fold([DVec3::ZERO; 3], add)
        })
        .collect();
    let [sent, escaped, taken] = sums.into_iter().fold([DVec3::ZERO; 3], add);
    let part = |light: DVec3| {
        let of_channel = |c: usize| {
            if sent[c] > 0.0 {
                light[c] / sent[c]
            } else {
                0.0
            }
        };
        DVec3::new(of_channel(0), of_channel(1), of_channel(2))
    };
    let share = part(escaped);
    let variance = (share * (DVec3::ONE - share)).max(DVec3::ZERO) / f64::from(rays);
    let deviation = variance.map(f64::sqrt);
    // What a handful of rays say is not told from none.
    let is_some = share.cmpgt(3.0 * deviation);
    Escape {
        share: DVec3::select(is_some, share, DVec3::ZERO),
        deviation: DVec3::select(is_some, deviation, DVec3::ZERO),
        taken: part(taken),
    }
}

fn passed(prepared: &Prepared, from: Vec3, direction: Vec3, origin: u32) -> Rgb {
    let passed = prepared.occluders.escape(from, direction, origin);
    if passed.is_black() {
        return passed;
    }
    let beside = (direction + direction.any_orthonormal_vector() * BESIDE).normalize();
    passed.min(prepared.occluders.escape(from, beside, origin))
}

/// What of the light of a ray is left after the glass on its way to where it ends, if light is known to reach that;
/// `escaped`: what leaves the scene.
fn left(prepared: &Prepared, from: Vec3, direction: Vec3, origin: u32, escaped: Rgb) -> Rgb {
    let occluders = &prepared.occluders;
    let hit = occluders.nearest_hit(from, direction, origin);
    let is_dark = hit.is_some_and(|hit| {
        let (patch, side) = (hit.patch as usize, usize::from(hit.back));
        !prepared.lit[patch][side].lit && !prepared.covered[patch][side]
    });
    match hit {
        _ if is_dark => Rgb::BLACK,
        _ if prepared.glass.is_empty() => Rgb::WHITE,
        Some(hit) => {
            let to = from + direction * hit.distance;
            occluders.strict_transmittance(from, to, [origin, hit.patch])
        }
        None => escaped,
    }
}
