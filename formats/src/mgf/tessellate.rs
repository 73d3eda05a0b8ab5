//! Shapes to triangles, within a chord tolerance.

use super::interpret::{Interpreter, Surface};
use super::mesh::{Face, Mesh};
use super::revolve::Bands;
use super::round::{Torus, add_sphere, sphere_triangles};
use super::surface::{Corner, Shape, vector_area};
use crate::polygon;
use glam::DVec3;
use sheen_solver::scene::SceneParts;
use std::f64::consts::PI;

/// Most triangles that a file may make.
const TRIANGLE_LIMIT: u64 = 32_000_000;
/// Largest distance of a chord from its arc, relative to the arc's radius.
const CHORD_TOLERANCE: f64 = 0.006;
/// Radii below this, relative to the diagonal of the scene's box, count as this large: small things get fewer sides.
const SMALL: f64 = 0.04;
/// Least sides of a circle, even.
const LEAST_SIDES: usize = 6;
/// Most polygons that are named one by one when they cross themselves.
const CROSSED_NAMED: usize = 10;

/// How far facets may be from what they stand for.
pub(super) struct Tolerance {
    diagonal: f64,
}

impl Tolerance {
    /// Sides of a circle; even.
    pub(super) fn sides(&self, radius: f64) -> usize {
        let chord = CHORD_TOLERANCE * radius.max(SMALL * self.diagonal) / radius;
        // NaN and everything coarse become the least.
        let sides = (PI / (1.0 - chord.min(1.0)).acos()).ceil() as usize;
        sides.next_multiple_of(2).max(LEAST_SIDES)
    }
}

/// Triangles of all surfaces, in their order; or a message when there are too many.
pub(super) fn tessellate(
    state: Interpreter,
) -> Result<(SceneParts, Vec<String>, super::MgfStats), String> {
    let Interpreter {
        surfaces,
        table,
        stats,
        mut notes,
        ..
    } = state;
    let tolerance = Tolerance {
        diagonal: stats.diagonal(),
    };
    let mut bands = Bands::default();
    let band_of: Vec<usize> = surfaces
        .iter()
        .map(|surface| match surface.shape {
            Shape::Cone { ends, radii, .. } => bands.add_cone(ends, radii),
            Shape::Ring {
                center,
                axis,
                radii,
            } => bands.add_ring(center, axis, radii),
            _ => usize::MAX,
        })
        .collect();
    bands.group(&tolerance);

    let count: u64 = surfaces
        .iter()
        .zip(&band_of)
        .map(|(surface, &band)| match &surface.shape {
            Shape::Polygon(loops) => loops.iter().map(|corners| corners.len() as u64 + 2).sum(),
            Shape::Cone { .. } | Shape::Ring { .. } => bands.triangle_count(band),
            Shape::Sphere { radius, .. } => sphere_triangles(&tolerance, *radius),
            &Shape::Torus {
                center,
                axis,
                major,
                minor,
                ..
            } => Torus {
                center,
                axis,
                major,
                minor,
            }
            .triangle_count(&tolerance),
        })
        .sum();
    if count > TRIANGLE_LIMIT {
        return Err(format!(
            "the surfaces make {count} triangles, more than {TRIANGLE_LIMIT}"
        ));
    }

    let mut mesh = Mesh::default();
    let mut crossed: Vec<&Surface> = Vec::new();
    for (surface, &band) in surfaces.iter().zip(&band_of) {
        let face = |inward: bool| Face {
            material: surface.material,
            flip: inward,
        };
        match &surface.shape {
            Shape::Polygon(loops) => {
                if !add_polygon(&mut mesh, face(false), loops) {
                    crossed.push(surface);
                }
            }
            Shape::Cone { inward, .. } => bands.emit(band, true, face(*inward), &mut mesh),
            Shape::Ring { .. } => bands.emit(band, false, face(false), &mut mesh),
            Shape::Sphere {
                center,
                radius,
                inward,
            } => {
                add_sphere(&mut mesh, face(*inward), &tolerance, *center, *radius);
            }
            &Shape::Torus {
                center,
                axis,
                major,
                minor,
                inward,
            } => {
                Torus {
                    center,
                    axis,
                    major,
                    minor,
                }
                .emit(&mut mesh, face(inward), &tolerance);
            }
        }
    }
    for surface in crossed.iter().take(CROSSED_NAMED) {
        let place = surface.source.entity(surface.line).place();
        notes.push(format!(
            "{place}: the polygon crosses itself: its triangles overlap, or some are missing"
        ));
    }
    if crossed.len() > CROSSED_NAMED {
        notes.push(format!(
            "{} more polygons cross themselves",
            crossed.len() - CROSSED_NAMED
        ));
    }
    if stats.degenerate > 0 {
        notes.push(format!(
            "{} surfaces without area dropped",
            stats.degenerate
        ));
    }
    let parts = mesh.finish(table.materials, &mut notes);
    Ok((parts, notes, stats))
}

/// False when the polygon crosses itself.
fn add_polygon(mesh: &mut Mesh, face: Face, loops: &[Vec<Corner>]) -> bool {
    let Some(front) = loops
        .first()
        .and_then(|outline| vector_area(outline).try_normalize())
    else {
        return false;
    };
    let positions: Vec<Vec<DVec3>> = loops
        .iter()
        .map(|corners| corners.iter().map(|corner| corner.position).collect())
        .collect();
    let corners: Vec<&Corner> = loops.iter().flatten().collect();
    let split = polygon::with_holes(&positions, front);
    for triangle in split.triangles {
        let [a, b, c] = triangle.map(|index| corners[index as usize]);
        let normals = match (a.normal, b.normal, c.normal) {
            (Some(a), Some(b), Some(c)) => Some([a, b, c]),
            _ => None,
        };
        mesh.triangle(face, [a.position, b.position, c.position], normals);
    }
    !split.crossing
}
