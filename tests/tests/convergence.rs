//! Images against path-traced references: small error at the default quality, and less with more quality.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{Quality, Solution, SolveConfig, solve};
use sheen_tests::images::{self, Reference};
use sheen_tests::scenes;
use sheen_tests::shared::shared;
use std::path::Path;

/// Energy ratio at the default quality: 3 %.
const ENERGY: f64 = 0.03;

fn solved(shared: &Path, scene: &str, quality: Quality) -> Solution {
    let scene = scenes::load(&shared.join(format!("reference/scenes/{scene}.obj")));
    let config = SolveConfig {
        quality,
        ..SolveConfig::default()
    };
    solve(&scene, &config, &mut ()).unwrap()
}

/// Solves from draft to the `highest` quality; the mean error over `cameras` must fall, and be within `relmse` at the default.
fn check(scene: &str, cameras: &[&str], relmse: f64, highest: Quality) {
    let Some(shared) = shared(scene) else { return };
    let references: Vec<Reference> = cameras
        .iter()
        .map(|camera| Reference::read(&shared, &format!("{scene}.{camera}")))
        .collect();
    let (mut errors, mut faults) = (Vec::new(), Vec::new());
    let qualities = [
        Quality::DRAFT,
        Quality::PREVIEW,
        Quality::DEFAULT,
        Quality::HIGH,
    ];
    for quality in qualities.into_iter().filter(|quality| *quality <= highest) {
        let solution = solved(&shared, scene, quality);
        let mut sum = 0.0;
        for (camera, reference) in cameras.iter().zip(&references) {
            let image = images::render(&solution, images::camera(&solution, camera));
            let score = reference.score(&image);
            let energy = score.comparison.mean_ratio;
            println!(
                "{scene}.{camera}, quality {}: relMSE {:.5} (noise {:.5} subtracted), energy ratio {energy:.4}, FLIP {:.4}, \
                 solved in {:.1} s, {:.1} MiB",
                quality.value(),
                score.relmse,
                reference.noise_down2,
                score.comparison.flip,
                solution.stats.solve.wall_s,
                solution.stats.solve.bytes.total as f64 / f64::from(1 << 20)
            );
            sum += score.relmse;
            if quality == Quality::DEFAULT {
                if score.relmse > relmse {
                    faults.push(format!(
                        "{camera}: relMSE {:.4}, at most {relmse}",
                        score.relmse
                    ));
                }
                if (energy - 1.0).abs() > ENERGY {
                    faults.push(format!("{camera}: energy ratio {energy:.4}, within 3 %"));
                }
            }
        }
        errors.push(sum / cameras.len() as f64);
    }
    // Each step more than halves the tolerances. Near the reference's own noise a difference means nothing: errors of
    // a thousandth count as equal.
    if errors.windows(2).any(|pair| pair[1] >= pair[0].max(1e-3)) {
        faults.push(format!("the error does not fall: {errors:?}"));
    }
    assert!(faults.is_empty(), "{scene}: {faults:#?}");
}

#[test]
fn cornell() {
    check("cornell", &["front"], 0.03, Quality::HIGH);
}

#[test]
fn cornell_glossy() {
    // High quality takes half a minute here; the other scenes show that it pays.
    check(
        "cornell_glossy",
        &["front", "inside"],
        0.08,
        Quality::DEFAULT,
    );
}

#[test]
fn three_lights() {
    check("three_lights", &["overview", "wall"], 0.08, Quality::HIGH);
}

#[test]
fn sphere() {
    check("sphere", &["front", "low"], 0.08, Quality::HIGH);
}
