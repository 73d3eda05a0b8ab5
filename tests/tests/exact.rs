//! Direct light and one reflection against closed forms (`exact_cases.md` 2b and 2c, adapted from CIE 171:2006 5.3, 5.6
//! and 5.7), by the solution and by the path tracer. Heights are along z.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::path::Sampler;
use sheen_solver::{PathTracer, Scene, SolveConfig, solve};
use sheen_tests::assert_close;
use sheen_tests::scenes::Builder;
use sheen_viewer::ways::cpu::Looker;
use std::f64::consts::PI;

const REFLECTANCE: f32 = 0.5;
/// How far off its surface the eye stands [m].
const OFF: f32 = 0.25;

const FLOOR: [(f32, f32, f32); 4] = [(0., 0., 0.), (4., 0., 0.), (4., 4., 0.), (0., 4., 0.)];
const CEILING: [(f32, f32, f32); 4] = [(0., 0., 3.), (0., 4., 3.), (4., 4., 3.), (4., 0., 3.)];
/// The wall y = 0.
const NEAR_WALL: [(f32, f32, f32); 4] = [(0., 0., 0.), (0., 0., 3.), (4., 0., 3.), (4., 0., 0.)];
/// The wall y = 4.
const FAR_WALL: [(f32, f32, f32); 4] = [(0., 4., 0.), (4., 4., 0.), (4., 4., 3.), (0., 4., 3.)];

/// A lamp of this radiance and a grey receiver; nothing else reflects.
fn scene(
    lamp: [(f32, f32, f32); 4],
    radiance: f32,
    receiver: [(f32, f32, f32); 4],
    block: Option<[Vec3; 2]>,
) -> Scene {
    let mut builder = Builder::new();
    let bright = builder.lambert("lamp", 0.0, radiance);
    let grey = builder.lambert("receiver", REFLECTANCE, 0.0);
    let black = builder.lambert("block", 0.0, 0.0);
    builder.quad(lamp.map(Vec3::from), bright);
    builder.quad(receiver.map(Vec3::from), grey);
    if let Some([low, high]) = block {
        builder.block(low, high, black);
    }
    builder.build()
}

/// How far the solution may be off: half a per cent, but where vertices are further apart than the light bends between
/// them: below the ceiling beside the panel (1.4 % at every quality), and where the block's shadow begins (1.1 % at
/// default quality, none at high).
fn solver_goal(name: &str, point: Vec3) -> f64 {
    match name {
        "panel on wall" if point.z == 2.75 => 1.5e-2,
        "block, floor" if point.y == 0.75 => 1.5e-2,
        _ => 5e-3,
    }
}

/// Compares the irradiance at points of the receiver, whose normal is `normal`, with what it should be; `rounding`: of
/// the published figures.
fn check(name: &str, scene: &Scene, normal: Vec3, expected: &[(Vec3, f64)], rounding: f64) {
    let solution = solve(scene, &SolveConfig::default(), &mut ()).unwrap();
    let looker = Looker::new(&solution, &[]);
    let tracer = PathTracer::new(scene);
    for &(point, irradiance) in expected {
        let eye = point + normal * OFF;
        let seen = looker.look(eye, -normal.as_dvec3(), 0.0, |v, m| m.shaded(&solution, v));
        let solved = seen[0] * PI / f64::from(REFLECTANCE);
        const SAMPLES: u32 = 1 << 14;
        let sample = |index| {
            let mut sampler = Sampler::new(0, index, 0);
            f64::from(tracer.reflected(eye, -normal, &mut sampler).mean())
        };
        let mean = (0..SAMPLES).map(sample).sum::<f64>() / f64::from(SAMPLES);
        let traced = mean * PI / f64::from(REFLECTANCE);
        if irradiance == 0.0 {
            assert_eq!(traced, 0.0, "{name}, {point}");
            // On the very edge of the shadow (y = 1.75) a vertex in the light shows through: 7 % of what is beside it.
            let most = if point.y == 1.75 { 0.3 } else { 1e-3 };
            assert!(solved.abs() < most, "{name}, {point}: {solved}");
            continue;
        }
        let slack = rounding / irradiance;
        assert_close(
            format!("{name}, {point}: paths"),
            traced,
            irradiance,
            1e-3 + slack,
        );
        assert_close(
            format!("{name}, {point}: solution"),
            solved,
            irradiance,
            solver_goal(name, point) + slack,
        );
    }
}

