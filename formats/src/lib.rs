//! Files in and out: scenes (OBJ/MTL, MGF, sidecar), solutions (`.sheen`), images (EXR, PNG).

pub mod error;
mod file;
pub mod image;
pub mod mgf;
pub mod obj;
mod polygon;
pub mod sidecar;
pub mod solution;

pub use error::FormatError;

use error::list;
use sheen_solver::brdf::is_widened;
use sheen_solver::{Gloss, Material, Scene, SceneError, SceneParts, Triangle};
use sidecar::Sidecar;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How to read a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Repair what can be repaired, with a note, instead of refusing it.
    pub lenient: bool,
}

/// A scene, and what its file holds that could not be represented or had to be repaired: one line each.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// For the user, one line each.
    pub notes: Vec<String>,
}

/// Reads a scene by its extension (`.obj`, `.mgf`, in any letter case) with its sidecar `<scene>.toml`, if there is
/// one.
///
/// Errors name the file, the line where there is one, and what was expected.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, FormatError> {
    let head = file::head(path, 64)?;
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    let looks_like = file::looks_like(&head);
    if !matches!(extension.as_str(), "obj" | "mgf") {
        let kind = looks_like.map_or(String::new(), |kind| format!(": it looks like {kind}"));
        return Err(FormatError::content(
            path,
            format!("is no scene that can be read, expected .obj or .mgf{kind}"),
        ));
    }
    if let Some(kind) = looks_like {
        return Err(FormatError::content(
            path,
            format!(
                "looks like {kind}, expected {} text",
                extension.to_uppercase()
            ),
        ));
    }
    if file::is_blank(&head) && file::is_blank(file::read_text(path)?.0.as_bytes()) {
        return Err(FormatError::content(path, "empty scene file"));
    }
    let mut places = Places::default();
    let (mut parts, mut notes) = if extension == "obj" {
        let scene = obj::read(path, options.lenient)?;
        places.triangle_lines = scene.triangle_lines;
        places.materials = scene.material_places;
        (scene.parts, scene.notes)
    } else {
        let scene = mgf::read(path)?;
        (scene.parts, scene.notes)
    };
    let sidecar_path = sidecar::path_for(path);
    if sidecar_path.exists() {
        let sidecar = sidecar::read(&sidecar_path)?;
        sidecar.apply(&mut parts)?;
        places.add_sidecar(&sidecar);
    }
    note_meaning(&parts, &mut notes);
    let (scene, repairs) =
        Scene::new(parts, options.lenient).map_err(|error| places.locate(path, error))?;
    notes.extend(repairs);
    Ok(Loaded { scene, notes })
}

/// Where things of a scene stand in its files.
#[derive(Default)]
struct Places {
    /// By triangle, from 1; empty when the format has no lines to tell.
    triangle_lines: Vec<usize>,
    materials: BTreeMap<String, (PathBuf, usize)>,
}

impl Places {
    fn add_sidecar(&mut self, sidecar: &Sidecar) {
        for (name, change) in &sidecar.materials {
            self.materials
                .insert(name.clone(), (sidecar.path.clone(), change.line));
        }
    }

    /// The error with the line that it is about, where that is known.
    fn locate(&self, path: &Path, error: SceneError) -> FormatError {
        let place = match &error {
            SceneError::Index { triangle, .. }
            | SceneError::NotFinite { triangle }
            | SceneError::Degenerate { triangle }
            | SceneError::Duplicate { triangle, .. }
            | SceneError::Normal { triangle, .. } => self
                .triangle_lines
                .get(*triangle)
                .map(|&line| (path.to_owned(), line)),
            SceneError::Reflectance { material, .. } | SceneError::Parameter { material, .. } => {
                self.materials.get(material).cloned()
            }
            // The solver names the emitter: material 'lamp'.
            SceneError::Emission { light, .. } => light
                .strip_prefix("material '")
                .and_then(|rest| rest.strip_suffix('\''))
                .and_then(|name| self.materials.get(name).cloned()),
            _ => None,
        };
        let mut message = error.to_string();
        if let SceneError::Duplicate { first, .. } = &error
            && let Some(line) = self.triangle_lines.get(*first)
        {
            message.push_str(&format!(", which stands in line {line}"));
        }
        match place {
            Some((path, line)) => FormatError::Line {
                path,
                line,
                message,
            },
            None => FormatError::Scene {
                path: path.to_owned(),
                cause: error,
            },
        }
    }
}

/// Materials that a triangle has.
fn used<'a>(materials: &'a [Material], triangles: &[Triangle]) -> Vec<&'a Material> {
    let mut used = vec![false; materials.len()];
    for triangle in triangles {
        if let Some(used) = used.get_mut(triangle.material as usize) {
            *used = true;
        }
    }
    let both = materials.iter().zip(used);
    both.filter(|(_, used)| *used).map(|(m, _)| m).collect()
}

/// Names of those `materials` that are so.
fn named<'a>(materials: &[&'a Material], which: impl Fn(&Material) -> bool) -> Vec<&'a str> {
    let those = materials.iter().filter(|m| which(m));
    those.map(|m| m.name.as_str()).collect()
}

fn is_mirror(material: &Material) -> bool {
    material.is_glossy() && matches!(material.gloss, Gloss::Ward { roughness: 0.0, .. })
}

/// One line about the lobes of `scene` that a solve widens to the Ward roughness `sharpest`, if there are any. Of mirrors
/// [`load_scene`] says so.
pub fn note_widened(scene: &Scene, sharpest: f32) -> Option<String> {
    let used = used(scene.materials(), scene.triangles());
    let widened = named(&used, |m| is_widened(m, sharpest) && !is_mirror(m));
    (!widened.is_empty()).then(|| {
        let names = list(widened);
        format!(
            "lobes sharper than this quality resolves become Ward roughness {sharpest:.3}: {names}"
        )
    })
}

/// Says what the method makes of things that it cannot represent, and what is missing.
fn note_meaning(parts: &SceneParts, notes: &mut Vec<String>) {
    let used = used(&parts.materials, &parts.triangles);
    let named = |which: fn(&Material) -> bool| named(&used, which);
    let mirrors = named(is_mirror);
    if !mirrors.is_empty() {
        let names = list(mirrors.iter().copied());
        notes.push(format!(
            "mirrors become the sharpest lobe that the quality resolves: {names}"
        ));
    }
    let glass = named(Material::is_glass);
    if !glass.is_empty() {
        let names = list(glass.iter().copied());
        notes.push(format!(
            "clear glass lets visibility rays pass, tinted, and is drawn blended: {names}"
        ));
    }
    if named(|m| !m.emission.is_black()).is_empty()
        && parts.point_lights.iter().all(|l| l.intensity.is_black())
    {
        notes.push("nothing emits: the solution is black".to_owned());
    }
    if parts.cameras.is_empty() {
        notes.push(
            "no camera is given: a default camera that sees the whole scene is used".to_owned(),
        );
    }
}
