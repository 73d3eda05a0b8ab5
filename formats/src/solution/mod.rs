//! Solutions as `.sheen` files: one chunk per array of [`Solution`], checksummed, memory-mapped for reading.
//!
//! The bytes are a function of the solution alone: the same solution gives the same file. For that, what differs
//! from run to run (`wall_s`, `cpu_s`, `peak_rss_bytes` and all of `phases_s` in the statistics) is written as zero.
//!
//! | tag | array | element |
//! |---|---|---|
//! | `POSI` `NORM` `RADI` | position, normal, radiance of the vertices | 3 × f32 |
//! | `VMAT` `DOFF` | material and distribution offset of the vertices | u32 |
//! | `DWRD` | distribution words | u32 |
//! | `TRIS` `EDGE` | triangles and their element edges | 3 × u32, u8 |
//! | `GCOR` `GMAT` | corners and materials of clear surfaces | 9 × f32, u32 |
//! | `MATS` `CAMS` `STAT` | materials, cameras, statistics | JSON |
//!
//! A reader trusts nothing: lengths bound every allocation, every index is checked, every number that must be finite
//! is looked at.

mod container;
mod records;

use crate::error::{FormatError, io_error, quote};
use crate::file;
use bytemuck::Pod;
use container::{Chunk, Tag};
use glam::Vec3;
use memmap2::Mmap;
use records::{CameraRecord, MaterialRecord};
use sheen_solver::directional::packed;
use sheen_solver::scene::check_camera;
use sheen_solver::solution::NO_DISTRIBUTION;
use sheen_solver::{Gloss, Material, Rgb, Solution};
use std::path::Path;

#[cfg(target_endian = "big")]
compile_error!("the arrays of a .sheen file are little endian and are read in place");

/// One chunk of a `.sheen` file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChunkInfo {
    /// Its name, four letters.
    pub tag: String,
    /// Its length.
    pub bytes: u64,
}

/// Writes `solution` to `path`, whole or not at all; the same solution always gives the same bytes.
///
/// Errors: a solution that [`read`] would refuse; what the operating system refuses.
pub fn write(path: &Path, solution: &Solution) -> Result<(), FormatError> {
    let fault = |message: String| FormatError::content(path, message);
    validate(solution)
        .map_err(|message| fault(format!("the solution is not written: {message}")))?;
    let json = |error: serde_json::Error| fault(format!("the solution is not written: {error}"));
    let materials: Vec<MaterialRecord> = solution
        .materials
        .iter()
        .map(MaterialRecord::from)
        .collect();
    let cameras: Vec<CameraRecord> = solution.cameras.iter().map(CameraRecord::from).collect();
    let materials = serde_json::to_vec(&materials).map_err(json)?;
    let cameras = serde_json::to_vec(&cameras).map_err(json)?;
    let stats = records::stats_json(&solution.stats).map_err(json)?;
    let chunks: [(Tag, &[u8]); 13] = [
        (*b"POSI", bytemuck::cast_slice(&solution.position)),
        (*b"NORM", bytemuck::cast_slice(&solution.normal)),
        (*b"RADI", bytemuck::cast_slice(&solution.radiance)),
        (*b"VMAT", bytemuck::cast_slice(&solution.material)),
        (
            *b"DOFF",
            bytemuck::cast_slice(&solution.distribution_offset),
        ),
        (*b"DWRD", bytemuck::cast_slice(&solution.distribution_words)),
        (*b"TRIS", bytemuck::cast_slice(&solution.triangles)),
        (*b"EDGE", &solution.element_edges),
        (*b"GCOR", bytemuck::cast_slice(&solution.glass_corners)),
        (*b"GMAT", bytemuck::cast_slice(&solution.glass_material)),
        (*b"MATS", &materials),
        (*b"CAMS", &cameras),
        (*b"STAT", &stats),
    ];
    file::write_whole(path, |writer| container::write(writer, &chunks))
}

/// Reads a `.sheen` file.
///
/// Errors, one line each: no such file, another format or version, truncated, damaged (checksum), inconsistent.
pub fn read(path: &Path) -> Result<Solution, FormatError> {
    decode(path, &map(path)?)
}

/// The solution in `file`, the bytes of a `.sheen` file; errors are those of [`read`] and name `path`.
pub fn decode(path: &Path, file: &[u8]) -> Result<Solution, FormatError> {
    assemble(file).map_err(|message| FormatError::content(path, message))
}

