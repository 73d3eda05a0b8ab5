//! Figure 8: what deviations within a distribution are held against, the radiance there or one for the whole scene.

use super::basis::PATHS;
use super::methods::TablesError;
use super::run::{Case, run};
use super::sheet::Sheet;
use super::truth::traced;
use crate::bench::table::{Table, Value};
use crate::compare::compare;
use crate::ways;
use sheen_solver::config::Refiner;
use sheen_solver::{Observer, SolveConfig};

/// Deviations that are tried with each.
const EPSILONS: [f32; 3] = [0.5, 0.25, 0.12];

/// Measures the `case`, which is [`super::GLOSSY_ROOM`]. Errors are those against path tracing.
pub fn refiner(case: &Case, observer: &mut dyn Observer) -> Result<(Table, Sheet), TablesError> {
    let mut table = Table::new(
        "refiner",
        "Figure 8: the absolute refiner and the relative one",
        &["refiner", "epsilon", "MiB", "s", "relMSE", "FLIP"],
    );
    let mut sheet = Sheet::new("figure8");
    let reference = traced(case, PATHS, observer);
    'all: for (refiner, name) in [
        (Refiner::Absolute, "absolute"),
        (Refiner::Relative, "relative"),
    ] {
        for epsilon in EPSILONS {
            let config = SolveConfig {
                refiner,
                epsilon: Some(epsilon),
                ..SolveConfig::default()
            };
            let Some(run) = run(case, &config, observer)? else {
                break 'all;
            };
            let picture = ways::cpu::render(&run.solution, &case.view, ways::ACROSS);
            let error = compare(&picture, &reference, 1, None)?;
            let bytes = 4.0 * run.solution.distribution_words.len() as f64;
            table.rows.push(vec![
                Value::Text(name.to_owned()),
                Value::Fixed(epsilon.into(), 2),
                Value::Fixed(bytes / f64::from(1 << 20), 2),
                Value::Fixed(run.seconds, 2),
                Value::Fixed(error.relmse, 5),
                Value::Fixed(error.flip, 4),
            ]);
            if epsilon == EPSILONS[0] {
                sheet.add(format!("{name}, epsilon {epsilon}"), picture);
            }
        }
    }
    sheet.add("path tracing", reference);
    table.notes.push(sheet.caption());
    Ok((table, sheet))
}
