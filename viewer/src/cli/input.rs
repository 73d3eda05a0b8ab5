//! Scenes and solutions from files; scenes are solved where a solution is wanted.

use super::{note, process, progress, values};
use anyhow::Context;
use sheen_formats::{LoadOptions, Loaded};
use sheen_solver::config::{Basis, Method, Refiner, Scheme, Visibility};
use sheen_solver::{Camera, Quality, Solution, SolveConfig};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Settings of a solve, shared by every subcommand that may have to solve.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct SolveArgs {
    /// draft, preview, default, high, or a number within 0..4
    #[arg(long, default_value = "default", value_name = "QUALITY")]
    quality: Quality,
    /// Stop refining after this time and keep what is there: 60s, 1.5m, 1h
    #[arg(long, value_parser = values::seconds, value_name = "TIME")]
    time_limit: Option<f64>,
    /// Lower the quality until the data of the solve fits into this much memory: 512MiB, 2GiB [default: three fifths of what is free]
    #[arg(long, value_parser = values::bytes, value_name = "SIZE")]
    memory_limit: Option<u64>,
    /// Deepest subdivision of directional distributions [default: follows from quality and gloss]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=7), value_name = "1..7")]
    levels: Option<u32>,
    /// Largest deviation within a cell of a directional distribution, as a share of its value, at most 10 [default: follows
    /// from quality]
    #[arg(long, value_parser = values::positive, value_name = "SHARE")]
    epsilon: Option<f64>,
    /// Threads [default: all of the machine]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), value_name = "N")]
    threads: Option<u16>,
    /// Share of the emitted power that a link may be wrong by [default: follows from quality]
    #[arg(long, value_parser = values::positive, value_name = "SHARE")]
    link_tolerance: Option<f64>,
    /// What becomes of light that arrives, for comparison: is (illumination samples), sr (the same, reflected one by one),
    /// rc (radiance clustering)
    #[arg(long, default_value = "is", value_name = "METHOD")]
    method: Method,
    /// Which light an iteration moves, for comparison: shooting, gathering
    #[arg(long, default_value = "shooting", value_name = "SCHEME")]
    scheme: Scheme,
    /// What deviations within distributions are held against, for comparison: relative, absolute
    #[arg(long, default_value = "relative", value_name = "REFINER")]
    refiner: Refiner,
    /// What distributions are stored on, for comparison: haar (adaptive), uniform
    #[arg(long, default_value = "haar", value_name = "BASIS")]
    basis: Basis,
    /// How links find what stands between their ends, for comparison: shafts (and what they hold, cut out exactly), rays
    #[arg(long, default_value = "shafts", value_name = "HOW")]
    visibility: Visibility,
    /// Rays along each axis of the stratification of a link, however weak [default: follows from quality]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=16), value_name = "N")]
    strata: Option<u32>,
    /// Gather light at vertices, or average what the elements around them show [default: follows from quality]
    #[arg(long, value_name = "true|false")]
    gather: Option<bool>,
    /// Repair faults of the scene that can be repaired, and say so, instead of refusing it
    #[arg(long)]
    lenient: bool,
}

impl SolveArgs {
    pub(super) fn is_lenient(&self) -> bool {
        self.lenient
    }

    pub(super) fn time_limit(&self) -> Option<Duration> {
        self.time_limit.map(Duration::from_secs_f64)
    }

    /// Runs `work` on as many threads as were asked for.
    pub(super) fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> anyhow::Result<T> {
        let Some(threads) = self.threads else {
            return Ok(work());
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build()
            .with_context(|| format!("--threads {threads}"))?;
        Ok(pool.install(work))
    }

    pub(super) fn config(&self) -> SolveConfig {
        SolveConfig {
            quality: self.quality,
            time_limit_s: self.time_limit,
            memory_limit: self.memory_limit.or_else(default_memory_limit),
            max_level: self.levels,
            epsilon: self.epsilon.map(|epsilon| epsilon as f32),
            threads: self.threads.map(usize::from),
            link_tolerance: self.link_tolerance.map(|share| share as f32),
            method: self.method,
            scheme: self.scheme,
            refiner: self.refiner,
            basis: self.basis,
            visibility: self.visibility,
            strata: self.strata,
            gather: self.gather,
            transport_epsilon: None,
            least_directional: None,
        }
    }
}

/// Three fifths of what is free: the program takes up to half as much again as the data that it counts.
fn default_memory_limit() -> Option<u64> {
    process::free_memory_bytes().map(|bytes| bytes / 5 * 3)
}

/// True for the file name of a solution.
pub(super) fn is_solution(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("sheen"))
}

