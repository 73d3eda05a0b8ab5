//! Numeric extremes (`hardening.md` section 1): scenes, lights and materials at the ends of their ranges have finite,
//! right solutions, or are refused in a line.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_formats::solution;
use sheen_solver::{
    Gloss, Material, PathTracer, Quality, Rgb, Scene, SceneError, Solution, SolveConfig,
    SolveError, Triangle, solve,
};
use sheen_tests::measure::{Random, extremes, front_triangles, mean_radiance, mean_radiance_of};
use sheen_tests::scenes::{self, Builder, brighter, longer};
use sheen_tests::{assert_close, images};
use sheen_viewer::camera::View;
use sheen_viewer::ways::path::{Budget, trace};
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

/// How far the power that surfaces receive may be from what is sent.
const LEDGER: f64 = 1e-3;

/// Solves for a first look; what is stored must be finite, and the power accounted for.
#[track_caller]
fn solved(name: &str, scene: &Scene) -> Solution {
    let config = SolveConfig {
        quality: Quality::PREVIEW,
        ..SolveConfig::default()
    };
    let solution = solve(scene, &config, &mut ()).unwrap();
    assert!(solution.position.iter().all(|p| p.is_finite()), "{name}");
    let (low, high) = extremes(solution.radiance.iter().copied());
    assert!(low >= 0.0 && high.is_finite(), "{name}: {low} to {high}");
    let s = &solution.stats.solve;
    println!(
        "{name}: {:.2} s, {} links, radiance {low:e} to {high:e}",
        s.wall_s, s.links
    );
    if s.emitted_w > 0.0 {
        let known = s.absorbed_w + s.escaped_w + s.unshot_w;
        assert_close(format!("{name}: ledger"), known / s.emitted_w, 1.0, LEDGER);
    }
    // And it can be stored and read again.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sheen");
    solution::write(&path, &solution).unwrap();
    assert_eq!(
        solution::read(&path).unwrap().radiance,
        solution.radiance,
        "{name}"
    );
    solution
}

/// Mean radiance of all fronts.
fn mean(scene: &Scene, solution: &Solution) -> f64 {
    let fronts = front_triangles(scene, solution);
    mean_radiance(solution, fronts.into_iter().map(|front| front.0)).0
}

fn room() -> Scene {
    scenes::room_with_glossy_floor()
}

/// `scene` moved by `offset`.
fn moved(scene: &Scene, offset: Vec3) -> Scene {
    let mut parts = scene.clone().into_parts();
    parts.points.iter_mut().for_each(|point| *point += offset);
    for light in &mut parts.point_lights {
        light.position += offset;
    }
    for camera in &mut parts.cameras {
        camera.eye += offset;
        camera.target += offset;
    }
    Builder { parts }.build()
}

/// A wall of a room, or a block in it, of one material.
fn room_with(material: Material) -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    let lamp = builder.lambert("lamp", 0.3, 2.0);
    let subject = builder.material(material);
    builder
        .room(
            Vec3::ZERO,
            Vec3::new(3.0, 2.5, 4.0),
            [wall, wall, subject, lamp, wall, wall],
        )
        .block(Vec3::new(1.0, 0.5, 1.5), Vec3::new(1.6, 0.9, 2.1), subject);
    builder.build()
}

#[test]
fn lengths_from_microns_to_megametres() {
    let plain = mean(&room(), &solved("1 m", &room()));
    for length in [1e-6, 1e-3, 1e3, 1e6] {
        let scene = longer(&room(), length);
        let name = format!("{length:e} m");
        let found = mean(&scene, &solved(&name, &scene));
        // Other roundings of the same numbers.
        assert_close(name, found, plain, 1e-3);
    }
}

#[test]
fn far_from_the_origin() {
    // Corners that are multiples of 1/16 m have exact coordinates there.
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    let floor = builder.phong("floor", 0.2, 0.5, 40.0);
    let lamp = builder.lambert("lamp", 0.3, 2.0);
    builder
        .room(
            Vec3::ZERO,
            Vec3::new(3.0, 2.5, 4.0),
            [wall, wall, floor, lamp, wall, wall],
        )
        .block(
            Vec3::new(1.0, 0.5, 1.5),
            Vec3::new(1.625, 0.875, 2.125),
            wall,
        );
    let scene = builder.build();
    let plain = solved("at the origin", &scene);
    for offset in [1e5, 1e6] {
        let moved = moved(&scene, Vec3::new(offset, -offset, offset));
        let found = solved(&format!("{offset:e} m off"), &moved);
        assert_eq!(plain.radiance, found.radiance, "{offset:e} m off");
        assert_eq!(plain.distribution_words, found.distribution_words);
    }
}

