//! `sheen bench`: tables of time, memory and error.

mod convergence;
mod frames;
mod rays;
mod scaling;
mod tables;

use super::{input, print};
use crate::bench::table::Table;
use anyhow::Context;
use std::path::Path;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Time, memory and error of a scene at rising qualities, or along another thing that is traded.
    Convergence(convergence::Args),
    /// The tables of Stamminger et al. 2000, theirs beside ours.
    Tables(tables::Args),
    /// Frames of a walk through a solution: time on the graphics device, frames a second.
    Frames(frames::Args),
    /// Visibility rays a second, on one thread.
    Rays(rays::Args),
    /// Time and memory of one room with more and finer things in it.
    Scaling(scaling::Args),
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    match &args.what {
        What::Convergence(args) => convergence::run(args),
        What::Tables(args) => tables::run(args),
        What::Frames(args) => frames::run(args),
        What::Rays(args) => rays::run(args),
        What::Scaling(args) => scaling::run(args),
    }
}

/// Writes each table as Markdown, CSV and JSON into `folder`, if there is one, and prints it.
fn give(tables: &[Table], folder: Option<&Path>) -> anyhow::Result<()> {
    for table in tables {
        if let Some(folder) = folder {
            for (kind, text) in [
                ("md", table.markdown()),
                ("csv", table.csv()),
                ("json", table.json()?),
            ] {
                input::write_text(&folder.join(format!("{}.{kind}", table.name)), &text)?;
            }
        }
        print(&table.markdown())?;
        print("\n")?;
    }
    Ok(())
}

/// Makes sure, before anything costly is done, that `folder` can take tables.
fn check_folder(folder: Option<&Path>) -> anyhow::Result<()> {
    let Some(folder) = folder else { return Ok(()) };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    input::check_output(&folder.join("table.md"))
}
