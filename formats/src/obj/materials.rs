//! MTL files: found beside the scene, checked line by line, then read by `tobj`.

use super::scan::{Ignored, Scan, Statement, numbers, split_keyword, statements, words};
use crate::error::{FormatError, list, quote, suggestion};
use crate::file;
use sheen_solver::{Gloss, Material, Rgb};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// All material libraries of a scene as one.
#[derive(Default)]
pub(super) struct Libraries {
    /// The checked statements, for `tobj`.
    pub clean: String,
    /// File and line of each material by name.
    pub places: BTreeMap<String, (PathBuf, usize)>,
    /// One line each.
    pub notes: Vec<String>,
}

/// Reads the libraries that `scan` names and checks that every material in use is there.
pub(super) fn read(path: &Path, scan: &Scan, lenient: bool) -> Result<Libraries, FormatError> {
    let mut libraries = Libraries::default();
    let mut ignored = Ignored::default();
    for (line, rest) in &scan.libraries {
        match find(path, rest).and_then(|files| {
            files
                .iter()
                .try_for_each(|f| libraries.add(f, &mut ignored))
        }) {
            Ok(()) => {}
            Err(FormatError::Io {
                path: library,
                cause,
            }) => {
                let message = format!(
                    "material library {}: {cause}",
                    quote(&library.display().to_string())
                );
                if !lenient {
                    return Err(FormatError::line(path, *line, message));
                }
                libraries.notes.push(message);
            }
            Err(FormatError::Content { message, .. }) => {
                return Err(FormatError::line(path, *line, message));
            }
            Err(error) => return Err(error),
        }
    }
    libraries.note_ignored(ignored);
    let undefined = scan
        .uses
        .iter()
        .filter(|(name, _)| !libraries.places.contains_key(*name));
    let undefined: Vec<(&String, usize)> = undefined.map(|(name, &line)| (name, line)).collect();
    if let Some(&(name, line)) = undefined.iter().min_by_key(|(_, line)| *line) {
        if !lenient {
            let near = suggestion(name, libraries.places.keys().map(String::as_str));
            let reason = if scan.libraries.is_empty() {
                "the file names no mtllib"
            } else {
                "no mtllib defines it"
            };
            let message = format!(
                "usemtl {}: {reason}{near} (use --lenient to take grey)",
                quote(name)
            );
            return Err(FormatError::line(path, line, message));
        }
        let names = list(undefined.iter().map(|(name, _)| name.as_str()));
        libraries.notes.push(format!(
            "undefined materials become grey (diffuse 0.5): {names}"
        ));
    }
    Ok(libraries)
}

/// The files of one `mtllib` statement: the rest of the line as one name or, if there is no such file, its words.
fn find(scene: &Path, rest: &str) -> Result<Vec<PathBuf>, FormatError> {
    let folder = scene.parent().unwrap_or(Path::new(""));
    let locate = |name: &str| -> Result<PathBuf, FormatError> {
        // Names written on Windows.
        let name = name.trim_matches('"').replace('\\', "/");
        let plain = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if name.contains(':') || !Path::new(&name).components().all(plain) {
            let message = format!(
                "material library {} is refused: expected a file in the scene's folder",
                quote(&name)
            );
            return Err(FormatError::content(scene, message));
        }
        Ok(folder.join(name))
    };
    let whole = locate(rest)?;
    if whole.exists() || !rest.contains(char::is_whitespace) {
        return Ok(vec![whole]);
    }
    rest.split_whitespace().map(locate).collect()
}

