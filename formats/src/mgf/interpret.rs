//! Executes the entities of a file and of those it includes: contexts change, transforms nest, surfaces gather.

use super::colour::Colour;
use super::context::{Contexts, Vertex};
use super::material::{MaterialTable, MgfMaterial};
use super::source::{Entity, Source};
use super::stats::MgfStats;
use super::surface::{Reader, Shape};
use super::xf::{Transform, Xf};
use crate::error::{FormatError, io_error, quote};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Most surfaces that arrays and includes may make.
pub(super) const SURFACE_LIMIT: u64 = 4_000_000;
/// Most entities that may be executed, arrays and includes repeated.
const ENTITY_LIMIT: u64 = 32_000_000;
/// Most files that `i` may execute, one executed twice counting twice.
const INCLUDE_LIMIT: u64 = 100_000;
/// Deepest nesting of `xf` and `i`.
const DEPTH_LIMIT: usize = 200;
/// So many unknown entities are named one by one.
const UNKNOWN_NAMED: usize = 10;
/// The name of the material that has none.
const UNNAMED: &str = "(unnamed)";

/// A shape with its material and the place it comes from.
pub(super) struct Surface {
    pub(super) shape: Shape,
    pub(super) material: u32,
    /// `file:line` is written only when a note needs it.
    pub(super) source: Rc<Source>,
    pub(super) line: usize,
}

/// All state between entities, and what has been gathered.
pub(super) struct Interpreter {
    colours: Contexts<Colour>,
    materials: Contexts<MgfMaterial>,
    vertices: Contexts<Vertex>,
    sources: HashMap<PathBuf, Rc<Source>>,
    /// Files that are open, outermost first.
    including: Vec<PathBuf>,
    depth: usize,
    executed: u64,
    included: u64,
    open_objects: u64,
    /// Places of unknown entities, in order.
    unknown: Vec<String>,
    /// Index of the material in a state of the material contexts.
    interned: Option<((usize, u64), u32)>,
    pub(super) table: MaterialTable,
    pub(super) surfaces: Vec<Surface>,
    pub(super) stats: MgfStats,
    pub(super) notes: Vec<String>,
}

impl Interpreter {
    /// Executes the file at `path`.
    pub(super) fn execute(path: &Path) -> Result<Self, FormatError> {
        let mut state = Self {
            colours: Contexts::new("colour"),
            materials: Contexts::new("material"),
            vertices: Contexts::new("vertex"),
            sources: HashMap::new(),
            including: vec![path.canonicalize().unwrap_or_else(|_| path.to_owned())],
            depth: 0,
            executed: 0,
            included: 0,
            open_objects: 0,
            unknown: Vec::new(),
            interned: None,
            table: MaterialTable::default(),
            surfaces: Vec::new(),
            stats: MgfStats::new(),
            notes: Vec::new(),
        };
        let bytes = std::fs::read(path).map_err(io_error(path))?;
        let source = state.load(path, &bytes)?;
        state.run(&source, 0..source.lines.len(), &Transform::IDENTITY)?;
        if state.open_objects > 0 {
            state.notes.push(format!(
                "{}: {} objects (o) are never ended",
                path.display(),
                state.open_objects
            ));
        }
        let named = state.unknown.iter().take(UNKNOWN_NAMED).cloned();
        state.notes.extend(named);
        if state.unknown.len() > UNKNOWN_NAMED {
            state.notes.push(format!(
                "{} more unknown entities ignored",
                state.unknown.len() - UNKNOWN_NAMED
            ));
        }
        Ok(state)
    }

    /// Splits a file and counts what is written in it.
    fn load(&mut self, path: &Path, bytes: &[u8]) -> Result<Rc<Source>, FormatError> {
        let source = Rc::new(Source::parse(path, bytes)?);
        for index in 0..source.lines.len() {
            let entity = source.entity(index);
            let keyword = entity.keyword();
            if is_known(keyword) {
                self.stats.add_entity(keyword);
            } else {
                self.unknown.push(format!(
                    "{}: unknown entity {} ignored",
                    entity.place(),
                    quote(keyword)
                ));
            }
        }
        Ok(source)
    }