/// The chunks of a `.sheen` file in their order. Checks head and table, not the chunks' content.
pub fn chunks(path: &Path) -> Result<Vec<ChunkInfo>, FormatError> {
    let map = map(path)?;
    let chunks = container::read(&map).map_err(|message| FormatError::content(path, message))?;
    let info = |chunk: &Chunk| ChunkInfo {
        tag: chunk.tag.escape_ascii().to_string(),
        bytes: chunk.bytes.len() as u64,
    };
    Ok(chunks.iter().map(info).collect())
}

fn map(path: &Path) -> Result<Mmap, FormatError> {
    let (file, _) = file::open(path)?;
    // SAFETY: the map is private to this module, read-only, and dropped before the call that made it returns. Files
    // of ours are replaced by renaming and never changed in place; a stranger who truncates one while it is read
    // ends the process with a bus error, which no check of ours could prevent.
    #[allow(unsafe_code, reason = "a memory map; see the comment above")]
    let map = unsafe { Mmap::map(&file) };
    map.map_err(io_error(path))
}

fn assemble(file: &[u8]) -> Result<Solution, String> {
    let chunks = Chunks(container::read(file)?);
    if let Some(chunk) = chunks.0.iter().find(|chunk| !TAGS.contains(&&chunk.tag)) {
        return Err(format!(
            "holds a chunk {} that version {} does not have",
            chunk.tag.escape_ascii(),
            container::VERSION
        ));
    }
    let materials: Vec<MaterialRecord> = chunks.json(b"MATS")?;
    let cameras: Vec<CameraRecord> = chunks.json(b"CAMS")?;
    let solution = Solution {
        position: chunks.array(b"POSI")?,
        normal: chunks.array(b"NORM")?,
        radiance: chunks.array(b"RADI")?,
        material: chunks.array(b"VMAT")?,
        distribution_offset: chunks.array(b"DOFF")?,
        distribution_words: chunks.array(b"DWRD")?,
        triangles: chunks.array(b"TRIS")?,
        element_edges: chunks.array(b"EDGE")?,
        glass_corners: chunks.array(b"GCOR")?,
        glass_material: chunks.array(b"GMAT")?,
        materials: materials.into_iter().map(Into::into).collect(),
        cameras: cameras.into_iter().map(Into::into).collect(),
        stats: chunks.json(b"STAT")?,
    };
    validate(&solution)?;
    Ok(solution)
}

const TAGS: [&Tag; 13] = [
    b"POSI", b"NORM", b"RADI", b"VMAT", b"DOFF", b"DWRD", b"TRIS", b"EDGE", b"GCOR", b"GMAT",
    b"MATS", b"CAMS", b"STAT",
];

struct Chunks<'a>(Vec<Chunk<'a>>);

impl<'a> Chunks<'a> {
    fn get(&self, tag: &Tag) -> Result<&'a [u8], String> {
        let mut found = self.0.iter().filter(|chunk| chunk.tag == *tag);
        match (found.next(), found.next()) {
            (Some(chunk), None) => chunk.check().map(|()| chunk.bytes),
            (None, _) => Err(format!("has no chunk {}", tag.escape_ascii())),
            (Some(_), Some(_)) => Err(format!("has chunk {} twice", tag.escape_ascii())),
        }
    }

    /// The array in a chunk; its length is the chunk's, so nothing is allocated that the file does not fill.
    fn array<T: Pod>(&self, tag: &Tag) -> Result<Vec<T>, String> {
        let bytes = self.get(tag)?;
        let element = size_of::<T>();
        if !bytes.len().is_multiple_of(element) {
            let name = tag.escape_ascii();
            return Err(format!(
                "chunk {name} has {} bytes, expected a multiple of {element}",
                bytes.len()
            ));
        }
        // A map starts on a page and chunks are aligned, so the cast succeeds; bytes from elsewhere are copied.
        Ok(match bytemuck::try_cast_slice(bytes) {
            Ok(array) => array.to_vec(),
            Err(_) => bytemuck::pod_collect_to_vec(bytes),
        })
    }

    fn json<T: serde::de::DeserializeOwned>(&self, tag: &Tag) -> Result<T, String> {
        serde_json::from_slice(self.get(tag)?)
            .map_err(|error| format!("chunk {}: {error}", tag.escape_ascii()))
    }
}

