//! Glossy exact cases (`exact_cases.md` 2e): the mirror limit, and two glossy patches against paths.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_formats::note_widened;
use sheen_solver::path::Sampler;
use sheen_solver::{Gloss, Material, PathTracer, Quality, Rgb, Scene, SolveConfig, solve};

use sheen_tests::assert_close;
use sheen_tests::scenes::Builder;
use sheen_viewer::verify::{Estimate, verify};

/// Radiance of the lamp.
const LAMP: f32 = 5.0;
/// Specular reflectance of the floor.
const SPECULAR: f32 = 0.6;

/// A glossy floor, two metres wide around the origin, and a square lamp one metre above it, half a metre to the left.
fn floor_and_lamp(gloss: Gloss) -> Scene {
    let mut builder = Builder::new();
    let floor = builder.material(Material {
        gloss,
        ..Material::lambert("floor", Rgb::BLACK)
    });
    let lamp = builder.lambert("lamp", 0.0, LAMP);
    let square = |x: f32, y: f32, half: f32| {
        [(-1., -1.), (-1., 1.), (1., 1.), (1., -1.)]
            .map(|(u, v)| Vec3::new(x + u * half, y, v * half))
    };
    builder.quad(square(0.0, 0.0, 1.0), floor);
    let mut down = square(-0.5, 1.0, 0.2);
    down.reverse();
    builder.quad(down, lamp);
    builder.build()
}

/// From the middle of the floor, towards what mirrors the lamp's point at `x`.
fn mirrored(x: f32) -> Vec3 {
    Vec3::new(-x, 1.0, 0.0).normalize()
}

/// What a mirror would show there, times what the sharpest lobes of this kind reflect: all, or with Phong the cosine.
fn image(gloss: Gloss, x: f32) -> f64 {
    let albedo = match gloss {
        Gloss::Phong { .. } => mirrored(x).y,
        _ => 1.0,
    };
    f64::from(SPECULAR * LAMP * albedo)
}

fn lobes() -> [(&'static str, Gloss); 4] {
    let specular = Rgb::splat(SPECULAR);
    let phong = |exponent| Gloss::Phong { specular, exponent };
    let ward = |roughness| Gloss::Ward {
        specular,
        roughness,
    };
    [
        ("Phong 1e4", phong(1e4)),
        ("Phong 1e6", phong(1e6)),
        ("Ward 0.01", ward(0.01)),
        ("Ward 1e-4", ward(1e-4)),
    ]
}

#[test]
fn paths_show_the_lamp_in_a_floor_that_is_nearly_a_mirror() {
    for (name, gloss) in lobes() {
        let scene = floor_and_lamp(gloss);
        let tracer = PathTracer::new(&scene);
        let towards = |x: f32| {
            let eye = mirrored(x) * 0.5;
            let sample = |index| {
                let mut sampler = Sampler::new(0, index, 0);
                f64::from(tracer.radiance(eye, -eye.normalize(), &mut sampler).mean())
            };
            const SAMPLES: u32 = 1 << 12;
            (0..SAMPLES).map(sample).sum::<f64>() / f64::from(SAMPLES)
        };
        for x in [-0.6, -0.5, -0.4] {
            // All of the lobe meets the lamp, and what it does not send below the surface is left.
            let found = towards(x);
            assert_close(format!("{name}, {x}"), found, image(gloss, x), 5e-3);
        }
        for x in [-0.85, -0.15, 0.5] {
            let beside = towards(x);
            assert!(beside < 1e-9, "{name}, {x}: {beside:e}");
        }
    }
}

#[test]
fn a_solution_shows_it_as_sharply_as_its_quality_resolves() {
    for (name, gloss) in lobes() {
        let scene = floor_and_lamp(gloss);
        let mut last = [f64::INFINITY; 2];
        for (quality, most) in [
            (Quality::PREVIEW, 0.13),
            (Quality::DEFAULT, 0.05),
            (Quality::HIGH, 0.01),
        ] {
            let config = SolveConfig {
                quality,
                ..SolveConfig::default()
            };
            // Lobes are widened, and whoever solves by the command line is told so.
            let sharpest = config.settings().unwrap().sharpest_roughness;
            let told = note_widened(&scene, sharpest).unwrap();
            assert!(told.contains("'floor'"), "{told}");

            let solution = solve(&scene, &config, &mut ()).unwrap();
            let is_middle =
                |&v: &usize| solution.position[v] == Vec3::ZERO && solution.normal[v] == Vec3::Y;
            let middle = (0..solution.position.len()).find(is_middle).unwrap();
            let towards = |x: f32| f64::from(solution.evaluate(middle, mirrored(x)).mean());
            let expected = image(gloss, -0.5);
            assert_close(
                format!("{name}, {quality:?}"),
                towards(-0.5),
                expected,
                most,
            );
            let beside = [-0.85, -0.15].map(towards);
            println!("{name}, {quality:?}: {beside:?} beside the image");
            assert!(beside[0] < 0.5 * last[0] && beside[1] < last[1], "{last:?}");
            last = beside;
        }
        // A hundredth of the image.
        assert!(last[0] < 0.03 && last[1] < 0.03, "{last:?}");
    }
}

#[test]
fn two_glossy_patches_and_a_lamp() {
    let mut builder = Builder::new();
    let low = builder.phong("low", 0.1, 0.7, 30.0);
    let side = builder.phong("side", 0.2, 0.5, 120.0);
    let lamp = builder.lambert("lamp", 0.0, 8.0);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    builder
        .quad(
            [
                at(0., 0., 0.),
                at(0., 0., 1.),
                at(1., 0., 1.),
                at(1., 0., 0.),
            ],
            low,
        )
        .quad(
            [
                at(0., 0., 0.),
                at(0., 1., 0.),
                at(0., 1., 1.),
                at(0., 0., 1.),
            ],
            side,
        )
        .quad(
            [
                at(0.9, 0.8, 0.6),
                at(0.7, 0.9, 0.6),
                at(0.7, 0.9, 0.4),
                at(0.9, 0.8, 0.4),
            ],
            lamp,
        );
    let scene = builder.build();
    let tracer = PathTracer::new(&scene);
    let mut last = f64::INFINITY;
    for (quality, most) in [
        (Quality::PREVIEW, 0.03),
        (Quality::DEFAULT, 0.012),
        (Quality::HIGH, 0.004),
    ] {
        let config = SolveConfig {
            quality,
            ..SolveConfig::default()
        };
        let solution = solve(&scene, &config, &mut ()).unwrap();
        let found = verify(&solution, &tracer, 1 << 21, 1, &mut ()).unwrap().all;
        println!("{quality:?}: bias {:?}, rms {:?}", found.bias, found.rms);
        let Estimate { value, low, high } = found.bias;
        // The z-test: zero is as near as half the interval, but for what the quality allows.
        assert!(value.abs() < most + 0.5 * (high - low), "{found:?}");
        assert!(found.rms.value < last, "{found:?}");
        last = found.rms.value;
    }
}
