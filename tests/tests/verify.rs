//! `verify`: its intervals hold the truth as often as they say, and it finds errors that are there.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::path::{Aim, Probes, Sampler};
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
    // Few probes that meet narrow highlights tell little of how much they vary: there it takes more of them until
    // intervals hold what they promise. Nobody need ask for as few: eight times as many are the default.
    for (name, scene, probes) in [
        ("furnace", scenes::own("furnace"), 1 << 13),
        ("glossy floor", scenes::room_with_glossy_floor(), 1 << 15),
    ] {
        let solution = solved(&scene, Quality::DRAFT);
        let tracer = PathTracer::new(&scene);
        // A long run stands for the truth: its own error is a twentieth of the others'.
        let truth = found(&solution, &tracer, 1 << 23, 0);
        let (mut bias, mut rms) = (0, 0);
        for seed in 1..=TRIALS {
            let errors = found(&solution, &tracer, probes, seed);
            bias += u32::from(holds(&errors.bias, truth.bias.value));
            rms += u32::from(holds(&errors.rms, truth.rms.value));
        }
        println!(
            "{name}: bias {:?}, rms {:?}; {bias} and {rms} of {TRIALS} hold them",
            truth.bias, truth.rms
        );
        assert!((930..=970).contains(&bias), "{name}: {bias} of {TRIALS}");
        assert!((930..=970).contains(&rms), "{name}: {rms} of {TRIALS}");
    }
}

#[test]
fn probes_that_are_aimed_at_highlights_tell_what_even_ones_do() {
    const PROBES: u32 = 1 << 19;
    let scene = scenes::room_with_glossy_floor();
    let tracer = PathTracer::new(&scene);
    let [even, aimed] = [Aim::Even, Aim::Highlights].map(|aim| {
        let probes = Probes::new(&tracer, aim);
        let (mut weights, mut light, mut squares) = (0.0, 0.0, 0.0);
        for index in 0..PROBES {
            let mut sampler = Sampler::new(index, 0, 0);
            let probe = probes.choose(&mut sampler).unwrap();
            let radiance = tracer.reflected(probe.eye, probe.direction, &mut sampler);
            let weight = f64::from(probe.weight);
            let value = weight * f64::from(radiance.mean());
            weights += weight;
            light += value;
            squares += value * value;
        }
        let n = f64::from(PROBES);
        assert_close(format!("{aim:?}, weight"), weights / n, 1.0, 5e-3);
        (light / n, ((squares / n - (light / n).powi(2)) / n).sqrt())
    });
    println!("mean radiance {even:?}, aimed {aimed:?}, with their standard deviations");
    assert!((even.0 - aimed.0).abs() < 4.0 * even.1.hypot(aimed.1));
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
