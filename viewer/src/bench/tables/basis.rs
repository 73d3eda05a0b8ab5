//! Table 2 and figure 7: the adaptive basis against the uniform one.

use super::methods::TablesError;
use super::run::{Case, Run, run};
use super::sheet::Sheet;
use super::truth::traced;
use crate::bench::table::{Table, Value};
use crate::compare::compare;
use crate::ways;
use sheen_formats::image::Image;
use sheen_solver::config::Basis;
use sheen_solver::{Observer, SolveConfig};

/// The scene, and its camera that sees nothing but highlights on the floor.
pub const GLOSSY_ROOM: (&str, &str) = ("glossy_room", "floor");

/// Deepest levels that are tried on both bases.
const LEVELS: [u32; 4] = [3, 4, 5, 6];

/// Deviations ε, and the deepest level there, that are tried on the adaptive one besides: it is ε that tells it how fine to
/// be, and the level is no more than a bound.
const DEVIATIONS: [(f32, u32); 7] = [
    (2.0, 3),
    (1.0, 3),
    (0.5, 4),
    (0.25, 4),
    (0.1, 6),
    (0.06, 6),
    (0.03, 6),
];

/// Table 2: triangles in thousands and seconds, of levels 3 and 4: uniform, Haar.
const PAPER: [(u32, [f64; 4]); 2] = [
    (3, [782.0, 640.0, 510.0, 722.0]),
    (4, [3127.0, 1829.0, 731.0, 1125.0]),
];

/// What the reference is solved with: nothing is coarser.
const FINEST: (f32, u32) = (0.02, 7);

/// Levels of the pictures side by side.
const SHOWN: [u32; 2] = [3, 4];
/// Paths a pixel of pictures that solutions stand beside.
pub(super) const PATHS: u32 = 256;

struct Row {
    basis: Basis,
    bytes: f64,
    seconds: f64,
    error: f64,
}

/// Measures the `case`, which is [`GLOSSY_ROOM`]. The uniform basis has its levels, the adaptive one also ε. Errors are
/// those of its picture against a solution on the adaptive basis at level 7. Cells of both bases are counted as the paper does, as triangles.
pub fn basis(case: &Case, observer: &mut dyn Observer) -> Result<(Table, Sheet), TablesError> {
    let mut table = Table::new(
        "basis",
        "Table 2: the adaptive basis (Haar) and the uniform one, for solving and display",
        &[
            "basis",
            "levels",
            "epsilon",
            "distributions",
            "triangles",
            "paper, thousands",
            "MiB",
            "s",
            "paper s",
            "relMSE of highlights",
        ],
    );
    let mut sheet = Sheet::new("figure7");
    let picture = |run: &Run| ways::cpu::render(&run.solution, &case.view, ways::ACROSS);
    let (epsilon, levels) = FINEST;
    let config = SolveConfig {
        epsilon: Some(epsilon),
        max_level: Some(levels),
        ..SolveConfig::default()
    };
    let Some(reference) = run(case, &config, observer)? else {
        return Ok((table, sheet));
    };
    let reference: Image = picture(&reference);
    let mut rows = Vec::new();
    let at_default = || LEVELS.iter().map(|&levels| (None, levels));
    let adaptive = DEVIATIONS.map(|(epsilon, levels)| (Some(epsilon), levels));
    let adaptive: Vec<_> = at_default().chain(adaptive).collect();
    'all: for (basis, name, tried) in [
        (Basis::Uniform, "uniform", at_default().collect()),
        (Basis::Haar, "Haar", adaptive),
    ] {
        for (epsilon, levels) in tried {
            let config = SolveConfig {
                basis,
                epsilon,
                max_level: Some(levels),
                ..SolveConfig::default()
            };
            let Some(run) = run(case, &config, observer)? else {
                break 'all;
            };
            let shown = picture(&run);
            let error = compare(&shown, &reference, 1, None)?.relmse;
            let stats = &run.solution.stats.solve;
            // Rows of the paper's levels are at default ε.
            let is_paper = |paper: &&(u32, _)| paper.0 == levels && epsilon.is_none();
            let paper = PAPER.iter().find(is_paper);
            let of_paper = |uniform: usize| {
                let column = uniform + usize::from(basis == Basis::Haar);
                paper.map_or(Value::None, |paper| Value::Fixed(paper.1[column], 0))
            };
            let bytes = 4.0 * run.solution.distribution_words.len() as f64;
            let triangles = triangles(&run);
            table.rows.push(vec![
                Value::Text(name.to_owned()),
                Value::Count(u64::from(levels)),
                match (basis, config.settings()?.epsilon) {
                    (Basis::Uniform, _) => Value::None,
                    (Basis::Haar, epsilon) => Value::Fixed(f64::from(epsilon), 2),
                },
                Value::Count(stats.distributions),
                Value::Count(triangles),
                of_paper(0),
                Value::Fixed(bytes / f64::from(1 << 20), 2),
                Value::Fixed(run.seconds, 2),
                of_paper(2),
                Value::Fixed(error, 6),
            ]);
            if epsilon.is_none() && SHOWN.contains(&levels) {
                sheet.add(format!("{name}, level {levels}"), shown);
            }
            rows.push(Row {
                basis,
                bytes,
                seconds: run.seconds,
                error,
            });
        }
    }
    table.notes = equal_errors(&rows);
    sheet.add("path tracing", traced(case, PATHS, observer));
    table.notes.push(sheet.caption());
    Ok((table, sheet))
}

/// Cells of the distributions that are shown.
fn triangles(run: &Run) -> u64 {
    let solution = &run.solution;
    let cells = |vertex| {
        let words = solution.distribution(vertex)?;
        Some(sheen_solver::directional::packed::leaves_and_depth(words).0 as u64)
    };
    (0..solution.position.len()).filter_map(cells).sum()
}

/// What the cheapest adaptive row takes that is no worse than each uniform one.
fn equal_errors(rows: &[Row]) -> Vec<String> {
    let of = |basis| rows.iter().filter(move |row| row.basis == basis);
    of(Basis::Uniform)
        .filter_map(|uniform| {
            let no_worse = of(Basis::Haar).filter(|row| row.error <= uniform.error);
            let haar = no_worse.min_by(|a, b| a.bytes.total_cmp(&b.bytes))?;
            Some(format!(
                "At no more than the relMSE {:.6} of uniform ones, adaptive ones take {:.2} of the bytes and {:.2} of the time.",
                uniform.error,
                haar.bytes / uniform.bytes,
                haar.seconds / uniform.seconds,
            ))
        })
        .collect()
}
