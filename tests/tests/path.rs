//! The path tracer: exact cases, and agreement with a reference renderer within the noise of both.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_formats::image::Image;
use sheen_solver::path::Sampler;
use sheen_solver::{Gloss, Material, PathTracer, Rgb, Scene};
use sheen_tests::assert_close;
use sheen_tests::images::Reference;
use sheen_tests::scenes::{self, Builder};
use sheen_tests::shared::shared;
use sheen_viewer::camera::View;
use sheen_viewer::ways::path::{Budget, Traced, trace};
use std::f64::consts::TAU;
use std::path::Path;

fn traced(scene: &Scene, camera: &str, samples: u32) -> Traced {
    let camera = scene.cameras().iter().find(|c| c.name == camera).unwrap();
    let view = View::new(camera, scene.bounds()).unwrap();
    let budget = Budget {
        samples,
        time_limit: None,
    };
    trace(&PathTracer::new(scene), &view, budget, 0, &mut ())
}

/// Mean radiance along one ray over `samples` paths [mean over channels].
fn along(scene: &Scene, eye: Vec3, direction: Vec3, samples: u32) -> f64 {
    let tracer = PathTracer::new(scene);
    let sample = |index| {
        let mut sampler = Sampler::new(0, index, 0);
        f64::from(tracer.radiance(eye, direction, &mut sampler).mean())
    };
    (0..samples).map(sample).sum::<f64>() / f64::from(samples)
}

fn mean(image: &Image) -> f64 {
    image
        .pixels
        .iter()
        .map(|p| f64::from(p.mean()))
        .sum::<f64>()
        / image.pixels.len() as f64
}

#[test]
fn a_furnace_shows_two_everywhere() {
    let scene = scenes::own("furnace");
    let camera = scene.cameras()[0].name.clone();
    let traced = traced(&scene, &camera, 64);
    // A geometric series with roulette; the noise of the picture's mean is some 1e-4.
    assert_close("furnace", mean(&traced.image), 2.0, 5e-4);
}

#[test]
fn the_form_factor_of_opposed_squares() {
    let mut builder = Builder::new();
    let lamp = builder.lambert("lamp", 0.0, 1.0);
    let plate = builder.lambert("plate", 0.5, 0.0);
    let square = |y: f32| [(0., 0.), (0., 1.), (1., 1.), (1., 0.)].map(|(x, z)| Vec3::new(x, y, z));
    let [a, b, c, d] = square(1.0);
    builder.quad([a, d, c, b], lamp);
    builder.quad(square(0.0), plate);
    let scene = builder.build();
    let tracer = PathTracer::new(&scene);
    const SAMPLES: u32 = 1 << 16;
    let sample = |index| {
        let mut sampler = Sampler::new(0, index, 0);
        let [x, z, ..] = sampler.draw();
        f64::from(
            tracer
                .radiance(Vec3::new(x, 0.5, z), Vec3::NEG_Y, &mut sampler)
                .mean(),
        )
    };
    let mean = (0..SAMPLES).map(sample).sum::<f64>() / f64::from(SAMPLES);
    // `exact_cases.md` 2a; radiance is ρ F L.
    assert_close("form factor", mean / 0.5, 0.199_824_895_698, 2e-4);
}

/// A large glossy square in the plane y = 0 that looks up.
fn plane(builder: &mut Builder, specular: f32, exponent: f32) {
    let gloss = builder.phong("plane", 0.0, specular, exponent);
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z) * 4.0;
    builder.quad(
        [
            corner(-1., -1.),
            corner(-1., 1.),
            corner(1., 1.),
            corner(1., -1.),
        ],
        gloss,
    );
}

#[test]
fn a_disc_of_light_in_a_phong_surface() {
    // `exact_cases.md` 2e: L_o = ks L (1 - cosⁿ⁺² θm), seen along the normal from below the disc.
    for (exponent, degrees, expected) in [
        (10.0f32, 45.0f32, 0.984_375),
        (50.0, 20.0, 0.960_621),
        (100.0, 10.0, 0.790_179),
        (1000.0, 5.0, 0.978_076),
    ] {
        let mut builder = Builder::new();
        plane(&mut builder, 1.0, exponent);
        let lamp = builder.lambert("lamp", 0.0, 1.0);
        let radius = degrees.to_radians().tan();
        const CORNERS: u32 = 128;
        // As large as the circle.
        let turn = std::f32::consts::TAU / CORNERS as f32;
        let radius = radius * (turn / turn.sin()).sqrt();
        let corner = |i: u32| {
            let (sine, cosine) = (turn * i as f32).sin_cos();
            Vec3::new(cosine * radius, 1.0, sine * radius)
        };
        for i in 0..CORNERS / 2 {
            let (a, b, c) = (corner(2 * i), corner(2 * i + 1), corner(2 * i + 2));
            builder.quad([Vec3::Y, a, b, c], lamp);
        }
        let scene = builder.build();
        let found = along(&scene, Vec3::Y * 0.9, Vec3::NEG_Y, 1 << 14);
        assert_close(format!("disc, n {exponent}"), found, expected, 2e-3);
    }
}

