//! Images of solutions, and how far they are from reference images.

use sheen_formats::image::{Image, read_exr};
use sheen_solver::{Camera, Solution};
use sheen_viewer::camera::View;
use sheen_viewer::compare::{Comparison, compare};
use sheen_viewer::ways::{ACROSS, cpu};
use std::path::Path;

/// The image of `solution` from `camera`, made on the processor.
pub fn render(solution: &Solution, camera: &Camera) -> Image {
    match View::new(camera, solution.bounds()) {
        Ok(view) => cpu::render(solution, &view, ACROSS),
        Err(error) => panic!("{error}"),
    }
}

/// The camera called `name`.
pub fn camera<'a>(solution: &'a Solution, name: &str) -> &'a Camera {
    let found = solution.cameras.iter().find(|camera| camera.name == name);
    found.unwrap_or_else(|| panic!("no camera '{name}'"))
}

/// A reference image and its noise.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The image.
    pub image: Image,
    /// Its relMSE after averaging blocks of 2 × 2 pixels, from the file beside it.
    pub noise_down2: f64,
    /// Root mean square of its noise, from there too.
    pub noise_rmse: f64,
}

impl Reference {
    /// The reference image `name` (`scene.camera`) in the folder `shared`. Panics when it cannot be read.
    pub fn read(shared: &Path, name: &str) -> Self {
        let folder = shared.join("reference/images");
        let image = match read_exr(&folder.join(format!("{name}.exr"))) {
            Ok(image) => image,
            Err(error) => panic!("{error}"),
        };
        let text = std::fs::read_to_string(folder.join(format!("{name}.json")));
        let facts: serde_json::Value =
            serde_json::from_str(&text.unwrap_or_default()).unwrap_or_default();
        let figure = |key: &str| {
            let found = facts[key].as_f64();
            found.unwrap_or_else(|| panic!("{name}.json: no {key}"))
        };
        Self {
            image,
            noise_down2: figure("noise_relmse_down2"),
            noise_rmse: figure("noise_rmse"),
        }
    }

    /// Compares `image` with this one after averaging blocks of 2 × 2 pixels.
    pub fn score(&self, image: &Image) -> Score {
        match compare(image, &self.image, 2, None) {
            Ok(comparison) => Score {
                relmse: comparison.relmse_trim999 - self.noise_down2,
                comparison,
            },
            Err(error) => panic!("{error}"),
        }
    }
}

/// How far an image is from its reference.
#[derive(Clone, Debug)]
pub struct Score {
    /// relMSE without the worst 0.1 % of the pixels, less the reference's own noise.
    pub relmse: f64,
    /// All figures.
    pub comparison: Comparison,
}
