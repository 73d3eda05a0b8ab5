//! Closure: in a closed scene the form factors of every vertex sum to one.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Scene, SolveConfig, solve};
use sheen_tests::measure::front_triangles;
use sheen_tests::scenes::Builder;

/// All surfaces emit 1 and reflect this: little, so that what arrives is nearly what is emitted, yet enough to be
/// read from f32 radiance (a rounding of 6e-8 is 4e-6 of what is reflected).
const REFLECTANCE: f32 = 1.0 / 64.0;

/// Incident form factors of a closed scene add up to 1 within 1 % at every vertex.
const CLOSURE: f64 = 0.01;

fn check(name: &str, build: impl FnOnce(&mut Builder, u32)) {
    let mut builder = Builder::new();
    let shell = builder.lambert("shell", REFLECTANCE, 1.0);
    build(&mut builder, shell);
    let scene: Scene = builder.build();
    let solution = solve(&scene, &SolveConfig::default(), &mut ()).unwrap();
    let rho = f64::from(REFLECTANCE);
    // L = 1 + ρ F L' with L' = 1 / (1 - ρ), the radiance of everything else: F is the sum of form factors.
    let closure = |v: u32| {
        let radiance = f64::from(solution.radiance[v as usize].mean());
        (radiance - 1.0) / rho * (1.0 - rho)
    };
    let (mut low, mut high, mut sum, mut count) = ((f64::INFINITY, 0), (0.0, 0), 0.0, 0);
    for (triangle, _) in front_triangles(&scene, &solution) {
        for v in solution.triangles[triangle] {
            let closure = closure(v);
            (sum, count) = (sum + closure, count + 1);
            if closure < low.0 {
                low = (closure, v);
            }
            if closure > high.0 {
                high = (closure, v);
            }
        }
    }
    let place = |v: u32| solution.position[v as usize];
    println!(
        "{name}: closure {:.5} at {} .. {:.5} at {}, mean {:.5}, {} vertices",
        low.0,
        place(low.1),
        high.0,
        place(high.1),
        sum / f64::from(count),
        solution.position.len()
    );
    assert!(
        (sum / f64::from(count) - 1.0).abs() < CLOSURE,
        "{name}: mean"
    );
    for (closure, v) in [low, high] {
        assert!(
            (closure - 1.0).abs() < CLOSURE,
            "{name}: {closure} at {}",
            place(v)
        );
    }
}

#[test]
fn a_box() {
    check("box", |builder, shell| {
        builder.room(Vec3::ZERO, Vec3::new(1.8, 1.2, 1.5), [shell; 6]);
    });
}

#[test]
fn a_long_corridor() {
    check("corridor", |builder, shell| {
        builder.room(Vec3::ZERO, Vec3::new(0.8, 1.0, 6.0), [shell; 6]);
    });
}

#[test]
fn a_room_with_blocks() {
    check("room with blocks", |builder, shell| {
        builder
            .room(Vec3::ZERO, Vec3::new(2.0, 1.5, 2.0), [shell; 6])
            .block(Vec3::new(0.3, 0.2, 0.4), Vec3::new(0.8, 0.9, 0.9), shell)
            .block(Vec3::new(1.1, 0.1, 1.0), Vec3::new(1.7, 0.4, 1.8), shell);
    });
}

#[test]
fn a_block_on_the_floor() {
    check("block on the floor", |builder, shell| {
        // Floor and block make one closed surface: the floor is left out under the block, the block has no bottom.
        let (x, z) = ([0.0, 0.6, 1.2, 2.0], [0.0, 0.7, 1.3, 2.0]);
        let (top, height) = (1.5, 0.8);
        let at = |i: usize, y: f32, j: usize| Vec3::new(x[i], y, z[j]);
        for i in 0..3 {
            for j in 0..3 {
                let (y, is_block) = if (i, j) == (1, 1) {
                    (height, true)
                } else {
                    (0.0, false)
                };
                let square = [
                    at(i, y, j),
                    at(i, y, j + 1),
                    at(i + 1, y, j + 1),
                    at(i + 1, y, j),
                ];
                builder.quad(square, shell);
                let mut ceiling = square.map(|corner| Vec3::new(corner.x, top, corner.z));
                ceiling.reverse();
                builder.quad(ceiling, shell);
                let mut sides = Vec::new();
                if is_block {
                    // Outward: seen from outside the block.
                    sides.extend([
                        (i, j, i, j + 1),
                        (i + 1, j + 1, i + 1, j),
                        (i + 1, j, i, j),
                        (i, j + 1, i + 1, j + 1),
                    ]);
                } else {
                    // Inward, where the room ends.
                    if i == 0 {
                        sides.push((0, j + 1, 0, j));
                    }
                    if i == 2 {
                        sides.push((3, j, 3, j + 1));
                    }
                    if j == 0 {
                        sides.push((i, 0, i + 1, 0));
                    }
                    if j == 2 {
                        sides.push((i + 1, 3, i, 3));
                    }
                }
                let high = if is_block { height } else { top };
                for (i0, j0, i1, j1) in sides {
                    builder.quad(
                        [
                            at(i0, 0.0, j0),
                            at(i1, 0.0, j1),
                            at(i1, high, j1),
                            at(i0, high, j0),
                        ],
                        shell,
                    );
                }
            }
        }
    });
}
