//! MGF, the Materials and Geometry Format (Ward 1995, version 2), by our own reader.
//!
//! Every entity is read: `v p n`, `c cxy cspec cmix cct`, `m sides rd td rs ts ir ed`, `f fh sph cyl cone ring torus
//! prism`, `o`, `xf` with nested arrays and mirrors, `i` with a transform. Left out, each with a note: `ies`
//! luminaires, entities that the format does not know, diffuse transmission (absorbed), rough transmission (taken as
//! clear), refraction (light goes straight on).
//!
//! Units as Radiance's `mgf2rad`: radiance = `ed` / (179 π), times the colour at luminance 1, in Radiance's RGB
//! primaries, unconverted. Unlike it, we keep the reflection of surfaces that emit, and the colour of `rs`; and where
//! reflectances that add up to at most one exceed it in a channel, their colours move towards grey, with a note.
//!
//! Curved surfaces become flat facets within a chord tolerance of 0.6 % of their radius, where radii below 4 % of the
//! scene's diagonal count as that large (six sides at least), with the exact normals of the surface. Their points lie slightly outside it, such
//! that the facets have exactly its area: a tessellated lamp keeps its flux.
//!
//! | module | activity |
//! |---|---|
//! | `source` | bytes to lines and words, blocks closed |
//! | `interpret` | entities executed: contexts, transforms, includes, limits |
//! | `context`, `xf`, `colour`, `material` | one kind of state each |
//! | `surface`, `stats` | surface entities to shapes in the world; exact figures |
//! | `tessellate`, `revolve`, `round`, `mesh` | shapes to triangles |

mod colour;
mod context;
mod interpret;
mod material;
mod mesh;
mod revolve;
mod round;
mod source;
mod stats;
mod surface;
mod tessellate;
mod xf;

pub use stats::MgfStats;

use crate::error::FormatError;
use interpret::Interpreter;
use sheen_solver::scene::SceneParts;
use std::path::Path;

/// What an MGF file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct MgfScene {
    /// Triangles and the materials they use; no cameras: the format has none.
    pub parts: SceneParts,
    /// For the user, one line each: what was left out or has no counterpart.
    pub notes: Vec<String>,
    /// Exact figures from before tessellation.
    pub stats: MgfStats,
}

/// Reads an MGF file and the files it includes.
///
/// Errors name file and line: numbers that are none or not finite, missing arguments, undefined names, unbalanced
/// `xf`, includes that recurse or cannot be read, arrays beyond 4 million surfaces. Ranges of reflectances are left
/// to [`sheen_solver::Scene::new`].
pub fn read(path: &Path) -> Result<MgfScene, FormatError> {
    let state = Interpreter::execute(path)?;
    let (parts, notes, stats) =
        tessellate::tessellate(state).map_err(|message| FormatError::Content {
            path: path.to_owned(),
            message,
        })?;
    Ok(MgfScene {
        parts,
        notes,
        stats,
    })
}
