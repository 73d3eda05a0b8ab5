//! The plain twin of `ways::solution`: the same image by rays, for machines without any graphics adapter.

use super::Shading;
use crate::camera::View;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use rayon::prelude::*;
use sheen_formats::image::Image;
use sheen_solver::{Observer, Progress, Rgb, Solution};
use std::time::Duration;

/// Power of two that brings all of `points` within 1 of the origin: the tree's own checks have absolute tolerances.
fn unit_scale<'a>(points: impl Iterator<Item = &'a Vec3>) -> f32 {
    let largest = points.fold(0.0f32, |largest, point| {
        largest.max(point.abs().max_element())
    });
    // The biased exponent of the reciprocal's power of two, kept where both it and its inverse are normal numbers.
    f32::from_bits((253 - (largest.to_bits() >> 23).clamp(1, 252)) << 23)
}

/// Triangles in a tree.
struct Surfaces {
    corners: Vec<[Vec3; 3]>,
    tree: Option<CwBvh>,
}

fn whole_ray(eye: Vec3, direction: DVec3) -> Ray {
    // The tree misses boxes along a direction that has a negative zero; plus zero it is none.
    let direction = direction.as_vec3a() + Vec3A::ZERO;
    Ray::new(eye.into(), direction, 0.0, f32::INFINITY)
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
struct Crossing {
    distance: f64,
    weights: [f64; 3],
    is_front: bool,
}

/// Meets the triangle with `corners` relative to the ray's origin. Rays from one eye see no crack between triangles
/// that share an edge: the sign for an edge is the same number, negated, on both of its sides.
fn cross(corners: [DVec3; 3], direction: DVec3) -> Option<Crossing> {
    let [a, b, c] = corners;
    let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(direction));
    let is_front = volumes.iter().all(|&v| v <= 0.0);
    if !is_front && !volumes.iter().all(|&v| v >= 0.0) {
        return None;
    }
    let sum: f64 = volumes.iter().sum();
    let distance = a.dot(b.cross(c)) / sum;
    let is_ahead = sum != 0.0 && distance > 0.0;
    is_ahead.then(|| Crossing {
        distance,
        weights: volumes.map(|v| v / sum),
        is_front,
    })
}

impl Surfaces {
    fn new(corners: Vec<[Vec3; 3]>) -> Self {
        // The tree works in single precision: a ray through an edge must not miss the boxes of both its faces.
        const SLACK: f32 = 8.0 * f32::EPSILON;
        let boxes: Vec<Aabb> = corners
            .iter()
            .map(|corners: &[Vec3; 3]| {
                let around = Aabb::from_points(&corners.map(Vec3A::from));
                Aabb::new(around.min - SLACK, around.max + SLACK)
            })
            .collect();
        let params = BvhBuildParams {
            pre_split: false,
            ..BvhBuildParams::medium_build()
        };
        let tree =
            (!boxes.is_empty()).then(|| build_cwbvh(&boxes, params, &mut Duration::default()));
        Self { corners, tree }
    }

    fn crossing(&self, index: usize, eye: Vec3, direction: DVec3) -> Option<Crossing> {
        let relative = self.corners[index].map(|corner| corner.as_dvec3() - eye.as_dvec3());
        cross(relative, direction)
    }

    /// The nearest front face.
    fn nearest(&self, eye: Vec3, direction: DVec3, near: f64) -> Option<(usize, Crossing)> {
        let tree = self.tree.as_ref()?;
        let mut best: Option<(usize, Crossing)> = None;
        let ray = whole_ray(eye, direction);
        tree.ray_traverse(ray, &mut RayHit::none(), |ray, slot| {
            let index = tree.primitive_indices[slot] as usize;
            match self.crossing(index, eye, direction) {
                Some(found) if found.is_front && found.distance >= near => {
                    if best.is_none_or(|(_, old)| found.distance < old.distance) {
                        best = Some((index, found));
                    }
                    (found.distance as f32).min(ray.tmax)
                }
                _ => f32::INFINITY,
            }
        });
        best
    }

    /// Calls `visit` for every triangle, of either side, between `near` and `far`.
    fn each_between(
        &self,
        eye: Vec3,
        direction: DVec3,
        near: f64,
        far: f64,
        mut visit: impl FnMut(usize),
    ) {
        let Some(tree) = &self.tree else { return };
        let ray = whole_ray(eye, direction);
        tree.ray_traverse_anyhit(ray, |_, slot| {
            let index = tree.primitive_indices[slot] as usize;
            if let Some(found) = self.crossing(index, eye, direction)
                && found.distance >= near
                && found.distance < far
            {
                visit(index);
            }
        });
    }
}

/// A solution that single rays can look at.
pub struct Looker<'a> {
    solution: &'a Solution,
    scale: f32,
    mesh: Surfaces,
    glass: Surfaces,
}

impl<'a> Looker<'a> {
    /// Makes `solution` ready for rays from `eyes` [m].
    pub fn new(solution: &'a Solution, eyes: &[Vec3]) -> Self {
        let clear = solution.glass_corners.as_flattened();
        let scale = unit_scale(solution.position.iter().chain(clear).chain(eyes));
        let scaled = |corners: &[Vec3; 3]| corners.map(|corner| corner * scale);
        let of_mesh = |t: &[u32; 3]| scaled(&t.map(|v| solution.position[v as usize]));
        Self {
            mesh: Surfaces::new(solution.triangles.iter().map(of_mesh).collect()),
            glass: Surfaces::new(solution.glass_corners.iter().map(scaled).collect()),
            solution,
            scale,
        }
    }