impl Libraries {
    fn add(&mut self, path: &Path, ignored: &mut Ignored) -> Result<(), FormatError> {
        if let Some(kind) = file::looks_like(&file::head(path, 16)?) {
            let message = format!(
                "material library {} looks like {kind}",
                quote(&path.display().to_string())
            );
            return Err(FormatError::content(path, message));
        }
        let (text, latin1) = file::read_text(path)?;
        if latin1 {
            self.notes.push(format!(
                "{} is not UTF-8: read as Latin-1",
                quote(&path.display().to_string())
            ));
        }
        let mut inside = false;
        for Statement { line, text } in statements(&text) {
            let (keyword, rest) = split_keyword(&text);
            let fault = |message| FormatError::line(path, line, message);
            match keyword {
                "newmtl" => {
                    if rest.is_empty() {
                        return Err(fault("expected a name after newmtl".to_owned()));
                    }
                    inside = true;
                    if self
                        .places
                        .insert(rest.to_owned(), (path.to_owned(), line))
                        .is_some()
                    {
                        self.notes.push(format!(
                            "material {} is defined again: the last one counts",
                            quote(rest)
                        ));
                    }
                    self.clean.push_str(&format!("newmtl {rest}\n"));
                }
                "" => {}
                _ if keyword.starts_with('#') => {}
                _ if !inside => {
                    return Err(fault(format!(
                        "{} stands before the first newmtl",
                        quote(keyword)
                    )));
                }
                "Kd" | "Ks" | "Ke" => {
                    let [r, g, b] = colour(keyword, rest).map_err(fault)?;
                    self.clean.push_str(&format!("{keyword} {r} {g} {b}\n"));
                }
                "Ns" => {
                    let n = number(keyword, rest).map_err(fault)?;
                    self.clean.push_str(&format!("{keyword} {n}\n"));
                }
                "Ka" if colour(keyword, rest).is_ok_and(|c| c == [0.0; 3]) => {}
                "Tf" if colour(keyword, rest).is_ok_and(|c| c == [1.0; 3]) => {}
                "d" if number(keyword, rest) == Ok(1.0) => {}
                "Tr" if number(keyword, rest) == Ok(0.0) => {}
                _ => ignored.add(keyword),
            }
        }
        Ok(())
    }

    fn note_ignored(&mut self, mut ignored: Ignored) {
        let texture = |k: &str| {
            k.starts_with("map_") || matches!(k, "bump" | "disp" | "decal" | "refl" | "norm")
        };
        if let Some(found) = ignored.take(texture) {
            self.notes.push(format!(
                "textures are not read, the constant values are used: {found}"
            ));
        }
        if let Some(found) = ignored.take(|k| matches!(k, "d" | "Tr" | "Tf")) {
            self.notes
                .push(format!("transparent materials are opaque here: {found}"));
        }
        if let Some(found) = ignored.rest() {
            self.notes.push(format!("ignored in materials: {found}"));
        }
    }
}

/// Three numbers; one stands for all three.
fn colour(keyword: &str, rest: &str) -> Result<[f32; 3], String> {
    let found: Vec<&str> = words(rest).collect();
    match numbers(&found)?[..] {
        [grey] => Ok([grey; 3]),
        [r, g, b] => Ok([r, g, b]),
        _ => Err(format!(
            "expected 3 numbers after {keyword}, found {}",
            found.len()
        )),
    }
}

fn number(keyword: &str, rest: &str) -> Result<f32, String> {
    let found: Vec<&str> = words(rest).collect();
    match numbers(&found)?[..] {
        [value] => Ok(value),
        _ => Err(format!(
            "expected 1 number after {keyword}, found {}",
            found.len()
        )),
    }
}

/// The material that `tobj` read, in the terms of the solver. What an MTL leaves out is zero, its exponent is 1.
pub(super) fn convert(material: &tobj::Material) -> Material {
    let specular = Rgb::from(material.specular.unwrap_or_default());
    let mut converted = Material::lambert(
        &material.name,
        Rgb::from(material.diffuse.unwrap_or_default()),
    );
    if !specular.is_black() {
        converted.gloss = Gloss::Phong {
            specular,
            exponent: material.shininess.unwrap_or(1.0),
        };
    }
    converted.emission = Rgb::from(material.emissive.unwrap_or_default());
    converted
}
