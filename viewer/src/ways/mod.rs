//! Ways of making an image, from a solution or from a scene.

pub mod chunks;
pub mod cpu;
pub mod path;
pub mod solution;

use crate::camera::View;
use crate::gpu::{Gpu, GpuError};
use sheen_formats::image::Image;
use sheen_solver::{Observer, Solution};

/// Where the light of glossy surfaces is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Shading {
    /// At every sample of every pixel.
    #[default]
    Samples,
    /// At the vertices, once a frame, and interpolated (§5.2): cheaper, and highlights smear between vertices.
    Vertices,
}

/// An image and how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Linear radiance.
    pub image: Image,
    /// Name of what made it.
    pub device: String,
    /// Why no graphics device made it, if one was wanted.
    pub fallback: Option<String>,
}

/// Renders `view` on a graphics device, or with `cpu`, or where there is no device, on the processor, which takes its time:
/// `observer` may watch and stop it, and gets `None`.
pub fn render(
    solution: &Solution,
    view: &View,
    across: u32,
    shading: Shading,
    cpu: bool,
    observer: &mut dyn Observer,
) -> Option<Rendered> {
    let on_gpu = || -> Result<(Image, String), GpuError> {
        let gpu = Gpu::headless()?;
        let mut renderer =
            solution::SolutionRenderer::new(&gpu, solution, chunks::Limits::default())?;
        renderer.shading = shading;
        Ok((renderer.render(&gpu, view, across)?, gpu.info.name))
    };
    let fallback = if cpu {
        None
    } else {
        match on_gpu() {
            Ok((image, device)) => {
                return Some(Rendered {
                    image,
                    device,
                    fallback: None,
                });
            }
            Err(error) => Some(error.to_string()),
        }
    };
    Some(Rendered {
        image: cpu::render_observed(solution, view, across, shading, observer)?,
        device: "the processor".to_owned(),
        fallback,
    })
}

/// Samples across and down a pixel of a picture. They stand in rows: what an edge that runs along one covers of a pixel
/// is known to half of the distance between them, here a sixteenth.
pub const ACROSS: u32 = 8;

/// Smallest square number of samples per pixel that is at least `samples`, as its root.
pub fn samples_across(samples: u32) -> u32 {
    let root = samples.isqrt();
    if root * root >= samples {
        root.max(1)
    } else {
        root + 1
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn samples_form_squares() {
        let across: Vec<u32> = [0, 1, 2, 4, 5, 16, 17, 64]
            .map(super::samples_across)
            .to_vec();
        assert_eq!(across, [1, 1, 2, 2, 3, 4, 5, 8]);
    }
}
