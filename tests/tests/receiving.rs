//! Clusters that receive light: what of it reaches the surfaces that they hold.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Material, Quality, Rgb, Scene, Solution, SolveConfig, solve};
use sheen_tests::scenes::Builder;

/// Tables along each side of a field.
const SIDE: u32 = 6;

/// Largest error of the mean irradiance, as a share of what tables get: how open a square is does not tell in which
/// directions.
const MOST: f32 = 0.25;

/// Square that faces up, or down.
fn square(builder: &mut Builder, middle: Vec3, half: f32, up: bool, material: u32) {
    let corner = |x: f32, z: f32| middle + Vec3::new(x, 0.0, z) * half;
    let (x, z) = if up { (-1.0, 1.0) } else { (1.0, -1.0) };
    let corners = [
        corner(-1.0, -1.0),
        corner(x, z),
        corner(1.0, 1.0),
        corner(z, x),
    ];
    builder.quad(corners, material);
}

/// Mean radiance of what faces up and has a material.
fn mean(solution: &Solution, material: u32) -> f32 {
    let is_own = |&v: &usize| solution.material[v] == material && solution.normal[v].y > 0.0;
    let own = || (0..solution.position.len()).filter(is_own);
    own().map(|v| solution.radiance[v].mean()).sum::<f32>() / own().count() as f32
}

/// Solved without light gathered at vertices: they show what transport found, at a link tolerance.
fn transported(scene: &Scene, tolerance: f32) -> Solution {
    let config = SolveConfig {
        quality: Quality::DRAFT,
        link_tolerance: Some(tolerance),
        ..SolveConfig::default()
    };
    solve(scene, &config, &mut ()).unwrap()
}

#[test]
fn tables_get_what_the_shelves_below_them_do_not() {
    let mut builder = Builder::new();
    let lamp = builder.lambert("lamp", 0.0, 1.0);
    let top = builder.lambert("top", 0.5, 0.0);
    let shelf = builder.lambert("shelf", 0.5, 0.0);
    for i in 0..9 {
        let at = Vec3::new((i % 3) as f32 - 1.0, 1.5, (i / 3) as f32 - 1.0);
        square(&mut builder, at * 2.0, 1.0, false, lamp);
    }
    for i in 0..SIDE * SIDE {
        let place = |k: u32| k as f32 * 0.1 - 0.05 * (SIDE - 1) as f32;
        let at = Vec3::new(place(i % SIDE), 0.0, place(i / SIDE));
        square(&mut builder, at, 0.03, true, top);
        square(&mut builder, at - Vec3::Y * 0.015, 0.03, true, shelf);
    }
    let scene = builder.build();
    let solved = |tolerance: f32| transported(&scene, tolerance);
    // The field as a few clusters, and every square by itself.
    let (coarse, fine) = (solved(3e-4), solved(1e-9));
    let links = |solution: &Solution| {
        let solve = &solution.stats.solve;
        (solve.links, solve.patch_links)
    };
    println!(
        "links, between patches: {:?}, {:?}",
        links(&coarse),
        links(&fine)
    );
    let whole = mean(&fine, top);
    for (name, material) in [("tops", top), ("shelves", shelf)] {
        let (got, expected) = (
            mean(&coarse, material) / whole,
            mean(&fine, material) / whole,
        );
        println!("{name}: {got:.3}, alone {expected:.3}");
        assert!(
            (got - expected).abs() < MOST,
            "{name}: {got}, not {expected}"
        );
    }
}

/// Mean green radiance of the ground on either side: below a board, and in the open.
fn below_and_beside(solution: &Solution, ground: u32) -> [f32; 2] {
    let mean = |is_own: &dyn Fn(f32) -> bool| {
        let own = (0..solution.position.len())
            .filter(|&v| solution.material[v] == ground && is_own(solution.position[v].x));
        let (sum, count) = own.fold((0.0, 0.0), |(sum, count), v| {
            (sum + solution.radiance[v].g, count + 1.0)
        });
        sum / count
    };
    [mean(&|x| x < -0.3), mean(&|x| x > 0.3)]
}

/// A ground, a board over half of it, a strong red lamp right above the ground and a wide faint green one far off.
fn ground_below_board(height: f32) -> (Scene, u32) {
    let mut builder = Builder::new();
    let coloured = |emission: Rgb| Material {
        emission,
        ..Material::lambert("lamp", Rgb::BLACK)
    };
    let strong = builder.material(coloured(Rgb::new(100.0, 0.0, 0.0)));
    let faint = builder.material(coloured(Rgb::new(0.0, 1.0, 0.0)));
    let board = builder.lambert("board", 0.0, 0.0);
    let ground = builder.lambert("ground", 0.5, 0.0);
    square(&mut builder, Vec3::ZERO, 1.0, true, ground);
    square(&mut builder, Vec3::new(0.2, 0.15, 0.0), 0.1, false, strong);
    square(&mut builder, Vec3::Y * 4.0, 2.0, false, faint);
    let corners = [(-1.2, -1.2), (-1.2, 1.2), (0.0, 1.2), (0.0, -1.2)];
    builder.quad(corners.map(|(x, z)| Vec3::new(x, height, z)), board);
    builder.parts.materials[board as usize].two_sided = true;
    (builder.build(), ground)
}

/// One link brings the light of a wide faint lamp to a whole ground that a strong red one has in pieces: those below a
/// board are not to be given the mean.
#[test]
fn what_lies_below_a_board_takes_none_of_what_the_rest_gets() {
    for height in [0.3, 0.01] {
        let (scene, ground) = ground_below_board(height);
        let solved = |tolerance: f32| transported(&scene, tolerance);
        let (coarse, fine) = (solved(1e-1), solved(1e-7));
        let [expected, got] = [&fine, &coarse].map(|solution| below_and_beside(solution, ground));
        println!("at {height}, {} links: {got:?}", coarse.stats.solve.links);
        println!(
            "at {height}, {} links: {expected:?}",
            fine.stats.solve.links
        );
        let [below, beside] = [0, 1].map(|i| (got[i] - expected[i]).abs() / expected[1]);
        assert!(
            below < 0.05,
            "below, at {height}: {got:?}, not {expected:?}"
        );
        assert!(
            beside < 0.1,
            "beside, at {height}: {got:?}, not {expected:?}"
        );
    }
}