#[test]
fn lamps_of_very_different_power() {
    // Beside a bright lamp a faint one is nothing.
    let with = |faint: f32| {
        let mut builder = Builder::new();
        let wall = builder.lambert("wall", 0.5, 0.0);
        let bright = builder.lambert("bright", 0.3, 1e9);
        let other = builder.lambert("other", 0.5, faint);
        builder.room(
            Vec3::ZERO,
            Vec3::ONE,
            [wall, wall, other, bright, wall, wall],
        );
        builder.build()
    };
    let (faint, dark) = (with(1e-9), with(0.0));
    let (found, plain) = (solved("1e9 and 1e-9", &faint), solved("1e9", &dark));
    assert_close("faint", mean(&faint, &found), mean(&dark, &plain), 1e-6);
    // Whatever the unit.
    let plain = mean(&room(), &solved("plain", &room()));
    for factor in [1e-30f32, 1e-9, 1e9, 1e25] {
        let scene = brighter(&room(), factor);
        let found = mean(&scene, &solved(&format!("light times {factor:e}"), &scene));
        assert_close(
            format!("light times {factor:e}"),
            found / f64::from(factor),
            plain,
            1e-3,
        );
    }
}

#[test]
fn light_below_the_smallest_normal_number() {
    let factor = 2f32.powi(-130);
    let scene = brighter(&room(), factor);
    let found = mean(&scene, &solved("subnormal", &scene));
    let plain = mean(&room(), &solved("plain", &room()));
    // Subnormals hold few digits, or are flushed to zero.
    assert!(
        found == 0.0 || (found / f64::from(factor) / plain - 1.0).abs() < 0.01,
        "{found:e}"
    );
}

#[test]
fn reflectances_of_nothing_and_of_all() {
    let cube = |reflectance: f32| {
        let mut builder = Builder::new();
        let wall = builder.lambert("wall", reflectance, FRAC_1_PI);
        builder.room(Vec3::ZERO, Vec3::ONE, [wall; 6]);
        builder.build()
    };
    let black = solved("black", &cube(0.0));
    let (low, high) = extremes(black.radiance.iter().copied().filter(|r| !r.is_black()));
    assert_eq!((low, high), (FRAC_1_PI, FRAC_1_PI));
    // One reflection is one too many.
    let all = solve(&cube(1.0), &SolveConfig::default(), &mut ());
    let Err(SolveError::NoLoss { material, .. }) = &all else {
        panic!("{all:?}");
    };
    assert_eq!(material, "wall");
    // What a millionth is, single precision knows to 6 %: so is what is left of sums over a million reflections.
    let bright = cube(0.999_999);
    let solution = solve(&bright, &SolveConfig::default(), &mut ()).unwrap();
    let lost = 1.0 - f64::from(0.999_999f32);
    assert_close(
        "a millionth lost",
        mean(&bright, &solution),
        PI.recip() / lost,
        0.06,
    );
}

#[test]
fn all_the_light_of_a_lamp_anywhere_in_a_black_box_arrives() {
    // `exact_cases.md` 2b, 5.4: Σ E A = Φ within 0.1 %. The ledger's absorbed power is that sum.
    let mut random = Random::new(5);
    for _ in 0..100 {
        let mut builder = Builder::new();
        let black = builder.lambert("black", 0.0, 0.0);
        let size = Vec3::new(1.0, 1.5, 2.0);
        let at = Vec3::new(random.unit(), random.unit(), random.unit()) * 0.98 + 0.01;
        builder.room(Vec3::ZERO, size, [black; 6]);
        builder.point_light(at * size, 100.0);
        let config = SolveConfig {
            quality: Quality::DRAFT,
            ..SolveConfig::default()
        };
        let s = solve(&builder.build(), &config, &mut ())
            .unwrap()
            .stats
            .solve;
        assert_close("emitted", s.emitted_w, 3.0 * 4.0 * PI * 100.0, 1e-6);
        assert_close("absorbed", s.absorbed_w, s.emitted_w, 1e-3);
    }
}

#[test]
fn lobes_from_flat_to_mirrors() {
    let specular = Rgb::splat(0.6);
    let gloss = [
        (
            "Phong 0",
            Gloss::Phong {
                specular,
                exponent: 0.0,
            },
        ),
        (
            "Phong 1e6",
            Gloss::Phong {
                specular,
                exponent: 1e6,
            },
        ),
        (
            "Ward 0",
            Gloss::Ward {
                specular,
                roughness: 0.0,
            },
        ),
        (
            "Ward 1e-4",
            Gloss::Ward {
                specular,
                roughness: 1e-4,
            },
        ),
        (
            "Ward 1",
            Gloss::Ward {
                specular,
                roughness: 1.0,
            },
        ),
    ];
    for (name, gloss) in gloss {
        let scene = room_with(Material {
            gloss,
            ..Material::lambert("subject", Rgb::splat(0.1))
        });
        let solution = solved(name, &scene);
        assert!(
            solution.distribution_words.iter().any(|&word| word != 0),
            "{name}"
        );
    }
    let gloss = Gloss::Ward {
        specular,
        roughness: 1.01,
    };
    let material = Material {
        gloss,
        ..Material::lambert("rough", Rgb::BLACK)
    };
    let parts = sheen_solver::SceneParts {
        materials: vec![material],
        ..Default::default()
    };
    let refused = Scene::new(parts, false);
    assert!(
        matches!(refused, Err(SceneError::Parameter { .. })),
        "{refused:?}"
    );
}

