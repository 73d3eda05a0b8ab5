//! Wavefront OBJ with MTL materials, read by `tobj` after a check of our own that knows the lines.
//!
//! `Kd` is the diffuse reflectance; `Ks` above zero adds a normalised modified Phong lobe of exponent `Ns`; `Ke` is
//! emitted radiance [W·sr⁻¹·m⁻²], from the front (counter-clockwise) side. Surfaces reflect on both sides. Positions
//! are metres. Corners at bitwise equal places become one point, so that neighbouring faces are connected; so do
//! equal normals. Not represented, and listed in the notes: textures, transparency, lines, points, free-form curves
//! and surfaces, smoothing groups, colours at vertices.

mod materials;
mod scan;

use crate::error::FormatError;
use crate::file;
use crate::polygon;
use glam::Vec3;
use sheen_solver::{Material, Rgb, SceneParts, Triangle};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// What an OBJ file holds, not yet validated as a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjScene {
    /// Points, faces, materials; no lamps and no cameras, which the format does not have.
    pub parts: SceneParts,
    /// For the user, one line each.
    pub notes: Vec<String>,
    /// Line of the face that each triangle is part of, from 1.
    pub triangle_lines: Vec<usize>,
    /// File and line where each material is defined, by name.
    pub material_places: BTreeMap<String, (PathBuf, usize)>,
}

/// Name of the material of faces without one.
const DEFAULT_MATERIAL: &str = "(none)";

/// Reads an OBJ file and the MTL files that it names, which must lie in its folder or below.
///
/// With `lenient`, missing libraries, undefined materials and polygons that cross themselves are notes. Errors name
/// file and line.
pub fn read(path: &Path, lenient: bool) -> Result<ObjScene, FormatError> {
    let (text, latin1) = file::read_text(path)?;
    let mut scan = scan::scan(path, &text)?;
    drop(text);
    let libraries = materials::read(path, &scan, lenient)?;
    let mut notes = Vec::new();
    if latin1 {
        notes.push("the file is not UTF-8: read as Latin-1".to_owned());
    }
    notes.extend(libraries.notes);
    note_ignored(std::mem::take(&mut scan.ignored), &mut notes);
    if scan.faces_without_material > 0 {
        notes.push(format!(
            "{} faces without a material become grey (diffuse 0.5)",
            scan.faces_without_material
        ));
    }
    let clean = format!("mtllib all\n{}", std::mem::take(&mut scan.clean));
    // The check went before: what `tobj` still finds has no line.
    let fault =
        |error| FormatError::content(path, format!("the OBJ reader refused the file: {error}"));
    let options = tobj::LoadOptions {
        triangulate: false,
        single_index: false,
        ..Default::default()
    };
    let (models, read_materials) = tobj::load_obj_buf(&mut clean.as_bytes(), &options, |_| {
        tobj::load_mtl_buf(&mut libraries.clean.as_bytes())
    })
    .map_err(fault)?;
    drop(clean);

    let mut builder = Builder {
        path,
        lenient,
        welder: Welder::default(),
        crossing: 0,
        scene: ObjScene::default(),
    };
    let material_ids = builder.materials(&read_materials.map_err(fault)?);
    let mut faces = scan.face_lines.iter().zip(&scan.face_has_normals);
    for model in models.iter().filter(|model| !model.mesh.indices.is_empty()) {
        let material = match model.mesh.material_id {
            Some(id) => material_ids[id],
            None => builder.default_material(),
        };
        builder.mesh(&model.mesh, material, &mut faces)?;
    }
    if builder.crossing > 0 {
        notes.push(format!(
            "{} polygons cross themselves: their triangles overlap, or some are missing",
            builder.crossing
        ));
    }
    let mut scene = builder.finish();
    scene.notes = notes;
    scene.material_places = libraries.places;
    Ok(scene)
}

fn note_ignored(mut ignored: scan::Ignored, notes: &mut Vec<String>) {
    if let Some(found) = ignored.take(|k| matches!(k, "l" | "p")) {
        notes.push(format!(
            "lines and points have no surface and are left out: {found}"
        ));
    }
    if let Some(found) = ignored.take(|k| k == "s") {
        notes.push(format!(
            "smoothing groups are ignored, only normals (vn) make a surface smooth: {found}"
        ));
    }
    if let Some(found) = ignored.take(|k| k == "vertex colour") {
        notes.push(format!("colours at vertices are ignored: {found}"));
    }
    let free_form = [
        "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "end",
        "vp",
    ];
    if let Some(found) = ignored.take(|k| free_form.contains(&k)) {
        notes.push(format!(
            "free-form curves and surfaces are left out: {found}"
        ));
    }
    if let Some(found) = ignored.rest() {
        notes.push(format!("ignored statements: {found}"));
    }
}

