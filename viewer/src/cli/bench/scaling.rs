//! `sheen bench scaling`

use crate::bench::scaling::scaling;
use crate::cli::{note, progress};
use sheen_solver::{Quality, SolveConfig};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Triangles of each room, about
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1000,10000,100000,1000000",
        value_parser = clap::value_parser!(u32).range(100..=20_000_000),
        value_name = "N,N,..."
    )]
    triangles: Vec<u32>,
    /// draft, preview, default, high, or a number within 0..4
    #[arg(long, default_value = "preview", value_name = "QUALITY")]
    quality: Quality,
    /// Folder for scaling.md, .csv and .json [default: the table is printed only]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    super::check_folder(args.output.as_deref())?;
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let config = SolveConfig {
        quality: args.quality,
        ..SolveConfig::default()
    };
    let table = scaling(&args.triangles, &config, &mut observer)?;
    observer.finish();
    if progress::is_interrupted() {
        note("interrupted: keeping the rows that were measured");
    }
    super::give(&[table], args.output.as_deref())
}
