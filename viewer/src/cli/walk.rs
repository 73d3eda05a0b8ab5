//! `sheen walk SCENE|SOLUTION`

use super::{input, note, progress};
use crate::camera::View;
use crate::script::{HeldKey, Script};
use crate::window::{self, WindowError};
use crate::{tonemap, ways};
use anyhow::Context;
use sheen_solver::{Camera, Solution};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Solution (.sheen), or a scene (.obj, .mgf) that is solved first
    input: PathBuf,
    /// Camera to start from [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Save what the window shows after some frames, and close it (for tests)
    #[arg(long, hide = true, value_name = "FILE.png")]
    screenshot: Option<PathBuf>,
    /// Frames before the screenshot, after the keys
    #[arg(
        long,
        hide = true,
        default_value_t = 5,
        value_parser = clap::value_parser!(u32).range(1..),
        requires = "screenshot"
    )]
    frames: u32,
    /// Keys to hold one after the other, each for some frames of 1/60 s
    #[arg(
        long,
        hide = true,
        value_delimiter = ',',
        value_name = "KEY:FRAMES,...",
        requires = "screenshot"
    )]
    keys: Vec<HeldKey>,
    #[command(flatten)]
    solve: input::SolveArgs,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    if let Some(path) = &args.screenshot {
        input::check_output(path)?;
    }
    let solution = Arc::new(input::solution(&args.input, &args.solve)?);
    let camera = input::camera(&solution.cameras, args.camera.as_deref())?;
    let title = args.input.file_stem().map_or_else(
        || "sheen".into(),
        |stem| stem.to_string_lossy().into_owned(),
    );
    let script = args.screenshot.clone().map(|path| Script {
        keys: args.keys.clone(),
        frames: args.frames,
        path,
    });
    match window::run(&title, Arc::clone(&solution), &camera, script) {
        Ok(()) => Ok(()),
        Err(WindowError::NoWindow { reason }) => {
            let path = PathBuf::from(format!("{title}.png"));
            write_picture(&solution, &camera, &path)?;
            note(&format!(
                "no window could be opened: {reason}; the picture of camera '{}' is in {} instead",
                camera.name,
                path.display()
            ));
            Ok(())
        }
        Err(error) => Err(error).context("window"),
    }
}

fn write_picture(solution: &Solution, camera: &Camera, path: &Path) -> anyhow::Result<()> {
    let view = View::new(camera, solution.bounds())?;
    let mut observer = progress::TerminalObserver::showing();
    let rendered = ways::render(
        solution,
        &view,
        ways::ACROSS,
        ways::Shading::default(),
        false,
        &mut observer,
    )
    .context("stopped before there was a picture")?;
    observer.finish();
    if let Some(reason) = &rendered.fallback {
        note(&format!("{reason}; rendering on the processor instead"));
    }
    let image = &rendered.image;
    let bytes = tonemap::display_bytes(&image.pixels, tonemap::default_exposure(&image.pixels));
    sheen_formats::image::write_png(path, &bytes, image.width, image.height)?;
    Ok(())
}
