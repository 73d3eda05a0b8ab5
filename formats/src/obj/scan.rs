//! First look at the text: every statement is checked where it stands, so that an error can name its line, and
//! what `tobj` is not to see is left out.

use crate::error::{FormatError, quote};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// A statement and the number of its first line.
pub(super) struct Statement<'a> {
    /// From 1.
    pub line: usize,
    /// Without line end; lines that end in `\` are joined with the next.
    pub text: Cow<'a, str>,
}

/// The statements of an OBJ or MTL file. Lines end in LF, CR LF or (old Macintosh) CR.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let mut lines = text.split(end).enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut text = Cow::Borrowed(first.trim());
        while let Some(part) = text.strip_suffix('\\') {
            let Some((_, next)) = lines.next() else {
                text = Cow::Owned(part.to_owned());
                break;
            };
            let part_length = part.len();
            let joined = text.to_mut();
            joined.truncate(part_length);
            joined.push(' ');
            joined.push_str(next.trim());
        }
        Some(Statement {
            line: index + 1,
            text,
        })
    })
}

/// Statements that are not represented: keyword and how often it stands there.
#[derive(Debug, Default)]
pub(super) struct Ignored {
    counts: BTreeMap<String, usize>,
    others: usize,
}

impl Ignored {
    /// Distinct keywords that are kept apart: a file that is no OBJ at all has millions.
    const DISTINCT: usize = 40;

    pub(super) fn add(&mut self, keyword: &str) {
        if let Some(count) = self.counts.get_mut(keyword) {
            *count += 1;
        } else if self.counts.len() < Self::DISTINCT && keyword.len() <= 32 {
            self.counts.insert(keyword.to_owned(), 1);
        } else {
            self.others += 1;
        }
    }

    /// Takes the keywords out for which `which` holds: "Ni (3), illum (2)", or nothing when there are none.
    pub(super) fn take(&mut self, which: impl Fn(&str) -> bool) -> Option<String> {
        let mut taken = Vec::new();
        self.counts.retain(|keyword, count| {
            let matches = which(keyword);
            if matches {
                taken.push(format!("{keyword} ({count})"));
            }
            !matches
        });
        (!taken.is_empty()).then(|| taken.join(", "))
    }

    /// What is left: statements of no known kind.
    pub(super) fn rest(mut self) -> Option<String> {
        let others = self.others;
        let known = self.take(|_| true);
        match (known, others) {
            (None, 0) => None,
            (Some(text), 0) => Some(text),
            (None, n) => Some(format!("unknown keywords ({n})")),
            (Some(text), n) => Some(format!("{text}, other unknown keywords ({n})")),
        }
    }
}

/// What the scan of an OBJ file found.
#[derive(Default)]
pub(super) struct Scan {
    /// The checked statements `v`, `vn`, `f`, `usemtl`: what `tobj` reads.
    pub clean: String,
    /// Line of each face.
    pub face_lines: Vec<usize>,
    /// Whether the corners of each face have normals.
    pub face_has_normals: Vec<bool>,
    /// `mtllib` statements: line and the rest of it.
    pub libraries: Vec<(usize, String)>,
    /// Material names in use and the line of their first `usemtl`.
    pub uses: BTreeMap<String, usize>,
    /// Faces that stand before the first `usemtl`.
    pub faces_without_material: usize,
    /// Statements that are not represented.
    pub ignored: Ignored,
}

/// Checks the statements of an OBJ file.
pub(super) fn scan(path: &Path, text: &str) -> Result<Scan, FormatError> {
    let mut scan = Scan::default();
    let mut counts = Counts::default();
    scan.clean.reserve(text.len());
    for Statement { line, text } in statements(text) {
        let (keyword, rest) = split_keyword(&text);
        scan.statement(keyword, rest, &mut counts, line)
            .map_err(|message| FormatError::line(path, line, message))?;
    }
    Ok(scan)
}

/// First word and the rest, trimmed.
pub(super) fn split_keyword(text: &str) -> (&str, &str) {
    text.split_once(char::is_whitespace)
        .map_or((text, ""), |(keyword, rest)| (keyword, rest.trim()))
}

/// The words of a statement of numbers, without a comment at its end.
pub(super) fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace()
        .take_while(|word| !word.starts_with('#'))
}

/// Entries so far: indices count from the start or, when negative, from here.
#[derive(Default)]
struct Counts {
    positions: usize,
    texture_coordinates: usize,
    normals: usize,
}