#[test]
fn slivers() {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    let lamp = builder.lambert("lamp", 0.3, 2.0);
    let shiny = builder.phong("sliver", 0.2, 0.6, 200.0);
    builder.room(Vec3::ZERO, Vec3::ONE, [wall, wall, wall, lamp, wall, wall]);
    // A million times as long as wide, in several directions.
    for (i, along) in [Vec3::X, Vec3::Z, Vec3::new(1.0, 0.0, 1.0)]
        .into_iter()
        .enumerate()
    {
        let from = Vec3::new(0.1, 0.2 + 0.2 * i as f32, 0.1);
        let wide = Vec3::Y * 0.8e-6;
        let to = from + along * 0.8;
        builder.quad([from, to, to + wide, from + wide], shiny);
    }
    let solution = solved("slivers", &builder.build());
    let lit: Vec<usize> = (0..solution.position.len())
        .filter(|&v| solution.material[v] == shiny && !solution.radiance[v].is_black())
        .collect();
    assert!(lit.len() >= 12, "{} vertices of slivers are lit", lit.len());
}

#[test]
fn surfaces_in_one_place() {
    // A cube whose walls all stand there twice, of another material each.
    let once = scenes::cube_with_lit_ceiling(1.0, 0.5);
    let mut twice = Builder {
        parts: once.clone().into_parts(),
    };
    let other = twice.lambert("other", 0.5, 0.0);
    let ceiling = twice.lambert("other ceiling", 0.5, FRAC_1_PI);
    twice.room(
        Vec3::ZERO,
        Vec3::ONE,
        [other, other, other, ceiling, other, other],
    );
    let twice = twice.build();
    let (single, double) = (solved("once", &once), solved("twice", &twice));
    for material in ["floor", "wall"] {
        let expected = mean_radiance_of(&once, &single, material);
        let found = mean_radiance_of(&twice, &double, material);
        assert_close(format!("{material}, twice"), found, expected, 0.01);
    }
}

#[test]
fn a_lamp_that_lies_on_what_it_lights() {
    // Distance zero: all of the floor's sky is the lamp. E = π L.
    let at =
        |y: f32| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| Vec3::new(x, y, z));
    let mut down = at(0.0);
    let mut up = at(0.0);
    up.reverse();
    let scene = scenes::sender_and_receiver(down, up, 0.5);
    let touching = solved("touching", &scene);
    assert!(mean(&scene, &touching) <= 1.0 + 1e-6);
    // A hair's breadth away it is seen.
    down.iter_mut().for_each(|corner| corner.y = 1e-4);
    let scene = scenes::sender_and_receiver(down, up, 0.5);
    let solution = solved("a tenth of a millimetre off", &scene);
    assert_close(
        "lit",
        mean_radiance_of(&scene, &solution, "receiver"),
        0.5,
        0.02,
    );
}

#[test]
fn lamps_inside_of_walls() {
    let quad =
        |y: f32| [(0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)].map(|(x, z)| Vec3::new(x, y, z));
    let with_lamp = |y: f32| {
        let mut builder = Builder::new();
        let wall = builder.lambert("wall", 0.5, 0.0);
        let lamp = builder.lambert("lamp", 0.0, 5.0);
        builder
            .room(Vec3::ZERO, Vec3::ONE, [wall; 6])
            .block(Vec3::new(0.2, 0.7, 0.2), Vec3::new(0.8, 0.9, 0.8), wall)
            .quad(quad(y), lamp);
        builder.build()
    };
    // Below the block it lights the room, on its face too; inside of it, nothing but its inside.
    let below = with_lamp(0.65);
    let floor = |scene: &Scene, name: &str| {
        let solution = solved(name, scene);
        let fronts = front_triangles(scene, &solution);
        // The room's floor is the first to face up at height 0.
        let on_floor = fronts.into_iter().map(|front| front.0).filter(|&t| {
            solution.triangles[t]
                .iter()
                .all(|&v| solution.position[v as usize].y == 0.0)
        });
        mean_radiance(&solution, on_floor).0
    };
    let (lit, on) = (
        floor(&below, "below"),
        floor(&with_lamp(0.7), "on its face"),
    );
    assert!(lit > 0.01, "{lit}");
    assert!((on / lit - 1.0).abs() < 0.3, "{on}, {lit} below");
    let inside = floor(&with_lamp(0.8), "inside");
    assert!(inside < 1e-3 * lit, "{inside}");
}

