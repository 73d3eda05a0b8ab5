//! `sheen compare TEST.exr REFERENCE.exr`

use super::{input, values};
use crate::compare::{compare, heatmap};
use anyhow::Context;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Image to judge (.exr, linear radiance)
    test: PathBuf,
    /// What it should look like (.exr)
    reference: PathBuf,
    /// Average blocks of K x K pixels first
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096), value_name = "K")]
    downsample: u32,
    /// Factor before display encoding, for PSNR and FLIP [default: .8 over the reference's 95th percentile]
    #[arg(long, value_parser = values::positive, value_name = "E")]
    exposure: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write the FLIP error of every pixel as a picture: black 0, pale yellow 1
    #[arg(long, value_name = "H.png")]
    heatmap: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    if let Some(path) = &args.heatmap {
        input::check_output(path)?;
    }
    let test = sheen_formats::image::read_exr(&args.test)?;
    let reference = sheen_formats::image::read_exr(&args.reference)?;
    let comparison =
        compare(&test, &reference, args.downsample, args.exposure).with_context(|| {
            format!(
                "{} against {}",
                args.test.display(),
                args.reference.display()
            )
        })?;
    if let Some(path) = &args.heatmap {
        let bytes = heatmap::image(&comparison.flip_map);
        sheen_formats::image::write_png(path, &bytes, comparison.width, comparison.height)?;
    }
    if args.json {
        return super::print(&(serde_json::to_string(&comparison)? + "\n"));
    }
    let mut text = String::new();
    for (name, value) in comparison.rows() {
        writeln!(text, "{name:16} {value:.6}")?;
    }
    super::print(&text)
}