    fn run(
        &mut self,
        source: &Rc<Source>,
        lines: Range<usize>,
        transform: &Transform,
    ) -> Result<(), FormatError> {
        let mut index = lines.start;
        while index < lines.end {
            let entity = source.entity(index);
            self.executed += 1;
            if self.executed > ENTITY_LIMIT {
                return Err(entity.fault(format!(
                    "more than {ENTITY_LIMIT} entities, arrays and includes repeated"
                )));
            }
            match entity.keyword() {
                "xf" => {
                    let end = source.lines[index].end;
                    let xf = Xf::parse(entity, 0)?;
                    let body = index + 1..end;
                    self.instances(entity, &xf, transform, |state, inner| {
                        state.run(source, body.clone(), inner)
                    })?;
                    index = end;
                }
                "i" => self.include(entity, transform)?,
                "f" | "fh" | "sph" | "cyl" | "cone" | "ring" | "torus" | "prism" => {
                    self.surface(source, index, transform)?;
                }
                _ => self.change(entity)?,
            }
            index += 1;
        }
        Ok(())
    }

    /// Runs `body` for every instance of an array; refuses arrays that would exceed the limits after one instance.
    fn instances(
        &mut self,
        entity: Entity<'_>,
        xf: &Xf,
        outer: &Transform,
        mut body: impl FnMut(&mut Self, &Transform) -> Result<(), FormatError>,
    ) -> Result<(), FormatError> {
        if self.depth >= DEPTH_LIMIT {
            return Err(entity.fault(format!(
                "transforms and includes are nested more than {DEPTH_LIMIT} deep"
            )));
        }
        self.depth += 1;
        let before = (self.executed, self.surfaces.len() as u64);
        for index in 0..xf.instance_count {
            self.executed += 1;
            body(self, &xf.instance(entity, outer, index)?)?;
            if index == 0 {
                // All instances are alike.
                let others = xf.instance_count - 1;
                let total = |now: u64, before: u64| {
                    (now - before).saturating_mul(others).saturating_add(now)
                };
                let surfaces = total(self.surfaces.len() as u64, before.1);
                let entities = total(self.executed, before.0);
                if surfaces > SURFACE_LIMIT || entities > ENTITY_LIMIT {
                    return Err(entity.fault(format!(
                        "an array of {} instances makes {surfaces} surfaces of {entities} entities: \
                         more than {SURFACE_LIMIT} of {ENTITY_LIMIT}",
                        xf.instance_count
                    )));
                }
            }
        }
        self.depth -= 1;
        Ok(())
    }

    /// `i file [transform]`, the file relative to the folder of the including one.
    fn include(&mut self, entity: Entity<'_>, transform: &Transform) -> Result<(), FormatError> {
        let Some(name) = entity.arguments().first() else {
            return Err(entity.wrong_count("i file [transform]"));
        };
        let path = entity.folder().join(name);
        let name = quote(name);
        self.included += 1;
        if self.included > INCLUDE_LIMIT {
            return Err(entity.fault(format!("more than {INCLUDE_LIMIT} includes")));
        }
        let unreadable = |reason: std::io::Error| {
            entity.fault(format!("cannot read the included {name}: {reason}"))
        };
        let canonical = path.canonicalize().map_err(unreadable)?;
        if self.including.contains(&canonical) {
            return Err(entity.fault(format!("{name} includes itself (recursion of 'i')")));
        }
        let source = if let Some(source) = self.sources.get(&canonical) {
            Rc::clone(source)
        } else {
            if !canonical.is_file() {
                return Err(
                    entity.fault(format!("cannot read the included {name}: expected a file"))
                );
            }
            let bytes = std::fs::read(&canonical).map_err(unreadable)?;
            let source = self.load(&path, &bytes)?;
            self.sources.insert(canonical.clone(), Rc::clone(&source));
            source
        };
        let xf = Xf::parse(entity, 1)?;
        self.including.push(canonical);
        self.instances(entity, &xf, transform, |state, inner| {
            state.run(&source, 0..source.lines.len(), inner)
        })?;
        self.including.pop();
        Ok(())
    }

