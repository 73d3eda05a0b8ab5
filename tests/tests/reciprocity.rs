//! Helmholtz reciprocity of a whole solve: a lamp and what it lights may change places (exact cases 2e).
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Quality, Scene, SolveConfig, solve};
use sheen_tests::assert_close;
use sheen_tests::measure::mean_radiance_of;
use sheen_tests::scenes::Builder;

/// Two solves, each within about half of this of the truth at default quality.
const RECIPROCITY: f64 = 0.015;

const REFLECTANCE: f32 = 0.1;

/// Two patches of different sizes in a room with a glossy floor and a glossy block; the one called `lamp` emits.
///
/// They do not see each other: a block stands between, so all light is reflected at least once.
fn scene(lamp: &str) -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.6, 0.0);
    let floor = builder.phong("floor", 0.2, 0.6, 30.0);
    let block = builder.phong("block", 0.3, 0.4, 12.0);
    let [first, second] = ["first", "second"].map(|name| {
        let emission = if name == lamp { 1.0 } else { 0.0 };
        builder.lambert(name, REFLECTANCE, emission)
    });
    builder.room(
        Vec3::ZERO,
        Vec3::new(3.0, 2.5, 4.0),
        [wall, wall, floor, wall, wall, wall],
    );
    builder.block(Vec3::new(0.6, 0.1, 1.7), Vec3::new(2.2, 1.9, 2.3), block);
    // Facing down.
    builder.quad(
        [
            Vec3::new(1.0, 2.3, 0.5),
            Vec3::new(1.6, 2.3, 0.5),
            Vec3::new(1.6, 2.3, 1.0),
            Vec3::new(1.0, 2.3, 1.0),
        ],
        first,
    );
    // Facing -z, towards the block.
    builder.quad(
        [
            Vec3::new(0.8, 0.6, 3.6),
            Vec3::new(0.8, 1.5, 3.6),
            Vec3::new(1.9, 1.5, 3.6),
            Vec3::new(1.9, 0.6, 3.6),
        ],
        second,
    );
    builder.build()
}

#[test]
fn lamp_and_receiver_change_places() {
    let config = SolveConfig {
        quality: Quality::DEFAULT,
        ..SolveConfig::default()
    };
    let (of_first, of_second) = (0.6 * 0.5, 0.9 * 1.1);
    // Power that one receives from the other, per radiance of it: A π L / ρ.
    let received = |lamp: &str, receiver: &str, area: f64| {
        let scene = scene(lamp);
        let solution = solve(&scene, &config, &mut ()).unwrap();
        area * mean_radiance_of(&scene, &solution, receiver)
    };
    let there = received("first", "second", of_second);
    let back = received("second", "first", of_first);
    println!(
        "there {there:.6}, back {back:.6}: {:+.3} %",
        100.0 * (back / there - 1.0)
    );
    assert!(there > 1e-4, "light gets round the block: {there}");
    assert_close("from the second to the first", back, there, RECIPROCITY);
}
