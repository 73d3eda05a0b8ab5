//! Things on a ground much larger than they are: what little comes back from it is all that shadows have.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::path::Sampler;
use sheen_solver::{PathTracer, Quality, Scene, Solution, SolveConfig, solve};
use sheen_tests::measure::{self, mean_of_corners};
use sheen_tests::scenes::Builder;

/// Half the sides of what is looked at.
const NEAR: Vec3 = Vec3::new(0.45, 0.0, 0.3);

/// A slab that floats over the middle of a square ground, and a lamp above.
fn slab(half: f32) -> Scene {
    let mut builder = Builder::new();
    let grey = builder.lambert("grey", 0.5, 0.0);
    let lamp = builder.lambert("lamp", 0.0, 30.0);
    let square = |half: f32, height: f32| {
        [(-1., -1.), (-1., 1.), (1., 1.), (1., -1.)]
            .map(|(x, z)| Vec3::new(x * half, height, z * half))
    };
    builder.quad(square(half, 0.0), grey);
    builder.block(Vec3::new(-0.6, 0.7, -0.4), Vec3::new(0.6, 0.74, 0.4), grey);
    let mut down = square(0.2, 2.5);
    down.reverse();
    builder.quad(down, lamp);
    builder.build()
}

/// Mean radiance of the triangles that look up or down at a height, near the middle.
fn shown(solution: &Solution, height: f32, up: f32) -> f64 {
    let is_there = |&triangle: &usize| {
        let corners = solution.triangles[triangle].map(|v| v as usize);
        let middle = corners.iter().map(|&v| solution.position[v]).sum::<Vec3>() / 3.0;
        let near = middle.x.abs() < NEAR.x && middle.z.abs() < NEAR.z;
        near && (middle.y - height).abs() < 1e-4 && solution.normal[corners[0]].y * up > 0.9
    };
    let (mut sum, mut area) = (0.0, 0.0);
    for triangle in (0..solution.triangles.len()).filter(is_there) {
        let [red, ..] = mean_of_corners(solution, triangle);
        sum += red * measure::area(solution, triangle);
        area += measure::area(solution, triangle);
    }
    sum / area
}

/// The same by path tracing, over an even spread of points.
fn traced(scene: &Scene, height: f32, up: f32) -> f64 {
    const PATHS: u32 = 1 << 16;
    let tracer = PathTracer::new(scene);
    let path = |index: u32| {
        let mut sampler = Sampler::new(0, index, 0);
        let [x, z, ..] = sampler.draw();
        let at = Vec3::new(2.0 * x - 1.0, 0.0, 2.0 * z - 1.0) * NEAR;
        let eye = at + Vec3::Y * (height + 0.01 * up);
        f64::from(tracer.radiance(eye, Vec3::Y * -up, &mut sampler).mean())
    };
    (0..PATHS).map(path).sum::<f64>() / f64::from(PATHS)
}

#[test]
fn a_slab_is_lit_from_below_however_large_the_ground() {
    for half in [1.5, 6.0, 30.0, 400.0] {
        let scene = slab(half);
        let config = SolveConfig {
            quality: Quality::DEFAULT,
            ..SolveConfig::default()
        };
        let solution = solve(&scene, &config, &mut ()).unwrap();
        for (name, height, up) in [("underside", 0.7, -1.0), ("shadow", 0.0, 1.0)] {
            let (found, right) = (shown(&solution, height, up), traced(&scene, height, up));
            println!("ground {half}, {name}: {found:.5}, right {right:.5}");
            // Light that has met three surfaces, in a shadow; paths are right to half a per cent.
            assert!((found / right - 1.0).abs() < 0.05, "{half} {name}");
        }
    }
}