/// Points of the near wall's middle, from the top down.
fn down_the_wall(heights: &[f32], values: &[f64]) -> Vec<(Vec3, f64)> {
    let points = heights.iter().map(|&z| Vec3::new(2.0, 0.0, z));
    points.zip(values.iter().copied()).collect()
}

/// Points at a height, away from the near wall.
fn away(z: f32, from: &[f32], values: &[f64]) -> Vec<(Vec3, f64)> {
    let points = from.iter().map(|&y| Vec3::new(2.0, y, z));
    points.zip(values.iter().copied()).collect()
}

#[test]
fn a_panel_in_the_ceiling_of_a_black_room() {
    let panel = [
        (1.5, 1.5, 3.),
        (1.5, 2.5, 3.),
        (2.5, 2.5, 3.),
        (2.5, 1.5, 3.),
    ];
    let wall = down_the_wall(
        &[2.75, 2.25, 1.75, 1.25, 0.75, 0.25],
        &[32.68, 75.19, 81.32, 69.06, 53.40, 40.00],
    );
    check(
        "panel on wall",
        &scene(panel, 1000.0, NEAR_WALL, None),
        Vec3::Y,
        &wall,
        5e-3,
    );
    let floor = away(
        0.0,
        &[0.25, 0.75, 1.25, 1.75],
        &[61.42, 79.26, 95.67, 105.78],
    );
    check(
        "panel on floor",
        &scene(panel, 1000.0, FLOOR, None),
        Vec3::Z,
        &floor,
        5e-3,
    );
}

#[test]
fn a_floor_that_reflects_evenly() {
    let radiance = 100.0 / std::f32::consts::PI;
    let wall = down_the_wall(
        &[0.75, 1.25, 1.75, 2.25, 2.75],
        &[35.901, 27.992, 21.639, 16.716, 12.967],
    );
    check(
        "floor on wall",
        &scene(FLOOR, radiance, NEAR_WALL, None),
        Vec3::Y,
        &wall,
        5e-4,
    );
    let ceiling = away(
        3.0,
        &[0.25, 0.75, 1.25, 1.75],
        &[26.80, 30.94, 33.98, 35.57],
    );
    check(
        "floor on ceiling",
        &scene(FLOOR, radiance, CEILING, None),
        Vec3::NEG_Z,
        &ceiling,
        5e-3,
    );
}

#[test]
fn a_wall_that_reflects_evenly_behind_a_block() {
    let radiance = 100.0 / std::f32::consts::PI;
    let block = Some([Vec3::new(0., 2.5, 0.), Vec3::new(4., 2.7, 1.)]);
    let wall = down_the_wall(
        &[2.75, 2.25, 1.75, 1.25, 0.75, 0.25],
        &[16.07, 16.33, 15.40, 13.32, 10.32, 7.08],
    );
    check(
        "block, wall",
        &scene(FAR_WALL, radiance, NEAR_WALL, block),
        Vec3::Y,
        &wall,
        5e-3,
    );
    // Before the block only: its foot stands on the floor.
    let before = [(0., 0., 0.), (4., 0., 0.), (4., 2.5, 0.), (0., 2.5, 0.)];
    let floor = away(
        0.0,
        &[0.25, 0.75, 1.25, 1.75, 2.25],
        &[3.38, 3.63, 3.01, 0.0, 0.0],
    );
    check(
        "block, floor",
        &scene(FAR_WALL, radiance, before, block),
        Vec3::Z,
        &floor,
        5e-3,
    );
}
