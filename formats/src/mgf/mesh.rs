//! Triangles as the scene takes them: single precision, points and normals welded, nothing degenerate or twice.

use glam::{DVec3, Vec3};
use sheen_solver::scene::{Material, SceneParts, Triangle};
use std::collections::{HashMap, HashSet};

/// Gathers triangles.
#[derive(Default)]
pub(super) struct Mesh {
    parts: SceneParts,
    points: HashMap<[u32; 3], u32>,
    normals: HashMap<[u32; 3], u32>,
    seen: HashSet<([u32; 3], u32)>,
    /// Triangles without area in single precision.
    vanished: usize,
    /// Triangles that were there already.
    duplicates: usize,
}

/// How a face is added.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) material: u32,
    /// Turn it over: winding and normals.
    pub(super) flip: bool,
}

impl Mesh {
    /// A triangle, counter-clockwise around its front. `normals`: unit.
    pub(super) fn triangle(
        &mut self,
        face: Face,
        mut corners: [DVec3; 3],
        mut normals: Option<[DVec3; 3]>,
    ) {
        if face.flip {
            corners.swap(0, 2);
            normals = normals.map(|[a, b, c]| [-c, -b, -a]);
        }
        let positions = corners.map(|corner| corner.as_vec3() + Vec3::ZERO);
        let [a, b, c] = positions.map(|position| position.as_dvec3());
        let normal = (b - a).cross(c - a);
        if normal.length_squared() == 0.0 {
            self.vanished += 1;
            return;
        }
        let points =
            positions.map(|position| index_of(position, &mut self.points, &mut self.parts.points));
        let mut key = points;
        key.rotate_left((0..3).min_by_key(|&i| points[i]).unwrap_or(0));
        if !self.seen.insert((key, face.material)) {
            self.duplicates += 1;
            return;
        }
        let front = normal.normalize().as_vec3();
        let normals = normals
            .map(|normals| normals.map(|normal| normal.as_vec3() + Vec3::ZERO))
            .filter(|normals| normals.iter().all(|normal| normal.dot(front) > 0.0))
            .map(|normals| {
                normals.map(|normal| index_of(normal, &mut self.normals, &mut self.parts.normals))
            });
        self.parts.triangles.push(Triangle {
            points,
            normals,
            material: face.material,
        });
    }

    /// Two triangles of a flat quadrilateral.
    pub(super) fn quad(
        &mut self,
        face: Face,
        [a, b, c, d]: [DVec3; 4],
        normals: Option<[DVec3; 4]>,
    ) {
        self.triangle(face, [a, b, c], normals.map(|[a, b, c, _]| [a, b, c]));
        self.triangle(face, [a, c, d], normals.map(|[a, _, c, d]| [a, c, d]));
    }

    /// The scene, and what was left out of it.
    pub(super) fn finish(
        mut self,
        materials: Vec<Material>,
        notes: &mut Vec<String>,
    ) -> SceneParts {
        if self.vanished > 0 {
            notes.push(format!(
                "{} triangles without area in single precision dropped",
                self.vanished
            ));
        }
        if self.duplicates > 0 {
            notes.push(format!("{} duplicate triangles dropped", self.duplicates));
        }
        self.parts.materials = materials;
        self.parts
    }
}

/// Index of a vector by its bits; the caller has made -0 into 0.
fn index_of(vector: Vec3, indices: &mut HashMap<[u32; 3], u32>, vectors: &mut Vec<Vec3>) -> u32 {
    *indices
        .entry(vector.to_array().map(f32::to_bits))
        .or_insert_with(|| {
            vectors.push(vector);
            (vectors.len() - 1) as u32
        })
}
