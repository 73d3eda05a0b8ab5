//! Spheres and tori as rows of flat quadrilaterals, closed, with exact normals.
//!
//! Their points lie a little outside, such that the facets together have exactly the area of the curved surface.

use super::mesh::{Face, Mesh};
use super::revolve::{band_area, solve_increasing};
use super::tessellate::Tolerance;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Rows of latitude for a number of meridians.
fn sphere_rows(sides: usize) -> usize {
    sides / 2
}

pub(super) fn sphere_triangles(tolerance: &Tolerance, radius: f64) -> u64 {
    let sides = tolerance.sides(radius);
    2 * (sides * (sphere_rows(sides) - 1)) as u64
}

/// A sphere; its poles lie along y.
pub(super) fn add_sphere(
    mesh: &mut Mesh,
    face: Face,
    tolerance: &Tolerance,
    center: DVec3,
    radius: f64,
) {
    let sides = tolerance.sides(radius);
    let rows = sphere_rows(sides);
    // From the south pole up; exact at the poles, where the sine of π would not be.
    let latitude = |row: usize| match row {
        0 => (0.0, -1.0),
        _ if row == rows => (0.0, 1.0),
        _ => {
            let (sine, cosine) = (PI * row as f64 / rows as f64).sin_cos();
            (sine, -cosine)
        }
    };
    let row_area = |row: usize| {
        let [(low, from), (high, to)] = [latitude(row), latitude(row + 1)];
        band_area(sides, [low, high], to - from)
    };
    let faceted: f64 = (0..rows).map(row_area).sum();
    let outer = radius * (4.0 * PI / faceted).sqrt();
    let direction = |row: usize, side: usize| {
        let (distance, height) = latitude(row);
        let (sine, cosine) = (TAU * (side % sides) as f64 / sides as f64).sin_cos();
        // Counter-clockwise around y.
        DVec3::new(distance * sine, height, distance * cosine)
    };
    for row in 0..rows {
        for side in 0..sides {
            let [a, b] = [direction(row, side), direction(row, side + 1)];
            let [d, c] = [direction(row + 1, side), direction(row + 1, side + 1)];
            let at = |normal: DVec3| center + normal * outer;
            if row == 0 {
                mesh.triangle(face, [at(a), at(c), at(d)], Some([a, c, d]));
            } else if row + 1 == rows {
                mesh.triangle(face, [at(a), at(b), at(d)], Some([a, b, d]));
            } else {
                mesh.quad(face, [a, b, c, d].map(at), Some([a, b, c, d]));
            }
        }
    }
}

/// A torus in the world.
#[derive(Clone, Copy)]
pub(super) struct Torus {
    pub(super) center: DVec3,
    pub(super) axis: DVec3,
    /// Of the circle that the tube follows.
    pub(super) major: f64,
    /// Of the tube.
    pub(super) minor: f64,
}

impl Torus {
    /// Sides around the axis and around the tube.
    fn sides(&self, tolerance: &Tolerance) -> (usize, usize) {
        (
            tolerance.sides(self.major + self.minor),
            tolerance.sides(self.minor),
        )
    }

    pub(super) fn triangle_count(&self, tolerance: &Tolerance) -> u64 {
        let (around, tube) = self.sides(tolerance);
        2 * (around * tube) as u64
    }

    pub(super) fn emit(&self, mesh: &mut Mesh, face: Face, tolerance: &Tolerance) {
        let (around, tube) = self.sides(tolerance);
        let half = PI / around as f64;
        // The circle's polygon keeps its length; the tube's radius then makes up the area.
        let stretch = half / half.sin();
        // Half a step off, so that no point lies on the axis where the tube touches it.
        let angle = |row: usize| TAU * ((row % tube) as f64 + 0.5) / tube as f64;
        let row = |index: usize, minor: f64| {
            let (sine, cosine) = angle(index).sin_cos();
            (stretch * (self.major + minor * cosine), minor * sine)
        };
        let faceted = |factor: f64| -> f64 {
            let area = |index: usize| {
                let [(a, from), (b, to)] = [
                    row(index, self.minor * factor),
                    row(index + 1, self.minor * factor),
                ];
                band_area(around, [a, b], to - from)
            };
            (0..tube).map(area).sum()
        };
        let exact = 4.0 * PI * PI * self.major * self.minor;
        let minor = self.minor * solve_increasing(exact, 0.8, 1.5, faceted);
        let (u, v) = self.axis.any_orthonormal_pair();
        let v = if u.cross(v).dot(self.axis) < 0.0 {
            -v
        } else {
            v
        };
        let corner = |side: usize, index: usize| {
            let (sine, cosine) = (TAU * (side % around) as f64 / around as f64).sin_cos();
            let outward = u * cosine + v * sine;
            let (distance, height) = row(index, minor);
            let (tube_sine, tube_cosine) = angle(index).sin_cos();
            (
                self.center + outward * distance + self.axis * height,
                outward * tube_cosine + self.axis * tube_sine,
            )
        };
        for index in 0..tube {
            for side in 0..around {
                let corners = [
                    corner(side, index),
                    corner(side + 1, index),
                    corner(side + 1, index + 1),
                    corner(side, index + 1),
                ];
                mesh.quad(
                    face,
                    corners.map(|(point, _)| point),
                    Some(corners.map(|(_, normal)| normal)),
                );
            }
        }
    }
}
