//! Fine tiles in the open: each sees next to nothing but one small light.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::{DVec3, Vec3};
use sheen_solver::{Scene, Solution, SolveConfig, solve};
use sheen_tests::measure::{lambert, relative};
use sheen_tests::scenes::Builder;
use std::f64::consts::PI;

/// Tiles along each side of a floor, which is one wide.
const TILES: u32 = 48;

/// Adds tiles that face up to the floor of a unit square.
fn tiles(builder: &mut Builder, material: u32) {
    for i in 0..TILES * TILES {
        let corner = |di: u32, dj: u32| {
            Vec3::new((i % TILES + di) as f32, 0.0, (i / TILES + dj) as f32) / TILES as f32
        };
        let corners = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
        builder.quad(corners, material);
    }
}

/// Where tiles show light, and how much.
fn shown(scene: &Scene, material: u32) -> Vec<(Vec3, f64)> {
    let solution: Solution = solve(scene, &SolveConfig::default(), &mut ()).unwrap();
    let is_shown = |&v: &usize| solution.material[v] == material && solution.normal[v].y > 0.0;
    let tiles: Vec<(Vec3, f64)> = (0..solution.position.len())
        .filter(is_shown)
        .map(|v| (solution.position[v], f64::from(solution.radiance[v].mean())))
        .collect();
    assert!(tiles.len() as u32 > TILES * TILES);
    tiles
}

/// Largest error of the radiance of tiles, as a share of what is right.
fn worst(tiles: &[(Vec3, f64)], right: impl Fn(Vec3) -> f64) -> f64 {
    let error = |&(at, found): &(Vec3, f64)| (found / right(at) - 1.0).abs();
    tiles.iter().map(error).fold(0.0, f64::max)
}

#[test]
fn a_small_lamp_over_a_large_floor() {
    let mut builder = Builder::new();
    let floor = builder.lambert("floor", 0.5, 0.0);
    let lamp = builder.lambert("lamp", 0.0, 8.0);
    tiles(&mut builder, floor);
    let corner = |x: f32, z: f32| Vec3::new(0.5 + 0.01 * x, 0.4, 0.5 + 0.01 * z);
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    builder.quad(corners, lamp);
    let found = shown(&builder.build(), floor);
    let right = |at: Vec3| 0.5 / PI * 8.0 * lambert(&relative(&corners, at), DVec3::Y);
    let error = worst(&found, right);
    println!("small lamp: {:.3} % at worst", 100.0 * error);
    assert!(error < 0.01, "{error}");
}

#[test]
fn a_point_light_over_a_large_floor() {
    let mut builder = Builder::new();
    let floor = builder.lambert("floor", 0.5, 0.0);
    tiles(&mut builder, floor);
    let light = Vec3::new(0.3, 0.05, 0.6);
    builder.point_light(light, 2.0);
    let found = shown(&builder.build(), floor);
    // ρ/π I cosθ/d².
    let right = |at: Vec3| {
        let to = (light - at).as_dvec3();
        0.5 / PI * 2.0 * to.y / to.length().powi(3)
    };
    let error = worst(&found, right);
    // Light at the rim is gathered a little inside.
    let is_inside = |v: &&(Vec3, f64)| {
        let from_rim = v.0.min(1.0 - v.0);
        from_rim.x.min(from_rim.z) > 0.5 / TILES as f32
    };
    let inside: Vec<(Vec3, f64)> = found.iter().filter(is_inside).copied().collect();
    let error_inside = worst(&inside, right);
    println!(
        "point light: {:.4} % at worst, {:.4} % inside",
        100.0 * error,
        100.0 * error_inside
    );
    assert!(
        error < 1e-2 && error_inside < 1e-3,
        "{error} {error_inside}"
    );
}

/// Radiance that a floor with reflectance 0.5 shows at a point: lamp, card with reflectance 0.8, floor, the lamp in
/// between; the integral over the card as a sum.
fn from_card(card: &[Vec3; 4], lamp: &[Vec3; 4], at: Vec3) -> f64 {
    const PARTS: u32 = 200;
    let (corner, opposite) = (card[0].as_dvec3(), card[2].as_dvec3());
    let at = at.as_dvec3();
    let mut sum = 0.0;
    for i in 0..PARTS * PARTS {
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(PARTS);
        let place = DVec3::new(
            corner.x + (opposite.x - corner.x) * share(i % PARTS),
            corner.y,
            corner.z + (opposite.z - corner.z) * share(i / PARTS),
        );
        let to = place - at;
        let crossing = at + to * (f64::from(lamp[0].y) / place.y);
        let is_within = |low: f32, high: f32, x: f64| x > f64::from(low) && x < f64::from(high);
        if is_within(lamp[0].x, lamp[2].x, crossing.x)
            && is_within(lamp[0].z, lamp[2].z, crossing.z)
        {
            continue;
        }
        let radiance = 0.8 / PI * 50.0 * lambert(&relative(lamp, place.as_vec3()), DVec3::NEG_Y);
        sum += radiance * to.y.powi(2) / to.length_squared().powi(2);
    }
    let area = (opposite.x - corner.x) * (opposite.z - corner.z);
    0.5 / PI * sum * area / f64::from(PARTS * PARTS)
}

#[test]
fn a_small_card_reflects_light_to_a_large_floor() {
    let mut builder = Builder::new();
    let floor = builder.lambert("floor", 0.5, 0.0);
    let card = builder.lambert("card", 0.8, 0.0);
    let lamp = builder.lambert("lamp", 0.0, 50.0);
    tiles(&mut builder, floor);
    let square = |height: f32, half: f32| {
        [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)]
            .map(|(x, z)| Vec3::new(0.5 + half * x, height, 0.5 + half * z))
    };
    // Faces the floor; the lamp below it faces it alone.
    builder.quad(square(0.5, 0.02), card);
    let mut up = square(0.48, 0.005);
    up.reverse();
    builder.quad(up, lamp);
    let scene = builder.build();
    let found = shown(&scene, floor);
    for at in [Vec3::new(0.13, 0.0, 0.21), Vec3::new(0.7, 0.0, 0.9)] {
        let right = from_card(&square(0.5, 0.02), &square(0.48, 0.005), at);
        let near = |v: &&(Vec3, f64)| v.0.distance(at) < 1.5 / TILES as f32;
        let around: Vec<f64> = found.iter().filter(near).map(|v| v.1).collect();
        let mean = around.iter().sum::<f64>() / around.len() as f64;
        println!("card: {mean:.6}, right {right:.6}, of {}", around.len());
        assert!((mean / right - 1.0).abs() < 0.02, "{mean} {right}");
    }
    let darkest = found.iter().map(|v| v.1).fold(f64::INFINITY, f64::min);
    assert!(darkest > 0.0, "{darkest}");
}