struct Builder<'a> {
    path: &'a Path,
    lenient: bool,
    welder: Welder,
    /// Polygons that cross themselves.
    crossing: usize,
    scene: ObjScene,
}

/// Points and normals by their bits.
#[derive(Default)]
struct Welder {
    points: HashMap<[u32; 3], u32>,
    normals: HashMap<[u32; 3], u32>,
}

fn weld(known: &mut HashMap<[u32; 3], u32>, all: &mut Vec<Vec3>, values: &[f32]) -> Vec<u32> {
    let id = |value: &[f32]| {
        // Adding zero makes -0 and 0 the same.
        let value = Vec3::new(value[0] + 0.0, value[1] + 0.0, value[2] + 0.0);
        *known
            .entry(value.to_array().map(f32::to_bits))
            .or_insert_with(|| {
                all.push(value);
                (all.len() - 1) as u32
            })
    };
    values.chunks_exact(3).map(id).collect()
}

impl Builder<'_> {
    /// Adds the materials, each name once with its last definition; gives the index of each in the scene.
    fn materials(&mut self, materials: &[tobj::Material]) -> Vec<u32> {
        let mut by_name: HashMap<&str, u32> = HashMap::new();
        let scene_materials = &mut self.scene.parts.materials;
        let mut place = |material: &tobj::Material, id: u32| {
            match scene_materials.get_mut(id as usize) {
                Some(earlier) => *earlier = materials::convert(material),
                None => scene_materials.push(materials::convert(material)),
            }
            id
        };
        let mut ids = Vec::with_capacity(materials.len());
        for material in materials {
            let next = by_name.len() as u32;
            ids.push(place(
                material,
                *by_name.entry(&material.name).or_insert(next),
            ));
        }
        ids
    }

    fn default_material(&mut self) -> u32 {
        let materials = &mut self.scene.parts.materials;
        let known = materials.iter().position(|m| m.name == DEFAULT_MATERIAL);
        known.unwrap_or_else(|| {
            materials.push(Material::lambert(DEFAULT_MATERIAL, Rgb::splat(0.5)));
            materials.len() - 1
        }) as u32
    }

    /// Adds the faces of `mesh`; `faces` gives the line of each and whether it has normals.
    fn mesh<'f>(
        &mut self,
        mesh: &tobj::Mesh,
        material: u32,
        faces: &mut impl Iterator<Item = (&'f usize, &'f bool)>,
    ) -> Result<(), FormatError> {
        let parts = &mut self.scene.parts;
        let points = weld(&mut self.welder.points, &mut parts.points, &mesh.positions);
        let normals = weld(&mut self.welder.normals, &mut parts.normals, &mesh.normals);
        let triangles_only = vec![
            3;
            if mesh.face_arities.is_empty() {
                mesh.indices.len() / 3
            } else {
                0
            }
        ];
        let mut start = 0;
        let mut corners = Vec::new();
        for (&count, (&line, &has_normals)) in
            mesh.face_arities.iter().chain(&triangles_only).zip(faces)
        {
            let range = start..start + count as usize;
            start = range.end;
            let point = |corner: u32| points[mesh.indices[range.start + corner as usize] as usize];
            let normal =
                |corner: u32| normals[mesh.normal_indices[range.start + corner as usize] as usize];
            corners.clear();
            corners.extend((0..count).map(|corner| parts.points[point(corner) as usize]));
            let triangulation = polygon::outline(&corners);
            if triangulation.crossing {
                if !self.lenient {
                    let message =
                        format!("the outline of the face with {count} corners crosses itself");
                    return Err(FormatError::line(self.path, line, message));
                }
                self.crossing += 1;
            }
            for triangle in triangulation.triangles {
                let normals = has_normals.then(|| triangle.map(normal));
                let flat = normals.is_some_and(|n| {
                    is_flat(&parts.normals, n, triangle.map(|i| corners[i as usize]))
                });
                let normals = normals.filter(|_| !flat);
                parts.triangles.push(Triangle {
                    points: triangle.map(point),
                    normals,
                    material,
                });
                self.scene.triangle_lines.push(line);
            }
        }
        Ok(())
    }

    fn finish(self) -> ObjScene {
        self.scene
    }
}

/// True when the three normals are one and that one is the face's, up to the decimals that files print: it says
/// nothing that the face does not.
fn is_flat(normals: &[Vec3], [a, b, c]: [u32; 3], [p, q, r]: [Vec3; 3]) -> bool {
    const PRINTED: f32 = 1e-4;
    let face = (q.as_dvec3() - p.as_dvec3())
        .cross(r.as_dvec3() - p.as_dvec3())
        .normalize_or_zero()
        .as_vec3();
    a == b && b == c && (normals[a as usize] - face).length() < PRINTED
}
