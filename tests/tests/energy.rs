//! The ledger of power: what is emitted is absorbed, unshot, or has escaped.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::config::{Quality, Settings};
use sheen_solver::{Scene, Solution, SolveConfig, solve};
use sheen_tests::measure::{area, front_triangles, mean_of_corners};
use sheen_tests::shared::shared;
use sheen_tests::{UntilReport, assert_close, scenes};
use std::f64::consts::PI;

/// Emitted power is absorbed, unshot or escaped to 0.5 %.
const LEDGER: f64 = 0.005;

/// The same in scenes of many small things at preview, as links leave it. What a thing stands on is found at 64 places of
/// an element: light that is taken to leave from thinner parts below things is lost in them, and given back.
const FURNISHED: f64 = 0.01;

/// Escape rays may start within rounding of an edge where two faces meet, and slip through it.
const SLIPPED: f64 = 5e-5;

/// Solves, and adds to `faults` where the ledger does not close.
fn check(name: &str, scene: &Scene, faults: &mut Vec<String>) -> Solution {
    let solution = solve(scene, &SolveConfig::default(), &mut ()).unwrap();
    check_solution(name, &solution, Quality::DEFAULT, LEDGER, faults);
    solution
}

/// `links`: how far off the ledger may be as links left it.
fn check_solution(
    name: &str,
    solution: &Solution,
    quality: Quality,
    links: f64,
    faults: &mut Vec<String>,
) {
    let s = &solution.stats.solve;
    println!(
        "{name}: emitted {:.5} W, absorbed {:.5}, unshot {:.5}, escaped {:.5}; {} iterations, {:.1} s",
        s.emitted_w, s.absorbed_w, s.unshot_w, s.escaped_w, s.iterations, s.wall_s
    );
    let known = s.absorbed_w + s.unshot_w + s.escaped_w;
    // As links left it, and after what they lost was given back.
    for (known, most) in [(known - s.corrected_w, links), (known, LEDGER)] {
        let error = known / s.emitted_w - 1.0;
        println!("{name}: ledger off by {:+.4} %", error * 100.0);
        if error.abs() > most {
            faults.push(format!("{name}: {:+.4} %", error * 100.0));
        }
    }
    // The iteration stopped because it was done.
    let share = f64::from(Settings::of(quality).unshot_share);
    assert!(
        s.unshot_w <= share * s.emitted_w,
        "{name}: {} W unshot",
        s.unshot_w
    );
    assert!(s.absorbed_w >= 0.0 && s.escaped_w >= 0.0);
}

/// π Σ L A over the fronts that emit, from the scene itself, all channels.
fn emitted(scene: &Scene) -> f64 {
    let of = |t: &sheen_solver::Triangle| {
        let [a, b, c] = scene.corners(t).map(|corner| corner.as_dvec3());
        let radiance = scene.materials()[t.material as usize].emission.mean();
        PI * 3.0 * f64::from(radiance) * (b - a).cross(c - a).length() * 0.5
    };
    scene.triangles().iter().map(of).sum()
}

#[test]
fn open_boxes_and_plates() {
    let mut faults = Vec::new();
    for name in [
        "cornell_box",
        "cornell_box_glossy",
        "parallel_plates",
        "three_lights",
        "glossy_sphere",
    ] {
        let scene = scenes::own(name);
        let solution = check(name, &scene, &mut faults);
        assert!(solution.stats.solve.escaped_w > 0.0, "{name} is open");
        // Sums over the same triangles: rounding of f32 areas.
        assert_close(
            format!("{name}: emitted"),
            solution.stats.solve.emitted_w,
            emitted(&scene),
            1e-4,
        );
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn closed_scenes_let_nothing_escape() {
    let mut faults = Vec::new();
    for (name, scene) in [
        ("furnace", scenes::own("furnace")),
        ("cube, ρ 0.8", scenes::cube_with_lit_ceiling(4.0, 0.8)),
        ("room with a glossy floor", scenes::room_with_glossy_floor()),
    ] {
        let solution = check(name, &scene, &mut faults);
        let s = &solution.stats.solve;
        // Rays of its own through edges of a closed room: none may pass, up to a few that meet an edge.
        if s.escaped_w > SLIPPED * s.emitted_w {
            faults.push(format!("{name}: {} W escaped", s.escaped_w));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn the_displayed_light_is_that_of_the_ledger() {
    let name = "cornell_box";
    let scene = scenes::own(name);
    let solution = solve(&scene, &SolveConfig::default(), &mut ()).unwrap();
    // Absorbed on a diffuse surface: (1 - ρ)/ρ π (L - Le), all channels. Outsides of the box see nothing.
    let mut absorbed = 0.0;
    for (triangle, surface) in front_triangles(&scene, &solution) {
        let material = &scene.materials()[scene.triangles()[surface].material as usize];
        let radiance = mean_of_corners(&solution, triangle);
        let (rho, own) = (material.diffuse.to_array(), material.emission.to_array());
        for i in 0..3 {
            let (rho, own) = (f64::from(rho[i]), f64::from(own[i]));
            absorbed += (1.0 - rho) / rho * PI * (radiance[i] - own) * area(&solution, triangle);
        }
    }
    // Light gathered at vertices against light transported between elements: two computations of one quantity, each
    // good to about 1 %.
    let s = &solution.stats.solve;
    assert_close(
        "absorbed, from the vertices",
        absorbed,
        s.absorbed_w + s.unshot_w,
        0.02,
    );
}

/// The ledger of a scene of many small things at preview; nothing is gathered at vertices.
fn check_furnished(name: &str, scene: &Scene) {
    let config = SolveConfig {
        quality: Quality::PREVIEW,
        ..SolveConfig::default()
    };
    let solution = solve(scene, &config, &mut UntilReport::transport_is_done()).unwrap();
    let mut faults = Vec::new();
    check_solution(name, &solution, Quality::PREVIEW, FURNISHED, &mut faults);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn a_furnished_room() {
    check_furnished("cafe", &scenes::own("cafe"));
}

#[test]
fn the_soda_shoppe() {
    let Some(shared) = shared("the_soda_shoppe") else {
        return;
    };
    for name in ["soda.mgf", "soda_phong.obj"] {
        let path = shared.join("reference/scenes").join(name);
        check_furnished(name, &scenes::load(&path));
    }
}
