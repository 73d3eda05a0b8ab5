//! Form factors of pairs of rectangles from solved radiance, against closed forms (exact_cases 2a).
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Scene, SolveConfig, solve};
use sheen_tests::measure::mean_radiance_of;
use sheen_tests::shared::shared;
use sheen_tests::{assert_close, scenes};

/// Form factor from the mean radiance of the receiver: ρ F L with L = 1.
fn form_factor(scene: &Scene, receiver: &str) -> f64 {
    let solution = solve(scene, &SolveConfig::default(), &mut ()).unwrap();
    let material = scene
        .materials()
        .iter()
        .find(|m| m.name == receiver)
        .unwrap();
    mean_radiance_of(scene, &solution, receiver) / f64::from(material.diffuse.mean())
}

const PARALLEL_UNIT_SQUARES: f64 = 0.199824895698387;
/// 0.2 %: what the sampling of a form factor by a hierarchy may cost.
const PLATES: f64 = 0.002;

#[test]
fn parallel_plates_of_our_own() {
    let found = form_factor(&scenes::own("parallel_plates"), "receiver");
    assert_close(
        "scenes/parallel_plates",
        found,
        PARALLEL_UNIT_SQUARES,
        PLATES,
    );
}

#[test]
fn parallel_plates_of_the_reference() {
    let Some(shared) = shared("parallel_plates_of_the_reference") else {
        return;
    };
    let scene = scenes::load(&shared.join("reference/scenes/parallel_plates.obj"));
    let receiver = scene
        .materials()
        .iter()
        .find(|m| m.emission.is_black())
        .unwrap();
    let found = form_factor(&scene, &receiver.name);
    assert_close(
        "reference parallel_plates",
        found,
        PARALLEL_UNIT_SQUARES,
        PLATES,
    );
}

/// A floor in y = 0 that looks up, from x, z to x + width, z + depth.
fn floor(x: f32, z: f32, width: f32, depth: f32) -> [Vec3; 4] {
    [(0.0, 0.0), (0.0, depth), (width, depth), (width, 0.0)]
        .map(|(dx, dz)| Vec3::new(x + dx, 0.0, z + dz))
}

#[test]
fn parallel_squares_at_other_distances() {
    for (gap, expected) in [
        (0.5, 0.415253283577),
        (2.0, 0.0685895888186),
        (10.0, 0.00316205683884),
    ] {
        let receiver = floor(0.0, 0.0, 1.0, 1.0);
        let mut sender = receiver.map(|corner| corner + Vec3::Y * gap);
        sender.reverse();
        let found = form_factor(
            &scenes::sender_and_receiver(sender, receiver, 0.5),
            "receiver",
        );
        // The same figure as for a distance of one.
        assert_close(format!("unit squares, gap {gap}"), found, expected, PLATES);
    }
}

#[test]
fn perpendicular_rectangles_with_a_common_edge() {
    // Of a receiver l × w in the floor to a sender l × h on the wall: (l, h, w), form factor.
    for ((l, h, w), expected) in [
        ((1.0, 1.0, 1.0), 0.200043776075403),
        ((1.0, 2.0, 1.0), 0.232852602795),
        ((2.0, 1.0, 1.0), 0.240636006177),
    ] {
        let receiver = floor(0.0, 0.0, l, w);
        let sender = [(0.0, 0.0), (l, 0.0), (l, h), (0.0, h)].map(|(x, y)| Vec3::new(x, y, 0.0));
        let found = form_factor(
            &scenes::sender_and_receiver(sender, receiver, 0.5),
            "receiver",
        );
        // Irradiance jumps from one half at the common edge: linear interpolation over the smallest triangles there
        // costs more than between opposed plates. 1 %, as for other figures of light.
        assert_close(
            format!("common edge, (l, h, w) = ({l}, {h}, {w})"),
            found,
            expected,
            0.01,
        );
    }
}
