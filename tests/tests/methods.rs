//! Baselines against what they are baselines of: gathering, summed reflections and radiance clustering are other ways to
//! the same light.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::config::{Method, Refiner, Scheme};
use sheen_solver::solve::{Arrived, Prepared, transported};
use sheen_solver::transport::illumination::{Unpacked, irradiance};
use sheen_solver::transport::openness::Openness;
use sheen_solver::{Quality, Scene, Solution, SolveConfig, solve};
use sheen_tests::images;
use sheen_tests::scenes::{self, Builder};
use sheen_viewer::compare::compare;

/// As elements show it: nothing is gathered again, all light has its direction, and directions are fine.
fn config(method: Method, scheme: Scheme) -> SolveConfig {
    SolveConfig {
        quality: Quality::new(0.5).unwrap(),
        method,
        scheme,
        epsilon: Some(0.1),
        transport_epsilon: Some(0.1),
        max_level: Some(5),
        gather: Some(false),
        least_directional: Some(0.0),
        ..SolveConfig::default()
    }
}

/// A glossy floor that mirrors a lamp, before a wall.
fn corner() -> Scene {
    let mut builder = Builder::new();
    let wall = builder.lambert("wall", 0.6, 0.0);
    let floor = builder.phong("floor", 0.1, 0.6, 20.0);
    let lamp = builder.lambert("lamp", 0.0, 5.0);
    let at = Vec3::new;
    builder
        .quad(
            [
                at(0., 0., 1.),
                at(1., 0., 1.),
                at(1., 0., 0.),
                at(0., 0., 0.),
            ],
            floor,
        )
        .quad(
            [
                at(0., 0., 0.),
                at(1., 0., 0.),
                at(1., 1., 0.),
                at(0., 1., 0.),
            ],
            wall,
        )
        .quad(
            [
                at(0.3, 0.8, 0.3),
                at(0.5, 0.8, 0.3),
                at(0.5, 0.8, 0.5),
                at(0.3, 0.8, 0.5),
            ],
            lamp,
        )
        .camera(at(0.8, 0.6, 1.9), at(0.5, 0.25, 0.3));
    builder.build()
}

fn solved(scene: &Scene, config: &SolveConfig) -> Solution {
    solve(scene, config, &mut ()).unwrap()
}

/// relMSE of what one shows against what the other shows.
fn difference(left: &Solution, right: &Solution) -> f64 {
    let [left, right] = [left, right].map(|s| images::render(s, &s.cameras[0]));
    compare(&left, &right, 1, None).unwrap().relmse
}

#[test]
fn gathering_finds_what_shooting_finds() {
    let scene = scenes::room_with_glossy_floor();
    let with = |scheme| {
        let config = SolveConfig {
            quality: Quality::PREVIEW,
            scheme,
            gather: Some(false),
            ..SolveConfig::default()
        };
        solved(&scene, &config)
    };
    let (shot, gathered) = (with(Scheme::Shooting), with(Scheme::Gathering));
    let [a, b] = [&shot, &gathered].map(|s| s.stats.solve.absorbed_w);
    println!("absorbed: {a} W shot, {b} W gathered");
    // What gathering leaves out: the share of the emitted power that its settings name.
    assert!((a / b - 1.0).abs() < 6e-3, "{a} {b}");
    assert!((a / shot.stats.solve.emitted_w - 1.0).abs() < 4e-3);
    let apart = difference(&shot, &gathered);
    println!("relMSE {apart:.6}");
    assert!(apart < 2e-3, "{apart}");
    assert!(gathered.stats.solve.illumination_samples > shot.stats.solve.illumination_samples);
}

#[test]
fn summed_reflections_are_the_reflection_of_the_sum() {
    let scene = corner();
    let of_sum = solved(
        &scene,
        &config(Method::IlluminationSamples, Scheme::Shooting),
    );
    let summed = solved(&scene, &config(Method::SummedReflections, Scheme::Shooting));
    let apart = difference(&of_sum, &summed);
    println!("summed reflections: relMSE {apart:.6}");
    assert!(apart < 1e-3, "{apart}");
    let [few, many] = [&of_sum, &summed].map(|s| s.stats.solve.basis_functions);
    println!("basis functions: {few} of the sum, {many} one by one");
    assert!(many > 4 * few, "{few} {many}");
}

#[test]
fn radiance_clustering_finds_what_samples_find() {
    let scene = corner();
    for scheme in [Scheme::Gathering, Scheme::Shooting] {
        let samples = solved(&scene, &config(Method::IlluminationSamples, scheme));
        let clusters = solved(&scene, &config(Method::RadianceClustering, scheme));
        let apart = difference(&samples, &clusters);
        println!("{scheme:?}: relMSE {apart:.6}");
        assert!(apart < 2e-3, "{scheme:?}: {apart}");
        let [a, b] = [&samples, &clusters].map(|s| s.stats.solve.absorbed_w);
        println!("{scheme:?}: absorbed {a} W and {b} W");
        assert!((a / b - 1.0).abs() < 3e-3, "{a} {b}");
        // Nothing that arrived is kept.
        assert_eq!(clusters.stats.solve.bytes.illumination_samples, 0);
    }
}

