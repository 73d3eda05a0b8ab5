//! Figure 4: the reflection of an area light that is represented by more and more illumination samples.

use super::methods::{TablesError, as_the_paper};
use super::run::{Case, run};
use super::sheet::Sheet;
use super::truth::traced;
use crate::bench::table::{Table, Value};
use crate::compare::compare;
use crate::ways;
use sheen_solver::hierarchy::{Hierarchy, NONE};
use sheen_solver::solve::{FirstLinks, Prepared, first_links};
use sheen_solver::{Observer, SolveConfig};

/// The scene.
pub const AREA_LIGHT: &str = "area_light";

/// Figure 4: samples of the light.
const PAPER: [u64; 3] = [4, 16, 64];
/// The coarsest links that are tried; others are a power of √2 finer.
const COARSEST: f32 = 1.0;
const MOST_STEPS: i32 = 60;
/// Paths a pixel.
const PATHS: u32 = 256;
const LEVELS: u32 = 6;
const EPSILON: f32 = 0.1;

/// Measures the `case`, which is [`AREA_LIGHT`]: the coarsest links that leave so many samples at a place of the glossy
/// surface on average, then the default settings. Errors are those against path tracing.
pub fn convergence4(
    case: &Case,
    observer: &mut dyn Observer,
) -> Result<(Table, Sheet), TablesError> {
    let mut table = Table::new(
        "convergence4",
        "Figure 4: reflections of an area light",
        &[
            "samples, paper",
            "samples",
            "link tolerance",
            "elements",
            "links",
            "s",
            "relMSE",
            "FLIP",
        ],
    );
    let mut sheet = Sheet::new("figure4");
    let reference = traced(case, PATHS, observer);
    let mut steps = Vec::new();
    let mut step = 0;
    for wanted in PAPER {
        while step < MOST_STEPS {
            let config = elements_only(tolerance(step));
            let samples = samples_at_a_place(case, &config)?;
            if samples >= wanted as f64 {
                steps.push((Some(wanted), samples, config));
                break;
            }
            step += 1;
        }
    }
    let default = SolveConfig::default();
    steps.push((None, samples_at_a_place(case, &default)?, default));
    for (wanted, samples, config) in steps {
        let Some(run) = run(case, &config, observer)? else {
            break;
        };
        let picture = ways::cpu::render(&run.solution, &case.view, ways::ACROSS);
        let error = compare(&picture, &reference, 1, None)?;
        let solve = &run.solution.stats.solve;
        table.rows.push(vec![
            wanted.map_or(Value::None, Value::Count),
            Value::Fixed(samples, 1),
            Value::Fixed(config.settings()?.link_tolerance.into(), 6),
            Value::Count(solve.elements),
            Value::Count(solve.links),
            Value::Fixed(run.seconds, 3),
            Value::Fixed(error.relmse, 5),
            Value::Fixed(error.flip, 4),
        ]);
        let what = match wanted {
            Some(wanted) => format!("at least {wanted} samples, elements averaged"),
            None => "the default settings".to_owned(),
        };
        sheet.add(what, picture);
    }
    sheet.add("path tracing", reference);
    table.notes.push(sheet.caption());
    Ok((table, sheet))
}

fn tolerance(step: i32) -> f32 {
    COARSEST * 0.5f32.powf(0.5 * step as f32)
}

fn elements_only(tolerance: f32) -> SolveConfig {
    SolveConfig {
        link_tolerance: Some(tolerance),
        ..as_the_paper(EPSILON, LEVELS)
    }
}

/// Illumination samples that glossy leaves have of the lamp: their mean, by area.
fn samples_at_a_place(case: &Case, config: &SolveConfig) -> Result<f64, TablesError> {
    let settings = config.settings()?;
    let prepared = Prepared::new(&case.scene, &settings);
    let FirstLinks {
        hierarchy, samples, ..
    } = first_links(&prepared, &settings);
    let (mut sum, mut area) = (0.0, 0.0);
    for element in &hierarchy.elements {
        if !hierarchy.is_leaf(element.node) || prepared.lobes[element.material as usize].is_none() {
            continue;
        }
        let weight = f64::from(hierarchy.node(element.node).area);
        let count: usize = way_up(&hierarchy, element.node)
            .map(|id| samples.of(id).len())
            .sum();
        sum += count as f64 * weight;
        area += weight;
    }
    Ok(if area > 0.0 { sum / area } else { 0.0 })
}

/// A node and all above it.
fn way_up(hierarchy: &Hierarchy, from: u32) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(from), |&id| {
        Some(hierarchy.node(id).parent).filter(|&parent| parent != NONE)
    })
}