#[test]
fn a_point_light_in_a_phong_surface() {
    // `exact_cases.md` 2e: ks (n + 2)/2π cosⁿα I cosθ/d².
    let mut builder = Builder::new();
    plane(&mut builder, 1.0, 50.0);
    builder.point_light(Vec3::Y * 2.0, 100.0);
    let scene = builder.build();
    let found = along(&scene, Vec3::Y, Vec3::NEG_Y, 1);
    assert_close("point light", found, 52.0 / TAU * 100.0 / 4.0, 1e-5);
}

#[test]
fn mirrors_and_glass_are_exact() {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.0, 1.0);
    builder.room(Vec3::splat(-2.0), Vec3::splat(2.0), [wall; 6]);
    let mirror = builder.material(Material {
        gloss: Gloss::Ward {
            specular: Rgb::splat(0.8),
            roughness: 0.0,
        },
        ..Material::lambert("mirror", Rgb::BLACK)
    });
    let glass = builder.material(Material {
        transmission: Rgb::new(0.5, 0.25, 0.75),
        gloss: Gloss::Ward {
            specular: Rgb::splat(0.1),
            roughness: 0.0,
        },
        ..Material::lambert("glass", Rgb::BLACK)
    });
    let square =
        |z: f32| [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(|(x, y)| Vec3::new(x, y, z));
    builder.quad(square(-1.0), mirror);
    builder.quad(square(1.0), glass);
    let scene = builder.build();
    let samples = 1 << 14;
    // Past the pane to a wall.
    let aside = Vec3::new(0.9, 0.0, -1.0).normalize();
    assert_close("mirror", along(&scene, Vec3::ZERO, aside, 4), 0.8, 1e-6);
    // Through the pane; what it reflects goes to the mirror and comes back, again and again.
    let found = along(&scene, Vec3::ZERO, Vec3::Z, samples);
    let series = 0.5 + 0.1 * 0.8 * (0.5 / (1.0 - 0.08));
    assert_close("pane before a mirror", found, series, 5e-3);
}

#[test]
fn lengths_and_lights_scale_bitwise() {
    let scene = scenes::room_with_glossy_floor();
    let radiance = |scene: &Scene, length: f32| -> Vec<Rgb> {
        let tracer = PathTracer::new(scene);
        let ray = |index: u32| {
            let mut sampler = Sampler::new(index, 0, 0);
            let [x, y, z, _] = sampler.draw();
            let direction = (Vec3::new(x, y, z) - 0.5).normalize();
            tracer.radiance(Vec3::new(0.5, 1.0, 0.75) * length, direction, &mut sampler)
        };
        (0..500).map(ray).collect()
    };
    let plain = radiance(&scene, 1.0);
    assert!(plain.iter().filter(|radiance| !radiance.is_black()).count() > 100);
    for length in [2f32.powi(20), 2f32.powi(-20)] {
        let found = radiance(&scenes::longer(&scene, length), length);
        assert_eq!(plain, found, "lengths times {length}");
    }
    let factor = 2f32.powi(30);
    let expected: Vec<Rgb> = plain.iter().map(|&radiance| radiance * factor).collect();
    let found = radiance(&scenes::brighter(&scene, factor), 1.0);
    assert_eq!(expected, found, "lights times {factor}");
}

/// Side of the blocks of pixels whose means are compared: of enough pixels that noise is nearly normal.
const BLOCK: u32 = 16;

/// Error of a picture over the noise of it and of its reference.
struct Agreement {
    /// Of the whole picture's mean, in standard deviations.
    mean: f64,
    /// Root mean square over blocks and channels, in standard deviations.
    rms: f64,
    /// Share of pixels and channels that are as near as noise explains with 95 % of all pictures.
    within: f64,
}

/// Half the side of the squares of pixels whose mean variance is a pixel's: few samples of one pixel alone do not
/// know what is rare. (The reference renderer against its own picture: 96 % of `sphere.front` without, 99.98 % with.)
const NEAR: i32 = 2;

