//! `sheen bench frames SCENE|SOLUTION`

use crate::bench::frames::{Walk, frames};
use crate::cli::{input, note, progress, values};
use crate::gpu::Gpu;
use anyhow::Context;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Solution (.sheen), or a scene (.obj, .mgf) that is solved first
    input: PathBuf,
    /// Sizes of the pictures
    #[arg(
        long,
        value_delimiter = ',',
        value_parser = values::size,
        default_value = "1280x720,1920x1080,3840x2160",
        value_name = "WxH,..."
    )]
    sizes: Vec<(u32, u32)>,
    /// Frames of each row
    #[arg(
        long,
        default_value_t = Walk::default().frames,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000),
        value_name = "N"
    )]
    frames: u32,
    /// Folder for frames.md, .csv and .json [default: the table is printed only]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    solve: input::SolveArgs,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    super::check_folder(args.output.as_deref())?;
    let place = || args.input.display().to_string();
    let gpu = Gpu::headless()?;
    let solution = input::solution(&args.input, &args.solve)?;
    anyhow::ensure!(
        !solution.cameras.is_empty(),
        "{}: holds no camera, expected at least one",
        place()
    );
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let walk = Walk {
        sizes: args.sizes.clone(),
        frames: args.frames,
        ..Walk::default()
    };
    let table = frames(&gpu, &solution, &walk, &mut observer).with_context(place)?;
    observer.finish();
    if progress::is_interrupted() {
        note("interrupted: keeping the rows that were measured");
    }
    super::give(&[table], args.output.as_deref())
}
