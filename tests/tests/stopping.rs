//! A solve that is stopped keeps what it has.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{Observer, Progress, Solution, SolveConfig, solve};
use sheen_tests::scenes;
use std::ops::ControlFlow;

/// Stops at the first report of a phase.
struct UntilPhase(&'static str);

impl Observer for UntilPhase {
    fn report(&mut self, progress: &Progress) -> ControlFlow<()> {
        if progress.phase == self.0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Mean radiance over the vertices that are not black, and their number.
fn mean(solution: &Solution) -> (f32, usize) {
    let lit: Vec<f32> = solution
        .radiance
        .iter()
        .map(|r| r.mean())
        .filter(|&r| r > 0.0)
        .collect();
    assert!(lit.iter().all(|r| r.is_finite()));
    (lit.iter().sum::<f32>() / lit.len() as f32, lit.len())
}

#[test]
fn while_vertices_are_gathered() {
    let scene = scenes::own("cornell_box_glossy");
    let whole = solve(&scene, &SolveConfig::default(), &mut ()).unwrap();
    let stopped = solve(
        &scene,
        &SolveConfig::default(),
        &mut UntilPhase("light at vertices"),
    )
    .unwrap();
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
        &mut UntilPhase("light transport"),
    )
    .unwrap();
    let s = &stopped.stats.solve;
    // The first iteration is kept as far as it came, and nothing is gathered.
    assert_eq!((s.iterations, s.vertex_links), (1, 0));
    let (mean, lit) = mean(&stopped);
    println!("mean radiance {mean} of {lit} vertices");
    assert!(lit > 0);
}
