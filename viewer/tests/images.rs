//! The device's image is the processor's.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::{add_grid, display_differences, empty, gpu, lobe, pack, room};
use glam::Vec3;
use sheen_formats::image::Image;
use sheen_solver::directional::{Basis, Projection, Projector, Source, packed};
use sheen_solver::{Observer, Progress, Rgb, Solution};
use sheen_viewer::camera::View;
use sheen_viewer::gpu::Gpu;
use sheen_viewer::ways::chunks::Limits;
use sheen_viewer::ways::{Shading, cpu, solution::SolutionRenderer};
use std::ops::ControlFlow;

fn view(solution: &Solution, change: impl FnOnce(&mut sheen_solver::Camera)) -> View {
    let mut camera = solution.cameras[0].clone();
    change(&mut camera);
    View::new(&camera, solution.bounds()).unwrap()
}

fn on_device(gpu: &Gpu, solution: &Solution, limits: Limits, view: &View, across: u32) -> Image {
    SolutionRenderer::new(gpu, solution, limits)
        .unwrap()
        .render(gpu, view, across)
        .unwrap()
}

/// Pixels in 1,000 that may differ by more: rasterisers snap vertices to 1/256 of a sample, so that a silhouette
/// moves by that much against the rays, and one of a pixel's 16 samples may fall on its other side.
const SILHOUETTES: usize = 1;

fn assert_alike(a: &Image, b: &Image, what: &str) {
    let differences = display_differences(a, b);
    let beyond = differences.iter().filter(|&&d| d > 2).count();
    let mean = differences.iter().map(|&d| f64::from(d)).sum::<f64>() / differences.len() as f64;
    eprintln!(
        "{what}: {beyond} of {} pixels beyond 2/255, mean difference {mean:.5}/255",
        differences.len()
    );
    assert!(
        beyond * 1000 <= differences.len() * SILHOUETTES,
        "{what}: {beyond} pixels"
    );
    // Nearly every byte is the same; the rest differs by rounding.
    assert!(mean < 0.05, "{what}: mean {mean}");
}

#[test]
fn device_and_processor_agree() {
    let Some(gpu) = gpu("device_and_processor_agree") else {
        return;
    };
    let solution = room();
    let mut renderer = SolutionRenderer::new(&gpu, &solution, Limits::default()).unwrap();
    let eyes = [
        Vec3::new(0.3, 1.1, 3.4),
        Vec3::new(-1.5, 0.4, 1.9),
        Vec3::new(1.7, 2.2, 0.5),
        Vec3::new(-1.0, 0.9, -1.6),
    ];
    for eye in eyes {
        let view = view(&solution, |camera| camera.eye = eye);
        for shading in [Shading::Samples, Shading::Vertices] {
            renderer.shading = shading;
            let device = renderer.render(&gpu, &view, 4).unwrap();
            let processor = cpu::render_with(&solution, &view, 4, shading);
            assert!(device.pixels.iter().any(|p| !p.is_black()));
            assert_alike(&device, &processor, &format!("eye {eye}, {shading:?}"));
        }
    }
}

/// The distributions of `solution` on the uniform basis.
fn on_uniform_basis(mut solution: Solution, level: u32) -> Solution {
    struct Stored<'a>(&'a [u32]);
    impl Source for Stored<'_> {
        fn eval(&mut self, _: &[u32], direction: Vec3) -> Rgb {
            packed::evaluate(self.0, direction)
        }
        fn narrow(&self, _: &mut Vec<u32>, _: std::ops::Range<usize>, _: Vec3, _: usize) {}
        fn candidate_count(&self) -> u32 {
            0
        }
    }
    let how = Projection {
        min_level: level,
        max_level: level,
        epsilon: 1.0,
        floor: 0.0,
        relative: true,
        horizon: None,
        integral: None,
        basis: Basis::Uniform,
    };
    let mut words = Vec::new();
    let mut offsets = solution.distribution_offset.clone();
    for (vertex, offset) in offsets.iter_mut().enumerate() {
        if let Some(stored) = solution.distribution(vertex) {
            *offset = words.len() as u32;
            Projector::default().project(&mut Stored(stored), &how, &mut words);
        }
    }
    (solution.distribution_words, solution.distribution_offset) = (words, offsets);
    solution
}