#[test]
fn one_triangle_and_none() {
    let mut builder = Builder::new();
    let lamp = builder.lambert("lamp", 0.5, 1.0);
    builder.quad([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Z, Vec3::Z], lamp);
    builder.parts.triangles.truncate(1);
    let scene = builder.build();
    let solution = solved("one triangle", &scene);
    let (low, high) = extremes(solution.radiance.iter().copied().filter(|r| !r.is_black()));
    assert_eq!((low, high), (1.0, 1.0));
    let none = Scene::new(sheen_solver::SceneParts::default(), false);
    assert!(matches!(none, Err(SceneError::NoSurface)), "{none:?}");
    // Without an area there is no lamp.
    let mut flat = scene.into_parts();
    flat.points[1] = flat.points[0];
    let refused = Scene::new(flat.clone(), false);
    assert!(
        matches!(refused, Err(SceneError::Degenerate { .. })),
        "{refused:?}"
    );
    assert!(matches!(Scene::new(flat, true), Err(SceneError::NoSurface)));
}

#[test]
fn a_hundred_thousand_lamps() {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.5, 0.0);
    builder.room(Vec3::ZERO, Vec3::ONE, [wall; 6]);
    let mut random = Random::new(9);
    for _ in 0..100_000 {
        let at = Vec3::new(random.unit(), random.unit(), random.unit());
        builder.point_light(at * 0.9 + 0.05, 1e-4);
    }
    let scene = builder.build();
    let config = SolveConfig {
        quality: Quality::DRAFT,
        ..SolveConfig::default()
    };
    let solution = solve(&scene, &config, &mut ()).unwrap();
    println!("{:.1} s", solution.stats.solve.wall_s);
    // Φ ρ / (π A (1 - ρ)) in the mean of a closed room.
    let expected = 4.0 * PI * 10.0 / (6.0 * PI);
    assert_close("mean radiance", mean(&scene, &solution), expected, 0.01);
}

#[test]
fn ten_million_triangles() {
    // A bumpy ground of 2,236² squares: valid, and refused at once where it cannot be held.
    const SIDE: u32 = 2236;
    let mut builder = Builder::new();
    let ground = builder.lambert("ground", 0.5, 0.0);
    let row = SIDE + 1;
    let mut random = Random::new(3);
    let points = (0..row * row).map(|i| {
        let bump = 0.01 * random.unit();
        Vec3::new((i % row) as f32, bump, (i / row) as f32)
    });
    builder.parts.points.extend(points);
    for i in (0..row * SIDE).filter(|i| i % row < SIDE) {
        for points in [[i, i + row, i + 1], [i + 1, i + row, i + row + 1]] {
            builder.parts.triangles.push(Triangle {
                points,
                normals: None,
                material: ground,
            });
        }
    }
    builder.point_light(Vec3::new(1e3, 1e3, 1e3), 1e6);
    let scene = builder.build();
    let count = scene.triangles().len();
    assert_eq!(count, 2 * (SIDE as usize).pow(2));
    let limit = 1 << 30;
    let config = SolveConfig {
        memory_limit: Some(limit),
        ..SolveConfig::default()
    };
    let refused = solve(&scene, &config, &mut ()).unwrap_err();
    println!("{count} triangles: {refused}");
    assert!(
        matches!(refused, SolveError::Memory { needed, .. } if needed > limit),
        "{refused}"
    );
}

#[test]
fn an_eye_inside_of_a_solid_sees_black() {
    let mut parts = room().into_parts();
    let camera = &mut parts.cameras[0];
    // The block's middle.
    (camera.eye, camera.target) = (Vec3::new(1.3, 0.5, 1.8), Vec3::new(1.3, 0.6, 9.0));
    (camera.width, camera.height) = (16, 12);
    let scene = Builder { parts }.build();
    let solution = solved("a room", &scene);
    let camera = &scene.cameras()[0];
    let view = View::new(camera, scene.bounds()).unwrap();
    let budget = Budget {
        samples: 16,
        time_limit: None,
    };
    let traced = trace(&PathTracer::new(&scene), &view, budget, 0, &mut ());
    for (name, image) in [
        ("solution", images::render(&solution, camera)),
        ("paths", traced.image),
    ] {
        assert!(image.pixels.iter().all(|p| p.is_black()), "{name}");
    }
}
