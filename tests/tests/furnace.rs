//! Closed scenes whose light is known exactly (exact_cases 2d, 2e): nothing may be lost or made.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::config::Quality;
use sheen_solver::solve::{enclosed, solve_furnace};
use sheen_solver::{PathTracer, Scene, SolveConfig, solve};
use sheen_tests::measure::{extremes, front_triangles, mean_radiance, mean_radiance_of};
use sheen_tests::shared::shared;
use sheen_tests::{assert_close, images, scenes};
use sheen_viewer::verify::{Verification, verify_furnace};
use std::f64::consts::PI;

/// What a furnace must show, in every pixel.
const FURNACE: f64 = 0.01;

/// The same with directions, in the root mean square: lobes that are not closed miss it on the sphere.
const DIRECTIONAL: f64 = 0.005;

/// Every surface emits 1 and reflects 0.5: radiance 1 / (1 - 0.5) everywhere.
fn assert_two_everywhere(name: &str, scene: &Scene) {
    let solution = solve(scene, &SolveConfig::default(), &mut ()).unwrap();
    let fronts = front_triangles(scene, &solution);
    let area: f64 = fronts
        .iter()
        .map(|&(t, _)| sheen_tests::measure::area(&solution, t))
        .sum();
    let whole: f64 = scene
        .triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = scene.corners(t);
            f64::from((b - a).cross(c - a).length()) * 0.5
        })
        .sum();
    // Rounding of positions only: the mesh covers each front once.
    assert!(
        (area / whole - 1.0).abs() < 1e-4,
        "{name}: {area} of {whole} m²"
    );
    let corners = fronts
        .iter()
        .flat_map(|&(t, _)| solution.triangles[t])
        .map(|v| solution.radiance[v as usize]);
    let (low, high) = extremes(corners);
    println!("{name}: vertices {low:.5}..{high:.5}");
    let worst = fronts
        .iter()
        .flat_map(|&(t, _)| solution.triangles[t])
        .max_by(|&a, &b| {
            let error = |v: u32| (solution.radiance[v as usize].mean() - 2.0).abs();
            error(a).total_cmp(&error(b))
        })
        .unwrap();
    println!(
        "{name}: worst vertex at {}",
        solution.position[worst as usize]
    );
    for camera in &solution.cameras {
        let (low, high) = extremes(images::render(&solution, camera).pixels);
        println!("{name}: pixels of '{}' {low:.5}..{high:.5}", camera.name);
        for value in [low, high] {
            assert!(
                (f64::from(value) / 2.0 - 1.0).abs() < FURNACE,
                "{name}: pixel {value}"
            );
        }
        let image = images::render(&solution, camera);
        let count = image.pixels.len() as f64;
        let errors = image.pixels.iter().map(|p| f64::from(p.mean()) / 2.0 - 1.0);
        let (sum, squares) = errors.fold((0.0, 0.0), |(s, q), e| (s + e, q + e * e));
        let (mean, rms) = (sum / count, (squares / count).sqrt());
        println!(
            "{name}: pixels of '{}' off by {mean:+.5} in the mean, {rms:.5} rms",
            camera.name
        );
        assert!(
            mean.abs() < FURNACE && rms < FURNACE,
            "{name}: mean {mean}, rms {rms}"
        );
    }
    for value in [low, high] {
        assert!(
            (f64::from(value) / 2.0 - 1.0).abs() < FURNACE,
            "{name}: vertex {value}"
        );
    }
}

#[test]
fn our_furnace_shows_two_everywhere() {
    assert_two_everywhere("scenes/furnace", &scenes::own("furnace"));
}

#[test]
fn the_reference_furnace_with_a_block_shows_two_everywhere() {
    let Some(shared) = shared("the_reference_furnace_with_a_block_shows_two_everywhere") else {
        return;
    };
    let scene = scenes::load(&shared.join("reference/scenes/furnace.obj"));
    assert_two_everywhere("reference furnace", &scene);
}

#[test]
fn mean_irradiance_of_a_closed_cube_is_exact() {
    for reflectance in [0.5, 0.8] {
        let scene = scenes::cube_with_lit_ceiling(4.0, reflectance as f32);
        let solution = solve(&scene, &SolveConfig::default(), &mut ()).unwrap();
        let fronts = front_triangles(&scene, &solution);
        let (radiance, area) = mean_radiance(&solution, fronts.iter().map(|&(t, _)| t));
        assert_close("area [m²]", area, 96.0, 1e-4);
        // The ceiling emits 1 W/m² on a sixth of the area.
        let irradiance = (PI * radiance - 1.0 / 6.0) / reflectance;
        // Whatever the mesh: Φ / (A (1 - ρ)). 1 %, as for energy and closure.
        let expected = 1.0 / 6.0 / (1.0 - reflectance);
        assert_close(
            format!("mean irradiance, ρ {reflectance}"),
            irradiance,
            expected,
            FURNACE,
        );
        // Converged means over the faces (exact_cases 2d), 1 % like the furnace.
        let faces = if reflectance == 0.5 {
            [1.10436, 0.17121, 0.18111]
        } else {
            [1.58751, 0.66098, 0.68788]
        };
        for (material, expected) in ["ceiling", "floor", "wall"].into_iter().zip(faces) {
            let found = PI * mean_radiance_of(&scene, &solution, material);
            assert_close(
                format!("radiosity of the {material}, ρ {reflectance}"),
                found,
                expected,
                FURNACE,
            );
        }
    }
}

