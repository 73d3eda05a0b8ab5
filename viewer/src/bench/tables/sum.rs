//! Table 1: the reflection of a sum against the sum of reflections.

use super::run::{Case, run};
use crate::bench::table::{Table, Value};
use sheen_solver::config::Method;
use sheen_solver::{Observer, SolveConfig, SolveError};

/// The scenes, by the angle between their lamps.
pub const LAMP_GRIDS: [&str; 3] = ["lamp_grid_3", "lamp_grid_15", "lamp_grid_30"];

/// Table 1: basis functions and BRDF evaluations, of the sum and one by one.
const PAPER: [[f64; 4]; 3] = [
    [4_998.0, 7_140.0, 457_968.0, 148_172.0],
    [3_752.0, 16_390.0, 342_000.0, 351_554.0],
    [3_096.0, 23_574.0, 251_790.0, 219_372.0],
];

/// Measures `cases`, which are [`LAMP_GRIDS`]. Ratios are summing reflections over reflecting the sum.
pub fn sum(cases: &[Case], observer: &mut dyn Observer) -> Result<Table, SolveError> {
    let mut table = Table::new(
        "sum",
        "Table 1: reflecting the sum of all samples (sum), and summing their reflections (each)",
        &[
            "scene",
            "basis functions, sum",
            "each",
            "ratio",
            "paper",
            "BRDF evaluations, sum",
            "each",
            "ratio",
            "paper",
            "s, sum",
            "each",
            "ratio",
        ],
    );
    for (case, paper) in cases.iter().zip(PAPER) {
        let config = |method| SolveConfig {
            method,
            ..super::methods::as_the_paper(0.5, 6)
        };
        let sum = run(case, &config(Method::IlluminationSamples), observer)?;
        let each = run(case, &config(Method::SummedReflections), observer)?;
        let (Some(sum), Some(each)) = (sum, each) else {
            break;
        };
        let [of_sum, of_each] = [&sum, &each].map(|run| &run.solution.stats.solve);
        let ratio = |each: f64, sum: f64| Value::Fixed(each / sum, 2);
        let counts = |sum: u64, each: u64, paper_sum: f64, paper_each: f64| {
            [
                Value::Count(sum),
                Value::Count(each),
                ratio(each as f64, sum as f64),
                ratio(paper_each, paper_sum),
            ]
        };
        let mut row = vec![Value::Text(case.name.clone())];
        row.extend(counts(
            of_sum.basis_functions,
            of_each.basis_functions,
            paper[0],
            paper[1],
        ));
        row.extend(counts(
            of_sum.brdf_evaluations,
            of_each.brdf_evaluations,
            paper[2],
            paper[3],
        ));
        row.extend([
            Value::Fixed(sum.seconds, 3),
            Value::Fixed(each.seconds, 3),
            ratio(each.seconds, sum.seconds),
        ]);
        table.rows.push(row);
    }
    Ok(table)
}
