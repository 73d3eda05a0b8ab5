//! `sheen render SCENE|SOLUTION -o I.exr|png`

use super::{input, note, progress, values};
use crate::camera::View;
use crate::ways::path::{Budget, trace};
use crate::{tonemap, ways};
use anyhow::Context;
use glam::Vec3;
use sheen_formats::image::Image;
use sheen_solver::scene::looks_along_up;
use sheen_solver::{Camera, PathTracer};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Solution (.sheen), or a scene (.obj, .mgf) that is solved first
    input: PathBuf,
    /// Image to write: .exr holds linear radiance, .png is tone-mapped
    #[arg(short, long, value_parser = output, value_name = "I.exr|I.png")]
    output: Output,
    /// How the image is made
    #[arg(long, value_enum, default_value = "solution")]
    way: Way,
    /// Camera of the scene [default: its first]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["eye", "target", "up", "fov_y"])]
    camera: Option<String>,
    /// Where the eye is [m]
    #[arg(long, value_parser = values::vector, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "target")]
    eye: Option<Vec3>,
    /// What it looks at [m]
    #[arg(long, value_parser = values::vector, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye")]
    target: Option<Vec3>,
    /// What is up [default: as the scene's first camera; straight up and down, where that looks]
    #[arg(long, value_parser = values::vector, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "eye")]
    up: Option<Vec3>,
    /// Vertical field of view, degrees [default: as the scene's first camera]
    #[arg(long, value_parser = values::positive, value_name = "DEGREES", requires = "eye")]
    fov_y: Option<f64>,
    /// Pixels [default: as the camera]
    #[arg(long, value_parser = values::size, value_name = "WxH")]
    size: Option<(u32, u32)>,
    /// Samples per pixel: of a solution [default: 64] rounded up to a square, at most 1024; of paths [default: 64, or
    /// as many as --time-limit gives]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=MOST_PATHS), value_name = "N")]
    spp: Option<u32>,
    /// Other random numbers for paths
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u32,
    /// Factor before display encoding (PNG) [default: .8 over the 95th percentile of luminance]
    #[arg(long, value_parser = values::positive, value_name = "FACTOR")]
    exposure: Option<f64>,
    /// Where the light of glossy surfaces is evaluated
    #[arg(long, value_enum, default_value = "samples")]
    shading: ways::Shading,
    /// Use no graphics device
    #[arg(long)]
    cpu: bool,
    #[command(flatten)]
    solve: input::SolveArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Way {
    /// The precomputed solution
    Solution,
    /// Path tracing on the processor: unbiased, noisy
    Path,
}

/// Most samples per pixel, of paths.
const MOST_PATHS: i64 = 1 << 24;
/// And of a solution, which has no noise.
const MOST_OF_SOLUTION: u32 = 1024;
/// Samples per pixel unless told.
const OF_SOLUTION: u32 = ways::ACROSS * ways::ACROSS;
const OF_PATHS: u32 = 64;

#[derive(Clone, Debug, PartialEq)]
enum Output {
    Exr(PathBuf),
    Png(PathBuf),
}

impl Output {
    fn path(&self) -> &PathBuf {
        let (Self::Exr(path) | Self::Png(path)) = self;
        path
    }
}

fn output(text: &str) -> Result<Output, String> {
    let path = PathBuf::from(text);
    match path
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase)
        .as_deref()
    {
        Some("exr") => Ok(Output::Exr(path)),
        Some("png") => Ok(Output::Png(path)),
        _ => Err("expected a file name that ends in .exr or .png".to_owned()),
    }
}

fn camera(args: &Args, cameras: &[Camera]) -> anyhow::Result<Camera> {
    let mut camera = input::camera(cameras, args.camera.as_deref())?;
    if let (Some(eye), Some(target)) = (args.eye, args.target) {
        let ahead = camera.target - camera.eye;
        camera.name = "command line".to_owned();
        (camera.eye, camera.target) = (eye, target);
        camera.up = args.up.unwrap_or(camera.up);
        // Straight down or up: a plan is turned as the scene's first camera stands.
        if args.up.is_none() && looks_along_up(&camera) {
            camera.up = ahead;
        }
        camera.fov_y_degrees = args
            .fov_y
            .map_or(camera.fov_y_degrees, |degrees| degrees as f32);
    }
    if let Some((width, height)) = args.size {
        (camera.width, camera.height) = (width, height);
    }
    Ok(camera)
}

/// A picture, and how it came about.
struct Picture {
    image: Image,
    variance: Option<Image>,
    camera: String,
    how: String,
}

fn from_solution(args: &Args) -> anyhow::Result<Picture> {
    let spp = args.spp.unwrap_or(OF_SOLUTION);
    anyhow::ensure!(
        spp <= MOST_OF_SOLUTION,
        "--spp {spp}: expected at most {MOST_OF_SOLUTION} for a solution, which has no noise"
    );
    let solution = input::solution(&args.input, &args.solve).map(Box::new)?;
    let camera = camera(args, &solution.cameras)?;
    let view =
        View::new(&camera, solution.bounds()).with_context(|| args.input.display().to_string())?;
    let mut observer = progress::TerminalObserver::showing();
    let rendered = ways::render(
        &solution,
        &view,
        ways::samples_across(spp),
        args.shading,
        args.cpu,
        &mut observer,
    )
    .context("stopped before there was a picture")?;
    observer.finish();
    if let Some(reason) = &rendered.fallback {
        note(&format!("{reason}; rendering on the processor instead"));
    }
    Ok(Picture {
        image: rendered.image,
        variance: None,
        camera: camera.name,
        how: format!("on {}", rendered.device),
    })
}

fn by_paths(args: &Args) -> anyhow::Result<Picture> {
    anyhow::ensure!(
        !input::is_solution(&args.input),
        "{}: is a solution, expected a scene: paths are traced through its surfaces",
        args.input.display()
    );
    let scene = input::load_scene(&args.input, args.solve.is_lenient())?.scene;
    let camera = camera(args, scene.cameras())?;
    let view =
        View::new(&camera, scene.bounds()).with_context(|| args.input.display().to_string())?;
    let time_limit = args.solve.time_limit();
    let budget = Budget {
        samples: match (args.spp, time_limit) {
            (Some(spp), _) => spp,
            (None, Some(_)) => MOST_PATHS as u32,
            (None, None) => OF_PATHS,
        },
        time_limit,
    };
    progress::catch_interrupts();
    let mut observer = progress::TerminalObserver::new();
    let tracer = PathTracer::new(&scene);
    let traced = args
        .solve
        .on_threads(|| trace(&tracer, &view, budget, args.seed, &mut observer))?;
    observer.finish();
    Ok(Picture {
        image: traced.image,
        variance: traced.variance,
        camera: camera.name,
        how: format!("{} paths a pixel", traced.samples),
    })
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    input::check_output(args.output.path())?;
    let picture = match args.way {
        Way::Solution => from_solution(args)?,
        Way::Path => by_paths(args)?,
    };
    let image = &picture.image;
    match &args.output {
        Output::Exr(path) => {
            sheen_formats::image::write_exr_with(path, image, picture.variance.as_ref())?;
        }
        Output::Png(path) => {
            let exposure = args
                .exposure
                .unwrap_or_else(|| tonemap::default_exposure(&image.pixels));
            let bytes = tonemap::display_bytes(&image.pixels, exposure);
            sheen_formats::image::write_png(path, &bytes, image.width, image.height)?;
        }
    }
    super::print(&format!(
        "{}: {}x{}, camera '{}', {}\n",
        args.output.path().display(),
        image.width,
        image.height,
        picture.camera,
        picture.how
    ))
}