/// How many standard deviations none of `count` normal numbers exceeds in 95 of 100 cases (Šidák's correction).
fn bound(count: usize) -> f64 {
    let tail = -(0.95f64.ln() / count as f64).exp_m1() / 2.0;
    // The tail of the normal distribution is e^{-z²/2} / (z √2π) (1 - 1/z² + 3/z⁴ ...).
    let tail_of =
        |z: f64| (-z * z / 2.0).exp() / (z * TAU.sqrt()) * (1.0 - 1.0 / (z * z) + 3.0 / z.powi(4));
    let (mut low, mut high) = (3.0, 10.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if tail_of(middle) > tail {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Share of pixels and channels of `found` that are within their Šidák bound of `reference`, whose variance is `more`
/// times that of `variance`.
fn within(found: &Image, reference: &Image, variance: &Image, more: f64) -> f64 {
    let (width, height) = (found.width as i32, found.height as i32);
    let bound = bound(3 * found.pixels.len());
    let near = |at: i32, side: i32| (at - NEAR).max(0)..(at + NEAR + 1).min(side);
    let mut close = 0;
    for y in 0..height {
        for x in 0..width {
            let at = |x: i32, y: i32| (y * width + x) as usize;
            let around = || near(y, height).flat_map(|y| near(x, width).map(move |x| at(x, y)));
            let count = around().count() as f64;
            for channel in 0..3 {
                let of = |image: &Image, i: usize| f64::from(image.pixels[i].to_array()[channel]);
                let noise = around().map(|i| of(variance, i)).sum::<f64>() / count * (1.0 + more);
                let error = of(found, at(x, y)) - of(reference, at(x, y));
                close += u32::from(error * error <= bound * bound * noise);
            }
        }
    }
    f64::from(close) / (3 * found.pixels.len()) as f64
}

/// Traces `scene.camera` and compares it with the reference of that name.
fn agreement(name: &str, shared: &Path, samples: u32) -> Agreement {
    let (file, camera) = name.split_once('.').unwrap();
    let scene = scenes::load(&shared.join(format!("reference/scenes/{file}.obj")));
    let reference = Reference::read(shared, name);
    let found = traced(&scene, camera, samples);
    let variance = found.variance.unwrap();
    // The reference's variance goes as ours, and adds up to what its noise is known to be.
    let reference_share = reference.noise_rmse * reference.noise_rmse / mean(&variance);
    let width = found.image.width;
    let block = |left: u32, top: u32, channel: usize| {
        let (mut error, mut noise) = (0.0, 0.0);
        for i in 0..BLOCK * BLOCK {
            let at = ((top + i / BLOCK) * width + left + i % BLOCK) as usize;
            let of = |image: &Image| f64::from(image.pixels[at].to_array()[channel]);
            error += of(&found.image) - of(&reference.image);
            noise += of(&variance) * (1.0 + reference_share);
        }
        (error, noise)
    };
    let starts = |side: u32| (0..side / BLOCK).map(|i| i * BLOCK);
    let places =
        starts(found.image.height).flat_map(|top| starts(width).map(move |left| (left, top)));
    let blocks: Vec<(f64, f64)> = places
        .flat_map(|(left, top)| (0..3).map(move |channel| (left, top, channel)))
        .map(|(left, top, channel)| block(left, top, channel))
        .filter(|&(_, noise)| noise > 0.0)
        .collect();
    let sum = |of: fn(&(f64, f64)) -> f64| blocks.iter().map(of).sum::<f64>();
    let agreement = Agreement {
        mean: sum(|b| b.0) / sum(|b| b.1).sqrt(),
        rms: (sum(|b| b.0 * b.0 / b.1) / blocks.len() as f64).sqrt(),
        within: within(&found.image, &reference.image, &variance, reference_share),
    };
    println!(
        "{name}: ratio {:.5}, mean off by {:.2} σ, {} blocks by {:.3} σ rms, {:.3} % of pixels within",
        mean(&found.image) / mean(&reference.image),
        agreement.mean,
        blocks.len(),
        agreement.rms,
        100.0 * agreement.within,
    );
    agreement
}

#[test]
fn bounds_are_those_of_tables() {
    // Two-sided: 4.892 of a million at 1e-6, as for 51,293 numbers.
    assert_close("bound", bound(51_293), 4.892, 1e-3);
}

#[test]
fn pictures_are_those_of_the_reference_renderer() {
    let Some(shared) = shared("pictures_are_those_of_the_reference_renderer") else {
        return;
    };
    // Few samples tell variances too small where light is rare: blocks are off by more than one σ there.
    for (name, samples, most_rms) in [
        ("cornell.front", 64, 1.2),
        ("cornell_glossy.front", 64, 1.2),
        ("cornell_glossy.inside", 64, 1.2),
        ("sphere.front", 64, 1.3),
    ] {
        let found = agreement(name, &shared, samples);
        assert!(found.mean.abs() < 4.0, "{name}: {} σ", found.mean);
        assert!(found.rms < most_rms, "{name}: {} σ", found.rms);
        assert!(found.within >= 0.997, "{name}: {}", found.within);
    }
}
