//! `sheen solve SCENE -o S.sheen`

use super::input;
use anyhow::Context;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene (.obj, .mgf)
    scene: PathBuf,
    /// Solution to write (.sheen)
    #[arg(short, long, value_name = "S.sheen")]
    output: PathBuf,
    /// Write counters, bytes and seconds as JSON
    #[arg(long, value_name = "S.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    solve: input::SolveArgs,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    anyhow::ensure!(
        input::is_solution(&args.output),
        "{}: expected a file name that ends in .sheen",
        args.output.display()
    );
    input::check_output(&args.output)?;
    if let Some(path) = &args.stats {
        input::check_output(path)?;
    }
    let solution = input::solve_scene(&args.scene, &args.solve)?;
    sheen_formats::solution::write(&args.output, &solution)?;
    if let Some(path) = &args.stats {
        let json = serde_json::to_string_pretty(&solution.stats).context("statistics")?;
        input::write_text(path, &(json + "\n"))?;
    }
    let stats = &solution.stats.solve;
    super::print(&format!(
        "{}: {} triangles, {} vertices, {} with a distribution; {:.1} s, {:.0} MiB\n",
        args.output.display(),
        solution.triangles.len(),
        solution.position.len(),
        crate::panels::glossy_vertices(&solution),
        stats.wall_s,
        stats.peak_rss_bytes as f64 / f64::from(1 << 20)
    ))
}