/// Reads a scene; its notes go to stderr.
pub(super) fn load_scene(path: &Path, lenient: bool) -> anyhow::Result<Loaded> {
    let loaded = sheen_formats::load_scene(path, &LoadOptions { lenient })?;
    for text in &loaded.notes {
        note(&format!("note: {text}"));
    }
    Ok(loaded)
}

/// Reads a scene and solves it.
pub(super) fn solve_scene(path: &Path, args: &SolveArgs) -> anyhow::Result<Solution> {
    progress::catch_interrupts();
    let started = Instant::now();
    let scene = load_scene(path, args.lenient)?.scene;
    let load_s = started.elapsed().as_secs_f64();
    let config = args.config();
    let place = || path.display().to_string();
    let sharpest = config.settings().with_context(place)?.sharpest_roughness;
    if let Some(text) = sheen_formats::note_widened(&scene, sharpest) {
        note(&format!("note: {text}"));
    }
    let cpu_before = process::cpu_seconds();
    let mut observer = progress::TerminalObserver::new();
    let solved = sheen_solver::solve(&scene, &config, &mut observer);
    observer.finish();
    let mut solution = solved.with_context(place)?;
    if progress::is_interrupted() {
        note("interrupted: keeping what has been solved so far");
    }
    let stats = &mut solution.stats.solve;
    if stats.quality < f64::from(config.quality.value()) {
        note(&format!(
            "note: quality {:.1} instead of {:.1}: more does not fit into {:.0}",
            stats.quality,
            config.quality.value(),
            bytesize::ByteSize(config.memory_limit.unwrap_or(0))
                .display()
                .iec()
        ));
    }
    stats.phases_s.load = load_s;
    if let (Some(before), Some(after)) = (cpu_before, process::cpu_seconds()) {
        stats.cpu_s = after - before;
    }
    if let Some(bytes) = process::peak_rss_bytes() {
        stats.peak_rss_bytes = bytes;
    }
    Ok(solution)
}

/// Reads a solution, or a scene that is then solved.
pub(super) fn solution(path: &Path, args: &SolveArgs) -> anyhow::Result<Solution> {
    if is_solution(path) {
        Ok(sheen_formats::solution::read(path)?)
    } else {
        solve_scene(path, args)
    }
}

/// The camera of this name; the first one without a name.
pub(super) fn camera(cameras: &[Camera], name: Option<&str>) -> anyhow::Result<Camera> {
    let Some(name) = name else {
        return cameras
            .first()
            .cloned()
            .context("the solution holds no camera: expected at least one");
    };
    cameras
        .iter()
        .find(|camera| camera.name == name)
        .cloned()
        .with_context(|| {
            let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
            format!(
                "no camera is called '{name}', expected one of: {}",
                names.join(", ")
            )
        })
}

/// Checks, before anything costly is done, that `path` can be written.
pub(super) fn check_output(path: &Path) -> anyhow::Result<()> {
    let name = path
        .file_name()
        .with_context(|| format!("{}: is no file name", path.display()))?;
    anyhow::ensure!(
        !path.is_dir(),
        "{}: is a folder, expected a file name",
        path.display()
    );
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    anyhow::ensure!(
        folder.is_dir(),
        "{}: no such folder, expected an existing one for the output",
        folder.display()
    );
    let mut probe_name = std::ffi::OsString::from(".");
    probe_name.push(name);
    probe_name.push(format!(".{}.probe", std::process::id()));
    let probe = folder.join(probe_name);
    let opened = std::fs::OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&probe);
    opened.with_context(|| format!("{}: cannot be written to", folder.display()))?;
    std::fs::remove_file(&probe).with_context(|| format!("{}", probe.display()))
}

/// Writes a small text file whole or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(format!(".{}.part", std::process::id()));
    let temporary = PathBuf::from(temporary);
    let written = std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, path));
    if written.is_err() {
        // Best effort: the error below is the one that counts.
        let _ = std::fs::remove_file(&temporary);
    }
    written.with_context(|| path.display().to_string())
}
