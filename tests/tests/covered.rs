//! Vertices below what stands on a surface: light is interpolated from them to places that are seen.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Quality, SolveConfig, solve};
use sheen_tests::images;
use sheen_tests::scenes::Builder;

/// Beside a block the floor sees half of what it sees elsewhere, and a block as bright as itself: the darkest pixel
/// over the median.
const LEAST: f32 = 0.6;

#[test]
fn a_block_on_the_floor_does_not_darken_what_is_beside_it() {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.8, 0.0);
    let lamp = builder.lambert("lamp", 0.8, 1.0);
    let block = builder.lambert("block", 0.8, 0.0);
    let room = [wall, wall, wall, lamp, wall, wall];
    builder.room(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0), room);
    // Its edges cross leaves of the floor.
    builder.block(
        Vec3::new(1.37, 0.0, 1.71),
        Vec3::new(2.81, 0.9, 2.33),
        block,
    );
    builder.camera(Vec3::new(0.5, 2.5, 0.4), Vec3::new(2.1, 0.0, 2.0));
    builder.camera(Vec3::new(3.6, 2.5, 3.5), Vec3::new(2.1, 0.0, 2.0));
    let scene = builder.build();
    let config = SolveConfig {
        quality: Quality::PREVIEW,
        ..SolveConfig::default()
    };
    let solution = solve(&scene, &config, &mut ()).unwrap();
    for camera in &solution.cameras {
        let image = images::render(&solution, camera);
        let mut radiance: Vec<f32> = image.pixels.iter().map(|p| p.mean()).collect();
        radiance.sort_by(f32::total_cmp);
        let median = radiance[radiance.len() / 2];
        let darkest = radiance[0] / median;
        println!("'{}': darkest {darkest:.3} of the median", camera.name);
        assert!(darkest > LEAST, "'{}': {darkest}", camera.name);
    }
}