/// Checks what every user of a solution relies on.
fn validate(s: &Solution) -> Result<(), String> {
    let vertices = s.position.len();
    for (what, count) in [
        ("normals", s.normal.len()),
        ("radiances", s.radiance.len()),
        ("vertex materials", s.material.len()),
        ("distribution offsets", s.distribution_offset.len()),
    ] {
        if count != vertices {
            return Err(format!("{count} {what} for {vertices} vertices"));
        }
    }
    if s.element_edges.len() != s.triangles.len() {
        return Err(format!(
            "{} element edges for {} triangles",
            s.element_edges.len(),
            s.triangles.len()
        ));
    }
    if s.glass_corners.len() != s.glass_material.len() {
        let (corners, materials) = (s.glass_corners.len(), s.glass_material.len());
        return Err(format!(
            "{materials} materials for {corners} clear surfaces"
        ));
    }
    finite("position", &s.position, |p| p.is_finite())?;
    finite("normal", &s.normal, |n| n.is_finite())?;
    finite("radiance", &s.radiance, |l| l.is_finite())?;
    finite("clear surface", &s.glass_corners, |corners: &[Vec3; 3]| {
        corners.iter().all(|p| p.is_finite())
    })?;
    for (owner, materials) in [
        ("vertex", &s.material),
        ("clear surface", &s.glass_material),
    ] {
        if let Some(index) = materials
            .iter()
            .position(|&m| m as usize >= s.materials.len())
        {
            let (material, count) = (materials[index], s.materials.len());
            return Err(format!(
                "{owner} {index} has material {material}, {count} exist"
            ));
        }
    }
    if let Some(index) = s
        .triangles
        .iter()
        .position(|t| t.iter().any(|&corner| corner as usize >= vertices))
    {
        return Err(format!(
            "triangle {index} has corners {:?}, {vertices} vertices exist",
            s.triangles[index]
        ));
    }
    if let Some(index) = s.element_edges.iter().position(|&edges| edges > 7) {
        return Err(format!(
            "triangle {index} has element edges {}, expected within 0..7",
            s.element_edges[index]
        ));
    }
    validate_distributions(s)?;
    s.materials.iter().try_for_each(validate_material)?;
    if s.cameras.is_empty() {
        return Err("holds no camera, expected at least one".to_owned());
    }
    s.cameras
        .iter()
        .try_for_each(|camera| check_camera(camera).map_err(|error| error.to_string()))
}

fn finite<T>(what: &str, values: &[T], is_finite: impl Fn(&T) -> bool) -> Result<(), String> {
    match values.iter().position(|value| !is_finite(value)) {
        Some(index) => Err(format!("{what} {index} is not finite")),
        None => Ok(()),
    }
}

fn validate_distributions(s: &Solution) -> Result<(), String> {
    let owners = s
        .distribution_offset
        .iter()
        .enumerate()
        .filter(|(_, offset)| **offset != NO_DISTRIBUTION);
    let words = s.distribution_words.len();
    // Each distribution reaches to the start of the next; the first starts where the words do.
    let ends = owners
        .clone()
        .skip(1)
        .map(|(_, &offset)| offset as usize)
        .chain([words]);
    let mut expected = 0;
    for ((vertex, &start), end) in owners.zip(ends) {
        let start = start as usize;
        if start != expected || end <= start || end > words {
            return Err(format!(
                "the distribution of vertex {vertex} at {start} does not lie where it should"
            ));
        }
        expected = end;
        if !packed::is_well_formed(&s.distribution_words[start..end]) {
            return Err(format!(
                "the distribution of vertex {vertex} is not well formed"
            ));
        }
    }
    if expected != words {
        return Err(format!("{words} distribution words that no vertex owns"));
    }
    Ok(())
}

fn validate_material(material: &Material) -> Result<(), String> {
    let (specular, shape) = match material.gloss {
        Gloss::None => (Rgb::BLACK, 0.0),
        Gloss::Phong { specular, exponent } => (specular, exponent),
        Gloss::Ward {
            specular,
            roughness,
        } => (specular, roughness),
    };
    let colours = [
        material.diffuse,
        specular,
        material.emission,
        material.transmission,
    ];
    let good = colours
        .iter()
        .flat_map(|c| c.to_array())
        .chain([shape])
        .all(|v| v.is_finite() && v >= 0.0);
    if good {
        Ok(())
    } else {
        Err(format!(
            "material {} has numbers out of range",
            quote(&material.name)
        ))
    }
}
