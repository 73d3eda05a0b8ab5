//! Questions for what stands on a part of a ray, and a record of those that a solve asks, for whoever wants to time them.

use crate::transport::visibility::NO_PATCH;
use glam::{Vec3, Vec3A};
use obvhs::ray::Ray;
use std::sync::{Mutex, PoisonError};

/// The tree misses what is nearer than 1e-4, whatever the scene: in coordinates of this many times the normalised ones
/// that is below rounding. A power of two.
pub(super) const SCALE: f32 = (1u32 << SCALE_EXPONENT) as f32;
pub(super) const SCALE_EXPONENT: u8 = 13;

/// A point in the coordinates of the tree.
pub(super) fn scaled(point: Vec3) -> Vec3A {
    (point * SCALE).into()
}

/// The part of a ray along unit `direction` between two distances.
pub(super) fn ray(from: Vec3, direction: Vec3, span: [f32; 2]) -> Ray {
    Ray::new(
        scaled(from),
        // The tree misses boxes along a direction that has a negative zero; plus zero it is none.
        (direction + Vec3::ZERO).into(),
        span[0] * SCALE,
        span[1] * SCALE,
    )
}

/// A question for what stands on a part of a ray, for those who want to time it.
#[derive(Clone, Copy)]
pub struct Query {
    /// In the coordinates of the tree.
    pub(super) ray: Ray,
    /// Patches that do not block.
    pub(super) ends: [u32; 2],
    /// From this distance on, patches after this one do not block.
    pub(super) end: Option<(f32, u32)>,
}

impl Query {
    /// What stands between two points, nearer to neither than a `gap` share of the way.
    pub fn between(from: Vec3, to: Vec3, gap: f32) -> Self {
        let (direction, length) = (to - from).normalize_and_length();
        Self {
            ray: ray(from, direction, [gap * length, (1.0 - gap) * length]),
            ends: [NO_PATCH; 2],
            end: None,
        }
    }

    /// Where the part begins, and the way to its end, normalised.
    pub fn part(&self) -> (Vec3, Vec3) {
        let Ray {
            origin,
            direction,
            tmin,
            tmax,
            ..
        } = self.ray;
        let [start, way] =
            [origin + direction * tmin, direction * (tmax - tmin)].map(|v| Vec3::from(v) / SCALE);
        (start, way)
    }
}

/// The first questions that are asked.
pub(super) struct Record {
    queries: Mutex<Vec<Query>>,
    most: usize,
}

impl Record {
    /// Room for `most`.
    pub(super) fn new(most: usize) -> Self {
        Self {
            queries: Mutex::default(),
            most,
        }
    }

    /// Keeps a question about a part of a ray that ends.
    pub(super) fn keep(&self, query: Query) {
        let mut queries = self.queries.lock().unwrap_or_else(PoisonError::into_inner);
        if queries.len() < self.most && query.ray.tmax < f32::INFINITY {
            queries.push(query);
        }
    }

    /// What was kept.
    pub(super) fn into_queries(self) -> Vec<Query> {
        let queries = self.queries.into_inner();
        queries.unwrap_or_else(PoisonError::into_inner)
    }
}
