//! What stands on a surface: it is dark below, and beside it loses nothing.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::config::Settings;
use sheen_solver::solve::Prepared;
use sheen_solver::{Quality, Scene, SolveConfig, solve};
use sheen_tests::UntilReport;
use sheen_tests::scenes::Builder;

/// What the links of a pass lose or find of the light that one surface sends through a room of black ones.
const LOST: f64 = 0.003;

/// A cell of what is exposed is this share of the side of an element: areas are known to half of one.
const CELL: f32 = 1.0 / 8.0;

/// Five faces of a box, whose inside is open below, or above.
fn open_box(builder: &mut Builder, low: Vec3, high: Vec3, is_open_above: bool, material: u32) {
    let at = |x: bool, y: bool, z: bool| {
        let pick = |is_high: bool, low: f32, high: f32| if is_high { high } else { low };
        Vec3::new(
            pick(x, low.x, high.x),
            pick(y != is_open_above, low.y, high.y),
            pick(z, low.z, high.z),
        )
    };
    let (o, i) = (false, true);
    for mut corners in [
        [at(o, o, o), at(o, o, i), at(o, i, i), at(o, i, o)],
        [at(i, o, o), at(i, i, o), at(i, i, i), at(i, o, i)],
        [at(o, i, o), at(o, i, i), at(i, i, i), at(i, i, o)],
        [at(o, o, o), at(o, i, o), at(i, i, o), at(i, o, o)],
        [at(o, o, i), at(i, o, i), at(i, i, i), at(o, i, i)],
    ] {
        if is_open_above {
            corners.reverse();
        }
        builder.quad(corners, material);
    }
}

const ROOM: Vec3 = Vec3::new(4.0, 3.0, 4.0);

/// A room of black surfaces with a box on its floor; the sides named `lamp` emit: floor, walls, ceiling or box.
fn room(lamp: &str, low: Vec3, high: Vec3) -> Scene {
    let mut builder = Builder::new();
    let [floor, walls, ceiling, block] = ["floor", "walls", "ceiling", "box"].map(|name| {
        let emission = if name == lamp { 1.0 } else { 0.0 };
        builder.lambert(name, 0.0, emission)
    });
    let sides = [walls, walls, floor, ceiling, walls, walls];
    builder.room(Vec3::ZERO, ROOM, sides);
    open_box(&mut builder, low, high, false, block);
    builder.build()
}

#[test]
fn what_is_sent_beside_a_foot_arrives() {
    let mut faults = Vec::new();
    for lamp in ["floor", "walls", "ceiling", "box"] {
        // The edges of the box cross leaves of the floor.
        let (low, high) = (Vec3::new(1.37, 0.0, 1.71), Vec3::new(2.81, 0.9, 2.33));
        let scene = room(lamp, low, high);
        for quality in [Quality::PREVIEW, Quality::DEFAULT] {
            let config = SolveConfig {
                quality,
                ..SolveConfig::default()
            };
            let solution = solve(&scene, &config, &mut UntilReport::transport_is_done()).unwrap();
            let s = &solution.stats.solve;
            let lost = s.corrected_w / s.emitted_w;
            let q = quality.value();
            println!("{lamp} at {q}: links lose {:+.3} %", 100.0 * lost);
            if lost.abs() > LOST {
                faults.push(format!("{lamp} at {q}: {:+.3} %", 100.0 * lost));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn what_a_box_stands_on_is_not_exposed() {
    // In the middle, and in a corner where two walls are its missing sides.
    for (name, low, high) in [
        (
            "in the middle",
            Vec3::new(1.37, 0.0, 1.71),
            Vec3::new(2.81, 0.9, 2.33),
        ),
        ("in a corner", Vec3::ZERO, Vec3::new(1.2, 1.9, 1.4)),
    ] {
        let scene = room("ceiling", low, high);
        let prepared = Prepared::new(&scene, &Settings::of(Quality::DEFAULT));
        let hierarchy = prepared.hierarchy();
        hierarchy.assert_well_formed();
        let whole = |name: &str| {
            let is_it = |e: &&sheen_solver::hierarchy::Element| {
                prepared.frame.materials[e.material as usize].name == name
            };
            let mut found = hierarchy.elements.iter().filter(is_it);
            (found.clone().filter(|e| e.back).count(), found.next())
        };
        let (backs, of_box) = whole("box");
        assert!(of_box.is_some(), "{name}: the outside of the box is lit");
        assert_eq!(backs, 0, "{name}: its inside is not");
        let (_, floor) = whole("floor");
        let floor = floor.unwrap();
        let share = hierarchy.node(floor.node).area / floor.polygon.vector_area().length();
        let covered = (high - low).x * (high - low).z / (ROOM.x * ROOM.z);
        println!("{name}: {share} of the floor is exposed, {covered} covered");
        let edge = ((high - low).x + (high - low).z) / ROOM.x;
        assert!(
            (share + covered - 1.0).abs() < CELL * edge,
            "{name}: {share} of the floor is exposed, {covered} covered"
        );
    }
}

#[test]
fn an_open_box_is_lit_from_inside() {
    let mut builder = Builder::new();
    let [wall, block] = ["walls", "box"].map(|name| builder.lambert(name, 0.5, 0.0));
    let lamp = builder.lambert("lamp", 0.5, 1.0);
    builder.room(Vec3::ZERO, ROOM, [wall, wall, wall, lamp, wall, wall]);
    let (low, high) = (Vec3::new(1.0, 0.1, 1.0), Vec3::new(2.0, 0.7, 2.5));
    open_box(&mut builder, low, high, true, block);
    let scene = builder.build();
    let prepared = Prepared::new(&scene, &Settings::of(Quality::DEFAULT));
    let is_box = |patch: usize| {
        let material = prepared.patches[patch].material;
        prepared.frame.materials[material as usize].name == "box"
    };
    let mut insides = 0;
    for (patch, sides) in prepared.lit.iter().enumerate().filter(|(p, _)| is_box(*p)) {
        insides += u32::from(sides[1].lit);
        println!("face {patch} of the crate: {sides:?}");
    }
    assert_eq!(insides, 5, "the insides of the crate are lit");
}
