//! `sheen verify SCENE`

use super::{input, progress};
use crate::verify::{Errors, Estimate, Verification, verify, verify_furnace};
use anyhow::Context;
use sheen_solver::solve::{enclosed, solve_furnace};
use sheen_solver::{PathTracer, Scene};
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scene (.obj, .mgf)
    scene: PathBuf,
    /// Its solution [default: the scene is solved first]
    #[arg(long, value_name = "S.sheen", conflicts_with = "furnace")]
    solution: Option<PathBuf>,
    /// Solve the scene as a directional furnace: all surfaces emit what they do not reflect, so that light is the same
    /// everywhere
    #[arg(long)]
    furnace: bool,
    /// Random points and directions, two paths each
    #[arg(long, default_value_t = 1 << 18, value_parser = clap::value_parser!(u32).range(2..=1 << 28), value_name = "N")]
    probes: u32,
    /// Other random numbers
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    solve: input::SolveArgs,
}

fn percent(estimate: &Estimate, sign: bool) -> String {
    let [value, low, high] = [estimate.value, estimate.low, estimate.high].map(|x| x * 100.0);
    if sign {
        format!("{value:+.2} ({low:+.2} to {high:+.2})")
    } else {
        format!("{value:.2} ({low:.2} to {high:.2})")
    }
}

fn row(text: &mut String, name: &str, share: f64, errors: &Errors) -> std::fmt::Result {
    writeln!(
        text,
        "{name:24} {:>9} {:>11.4e} {:>28} {:>28} {:>8.1}",
        errors.probes,
        errors.radiance,
        percent(&errors.bias, true),
        percent(&errors.rms, false),
        share * 100.0
    )
}

fn table(found: &Verification) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(
        text,
        "{:24} {:>9} {:>11} {:>28} {:>28} {:>8}",
        "material", "probes", "radiance", "bias % (95 %)", "rms error % (95 %)", "share %"
    )?;
    row(&mut text, "all", 1.0, &found.all)?;
    for one in &found.materials {
        row(&mut text, &one.material, one.share, &one.errors)?;
    }
    Ok(text)
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    anyhow::ensure!(
        !input::is_solution(&args.scene),
        "{}: is a solution, expected the scene that it solves, with --solution {0}",
        args.scene.display()
    );
    let scene = input::load_scene(&args.scene, args.solve.is_lenient())?.scene;
    let found = if args.furnace {
        furnace(args, &scene)?
    } else {
        paths(args, &scene)?
    };
    let found = found.with_context(|| {
        format!(
            "{}: nothing to verify, expected surfaces",
            args.scene.display()
        )
    })?;
    super::print(&if args.json {
        serde_json::to_string(&found)? + "\n"
    } else {
        table(&found)?
    })
}

/// Against paths through the scene.
fn paths(args: &Args, scene: &Scene) -> anyhow::Result<Option<Verification>> {
    let solution = match &args.solution {
        Some(path) => {
            let solution = sheen_formats::solution::read(path)?;
            anyhow::ensure!(
                solution.materials == scene.materials(),
                "{}: has other materials than {}, expected a solution of that scene",
                path.display(),
                args.scene.display()
            );
            solution
        }
        None => input::solve_scene(&args.scene, &args.solve)?,
    };
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let found = args.solve.on_threads(|| {
        let tracer = PathTracer::new(scene);
        verify(&solution, &tracer, args.probes, args.seed, &mut observer)
    })?;
    observer.finish();
    Ok(found)
}

/// Against the one radiance of a furnace.
fn furnace(args: &Args, scene: &Scene) -> anyhow::Result<Option<Verification>> {
    let place = || args.scene.display().to_string();
    let enclosed = enclosed(scene).with_context(place)?;
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let solved = solve_furnace(&enclosed, &args.solve.config(), &mut observer);
    observer.finish();
    let (solution, radiance) = solved.with_context(place)?;
    let mut observer = progress::TerminalObserver::new();
    let (probes, seed) = (args.probes, args.seed);
    let found = args.solve.on_threads(|| {
        let tracer = PathTracer::new(&enclosed);
        verify_furnace(&solution, radiance, &tracer, probes, seed, &mut observer)
    })?;
    observer.finish();
    Ok(found)
}
