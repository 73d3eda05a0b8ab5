//! A cube with a ceiling that emits: the radiosity of its faces (`exact_cases.md` 2d), element by element.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::Scene;
use sheen_solver::config::{Quality, Settings};
use sheen_solver::solve::{Prepared, transported};
use sheen_solver::stats::SolveStats;
use sheen_tests::assert_close;

use sheen_tests::scenes::{self, Builder};
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

const FACES: [&str; 3] = ["ceiling", "floor", "wall"];

/// Exitance [W/m²] of the ceiling, the floor and the walls, means over their leaves; and the work that it took.
fn radiosity(scene: &Scene, settings: &Settings) -> ([f64; 3], SolveStats) {
    let prepared = Prepared::new(scene, settings);
    let done = transported(&prepared, settings).unwrap();
    let unit = f64::from(prepared.frame.radiance_unit());
    let hierarchy = &done.hierarchy;
    let leaves = hierarchy
        .elements
        .iter()
        .filter(|e| hierarchy.is_leaf(e.node));
    let (mut power, mut area) = ([0.0; 3], [0.0; 3]);
    for element in leaves.filter(|e| !e.back) {
        let node = element.node as usize;
        let material = &scene.materials()[element.material as usize];
        let face = FACES.iter().position(|face| *face == material.name);
        let face = face.unwrap();
        let size = f64::from(hierarchy.node(element.node).area);
        let received = f64::from(done.irradiance[node].g * material.diffuse.g) * unit;
        power[face] += size * (received + PI * f64::from(material.emission.g));
        area[face] += size;
    }
    (
        [0, 1, 2].map(|face| power[face] / area[face]),
        done.stats.solve,
    )
}

/// The unit cube with `n` × `n` patches a face.
fn cube_of_patches(n: u16, reflectance: f32) -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", reflectance, 0.0);
    let floor = builder.lambert("floor", reflectance, 0.0);
    let ceiling = builder.lambert("ceiling", reflectance, FRAC_1_PI);
    let at = |i: u16| f32::from(i) / f32::from(n);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        // Counter-clockwise on the square; the third coordinate is the face's.
        let square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| (at(i), at(j)));
        for axis in 0..3 {
            let corner = |height: f32| {
                square.map(|(u, v)| match axis {
                    0 => Vec3::new(height, u, v),
                    1 => Vec3::new(v, height, u),
                    _ => Vec3::new(u, v, height),
                })
            };
            let [low, mut high] = [corner(0.0), corner(1.0)];
            high.reverse();
            let [below, above] = if axis == 1 {
                [floor, ceiling]
            } else {
                [wall; 2]
            };
            builder.quad(low, below).quad(high, above);
        }
    }
    builder.build()
}

#[test]
fn constant_patches_converge_as_the_square_of_their_size() {
    // The mean of the face opposite of the emitter, ρ .5: without end, and with n × n constants a face.
    const LIMIT: f64 = 0.17121;
    let error = |n: u16, expected: f64| {
        // Every pair of patches has a link, and no patch is split.
        let settings = Settings {
            link_tolerance: 1e-9,
            link_irradiance: 1e-9,
            min_radius: 1.0,
            unshot_share: 1e-6,
            ..Settings::of(Quality::HIGH)
        };
        let ([_, opposite, _], stats) = radiosity(&cube_of_patches(n, 0.5), &settings);
        assert_eq!(stats.leaves, 6 * u64::from(n) * u64::from(n));
        // Kernels of near patches are means of a few points.
        assert_close(format!("{n} × {n}"), opposite, expected, 1e-4);
        opposite - LIMIT
    };
    let [coarse, fine] = [error(4, 0.171_829), error(8, 0.171_373)];
    println!("half the size: {:.2} times the accuracy", coarse / fine);
    assert!(coarse > 3.3 * fine, "{coarse}, {fine}");
}

#[test]
fn means_of_faces_are_those_of_the_limit() {
    for (reflectance, expected) in [
        (0.5, [1.104_36, 0.171_21, 0.181_11]),
        (0.8, [1.587_51, 0.660_98, 0.687_88]),
    ] {
        let scene = scenes::cube_with_lit_ceiling(1.0, reflectance);
        // Links may be wrong by a share of all power, of which the opposite face has the least.
        for (quality, most) in [(Quality::DEFAULT, 4e-3), (Quality::HIGH, 1e-3)] {
            let (found, _) = radiosity(&scene, &Settings::of(quality));
            for ((face, found), expected) in FACES.into_iter().zip(found).zip(expected) {
                let name = format!("ρ {reflectance}, {quality:?}, {face}");
                assert_close(name, found, expected, most);
            }
        }
    }
}
