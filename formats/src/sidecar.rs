//! The sidecar `<scene>.toml`: cameras, point lights, and changes to materials of the scene beside it.
//!
//! ```toml
//! [[camera]]
//! name = "front"
//! eye = [0, 1, 4]        # metres
//! target = [0, 1, 0]
//! up = [0, 1, 0]         # this is the default
//! fov_y = 45             # degrees
//! width = 640            # pixels; these are the defaults
//! height = 480
//!
//! [[point_light]]
//! position = [0, 2, 0]   # metres
//! intensity = [1, 1, 1]  # W/sr
//!
//! [material.floor]       # every key is optional
//! diffuse = [0.2, 0.2, 0.2]
//! specular = [0.5, 0.5, 0.5]
//! exponent = 50          # Phong; or roughness = 0.1 for Ward
//! emission = [0, 0, 0]   # W/(sr m²)
//! ```

use crate::error::{FormatError, list, quote, suggestion};
use crate::file;
use glam::Vec3;
use serde::Deserialize;
use sheen_solver::scene::{EMISSION_LIMIT, check_camera};
use sheen_solver::{Camera, Gloss, PointLight, Rgb, SceneParts};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// What a sidecar holds; every number in it is checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sidecar {
    /// Where it was read from.
    pub path: PathBuf,
    /// Cameras, names unique.
    pub cameras: Vec<Camera>,
    /// Point lights.
    pub point_lights: Vec<PointLight>,
    /// Changes to materials by name.
    pub materials: BTreeMap<String, MaterialChange>,
}

/// What changes in a material; `None` stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialChange {
    /// Line of its table, from 1.
    pub line: usize,
    /// Lambertian reflectance, within 0..1.
    pub diffuse: Option<Rgb>,
    /// Reflectance of the lobe, within 0..1.
    pub specular: Option<Rgb>,
    /// Makes the lobe a Phong lobe of this exponent.
    pub exponent: Option<f32>,
    /// Makes the lobe a Ward lobe of this roughness.
    pub roughness: Option<f32>,
    /// Emitted radiance [W·sr⁻¹·m⁻²].
    pub emission: Option<Rgb>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    #[serde(default)]
    camera: Vec<Spanned<CameraTable>>,
    #[serde(default)]
    point_light: Vec<Spanned<PointLightTable>>,
    #[serde(default)]
    material: BTreeMap<String, Spanned<MaterialTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    name: String,
    eye: [f32; 3],
    target: [f32; 3],
    #[serde(default = "upwards")]
    up: [f32; 3],
    fov_y: f32,
    #[serde(default = "default_width")]
    width: u32,
    #[serde(default = "default_height")]
    height: u32,
}

fn upwards() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}

fn default_width() -> u32 {
    640
}