/// How far light in rooms that lose a thousandth at each reflection may be off.
const BRIGHT: f64 = 0.005;

#[test]
fn a_room_that_loses_a_thousandth_sums_a_thousand_reflections() {
    let mut builder = scenes::Builder::new();
    let shining = builder.lambert("shining", 0.999, 1.0);
    builder.room(Vec3::ZERO, Vec3::ONE, [shining; 6]);
    let shining = builder.build();
    let lit = scenes::cube_with_lit_ceiling(1.0, 0.999);
    for quality in [Quality::PREVIEW, Quality::DEFAULT] {
        let config = SolveConfig {
            quality,
            ..SolveConfig::default()
        };
        let of = |scene: &Scene| {
            let solution = solve(scene, &config, &mut ()).unwrap();
            let fronts: Vec<usize> = front_triangles(scene, &solution)
                .into_iter()
                .map(|front| front.0)
                .collect();
            (solution, fronts)
        };
        // 1 / (1 - 0.999) everywhere.
        let (solution, fronts) = of(&shining);
        let corners = fronts.iter().flat_map(|&t| solution.triangles[t]);
        let (low, high) = extremes(corners.map(|v| solution.radiance[v as usize]));
        println!("shining: {low} to {high}, {quality:?}");
        for value in [low, high] {
            assert_close("a vertex", f64::from(value), 1000.0, BRIGHT);
        }
        // One sixth of the room emits 1/π: all light is a thousand times that. It is even but for the ceiling's own
        // emission and what of it meets the walls at once.
        let (solution, fronts) = of(&lit);
        let (mean, _) = mean_radiance(&solution, fronts);
        assert_close("mean", mean, 1000.0 / 6.0 / PI, BRIGHT);
        let floor = mean_radiance_of(&lit, &solution, "floor");
        println!("lit: {mean} in the mean, {floor} on the floor, {quality:?}");
    }
}

/// All surfaces of a scene emit what they do not reflect: errors over all of them.
fn directional_furnace(scene: &Scene, quality: Quality, probes: u32) -> Verification {
    let config = SolveConfig {
        quality,
        ..SolveConfig::default()
    };
    let enclosed = enclosed(scene).unwrap();
    let (solution, radiance) = solve_furnace(&enclosed, &config, &mut ()).unwrap();
    let tracer = PathTracer::new(&enclosed);
    verify_furnace(&solution, radiance, &tracer, probes, 0, &mut ()).unwrap()
}

#[test]
fn a_directional_furnace_shows_one_radiance() {
    for name in ["cornell_box", "cornell_box_glossy", "glossy_sphere"] {
        let mut last = f64::INFINITY;
        for quality in [Quality::PREVIEW, Quality::DEFAULT] {
            let all = directional_furnace(&scenes::own(name), quality, 1 << 16).all;
            let (rms, mean) = (all.rms.value, all.bias.value);
            println!("{name}, {quality:?}: {rms:.5} rms, {mean:+.5} in the mean");
            assert!(rms < last, "{name}: {rms} after {last}");
            last = rms;
        }
        assert!(last < DIRECTIONAL, "{name}: {last}");
    }
}

/// A room of 2 m with a lamp below its ceiling, all to be filled with things of the last material.
fn lit_room(albedo: [f32; 3]) -> (scenes::Builder, u32) {
    let [diffuse, specular, exponent] = albedo;
    let mut builder = scenes::Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    let lamp = builder.lambert("lamp", 0.0, 5.0);
    let thing = builder.phong("thing", diffuse, specular, exponent);
    builder.room(Vec3::ZERO, Vec3::splat(2.0), [wall; 6]);
    let corner = |x: f32, z: f32| Vec3::new(x, 1.99, z);
    builder.quad(
        [
            corner(0.8, 0.8),
            corner(1.2, 0.8),
            corner(1.2, 1.2),
            corner(0.8, 1.2),
        ],
        lamp,
    );
    (builder, thing)
}

/// Root mean square and mean of the errors of all things in a furnace.
fn errors_of_things(name: &str, scene: &Scene, probes: u32) -> (f64, f64) {
    let found = directional_furnace(scene, Quality::DEFAULT, probes);
    let of_things = found.materials.iter().find(|of| of.material == "thing");
    let errors = &of_things.expect("things are met").errors;
    let (rms, mean, probes) = (errors.rms.value, errors.bias.value, errors.probes);
    println!("{name}: {rms:.5} rms, {mean:+.5} in the mean of {probes} probes");
    assert!(probes > 200, "{name}: {probes}");
    (rms, mean)
}

