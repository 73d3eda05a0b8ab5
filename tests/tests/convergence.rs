//! Images against path-traced references: small error at the default quality, and less with more quality.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{Quality, Solution, SolveConfig, solve};
use sheen_tests::images::{self, Reference};
use sheen_tests::scenes;
use sheen_tests::shared::shared;
use std::path::Path;

/// Energy ratio at the default quality: 1 %.
const ENERGY: f64 = 0.01;

/// What pictures at the default quality may be wrong by.
struct Limits {
    relmse: f64,
    flip: f64,
}

fn solved(shared: &Path, scene: &str, quality: Quality) -> Solution {
    let scene = scenes::load(&shared.join(format!("reference/scenes/{scene}.obj")));
    let config = SolveConfig {
        quality,
        ..SolveConfig::default()
    };
    solve(&scene, &config, &mut ()).unwrap()
}

/// Solves from draft to the `highest` quality; the mean error over `cameras` must fall, and be within `limits` at the default.
fn check(scene: &str, cameras: &[&str], limits: &Limits, highest: Quality) {
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
                for (what, found, most) in [
                    ("relMSE", score.relmse, limits.relmse),
                    ("FLIP", score.comparison.flip, limits.flip),
                ] {
                    if found > most {
                        faults.push(format!("{camera}: {what} {found:.4}, at most {most}"));
                    }
                }
                if (energy - 1.0).abs() > ENERGY {
                    faults.push(format!("{camera}: energy ratio {energy:.4}, within 1 %"));
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

const GLOSSY: Limits = Limits {
    relmse: 0.015,
    flip: 0.06,
};

#[test]
fn cornell() {
    let limits = Limits {
        relmse: 0.004,
        flip: 0.04,
    };
    check("cornell", &["front"], &limits, Quality::HIGH);
}

#[test]
fn cornell_glossy() {
    // High quality takes long here; the other scenes show that it pays.
    let cameras = ["front", "inside"];
    check("cornell_glossy", &cameras, &GLOSSY, Quality::DEFAULT);
}

#[test]
fn three_lights() {
    let limits = Limits {
        relmse: 0.03,
        flip: 0.06,
    };
    check(
        "three_lights",
        &["overview", "wall"],
        &limits,
        Quality::HIGH,
    );
}

#[test]
fn sphere() {
    check("sphere", &["front", "low"], &GLOSSY, Quality::HIGH);
}
