//! `sheen bench tables`

use crate::bench::table::Table;
use crate::bench::tables::{self, Case, Sheet, Tables};
use crate::camera::View;
use crate::cli::{input, note, progress};
use anyhow::Context;
use std::path::{Path, PathBuf};

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Name {
    /// Table 1: reflecting the sum against summing reflections.
    Sum,
    /// Table 2 and figure 7: the adaptive basis against the uniform one.
    Basis,
    /// Table 3: memory of illumination samples against radiance clustering.
    Memory,
    /// Table 4: time of the same.
    Time,
    /// Section 6.5: the Soda Shoppe.
    Soda,
    /// What shafts save of its visibility rays.
    Visibility,
    /// Figure 4: reflections of an area light by more and more samples.
    Convergence4,
    /// Figure 8: the absolute refiner against the relative one.
    Refiner,
}

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Which of them [default: all]
    #[arg(value_name = "TABLE")]
    tables: Vec<Name>,
    /// Folder of the scenes
    #[arg(long, default_value = "scenes", value_name = "FOLDER")]
    scenes: PathBuf,
    /// Soda Shoppe (.obj, .mgf), if there is one; tables of it alone are left out otherwise
    #[arg(long, value_name = "SCENE")]
    soda: Option<PathBuf>,
    /// Folder for the tables as .md, .csv and .json, and for the figures as .png [default: tables are printed only]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

impl Args {
    fn wants(&self, name: Name) -> bool {
        self.tables.is_empty() || self.tables.contains(&name)
    }

    /// A scene of ours by its name, seen by one of its cameras or by its first.
    fn case(&self, name: &str, camera: Option<&str>) -> anyhow::Result<Case> {
        let path = self.scenes.join(name).join(format!("{name}.obj"));
        case(name, &path, camera)
    }
}

fn case(name: &str, path: &Path, camera: Option<&str>) -> anyhow::Result<Case> {
    let scene = input::load_scene(path, false)?.scene;
    let camera = input::camera(scene.cameras(), camera)?;
    let view = View::new(&camera, scene.bounds()).with_context(|| path.display().to_string())?;
    Ok(Case {
        name: name.to_owned(),
        scene,
        view,
    })
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    super::check_folder(args.output.as_deref())?;
    let is_of_soda = |name: &Name| matches!(name, Name::Soda | Name::Visibility);
    if args.soda.is_none() && args.tables.iter().any(is_of_soda) {
        anyhow::bail!("tables of the Soda Shoppe need it: expected --soda SCENE");
    }
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let mut found: Vec<Table> = Vec::new();
    let mut sheets: Vec<Sheet> = Vec::new();
    if args.wants(Name::Sum) {
        let mut cases = Vec::new();
        for name in tables::LAMP_GRIDS {
            cases.push(args.case(name, None)?);
        }
        found.push(tables::sum(&cases, &mut observer)?);
    }
    if args.wants(Name::Basis) {
        let (name, camera) = tables::GLOSSY_ROOM;
        let (table, sheet) = tables::basis(&args.case(name, Some(camera))?, &mut observer)?;
        found.push(table);
        sheets.push(sheet);
    }
    if args.wants(Name::Memory) || args.wants(Name::Time) {
        let mut cases = Vec::new();
        for name in ["three_lights", "glossy_sphere", "cafe"] {
            cases.push(args.case(name, None)?);
        }
        if let Some(path) = &args.soda {
            cases.push(case("soda", path, None)?);
        }
        let Tables { memory, time } = tables::methods(&cases, &mut observer)?;
        let both = [(Name::Memory, memory), (Name::Time, time)];
        let wanted = both.into_iter().filter(|(name, _)| args.wants(*name));
        found.extend(wanted.map(|(_, table)| table));
    }
    if let Some(path) = &args.soda {
        if args.wants(Name::Soda) {
            found.push(tables::soda(&case("soda", path, None)?, &mut observer)?);
        }
        if args.wants(Name::Visibility) {
            found.push(tables::visibility(
                &case("soda", path, None)?,
                &mut observer,
            )?);
        }
    }
    if args.wants(Name::Convergence4) {
        let case = args.case(tables::AREA_LIGHT, None)?;
        let (table, sheet) = tables::convergence4(&case, &mut observer)?;
        found.push(table);
        sheets.push(sheet);
    }
    if args.wants(Name::Refiner) {
        let (name, camera) = tables::GLOSSY_ROOM;
        let (table, sheet) = tables::refiner(&args.case(name, Some(camera))?, &mut observer)?;
        found.push(table);
        sheets.push(sheet);
    }
    observer.finish();
    if progress::is_interrupted() {
        note("interrupted: keeping the rows that were measured");
    }
    if let Some(folder) = &args.output {
        for sheet in &sheets {
            if let Some((bytes, width, height)) = sheet.display() {
                let path = folder.join(format!("{}.png", sheet.name));
                sheen_formats::image::write_png(&path, &bytes, width, height)?;
            }
        }
    }
    super::give(&found, args.output.as_deref())
}
