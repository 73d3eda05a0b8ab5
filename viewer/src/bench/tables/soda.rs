//! Section 6.5: a scene as large as the paper's last, and what shafts save of its visibility rays.

use super::methods::{TablesError, as_the_paper};
use super::run::{Case, Run, run};
use crate::bench::table::{Table, Value};
use crate::compare::compare;
use crate::ways;
use sheen_solver::config::Visibility;
use sheen_solver::{Observer, SolveConfig};

/// Links may be wrong by this share of the emitted power: no fewer links than the paper has.
const TOLERANCE: f32 = 6.9e-5;

/// Distributions as coarse as in the paper's other tables; weak light forgets its direction, as always.
fn config() -> SolveConfig {
    SolveConfig {
        link_tolerance: Some(TOLERANCE),
        least_directional: None,
        ..as_the_paper(0.5, 3)
    }
}

/// Measures the Soda Shoppe. Wall time is that of all cores, and without reading the scene.
pub fn soda(case: &Case, observer: &mut dyn Observer) -> Result<Table, TablesError> {
    let mut table = Table::new(
        "soda",
        "Section 6.5: the Soda Shoppe",
        &["what", "ours", "paper"],
    );
    let Some(run) = run(case, &config(), observer)? else {
        return Ok(table);
    };
    let (scene, solve) = (&run.solution.stats.scene, &run.solution.stats.solve);
    let phases = &solve.phases_s;
    let parts = solve.wall_s - phases.load;
    let percent = |part: f64, whole: f64| Value::Fixed(100.0 * part / whole, 1);
    let push_pull = phases.push + phases.reflect + phases.pull;
    let rays = solve.rays as f64 / solve.links as f64;
    let of_paper = |figure: f64| Value::Fixed(figure, 0);
    table.rows = [
        (
            "initial patches",
            Value::Count(scene.patches),
            of_paper(1644.0),
        ),
        ("links", Value::Count(solve.links), of_paper(743_284.0)),
        (
            "patches in the end",
            Value::Count(solve.leaves),
            of_paper(29_138.0),
        ),
        ("seconds", Value::Fixed(solve.wall_s, 2), of_paper(8488.0)),
        (
            "of this, before the first link, %",
            percent(phases.hierarchy, parts),
            Value::None,
        ),
        (
            "propagation, %",
            percent(phases.propagate, parts),
            of_paper(91.0),
        ),
        (
            "visibility, % of propagation",
            percent(phases.visibility, phases.propagate),
            of_paper(97.0),
        ),
        (
            "push, reflection and pull, %",
            percent(push_pull, parts),
            of_paper(9.0),
        ),
        ("vertices, %", percent(phases.export, parts), Value::None),
        ("visibility rays a link", Value::Fixed(rays, 2), Value::None),
        (
            "allocated at most, MiB",
            Value::Fixed(run.allocated as f64 / f64::from(1 << 20), 1),
            Value::None,
        ),
    ]
    .map(|(what, ours, paper)| vec![Value::Text(what.to_owned()), ours, paper])
    .to_vec();
    Ok(table)
}

/// Rays along each axis of the stratification that are tried.
const STRATA: [u32; 5] = [2, 3, 4, 6, 8];
/// And what stands for the truth.
const MOST_STRATA: u32 = 16;

struct Row {
    rays: f64,
    error: f64,
}

/// Rays of a solve with shafts, and without: graded by what links carry, and as many on each link. Errors are those of
/// the picture against one whose links, found in the same way, had very many rays: what is left is the noise of
/// visibility.
pub fn visibility(case: &Case, observer: &mut dyn Observer) -> Result<Table, TablesError> {
    let mut table = Table::new(
        "visibility",
        "Visibility by shafts and by stratified rays alone",
        &[
            "visibility",
            "rays on a link",
            "links",
            "rays",
            "rays a link",
            "s",
            "relMSE",
        ],
    );
    let config = |visibility, strata| SolveConfig {
        visibility,
        strata,
        ..config()
    };
    let picture = |run: &Run| ways::cpu::render(&run.solution, &case.view, ways::ACROSS);
    let mut rows = Vec::new();
    let alone: Vec<Option<u32>> = [None].into_iter().chain(STRATA.map(Some)).collect();
    'all: for (name, visibility, tried) in [
        ("shafts", Visibility::Shafts, &[None][..]),
        ("rays", Visibility::Rays, &alone),
    ] {
        let most = config(visibility, Some(MOST_STRATA));
        let Some(reference) = run(case, &most, observer)? else {
            break;
        };
        let reference = picture(&reference);
        for &strata in tried {
            let Some(run) = run(case, &config(visibility, strata), observer)? else {
                break 'all;
            };
            let error = compare(&picture(&run), &reference, 1, None)?.relmse;
            let solve = &run.solution.stats.solve;
            let rays = solve.rays as f64;
            let on_a_link = match strata {
                Some(strata) => Value::Count(u64::from(strata * strata)),
                None => Value::Text("graded".to_owned()),
            };
            table.rows.push(vec![
                Value::Text(name.to_owned()),
                on_a_link,
                Value::Count(solve.links),
                Value::Count(solve.rays),
                Value::Fixed(rays / solve.links as f64, 2),
                Value::Fixed(run.seconds, 2),
                Value::Fixed(error, 6),
            ]);
            let is_plain = strata.is_some();
            if is_plain || visibility == Visibility::Shafts {
                rows.push(Row { rays, error });
            }
        }
    }
    table.notes.extend(equal_error(&rows));
    Ok(table)
}

/// How many times the rays of the first row the cheapest other takes that is no worse.
fn equal_error(rows: &[Row]) -> Option<String> {
    let (shafts, plain) = rows.split_first()?;
    let no_worse = plain.iter().filter(|row| row.error <= shafts.error);
    let text = match no_worse.min_by(|a, b| a.rays.total_cmp(&b.rays)) {
        Some(row) => format!(
            "Rays alone, as many on each link, take {:.2} times as many for no larger an error.",
            row.rays / shafts.rays
        ),
        None => {
            let most = plain.iter().max_by(|a, b| a.rays.total_cmp(&b.rays))?;
            format!(
                "Rays alone, as many on each link, have a larger error with {:.2} times as many.",
                most.rays / shafts.rays
            )
        }
    };
    Some(text)
}
