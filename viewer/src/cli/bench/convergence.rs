//! `sheen bench convergence SCENE`

use crate::bench::convergence::{Ladder, Step, Truth, climb};
use crate::bench::plot;
use crate::camera::View;
use crate::cli::{input, note, print, progress, values};
use crate::ways::path::{Budget, trace};
use anyhow::Context;
use sheen_solver::{Camera, PathTracer, Quality, Scene, SolveConfig};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene (.obj, .mgf)
    scene: PathBuf,
    /// Folder for convergence.md, .csv, .json and .svg [default: the table is printed only]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Qualities, cheapest first: names or numbers within 0..4
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "draft,preview,default,high",
        value_name = "Q,Q,..."
    )]
    qualities: Vec<Quality>,
    /// Deepest subdivisions of directional distributions, at one quality, instead of qualities
    #[arg(long, value_delimiter = ',', value_name = "N,N,...", conflicts_with = "qualities",
        value_parser = clap::value_parser!(u32).range(1..=7))]
    levels: Vec<u32>,
    /// Largest deviations within cells of distributions, at one quality, instead of qualities
    #[arg(long, value_delimiter = ',', value_name = "E,E,...", conflicts_with_all = ["qualities", "levels"],
        value_parser = values::positive)]
    epsilons: Vec<f64>,
    /// Memory limits, below which the quality is lowered, instead of qualities
    #[arg(long, value_delimiter = ',', value_name = "SIZE,SIZE,...",
        conflicts_with_all = ["qualities", "levels", "epsilons"], value_parser = values::bytes)]
    memory_limits: Vec<u64>,
    /// The one quality of levels and deviations, and the highest of memory limits
    #[arg(
        long,
        default_value = "default",
        value_name = "QUALITY",
        conflicts_with = "qualities"
    )]
    quality: Quality,
    /// Camera of the scene [default: its first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// What the picture should look like (.exr) [default: path tracing]
    #[arg(long, value_name = "R.exr")]
    reference: Option<PathBuf>,
    /// relMSE of the reference's own noise, averaged over 2 x 2 pixels, which is subtracted
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "RELMSE",
        requires = "reference"
    )]
    reference_noise: f64,
    /// Paths a pixel of a path-traced reference
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(2..=1 << 24), value_name = "N", conflicts_with = "reference")]
    spp: u32,
    /// Random points and directions that the error over all surfaces is measured at
    #[arg(long, default_value_t = 1 << 18, value_parser = clap::value_parser!(u32).range(2..=1 << 28), value_name = "N")]
    probes: u32,
    /// Repair faults of the scene that can be repaired, and say so, instead of refusing it
    #[arg(long)]
    lenient: bool,
}

/// What is traded, and its steps.
fn steps(args: &Args) -> (&'static str, Vec<Step>) {
    let step = |label: String, config: SolveConfig| Step { label, config };
    let at_quality = SolveConfig {
        quality: args.quality,
        ..SolveConfig::default()
    };
    let of_level = |&level: &u32| {
        let max_level = Some(level);
        step(
            level.to_string(),
            SolveConfig {
                max_level,
                ..at_quality.clone()
            },
        )
    };
    let of_epsilon = |&epsilon: &f64| {
        let deviation = Some(epsilon as f32);
        step(
            epsilon.to_string(),
            SolveConfig {
                epsilon: deviation,
                ..at_quality.clone()
            },
        )
    };
    let of_limit = |&bytes: &u64| {
        let memory_limit = Some(bytes);
        let label = format!("{}", bytesize::ByteSize(bytes).display().iec());
        step(
            label,
            SolveConfig {
                memory_limit,
                ..at_quality.clone()
            },
        )
    };
    let of_quality = |&quality: &Quality| {
        let config = SolveConfig {
            quality,
            ..SolveConfig::default()
        };
        step(quality.value().to_string(), config)
    };
    if !args.levels.is_empty() {
        ("levels", args.levels.iter().map(of_level).collect())
    } else if !args.epsilons.is_empty() {
        ("epsilon", args.epsilons.iter().map(of_epsilon).collect())
    } else if !args.memory_limits.is_empty() {
        (
            "memory limit",
            args.memory_limits.iter().map(of_limit).collect(),
        )
    } else {
        ("quality", args.qualities.iter().map(of_quality).collect())
    }
}

fn truth(
    args: &Args,
    scene: &Scene,
    view: &View,
    observer: &mut progress::TerminalObserver,
) -> anyhow::Result<Truth> {
    if let Some(path) = &args.reference {
        return Ok(Truth {
            image: sheen_formats::image::read_exr(path)?,
            noise: args.reference_noise,
            source: path
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        });
    }
    let budget = Budget {
        samples: args.spp,
        time_limit: None,
    };
    Ok(Truth::traced(trace(
        &PathTracer::new(scene),
        view,
        budget,
        0,
        observer,
    )))
}

fn files(ladder: &Ladder) -> anyhow::Result<Vec<(&'static str, String)>> {
    let points: Vec<(f64, f64, String)> = ladder
        .rows
        .iter()
        .map(|row| {
            let label = format!("{} {}", ladder.dimension, row.step);
            (row.seconds, row.relmse, label)
        })
        .collect();
    let mut files = vec![
        ("convergence.md", ladder.markdown()),
        ("convergence.csv", ladder.csv()),
        (
            "convergence.json",
            serde_json::to_string_pretty(ladder)? + "\n",
        ),
    ];
    if let Some(svg) = plot::log_log(&ladder.scene, ["seconds", "relMSE"], &points) {
        files.push(("convergence.svg", svg));
    }
    Ok(files)
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        input::check_output(&folder.join("convergence.csv"))?;
    }
    let scene = input::load_scene(&args.scene, args.lenient)?.scene;
    let camera: Camera = input::camera(scene.cameras(), args.camera.as_deref())?;
    let view =
        View::new(&camera, scene.bounds()).with_context(|| args.scene.display().to_string())?;
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let truth = truth(args, &scene, &view, &mut observer)?;
    let name = args.scene.file_stem().unwrap_or(args.scene.as_os_str());
    let name = name.to_string_lossy();
    let (dimension, steps) = steps(args);
    let ladder = climb(
        &name,
        &scene,
        (dimension, &steps),
        &view,
        &truth,
        args.probes,
        &mut observer,
    )
    .with_context(|| args.scene.display().to_string())?;
    observer.finish();
    if progress::is_interrupted() {
        note("interrupted: keeping the steps that were measured");
    }
    if let Some(folder) = &args.output {
        for (name, text) in files(&ladder)? {
            input::write_text(&Path::new(folder).join(name), &text)?;
        }
    }
    print(&ladder.markdown())
}