#[test]
fn the_uniform_basis_looks_the_same_on_both() {
    let Some(gpu) = gpu("the_uniform_basis_looks_the_same_on_both") else {
        return;
    };
    let adaptive = room();
    for level in [0, 1, 4] {
        let solution = on_uniform_basis(room(), level);
        let view = view(&solution, |_| {});
        let device = on_device(&gpu, &solution, Limits::default(), &view, 2);
        let processor = cpu::render(&solution, &view, 2);
        assert_alike(&device, &processor, &format!("level {level}"));
        let expected = cpu::render(&adaptive, &view, 2);
        let same = display_differences(&processor, &expected);
        let mean = same.iter().map(|&d| f64::from(d)).sum::<f64>() / same.len() as f64;
        eprintln!("level {level}: mean difference to the adaptive basis {mean:.3}/255");
        assert!(level < 4 || mean < 1.0, "{mean}");
    }
}

/// Keeps what is reported, and stops after some reports.
struct Reports {
    done: Vec<f32>,
    most: usize,
}

impl Observer for Reports {
    fn report(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.done.push(progress.done);
        if self.done.len() < self.most {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }
}

#[test]
fn the_processor_reports_its_progress_and_can_be_stopped() {
    let solution = room();
    let view = view(&solution, |camera| {
        (camera.width, camera.height) = (40, 75);
    });
    let watched = |most: usize| {
        let mut reports = Reports {
            done: Vec::new(),
            most,
        };
        let shading = Shading::default();
        let image = cpu::render_observed(&solution, &view, 1, shading, &mut reports);
        (image, reports.done)
    };
    let (image, done) = watched(usize::MAX);
    assert_eq!(image, Some(cpu::render(&solution, &view, 1)));
    assert!(done.len() > 2 && done.is_sorted(), "{done:?}");
    assert_eq!(done.last(), Some(&1.0));
    let (image, done) = watched(2);
    assert_eq!((image, done.len()), (None, 2));
}

#[test]
fn the_highlight_moves_with_the_eye() {
    let solution = room();
    let brightest = |eye: Vec3| {
        let view = view(&solution, |camera| {
            (camera.eye, camera.target, camera.fov_y_degrees) =
                (eye, Vec3::new(eye.x, 0.0, 0.0), 40.0);
        });
        let image = cpu::render(&solution, &view, 1);
        // Below the horizon of the lamp, left of the glass: the floor.
        let rows = image.height / 2..image.height;
        rows.flat_map(|y| (0..image.width).map(move |x| (x, y)))
            .max_by(|a, b| {
                let at =
                    |&(x, y): &(u32, u32)| image.pixels[(y * image.width + x) as usize].luminance();
                at(a).total_cmp(&at(b))
            })
            .unwrap()
            .0 as f32
            / image.width as f32
    };
    // Looking straight ahead from further left, the lamp's reflection stands further right.
    let (left, right) = (
        brightest(Vec3::new(-1.0, 1.0, 3.0)),
        brightest(Vec3::new(0.2, 1.0, 3.0)),
    );
    assert!(left > right + 0.1, "{left} {right}");
}

#[test]
fn cutting_into_chunks_changes_nothing() {
    let Some(gpu) = gpu("cutting_into_chunks_changes_nothing") else {
        return;
    };
    let solution = room();
    let view = view(&solution, |_| ());
    let whole = on_device(&gpu, &solution, Limits::default(), &view, 2);
    for limits in [
        Limits {
            vertices: 40,
            ..Limits::default()
        },
        Limits {
            words: 20_000,
            ..Limits::default()
        },
        Limits {
            triangles: 7,
            ..Limits::default()
        },
    ] {
        assert!(sheen_viewer::ways::chunks::cut(&solution, limits).len() > 1);
        assert_eq!(
            on_device(&gpu, &solution, limits, &view, 2),
            whole,
            "{limits:?}"
        );
    }
}

#[test]
fn tiles_meet_without_a_seam() {
    let Some(gpu) = gpu("tiles_meet_without_a_seam") else {
        return;
    };
    let solution = room();
    // 2048 samples a tile: at 32 across a pixel, 64 pixels.
    let view = view(&solution, |camera| (camera.width, camera.height) = (96, 72));
    let tiled = on_device(&gpu, &solution, Limits::default(), &view, 32);
    assert_alike(&tiled, &cpu::render(&solution, &view, 32), "tiles");
}

#[test]
fn radiance_far_beyond_half_floats_survives() {
    let Some(gpu) = gpu("radiance_far_beyond_half_floats_survives") else {
        return;
    };
    for factor in [2f32.powi(60), 2f32.powi(-60)] {
        let mut solution = empty();
        let whole = (Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        let distribution =
            |_: Vec3| pack(1, Vec3::Z, factor, &lobe(Vec3::Z, 0, Rgb::splat(factor)));
        add_grid(
            &mut solution,
            whole,
            2,
            1,
            &|_| Rgb::new(1.0, 2.0, 3.0) * factor,
            Some(&distribution),
        );
        let view = view(&solution, |camera| (camera.width, camera.height) = (8, 6));
        for image in [
            on_device(&gpu, &solution, Limits::default(), &view, 4),
            cpu::render(&solution, &view, 4),
        ] {
            for pixel in &image.pixels {
                for (value, expected) in pixel.to_array().iter().zip([2.0, 3.0, 4.0]) {
                    // f32 interpolation and a mean of 16.
                    assert!(
                        (value / factor / expected - 1.0).abs() < 1e-5,
                        "{factor}: {value}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_scale_of_a_scene_does_not_matter() {
    let Some(gpu) = gpu("the_scale_of_a_scene_does_not_matter") else {
        return;
    };
    let plain = room();
    let expected = on_device(&gpu, &plain, Limits::default(), &view(&plain, |_| ()), 4);
    for factor in [2f32.powi(20), 2f32.powi(-20)] {
        let mut solution = plain.clone();
        solution.position.iter_mut().for_each(|p| *p *= factor);
        solution
            .glass_corners
            .as_flattened_mut()
            .iter_mut()
            .for_each(|p| *p *= factor);
        let view = view(&solution, |camera| {
            camera.eye *= factor;
            camera.target *= factor;
        });
        assert_alike(
            &on_device(&gpu, &solution, Limits::default(), &view, 4),
            &expected,
            &format!("{factor}"),
        );
        assert_alike(
            &cpu::render(&solution, &view, 4),
            &expected,
            &format!("{factor}, processor"),
        );
    }
}

#[test]
fn glass_tints_what_is_behind_it_and_nothing_else() {
    let mut solution = empty();
    let wall = (Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    add_grid(&mut solution, wall, 1, 0, &|_| Rgb::WHITE, None);
    let square = |z: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x, y, z);
        [
            [corner(0.0, -5.0), corner(5.0, -5.0), corner(5.0, 5.0)],
            [corner(0.0, -5.0), corner(5.0, 5.0), corner(0.0, 5.0)],
        ]
    };
    // Two panes before the right half of the wall, one behind it.
    solution.glass_corners = [square(1.0), square(0.5), square(-1.0)].concat();
    solution.glass_material = vec![3; 6];
    let view = view(&solution, |camera| {
        (camera.eye, camera.target) = (Vec3::Z * 3.0, Vec3::ZERO);
    });
    let images = gpu("glass_tints_what_is_behind_it_and_nothing_else")
        .map(|gpu| on_device(&gpu, &solution, Limits::default(), &view, 4))
        .into_iter()
        .chain([cpu::render(&solution, &view, 4)]);
    for image in images {
        let at = |x: u32| image.pixels[(60 * image.width + x) as usize].to_array();
        assert_eq!(at(20), [1.0; 3]);
        for (value, expected) in at(140).iter().zip([0.25, 0.64, 0.36]) {
            // The tint of 16-bit floats, twice.
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
        }
    }
}

#[test]
fn an_empty_solution_is_black() {
    let solution = empty();
    let view = view(&solution, |camera| (camera.width, camera.height) = (7, 5));
    assert!(
        cpu::render(&solution, &view, 4)
            .pixels
            .iter()
            .all(|p| p.is_black())
    );
    if let Some(gpu) = gpu("an_empty_solution_is_black") {
        let image = on_device(&gpu, &solution, Limits::default(), &view, 4);
        assert!(image.pixels.len() == 35 && image.pixels.iter().all(|p| p.is_black()));
    }
}