#[test]
fn narrow_glossy_strips_are_bright_right_beside_each_other() {
    // A vertex in the corner between two strips is far closer to the other one than that is long, and it has a lobe.
    let (mut builder, strip) = lit_room([0.3, 0.4, 30.0]);
    let (along, across, up) = (Vec3::Z * 0.12, Vec3::X * 0.0017, Vec3::Y * 0.0017);
    for i in 0..40u16 {
        let (column, row) = (f32::from(i % 8), f32::from(i / 8));
        let at = Vec3::new(0.6 + 0.1 * column, 0.5 + 0.1 * row, 1.0);
        builder.quad([at, at + along, at + along + across, at + across], strip);
        builder.quad([at, at + up, at + up + along, at + along], strip);
    }
    let (rms, mean) = errors_of_things("strips", &builder.build(), 1 << 20);
    assert!(rms < 0.02 && mean.abs() < DIRECTIONAL, "{rms}, {mean}");
}

#[test]
fn bars_side_by_side_cover_each_other() {
    // Half of the side of a high bar is inside of the low one beside it, and light does not get there.
    let (mut builder, bar) = lit_room([0.3, 0.4, 30.0]);
    for (i, height) in (0u16..).zip([0.015, 0.03, 0.015, 0.03]) {
        let at = Vec3::new(1.0 + 0.015 * f32::from(i), 0.0, 0.2);
        builder.block(at, at + Vec3::new(0.015, height, 1.6), bar);
    }
    let (rms, mean) = errors_of_things("bars", &builder.build(), 1 << 18);
    assert!(rms < 0.025 && mean.abs() < DIRECTIONAL, "{rms}, {mean}");
}

#[test]
fn a_narrow_gap_is_as_bright_as_the_room() {
    // Two cupboards 6 mm apart, before a wall and above a floor at the same distance.
    let (mut builder, cupboard) = lit_room([0.7, 0.1, 550.0]);
    for left in [0.6, 0.906] {
        let low = Vec3::new(left, 0.006, 0.006);
        builder.block(low, low + Vec3::new(0.3, 0.8, 0.6), cupboard);
    }
    let (rms, mean) = errors_of_things("cupboards", &builder.build(), 1 << 17);
    assert!(rms < 0.03 && mean.abs() < FURNACE, "{rms}, {mean}");
}

#[test]
fn a_counter_is_bright_up_to_the_cupboard_below_it() {
    // Its panels, through the whole room, meet the counter along edges of leaves; between them stands a box in the dark.
    let (mut builder, counter) = lit_room([0.7, 0.1, 550.0]);
    let panel = builder.lambert("panel", 0.6, 0.0);
    for x in [0.75, 1.25] {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)];
        builder.quad(corners.map(|(y, z)| Vec3::new(x, y, z)), panel);
    }
    builder.block(Vec3::new(0.85, 0.1, 0.2), Vec3::new(1.15, 0.7, 1.8), panel);
    let corners = [(0.5, 0.0), (0.5, 2.0), (1.5, 2.0), (1.5, 0.0)];
    builder.quad(corners.map(|(x, z)| Vec3::new(x, 0.8, z)), counter);
    let (rms, mean) = errors_of_things("counter", &builder.build(), 1 << 16);
    assert!(rms < 0.015 && mean.abs() < FURNACE, "{rms}, {mean}");
}

#[test]
fn a_panel_is_bright_up_to_the_rail_that_it_ends_in() {
    // A crate below a lid that is too short: its sides end in rails narrower than their leaves, and from inside see
    // little but backs.
    let (mut builder, side) = lit_room([0.72, 0.1, 550.0]);
    let rail = builder.lambert("rail", 0.6, 0.0);
    let (low, high, top) = (0.6, 1.4, 0.6);
    let up = Vec3::Y * top;
    let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let corners = [at(low, low), at(low, high), at(high, high), at(high, low)];
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % 4];
        builder.quad([from, to, to + up, from + up], side);
        let along = (to - from).normalize();
        let half = Vec3::new(0.02, 0.03, 0.02);
        let (a, b) = (from + up + along * 0.021, to + up - along * 0.021);
        let across = half - half * along.abs();
        builder.block(a.min(b) - across, a.max(b) + across, rail);
    }
    let bottom = [(low, low), (high, low), (high, high), (low, high)];
    builder.quad(bottom.map(|(x, z)| Vec3::new(x, 0.01, z)), side);
    let lid = [(low, low), (low, high), (1.25, high), (1.25, low)];
    builder.quad(lid.map(|(x, z)| Vec3::new(x, 0.631, z)), rail);
    let (rms, mean) = errors_of_things("crate", &builder.build(), 1 << 17);
    assert!(rms < 0.009 && mean.abs() < FURNACE, "{rms}, {mean}");
}