fn default_height() -> u32 {
    480
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointLightTable {
    position: [f32; 3],
    intensity: [f32; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: Option<f32>,
    roughness: Option<f32>,
    emission: Option<[f32; 3]>,
}

/// Largest sidecar that is read [B].
const LARGEST: u64 = 16 << 20;

/// Where the sidecar of a scene lies: `room.obj` has `room.toml`.
pub fn path_for(scene: &Path) -> PathBuf {
    scene.with_extension("toml")
}

/// Reads a sidecar. Errors name file and line; an unknown key comes with the nearest known one.
pub fn read(path: &Path) -> Result<Sidecar, FormatError> {
    let bytes = file::read_bytes(path, LARGEST)?;
    let text = match std::str::from_utf8(&bytes) {
        Ok(text) => text.strip_prefix('\u{FEFF}').unwrap_or(text),
        Err(error) => {
            let line = 1 + bytes[..error.valid_up_to()]
                .iter()
                .filter(|&&b| b == b'\n')
                .count();
            return Err(FormatError::line(path, line, "is not UTF-8 text"));
        }
    };
    let place = Place { path, text };
    let tables: FileTable = toml::from_str(text).map_err(|error| place.toml_error(&error))?;
    let mut sidecar = Sidecar {
        path: path.to_owned(),
        ..Default::default()
    };
    let mut names = BTreeSet::new();
    for table in tables.camera {
        let line = place.line(table.span().start);
        let camera = camera(table.into_inner());
        let fault = |message: String| FormatError::line(path, line, message);
        check_camera(&camera).map_err(|error| fault(error.to_string()))?;
        if camera.name.trim().is_empty() {
            return Err(fault("the camera's name is empty".to_owned()));
        }
        if !names.insert(camera.name.clone()) {
            return Err(fault(format!(
                "camera {} stands here for the second time",
                quote(&camera.name)
            )));
        }
        sidecar.cameras.push(camera);
    }
    for table in tables.point_light {
        let line = place.line(table.span().start);
        let table = table.into_inner();
        let lamp = PointLight {
            position: Vec3::from(table.position),
            intensity: Rgb::from(table.intensity),
        };
        if !lamp.position.is_finite() {
            return Err(FormatError::line(
                path,
                line,
                "the position of the point light is not finite",
            ));
        }
        check_emission("intensity", lamp.intensity)
            .map_err(|message| FormatError::line(path, line, message))?;
        sidecar.point_lights.push(lamp);
    }
    for (name, table) in tables.material {
        let line = place.line(table.span().start);
        let change = material_change(table.into_inner(), line).map_err(|message| {
            FormatError::line(path, line, format!("material {}: {message}", quote(&name)))
        })?;
        sidecar.materials.insert(name, change);
    }
    Ok(sidecar)
}

fn camera(table: CameraTable) -> Camera {
    Camera {
        name: table.name,
        eye: Vec3::from(table.eye),
        target: Vec3::from(table.target),
        up: Vec3::from(table.up),
        fov_y_degrees: table.fov_y,
        width: table.width,
        height: table.height,
    }
}

fn check_emission(what: &str, value: Rgb) -> Result<(), String> {
    if value
        .to_array()
        .iter()
        .all(|channel| (0.0..=EMISSION_LIMIT).contains(channel))
    {
        return Ok(());
    }
    Err(format!(
        "{what} {:?} must be finite, not negative and at most {EMISSION_LIMIT:e}",
        value.to_array()
    ))
}

fn material_change(table: MaterialTable, line: usize) -> Result<MaterialChange, String> {
    for (what, value) in [("diffuse", table.diffuse), ("specular", table.specular)] {
        if let Some(value) = value.filter(|v| !v.iter().all(|c| (0.0..=1.0).contains(c))) {
            return Err(format!("{what} is {value:?}, expected within 0..1"));
        }
    }
    if let Some(n) = table.exponent.filter(|n| !(0.0..=1e7).contains(n)) {
        return Err(format!("exponent is {n}, expected within 0..1e7"));
    }
    if let Some(roughness) = table.roughness.filter(|r| !(0.0..=1.0).contains(r)) {
        return Err(format!("roughness is {roughness}, expected within 0..1"));
    }
    if table.exponent.is_some() && table.roughness.is_some() {
        return Err(
            "has both exponent (Phong) and roughness (Ward), expected one of them".to_owned(),
        );
    }
    let emission = table.emission.map(Rgb::from);
    emission.map_or(Ok(()), |emission| check_emission("emission", emission))?;
    Ok(MaterialChange {
        line,
        diffuse: table.diffuse.map(Rgb::from),
        specular: table.specular.map(Rgb::from),
        exponent: table.exponent,
        roughness: table.roughness,
        emission,
    })
}

impl Sidecar {
    /// Adds cameras and lamps to `parts` and changes its materials.
    ///
    /// Errors: a change to a material that does not exist, or of a lobe that the material does not have.
    pub fn apply(&self, parts: &mut SceneParts) -> Result<(), FormatError> {
        for (name, change) in &self.materials {
            let fault = |message| FormatError::line(&self.path, change.line, message);
            let Some(index) = parts.materials.iter().position(|m| m.name == *name) else {
                let names = || parts.materials.iter().map(|m| m.name.as_str());
                let near = suggestion(name, names());
                let known = list(names());
                return Err(fault(format!(
                    "no material {} in the scene{near} (it has {known})",
                    quote(name)
                )));
            };
            let material = &mut parts.materials[index];
            material.gloss = change
                .gloss(material.gloss)
                .map_err(|reason| fault(format!("material {}: {reason}", quote(name))))?;
            material.diffuse = change.diffuse.unwrap_or(material.diffuse);
            material.emission = change.emission.unwrap_or(material.emission);
        }
        parts.cameras.extend(self.cameras.iter().cloned());
        parts.point_lights.extend(&self.point_lights);
        Ok(())
    }
}

impl MaterialChange {
    fn gloss(&self, old: Gloss) -> Result<Gloss, &'static str> {
        let (old_specular, old_exponent, old_roughness) = match old {
            Gloss::None => (None, None, None),
            Gloss::Phong { specular, exponent } => (Some(specular), Some(exponent), None),
            Gloss::Ward {
                specular,
                roughness,
            } => (Some(specular), None, Some(roughness)),
        };
        if self.specular.is_none() && self.exponent.is_none() && self.roughness.is_none() {
            return Ok(old);
        }
        let Some(specular) = self.specular.or(old_specular) else {
            return Err("is diffuse: exponent or roughness needs specular beside it");
        };
        match (self.exponent, self.roughness, old_exponent, old_roughness) {
            (Some(exponent), ..) | (None, None, Some(exponent), _) => {
                Ok(Gloss::Phong { specular, exponent })
            }
            (None, Some(roughness), ..) | (None, None, None, Some(roughness)) => Ok(Gloss::Ward {
                specular,
                roughness,
            }),
            (None, None, None, None) if specular.is_black() => Ok(Gloss::None),
            (None, None, None, None) => {
                Err("is diffuse: specular needs exponent (Phong) or roughness (Ward) beside it")
            }
        }
    }
}

struct Place<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Place<'_> {
    fn line(&self, offset: usize) -> usize {
        1 + self
            .text
            .as_bytes()
            .iter()
            .take(offset)
            .filter(|&&byte| byte == b'\n')
            .count()
    }

    fn toml_error(&self, error: &toml::de::Error) -> FormatError {
        let mut message = error.message().to_owned();
        // serde writes: unknown field `fovy`, expected one of `name`, `eye`, ...
        if let Some(rest) = message.strip_prefix("unknown field ") {
            let mut quoted = rest.split('`').skip(1).step_by(2);
            let unknown = quoted.next().unwrap_or_default();
            let near = suggestion(unknown, quoted);
            message.push_str(&near);
        }
        match error.span() {
            Some(span) => FormatError::line(self.path, self.line(span.start), message),
            None => FormatError::content(self.path, message),
        }
    }
}
