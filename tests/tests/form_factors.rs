//! Form factors of pairs of rectangles from solved radiance, against closed forms (exact_cases 2a).
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use glam::Vec3;
use sheen_solver::{Scene, SolveConfig, solve};
use sheen_tests::measure::mean_radiance_of;
use sheen_tests::scenes::Builder;
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
        (0.1, 0.826994522397),
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
        ((1.0, 1.0, 2.0), 0.116426301398),
        ((2.0, 1.0, 1.0), 0.240636006177),
        ((1.0, 0.1, 1.0), 0.0432513694007),
        ((1.0, 10.0, 1.0), 0.249209485791),
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

#[test]
fn parallel_rectangles_and_their_sides_exchanged() {
    // A₁ F₁₂ = A₂ F₂₁: of a large and a small rectangle, each in turn the sender.
    let opposed = |lower: [Vec3; 4], upper: [Vec3; 4], down: bool| {
        let mut upper = upper.map(|corner| corner + Vec3::Y);
        upper.reverse();
        let (sender, receiver) = if down { (upper, lower) } else { (lower, upper) };
        form_factor(
            &scenes::sender_and_receiver(sender, receiver, 0.5),
            "receiver",
        )
    };
    let rectangle = floor(0.0, 0.0, 2.0, 1.0);
    assert_close(
        "2 × 1, gap 1",
        opposed(rectangle, rectangle, true),
        0.285875384851,
        PLATES,
    );
    let large = floor(0.0, 0.0, 10.0, 10.0);
    assert_close(
        "10 × 10, gap 1",
        opposed(large, large, true),
        0.826994522397,
        PLATES,
    );
    let small = floor(0.5, 0.25, 0.5, 0.25);
    let to_small = opposed(rectangle, small, false) * 0.125;
    let to_large = opposed(rectangle, small, true) * 2.0;
    assert_close("exchanged", to_small, to_large, PLATES);
}

#[test]
fn coaxial_discs() {
    // From the lower disc to the upper: radii, distance, form factor. Discs are polygons of the same areas.
    for ((lower, upper, height), expected) in [
        ((1.0f32, 1.0f32, 1.0f32), 0.381966011250),
        ((1.0, 1.0, 0.1), 0.904875078027),
        ((1.0, 2.0, 1.0), 0.763932022500),
        ((1.0, 0.5, 2.0), 0.0480589839890),
    ] {
        const SIDES: u32 = 48;
        let mut builder = Builder::new();
        let emitter = builder.lambert("emitter", 0.0, 1.0);
        let grey = builder.lambert("receiver", 0.5, 0.0);
        let turn = std::f32::consts::TAU / SIDES as f32;
        // The same area as the disc.
        let widen = (turn / turn.sin()).sqrt();
        let mut disc = |radius: f32, y: f32, up: bool, material: u32| {
            let at = |i: u32| {
                let (sin, cos) = (turn * i as f32).sin_cos();
                Vec3::new(radius * widen * cos, y, radius * widen * sin)
            };
            let centre = Vec3::new(0.0, y, 0.0);
            for i in (0..SIDES).step_by(2) {
                // Kites of two sectors each.
                let mut kite = [centre, at(i + 2), at(i + 1), at(i)];
                if !up {
                    kite.reverse();
                }
                builder.quad(kite, material);
            }
        };
        disc(lower, 0.0, true, grey);
        disc(upper, height, false, emitter);
        let found = form_factor(&builder.build(), "receiver");
        // Wedges that meet in the middle are split less than squares are: what is interpolated between their corners is
        // 1 % off.
        assert_close(
            format!("discs {lower}, {upper}, {height}"),
            found,
            expected,
            0.015,
        );
    }
}

#[test]
fn however_turned_and_wherever_begun() {
    let receiver = floor(0.0, 0.0, 1.0, 1.0);
    let mut sender = receiver.map(|corner| corner + Vec3::Y);
    sender.reverse();
    for begin in 0..4 {
        let turn = glam::Quat::from_axis_angle(Vec3::new(0.6, -0.48, 0.64), 0.7 * begin as f32);
        let [sender, receiver] = [sender, receiver].map(|corners| {
            let mut corners = corners.map(|corner| turn * corner);
            corners.rotate_left(begin);
            corners
        });
        let found = form_factor(
            &scenes::sender_and_receiver(sender, receiver, 0.5),
            "receiver",
        );
        assert_close(
            format!("turned {begin} times"),
            found,
            0.199824895698387,
            PLATES,
        );
    }
}
