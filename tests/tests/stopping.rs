//! A solve that is stopped keeps what it has.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{Quality, Solution, SolveConfig, SolveError, solve};
use sheen_tests::{UntilReport, scenes};

/// Mean radiance over the vertices that reflect light, and their number.
fn mean(solution: &Solution) -> (f32, usize) {
    let radiance = |v: usize| solution.radiance[v].mean();
    assert!((0..solution.radiance.len()).all(|v| radiance(v).is_finite()));
    let emits = |v: usize| {
        let material = &solution.materials[solution.material[v] as usize];
        !material.emission.is_black()
    };
    let lit: Vec<f32> = (0..solution.radiance.len())
        .filter(|&v| !emits(v))
        .map(radiance)
        .filter(|&r| r > 0.0)
        .collect();
    (lit.iter().sum::<f32>() / lit.len() as f32, lit.len())
}

#[test]
fn while_vertices_are_gathered() {
    let scene = scenes::own("cornell_box_glossy");
    // More vertices than a few batches have.
    let config = SolveConfig {
        quality: Quality::new(2.5).unwrap(),
        ..SolveConfig::default()
    };
    let whole = solve(&scene, &config, &mut ()).unwrap();
    let stopped = solve(&scene, &config, &mut UntilReport(0, "light at vertices")).unwrap();
    let (gathered, all) = (
        stopped.stats.solve.vertex_links,
        whole.stats.solve.vertex_links,
    );
    println!("{gathered} of {all} links to vertices");
    // One batch was gathered, the others have the mean of their elements.
    assert!(gathered > 0 && gathered < all / 2, "{gathered} of {all}");
    assert_eq!(stopped.position.len(), stopped.radiance.len());
    let highest = stopped.triangles.iter().flatten().max().unwrap();
    assert!((*highest as usize) < stopped.position.len());
    let ((mean_stopped, lit), (mean_whole, _)) = (mean(&stopped), mean(&whole));
    println!("mean radiance {mean_stopped} of {lit} vertices, {mean_whole} when whole");
    // Vertices stand closer where there is more to see: only alike.
    assert!((mean_stopped / mean_whole - 1.0).abs() < 0.2);
    assert!(lit > stopped.position.len() / 2);
}

#[test]
fn during_light_transport() {
    let scene = scenes::own("cornell_box_glossy");
    let stopped = solve(
        &scene,
        &SolveConfig::default(),
        // A dozen levels of receivers: into the second iteration.
        &mut UntilReport(12, "light transport"),
    )
    .unwrap();
    let s = &stopped.stats.solve;
    // The iterations are kept as far as they came, and nothing is gathered.
    assert!(s.iterations > 0 && s.iterations < 4, "{}", s.iterations);
    assert_eq!(s.vertex_links, 0);
    assert!(s.illumination_samples > 0);
    let (mean, lit) = mean(&stopped);
    println!("mean radiance {mean} of {lit} vertices");
    assert!(lit > 0 && mean > 0.0);
}

#[test]
fn quality_is_lowered_until_the_data_fits_into_memory() {
    let scene = scenes::own("cornell_box_glossy");
    let solved = |memory_limit: Option<u64>| {
        let config = SolveConfig {
            memory_limit,
            ..SolveConfig::default()
        };
        solve(&scene, &config, &mut ())
    };
    let whole = solved(None).unwrap().stats.solve;
    assert_eq!(whole.quality, 2.0);
    // What it takes at its most is between the sum of the kinds, which do not stand beside each other all the time, and
    // half of that.
    assert_eq!(
        solved(Some(whole.bytes.total)).unwrap().stats.solve.quality,
        2.0
    );
    let limit = whole.bytes.total / 4;
    let fitting = solved(Some(limit)).unwrap().stats.solve;
    println!(
        "{} bytes, quality {} in {limit}: {}",
        whole.bytes.total, fitting.quality, fitting.bytes.total
    );
    assert!(fitting.quality > 0.0 && fitting.quality < 2.0);
    assert!(fitting.links > 0 && fitting.links < whole.links);
    // Nothing helps against too little.
    let refused = solved(Some(100_000)).unwrap_err();
    assert!(
        matches!(refused, SolveError::Memory { limit: 100_000, needed } if needed > 100_000),
        "{refused}"
    );
}