    fn surface(
        &mut self,
        source: &Rc<Source>,
        index: usize,
        transform: &Transform,
    ) -> Result<(), FormatError> {
        let entity = source.entity(index);
        let reader = Reader {
            entity,
            transform,
            vertices: &self.vertices,
        };
        let measured = reader.read(&mut self.stats)?;
        let material = self.materials.current();
        let name = self.materials.current_name().unwrap_or(UNNAMED);
        self.stats
            .add_surface(entity.keyword(), name, measured.area, material.emittance());
        if measured.shapes.is_empty() {
            if measured.area > 0.0 {
                self.note_once(format!(
                    "{}: a cone without height has no direction: dropped",
                    entity.place()
                ));
            }
            return Ok(());
        }
        let state = self.materials.state();
        let interned = self
            .interned
            .filter(|(known, _)| *known == state)
            .map(|(_, index)| index);
        let index_of_material =
            interned.unwrap_or_else(|| self.table.intern(name, material, &mut self.notes));
        self.interned = Some((state, index_of_material));
        self.surfaces
            .extend(measured.shapes.into_iter().map(|shape| Surface {
                shape,
                material: index_of_material,
                source: Rc::clone(source),
                line: index,
            }));
        if self.surfaces.len() as u64 > SURFACE_LIMIT {
            return Err(entity.fault(format!("more than {SURFACE_LIMIT} surfaces")));
        }
        Ok(())
    }

    /// Entities that change a context, or nothing.
    fn change(&mut self, entity: Entity<'_>) -> Result<(), FormatError> {
        match entity.keyword() {
            "v" => self.vertices.open(entity),
            "p" | "n" => self.vertices.current_mut().set(entity),
            "c" => self.colours.open(entity),
            "cxy" | "cspec" | "cct" => {
                *self.colours.current_mut() = Colour::parse(entity)?;
                Ok(())
            }
            "cmix" => self.mix(entity),
            "m" => self.materials.open(entity),
            "sides" | "rd" | "td" | "ed" | "rs" | "ts" | "ir" => {
                let colour = *self.colours.current();
                self.materials.current_mut().set(entity, colour)
            }
            "o" => {
                self.object(entity);
                Ok(())
            }
            "ies" => {
                let Some(name) = entity.arguments().first() else {
                    return Err(entity.wrong_count("ies file [-m multiplier] [transform]"));
                };
                self.note_once(format!(
                    "{}: luminaire file {} (ies) is not read: its light is missing",
                    entity.place(),
                    quote(name)
                ));
                Ok(())
            }
            // Noted when its file was loaded; Radiance goes on, too.
            _ => Ok(()),
        }
    }

    /// `cmix weight colour weight colour ...`
    fn mix(&mut self, entity: Entity<'_>) -> Result<(), FormatError> {
        let count = entity.arguments().len();
        if count < 4 || count % 2 == 1 {
            return Err(entity.wrong_count("cmix weight1 colour1 weight2 colour2 ..."));
        }
        let pairs = (0..count).step_by(2).map(|at| {
            let colour = self.colours.get(entity, &entity.arguments()[at + 1])?;
            Ok((entity.number(at, "a weight")?, *colour))
        });
        let mixed = Colour::mix(entity, &pairs.collect::<Result<Vec<_>, FormatError>>()?)?;
        *self.colours.current_mut() = mixed;
        Ok(())
    }

    /// Objects have names for people; only their nesting is followed.
    fn object(&mut self, entity: Entity<'_>) {
        if !entity.arguments().is_empty() {
            self.open_objects += 1;
        } else if self.open_objects > 0 {
            self.open_objects -= 1;
        } else {
            self.note_once(format!(
                "{}: 'o' ends an object, but none is open",
                entity.place()
            ));
        }
    }

    /// Arrays execute a line many times; it is worth one note.
    fn note_once(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }
}

fn is_known(keyword: &str) -> bool {
    matches!(
        keyword,
        "v" | "p"
            | "n"
            | "c"
            | "cxy"
            | "cspec"
            | "cmix"
            | "cct"
            | "m"
            | "sides"
            | "rd"
            | "td"
            | "rs"
            | "ts"
            | "ir"
            | "ed"
            | "f"
            | "fh"
            | "sph"
            | "cyl"
            | "cone"
            | "ring"
            | "torus"
            | "prism"
            | "o"
            | "xf"
            | "i"
            | "ies"
    )
}
