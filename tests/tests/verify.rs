//! `verify`: its intervals hold the truth as often as they say, and it finds errors that are there.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{PathTracer, Quality, Rgb, Scene, Solution, SolveConfig, solve};
use sheen_tests::assert_close;
use sheen_tests::scenes;
use sheen_viewer::verify::{Errors, Estimate, verify};

fn solved(scene: &Scene, quality: Quality) -> Solution {
    let config = SolveConfig {
        quality,
        ..SolveConfig::default()
    };
    solve(scene, &config, &mut ()).unwrap()
}

fn found(solution: &Solution, tracer: &PathTracer, probes: u32, seed: u32) -> Errors {
    verify(solution, tracer, probes, seed, &mut ()).unwrap().all
}

fn holds(estimate: &Estimate, truth: f64) -> bool {
    (estimate.low..=estimate.high).contains(&truth)
}

#[test]
fn intervals_hold_the_truth_in_95_of_100_runs() {
    const TRIALS: u32 = 1000;
    for (name, scene, is_even) in [
        ("furnace", scenes::own("furnace"), true),
        ("glossy floor", scenes::room_with_glossy_floor(), false),
    ] {
        let solution = solved(&scene, Quality::DRAFT);
        let tracer = PathTracer::new(&scene);
        // A long run stands for the truth: its own error is a twentieth of the others'.
        let truth = found(&solution, &tracer, 1 << 22, 0);
        let (mut bias, mut rms) = (0, 0);
        for seed in 1..=TRIALS {
            let errors = found(&solution, &tracer, 1 << 13, seed);
            bias += u32::from(holds(&errors.bias, truth.bias.value));
            rms += u32::from(holds(&errors.rms, truth.rms.value));
        }
        println!(
            "{name}: bias {:?}, rms {:?}; {bias} and {rms} of {TRIALS} hold them",
            truth.bias, truth.rms
        );
        assert!((930..=970).contains(&bias), "{name}: {bias} of {TRIALS}");
        // Where few probes meet a narrow highlight, they tell its square error too small more often than not.
        let least = if is_even { 930 } else { 800 };
        assert!((least..=970).contains(&rms), "{name}: {rms} of {TRIALS}");
    }
}

#[test]
fn an_error_that_was_put_there_is_found() {
    let scene = scenes::own("furnace");
    let mut solution = solved(&scene, Quality::DEFAULT);
    let tracer = PathTracer::new(&scene);
    let plain = found(&solution, &tracer, 1 << 16, 0);
    // Emission is 1, and so is what is reflected: radiance 2.2 holds .2 too much.
    for radiance in &mut solution.radiance {
        *radiance *= 1.1;
    }
    let brighter = found(&solution, &tracer, 1 << 16, 0);
    println!("{plain:?} {brighter:?}");
    assert!(
        plain.bias.value.abs() < 0.01 && plain.rms.high < 0.1,
        "{plain:?}"
    );
    assert_close("bias", brighter.bias.value - plain.bias.value, 0.2, 5e-3);
    assert!(
        holds(&brighter.bias, 0.2 + plain.bias.value),
        "{brighter:?}"
    );
    // Half of all sides are the outside of the shell, which is black.
    assert_close("rms", brighter.rms.value, 0.2 * 2f64.sqrt(), 0.02);
}

#[test]
fn the_error_of_a_black_solution_is_all_of_the_light() {
    let scene = scenes::room_with_glossy_floor();
    let mut solution = solved(&scene, Quality::DRAFT);
    let tracer = PathTracer::new(&scene);
    for (radiance, &material) in solution.radiance.iter_mut().zip(&solution.material) {
        let emission = solution.materials[material as usize].emission;
        *radiance = if radiance.is_black() {
            Rgb::BLACK
        } else {
            emission
        };
    }
    solution
        .distribution_offset
        .fill(sheen_solver::solution::NO_DISTRIBUTION);
    let errors = found(&solution, &tracer, 1 << 14, 0);
    assert!((errors.bias.value + 1.0).abs() < 1e-6, "{errors:?}");
}
