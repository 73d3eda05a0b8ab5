//! `sheen bench rays SCENE`

use crate::bench::rays::{RayBench, npy, rays};
use crate::cli::{input, note, progress};
use anyhow::Context;
use sheen_solver::{Quality, SolveConfig};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene (.obj, .mgf)
    scene: PathBuf,
    /// Rays of each kind, at most
    #[arg(
        long,
        default_value_t = 2_000_000,
        value_parser = clap::value_parser!(u32).range(1..=100_000_000),
        value_name = "N"
    )]
    rays: u32,
    /// Of the solve whose rays they are: draft, preview, default, high, or a number within 0..4
    #[arg(long, default_value = "default", value_name = "QUALITY")]
    quality: Quality,
    /// Folder for rays.md, .csv and .json, and for the rays themselves: random.npy, solve.npy, each n x 6 numbers, where a
    /// ray begins and the way to its end, in the scene's units [default: the table is printed only]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    super::check_folder(args.output.as_deref())?;
    let loaded = input::load_scene(&args.scene, false)?;
    progress::catch_interrupts();
    let config = SolveConfig {
        quality: args.quality,
        ..SolveConfig::default()
    };
    note("collecting the rays of a solve");
    let RayBench { table, kinds } = rays(&loaded.scene, &config, args.rays as usize)?;
    if let Some(folder) = &args.output {
        for (name, rays) in kinds {
            let path = folder.join(format!("{name}.npy"));
            std::fs::write(&path, npy(&rays)).with_context(|| path.display().to_string())?;
        }
    }
    super::give(&[table], args.output.as_deref())
}