impl Scan {
    fn statement(
        &mut self,
        keyword: &str,
        rest: &str,
        counts: &mut Counts,
        line: usize,
    ) -> Result<(), String> {
        match keyword {
            "" => {}
            "v" => {
                counts.positions += 1;
                self.position(rest)?;
            }
            "vn" => {
                counts.normals += 1;
                let found: Vec<&str> = words(rest).collect();
                let [_, _, _] = numbers(&found)?[..] else {
                    return Err(format!(
                        "expected 3 numbers after vn, found {}",
                        found.len()
                    ));
                };
                self.keep("vn", &found);
            }
            "vt" => counts.texture_coordinates += 1,
            "f" => self.face(rest, counts, line)?,
            "usemtl" => {
                if rest.is_empty() {
                    return Err("expected a material name after usemtl".to_owned());
                }
                self.uses.entry(rest.to_owned()).or_insert(line);
                self.keep("usemtl", &[rest]);
            }
            "mtllib" => {
                if rest.is_empty() {
                    return Err("expected a file name after mtllib".to_owned());
                }
                self.libraries.push((line, rest.to_owned()));
            }
            // Names and groups have no meaning for light.
            "o" | "g" => {}
            "s" if matches!(rest, "off" | "0" | "") => {}
            _ if keyword.starts_with('#') => {}
            _ => self.ignored.add(keyword),
        }
        Ok(())
    }

    fn keep(&mut self, keyword: &str, words: &[&str]) {
        self.clean.push_str(keyword);
        for word in words {
            self.clean.push(' ');
            self.clean.push_str(word);
        }
        self.clean.push('\n');
    }

    fn position(&mut self, rest: &str) -> Result<(), String> {
        let found: Vec<&str> = words(rest).collect();
        match numbers(&found)?[..] {
            [_, _, _] => {}
            [_, _, _, 0.0] => {
                return Err("the weight w of the position is 0: it has no place".to_owned());
            }
            [_, _, _, _] => {}
            // Colours at vertices: tools write them, nothing standard says what they mean.
            [_, _, _, _, _, _] | [_, _, _, _, _, _, _] => {
                self.ignored.add("vertex colour");
                self.keep("v", &found[..3]);
                return Ok(());
            }
            _ => return Err(format!("expected 3 numbers after v, found {}", found.len())),
        }
        self.keep("v", &found);
        Ok(())
    }

    fn face(&mut self, rest: &str, counts: &Counts, line: usize) -> Result<(), String> {
        self.clean.push('f');
        let (mut corners, mut with_normals) = (0, 0);
        for word in words(rest) {
            corners += 1;
            with_normals += usize::from(
                check_corner(word, counts).map_err(|m| format!("corner {corners}: {m}"))?,
            );
            self.clean.push(' ');
            self.clean.push_str(word);
        }
        self.clean.push('\n');
        if corners < 3 {
            return Err(format!(
                "expected at least 3 corners after f, found {corners}"
            ));
        }
        if with_normals != 0 && with_normals != corners {
            return Err(format!(
                "{with_normals} of {corners} corners have a normal, expected all or none"
            ));
        }
        self.face_lines.push(line);
        self.face_has_normals.push(with_normals != 0);
        self.faces_without_material += usize::from(self.uses.is_empty());
        Ok(())
    }
}

/// Checks `v`, `v/vt`, `v//vn` or `v/vt/vn`; true when there is a normal.
fn check_corner(word: &str, counts: &Counts) -> Result<bool, String> {
    let mut parts = word.split('/');
    let (position, texture, normal) = (parts.next().unwrap_or(""), parts.next(), parts.next());
    let shape = || format!("expected v, v/vt, v//vn or v/vt/vn, found {}", quote(word));
    if parts.next().is_some() {
        return Err(shape());
    }
    let check = |part: &str, what: &str, count: usize| -> Result<(), String> {
        let Ok(index) = part.parse::<i64>() else {
            return Err(shape());
        };
        if index == 0 {
            return Err(format!("the {what} index is 0, indices count from 1"));
        }
        if index.unsigned_abs() > count as u64 {
            return Err(format!(
                "the {what} index {index} is out of range, {count} stand before this line"
            ));
        }
        Ok(())
    };
    check(position, "position", counts.positions)?;
    match (texture, normal) {
        (None, _) => Ok(false),
        (Some(""), None | Some("")) => Err(shape()),
        (Some(texture), normal) => {
            if !texture.is_empty() {
                check(texture, "texture coordinate", counts.texture_coordinates)?;
            }
            if let Some(normal) = normal {
                check(normal, "normal", counts.normals)?;
            }
            Ok(normal.is_some())
        }
    }
}

/// The words as numbers. NaN and infinite ones are numbers here: what to do with them is decided with the scene.
pub(super) fn numbers(words: &[&str]) -> Result<Vec<f32>, String> {
    words
        .iter()
        .map(|word| {
            word.parse()
                .map_err(|_| format!("expected a number, found {}", quote(word)))
        })
        .collect()
}