#[test]
fn radiance_clustering_keeps_the_light_of_what_is_split_later() {
    let scene = scenes::own("cornell_box_glossy");
    for scheme in [Scheme::Gathering, Scheme::Shooting] {
        let config = SolveConfig {
            quality: Quality::DRAFT,
            method: Method::RadianceClustering,
            scheme,
            max_level: Some(3),
            epsilon: Some(1.0),
            gather: Some(false),
            ..SolveConfig::default()
        };
        let stats = solved(&scene, &config).stats.solve;
        let known = (stats.absorbed_w + stats.escaped_w + stats.unshot_w) / stats.emitted_w;
        println!("{scheme:?}: {known} of the power is accounted for");
        assert!((known - 1.0).abs() < 5e-3, "{scheme:?}: {known}");
    }
}

#[test]
fn radiance_clustering_does_not_depend_on_threads() {
    let scene = corner();
    let with = |threads| {
        let config = SolveConfig {
            threads: Some(threads),
            ..config(Method::RadianceClustering, Scheme::Shooting)
        };
        solved(&scene, &config)
    };
    let (one, three) = (with(1), with(3));
    assert!(!one.distribution_words.is_empty());
    assert_eq!(one.radiance, three.radiance);
    assert_eq!(one.distribution_words, three.distribution_words);
}

#[test]
fn the_absolute_refiner_spends_cells_where_it_is_bright() {
    let scene = scenes::own("three_lights");
    let with = |refiner| {
        let config = SolveConfig {
            refiner,
            epsilon: Some(0.4),
            ..SolveConfig::default()
        };
        solved(&scene, &config)
    };
    let (relative, absolute) = (with(Refiner::Relative), with(Refiner::Absolute));
    // The reflector is much brighter than the scene.
    let [few, many] = [&relative, &absolute].map(|s| s.stats.solve.basis_functions);
    println!("basis functions: {few} relative, {many} absolute");
    assert!(many > few, "{few} {many}");
}

#[test]
fn samples_are_kept_for_what_mirrors_them_alone() {
    let scene = scenes::own("cornell_box_glossy");
    let settings = SolveConfig {
        quality: Quality::DRAFT,
        ..SolveConfig::default()
    };
    let settings = settings.settings().unwrap();
    let prepared = Prepared::new(&scene, &settings);
    let mut openness = Openness::new(&prepared.hierarchy(), &prepared.occluders);
    let done = transported(&prepared, &settings).unwrap();
    openness.look(&done.hierarchy, &prepared.occluders);
    let Arrived::Samples(samples) = &done.arrived else {
        panic!("samples are kept");
    };
    let (mut unpacked, mut field) = (Unpacked::default(), Vec::new());
    let (mut received, mut difference) = (0.0, 0.0);
    let (mut glossy, mut diffuse) = (0, 0);
    let tree = &done.hierarchy;
    for element in &tree.elements {
        let leaf = element.node;
        if prepared.lobes[element.material as usize].is_none() {
            assert_eq!(samples.of(leaf).len(), 0, "node {leaf}");
            diffuse += u32::from(!done.irradiance[leaf as usize].is_black());
            continue;
        }
        if !tree.is_leaf(leaf) || element.exposed.is_none() {
            continue;
        }
        field.clear();
        samples.field(tree, leaf, true, &openness, &mut unpacked, &mut field);
        let expected = irradiance(&field, tree.shading_normal(element)).mean();
        let found = done.irradiance[leaf as usize].mean();
        received += f64::from(expected);
        difference += f64::from((found - expected).abs());
        glossy += 1;
    }
    println!(
        "{glossy} glossy leaves differ by {:.2e}",
        difference / received
    );
    // Samples are kept with 16 bits.
    assert!(glossy > 100 && difference < 1e-4 * received);
    assert!(diffuse > 100, "{diffuse}");
}

/// Diffuse leaves that are split late have what they were part of had collected: no light is lost or made.
#[test]
fn what_diffuse_leaves_collect_is_what_all_iterations_bring() {
    let scene = scenes::own("cornell_box");
    let with = |scheme| {
        let config = SolveConfig {
            scheme,
            gather: Some(false),
            ..SolveConfig::default()
        };
        solved(&scene, &config)
    };
    let (collected, at_once) = (with(Scheme::Shooting), with(Scheme::Gathering));
    let apart = difference(&collected, &at_once);
    println!("shooting and gathering: relMSE {apart:.6}");
    // As rooms with glossy floors: links of all light and of its parts are refined elsewhere.
    assert!(apart < 2e-3, "{apart}");
    let [a, b] = [&collected, &at_once].map(|s| s.stats.solve.absorbed_w);
    println!("absorbed {a} W and {b} W");
    assert!((a / b - 1.0).abs() < 3e-3, "{a} {b}");
    assert_eq!(collected.stats.solve.bytes.illumination_samples, 0);
}