    /// What is seen from `eye` [m] along unit `direction` beyond `near` [m], where `radiance` gives each vertex's
    /// at a meeting [W·sr⁻¹·m⁻²].
    pub fn look(
        &self,
        eye: Vec3,
        direction: DVec3,
        near: f64,
        radiance: impl Fn(usize, &Meeting) -> Rgb,
    ) -> [f64; 3] {
        let eye = eye * self.scale;
        let near = near * f64::from(self.scale);
        let Some((triangle, crossing)) = self.mesh.nearest(eye, direction, near) else {
            return [0.0; 3];
        };
        let mut sum = [0.0; 3];
        let corners = self.solution.triangles[triangle].map(|corner| corner as usize);
        let meeting = Meeting::new(self.solution, corners, crossing.weights, direction);
        for (vertex, weight) in corners.into_iter().zip(crossing.weights) {
            for (channel, value) in sum.iter_mut().zip(radiance(vertex, &meeting).to_array()) {
                *channel += f64::from(value) * weight;
            }
        }
        self.glass
            .each_between(eye, direction, near, crossing.distance, |index| {
                let material = self.solution.glass_material[index] as usize;
                let tint = self.solution.materials[material].transmission.to_array();
                for (channel, tint) in sum.iter_mut().zip(tint) {
                    *channel *= f64::from(tint);
                }
            });
        sum
    }
}

/// Radiance of a vertex towards `eye`.
fn towards(solution: &Solution, vertex: usize, eye: Vec3) -> Rgb {
    let direction = (eye - solution.position[vertex]).normalize_or_zero();
    solution.evaluate(vertex, direction)
}

/// Distributions are not asked for directions nearer to the surface.
const GRAZING: f32 = 0.02;

fn mirrored(normal: Vec3, direction: Vec3) -> Vec3 {
    normal * (2.0 * normal.dot(direction)) - direction
}

/// Where a ray meets the mesh.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Towards what the surface mirrors to where the ray comes from, unit.
    mirrored: Vec3,
}

impl Meeting {
    fn new(solution: &Solution, corners: [usize; 3], weights: [f64; 3], direction: DVec3) -> Self {
        let normals = corners.iter().zip(weights);
        let normal: Vec3 = normals.map(|(&v, w)| solution.normal[v] * w as f32).sum();
        Self {
            mirrored: mirrored(normal.normalize_or_zero(), -direction.as_vec3()),
        }
    }

    /// Radiance that a vertex would have here: towards what mirrors there what is mirrored here. Lobes follow mirror
    /// directions, so the corners of a triangle are blended where they agree, over curved surfaces too.
    pub fn shaded(&self, solution: &Solution, vertex: usize) -> Rgb {
        let normal = solution.normal[vertex];
        let mut direction = mirrored(normal, self.mirrored);
        let height = normal.dot(direction);
        if height < GRAZING {
            direction = (direction + normal * (GRAZING - height)).normalize_or_zero();
        }
        solution.evaluate(vertex, direction)
    }
}

/// [`render_with`] the usual shading.
pub fn render(solution: &Solution, view: &View, across: u32) -> Image {
    render_with(solution, view, across, Shading::default())
}

/// [`render_observed`] by nobody.
pub fn render_with(solution: &Solution, view: &View, across: u32, shading: Shading) -> Image {
    let image = render_observed(solution, view, across, shading, &mut ());
    // Nobody stops it.
    image.unwrap_or_default()
}

/// Rows between two reports.
const BAND: usize = 16;

/// Renders `view` of `solution`; `None` when the observer stops it. A pixel is the mean over `across` × `across` samples
/// at the middles of its cells.
///
/// Cost: one ray per sample, and three evaluations of distributions per sample or one per vertex.
pub fn render_observed(
    solution: &Solution,
    view: &View,
    across: u32,
    shading: Shading,
    observer: &mut dyn Observer,
) -> Option<Image> {
    let of_vertices: Vec<Rgb> = match shading {
        Shading::Samples => Vec::new(),
        Shading::Vertices => (0..solution.position.len())
            .into_par_iter()
            .map(|vertex| towards(solution, vertex, view.eye))
            .collect(),
    };
    let looker = Looker::new(solution, &[view.eye]);
    let sample = |x: f64, y: f64| {
        let direction = view.direction(x, y);
        let near = view.near_along(direction);
        looker.look(view.eye, direction, near, |vertex, meeting| match shading {
            Shading::Samples => meeting.shaded(solution, vertex),
            Shading::Vertices => of_vertices[vertex],
        })
    };
    let step = 1.0 / f64::from(across);
    let (width, height) = (view.width as usize, view.height as usize);
    let pixel = |index: usize| {
        let (column, row) = (index % width, index / width);
        let mut sum = [0.0; 3];
        for cell in 0..across * across {
            let x = column as f64 + (f64::from(cell % across) + 0.5) * step;
            let y = row as f64 + (f64::from(cell / across) + 0.5) * step;
            for (total, value) in sum.iter_mut().zip(sample(x, y)) {
                *total += value;
            }
        }
        Rgb::from(sum.map(|total: f64| (total * step * step) as f32))
    };
    let mut pixels = Vec::with_capacity(width * height);
    for first in (0..height).step_by(BAND) {
        let rows = first..height.min(first + BAND);
        let band = (rows.start * width..rows.end * width).into_par_iter();
        pixels.par_extend(band.map(pixel));
        let progress = Progress {
            phase: "picture",
            done: rows.end as f32 / height as f32,
        };
        if observer.report(&progress).is_break() {
            return None;
        }
    }
    Some(Image {
        width: view.width,
        height: view.height,
        pixels,
    })
}
