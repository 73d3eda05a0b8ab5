//! Clusters carry links: few pairs of patches are ever linked one by one.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::config::{Quality, Settings};
use sheen_solver::solve::{Prepared, first_links};
use sheen_solver::transport::link::Sender;
use sheen_solver::{SolveConfig, solve};
use sheen_tests::{UntilReport, scenes};
use std::collections::HashSet;

/// At most 5 % of all pairs of patches.
const SHARE: f64 = 0.05;

#[test]
fn pairs_of_the_cafe_that_emitters_are_linked_with() {
    let settings = Settings::of(Quality::DEFAULT);
    let prepared = Prepared::new(&scenes::own("cafe"), &settings);
    let links = first_links(&prepared, &settings);
    let patches = prepared.patches.len();
    let emitters: HashSet<u32> = (0..links.emitted.len() as u32)
        .filter(|&id| links.emitted.peak[id as usize] > 0.0)
        .filter_map(|id| links.hierarchy.element_of(id).map(|e| e.patch))
        .collect();
    let pairs: HashSet<(u32, u32)> = links
        .records
        .iter()
        .filter_map(|record| {
            let receiver = links.hierarchy.element_of(record.receiver)?;
            let sender = Sender::new(&links.hierarchy, record.sender);
            sender.polygon.map(|_| (receiver.patch, sender.patch))
        })
        .collect();
    let share = pairs.len() as f64 / (patches * emitters.len()) as f64;
    println!(
        "cafe, emitted light: {} links, {} of {patches} x {} pairs linked one by one: {:.3} %",
        links.records.len(),
        pairs.len(),
        emitters.len(),
        share * 100.0
    );
    // Harder than of all pairs: of the pairs whose sender emits.
    assert!(share < SHARE, "{share}");
    assert!(links.records.len() > 1000);
}

#[test]
fn pairs_of_the_cafe_linked_in_the_whole_transport() {
    let scene = scenes::own("cafe");
    let patches = Prepared::new(&scene, &Settings::of(Quality::DEFAULT))
        .patches
        .len();
    let solution = solve(
        &scene,
        &SolveConfig::default(),
        &mut UntilReport::transport_is_done(),
    )
    .unwrap();
    let s = &solution.stats;
    // Links are counted each time and for each part of a patch: not less than the distinct pairs.
    let share = s.solve.patch_links as f64 / (patches as f64).powi(2);
    println!(
        "cafe, all reflections: {patches} patches, {} links, {} of them between patches: at most {:.3} % of all pairs; {} iterations, {:.1} s",
        s.solve.links,
        s.solve.patch_links,
        share * 100.0,
        s.solve.iterations,
        s.solve.wall_s
    );
    assert!(share < SHARE, "{share}");
    assert!(s.solve.links > s.solve.patch_links);
    // It was not stopped before its end.
    let goal = f64::from(Settings::of(Quality::DEFAULT).unshot_share);
    assert!(s.solve.unshot_w <= goal * s.solve.emitted_w);
}
