//! Tables 3 and 4: illumination samples against radiance clustering.

use super::run::{Case, run};
use crate::bench::table::{Table, Value};
use crate::compare::{CompareError, compare};
use crate::ways;
use sheen_solver::config::{Method, Scheme};
use sheen_solver::stats::SolveStats;
use sheen_solver::{Observer, Quality, SolveConfig, SolveError};

/// Both tables, from the same solves.
pub struct Tables {
    /// Table 3.
    pub memory: Table,
    /// Table 4.
    pub time: Table,
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum TablesError {
    /// A solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Pictures do not fit.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

/// Deviation and deepest level, and what the paper saves of basis functions and of time [%].
const PAPER: [(&str, f32, u32, f64, f64); 6] = [
    ("three_lights", 0.5, 3, 38.0, 50.0),
    ("three_lights", 0.1, 3, 37.0, 51.0),
    ("three_lights", 0.5, 4, 37.0, 48.0),
    ("three_lights", 0.5, 5, 37.0, 44.0),
    ("glossy_sphere", 0.5, 3, 41.0, 34.0),
    ("soda", 0.5, 3, 37.0, 27.0),
];

/// Directions that are taken for the truth.
const FINE_EPSILON: f32 = 0.05;
const FINE_LEVEL: u32 = 6;

/// Scenes that the paper has not, and the same of them, at draft quality: at default radiance clustering takes hours.
const OURS: [(&str, f32, u32); 1] = [("cafe", 0.5, 3)];

/// A solve as in the paper: all light has its direction, and elements are averaged for display (§5.2).
pub(super) fn as_the_paper(epsilon: f32, levels: u32) -> SolveConfig {
    SolveConfig {
        max_level: Some(levels),
        epsilon: Some(epsilon),
        transport_epsilon: Some(epsilon),
        least_directional: Some(0.0),
        gather: Some(false),
        ..SolveConfig::default()
    }
}

const SCHEMES: [(Scheme, &str); 2] = [
    (Scheme::Gathering, "gathering"),
    (Scheme::Shooting, "shooting"),
];

/// Measures `cases`. Savings are what illumination samples (IS) take less than radiance clustering (RC).
pub fn methods(cases: &[Case], observer: &mut dyn Observer) -> Result<Tables, TablesError> {
    let common = ["scene", "epsilon", "levels", "scheme"];
    let table =
        |name: &str, title: &str, own: &[&str]| Table::new(name, title, &[&common, own].concat());
    let mut memory = table(
        "memory",
        "Table 3: memory, counted by allocation, and the number of directional basis functions made",
        &[
            "IS MiB",
            "RC MiB",
            "saved %",
            "IS light MiB",
            "RC light MiB",
            "saved %",
            "IS basis functions",
            "RC basis functions",
            "saved %",
            "paper %",
            "FLIP",
            "IS FLIP to fine",
            "RC FLIP to fine",
        ],
    );
    memory.notes.push(format!(
        "MiB is all that the program allocates at most, scene and mesh included; of light, what transport keeps of it. FLIP is \
         that of the two pictures, and of each to one with fine directions (ε {FINE_EPSILON}, level {FINE_LEVEL})."
    ));
    let mut time = table(
        "time",
        "Table 4: time",
        &["IS s", "RC s", "saved %", "paper %", "IS links", "RC links"],
    );
    let of_paper = PAPER
        .map(|(scene, epsilon, levels, basis, time)| (scene, epsilon, levels, Some((basis, time))));
    let ours = OURS.map(|(scene, epsilon, levels)| (scene, epsilon, levels, None));
    for table in [&mut memory, &mut time] {
        table
            .notes
            .push("The café is solved at draft quality.".to_owned());
    }
    'all: for (scene, epsilon, levels, paper) in of_paper.into_iter().chain(ours) {
        let Some(case) = cases.iter().find(|case| case.name == scene) else {
            continue;
        };
        for (scheme, scheme_name) in SCHEMES {
            let config = |method, epsilon, levels| SolveConfig {
                method,
                scheme,
                quality: match paper {
                    Some(_) => Quality::DEFAULT,
                    None => Quality::DRAFT,
                },
                ..as_the_paper(epsilon, levels)
            };
            let of = |method| config(method, epsilon, levels);
            let fine = config(Method::IlluminationSamples, FINE_EPSILON, FINE_LEVEL);
            let samples = run(case, &of(Method::IlluminationSamples), observer)?;
            let clusters = run(case, &of(Method::RadianceClustering), observer)?;
            let fine = run(case, &fine, observer)?;
            let (Some(samples), Some(clusters), Some(fine)) = (samples, clusters, fine) else {
                break 'all;
            };
            let [left, right, truth] = [&samples, &clusters, &fine]
                .map(|run| ways::cpu::render(&run.solution, &case.view, ways::ACROSS));
            let flip = |a, b| -> Result<Value, CompareError> {
                Ok(Value::Fixed(compare(a, b, 1, None)?.flip, 4))
            };
            let [of_samples, of_clusters] =
                [&samples, &clusters].map(|run| &run.solution.stats.solve);
            let saved = |less: f64, more: f64| Value::Fixed(100.0 * (1.0 - less / more), 1);
            let light =
                |solve: &SolveStats| solve.bytes.illumination_samples + solve.bytes.distributions;
            let mib = |bytes: u64| Value::Fixed(bytes as f64 / f64::from(1 << 20), 2);
            let paper = |of: fn((f64, f64)) -> f64| {
                paper.map_or(Value::None, |figures| Value::Fixed(of(figures), 0))
            };
            let row = |own: Vec<Value>| {
                let mut row = vec![
                    Value::Text(case.name.clone()),
                    Value::Fixed(f64::from(epsilon), 1),
                    Value::Count(u64::from(levels)),
                    Value::Text(scheme_name.to_owned()),
                ];
                row.extend(own);
                row
            };
            memory.rows.push(row(vec![
                mib(samples.allocated),
                mib(clusters.allocated),
                saved(samples.allocated as f64, clusters.allocated as f64),
                mib(light(of_samples)),
                mib(light(of_clusters)),
                saved(light(of_samples) as f64, light(of_clusters) as f64),
                Value::Count(of_samples.basis_functions),
                Value::Count(of_clusters.basis_functions),
                saved(
                    of_samples.basis_functions as f64,
                    of_clusters.basis_functions as f64,
                ),
                paper(|figures| figures.0),
                flip(&left, &right)?,
                flip(&left, &truth)?,
                flip(&right, &truth)?,
            ]));
            time.rows.push(row(vec![
                Value::Fixed(samples.seconds, 3),
                Value::Fixed(clusters.seconds, 3),
                saved(samples.seconds, clusters.seconds),
                paper(|figures| figures.1),
                Value::Count(of_samples.links),
                Value::Count(of_clusters.links),
            ]));
        }
    }
    Ok(Tables { memory, time })
}
