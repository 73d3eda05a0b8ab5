//! Files in and out: scenes (OBJ/MTL, MGF, sidecar), solutions (`.sheen`), images (EXR, PNG).

pub mod error;
pub mod image;
pub mod mgf;
pub mod obj;
pub mod sidecar;
pub mod solution;

pub use error::FormatError;

use sheen_solver::Scene;
use std::path::Path;

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

/// Reads a scene by its extension (`.obj`, `.mgf`) with its sidecar `<scene>.toml`, if there is one.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, FormatError> {
    let _ = (path, options);
    todo!()
}
