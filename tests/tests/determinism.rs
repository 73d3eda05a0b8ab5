//! The same bits for any number of threads; powers of two in lengths and lights scale the result exactly.
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_solver::{Quality, Rgb, Scene, Solution, SolveConfig, solve};
use sheen_tests::scenes;

fn solved(scene: &Scene, threads: Option<usize>) -> Solution {
    let config = SolveConfig {
        quality: Quality::PREVIEW,
        threads,
        ..SolveConfig::default()
    };
    solve(scene, &config, &mut ()).unwrap()
}

/// A diffuse and glossy scene from a file, and one with a point light.
fn subjects() -> [(&'static str, Scene); 2] {
    [
        ("cornell_box_glossy", scenes::own("cornell_box_glossy")),
        ("room with a glossy floor", scenes::room_with_glossy_floor()),
    ]
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in subjects() {
        let file = |threads: usize| {
            let path = folder.path().join(format!("{threads}.sheen"));
            sheen_formats::solution::write(&path, &solved(&scene, Some(threads))).unwrap();
            std::fs::read(path).unwrap()
        };
        let one = file(1);
        println!("{name}: {} bytes", one.len());
        assert!(one.len() > 10_000);
        for threads in [2, 8] {
            assert!(
                file(threads) == one,
                "{name}: {threads} threads give another file than one"
            );
        }
    }
}

/// Panics unless `found` is `expected` with positions times `length` and radiance times `radiance`, bit for bit.
fn assert_scaled(name: &str, expected: &Solution, found: &Solution, length: f32, radiance: f32) {
    assert_eq!(expected.triangles, found.triangles, "{name}: triangles");
    assert_eq!(
        expected.distribution_offset, found.distribution_offset,
        "{name}: offsets"
    );
    for v in 0..expected.position.len() {
        let bits = |c: Rgb, by: f32| c.to_array().map(|channel| (channel * by).to_bits());
        assert_eq!(
            bits(expected.radiance[v], radiance),
            bits(found.radiance[v], 1.0),
            "{name}: radiance of vertex {v}, {:?} and {:?}",
            expected.radiance[v],
            found.radiance[v]
        );
        let place = expected.position[v] * length;
        assert_eq!(
            place.to_array(),
            found.position[v].to_array(),
            "{name}: vertex {v}"
        );
        match (expected.distribution(v), found.distribution(v)) {
            (None, None) => {}
            (Some(expected), Some(found)) => {
                // The first word is the scale of the others.
                let scale = f32::from_bits(expected[0]) * radiance;
                assert_eq!(scale.to_bits(), found[0], "{name}: scale of vertex {v}");
                assert_eq!(
                    expected[1..],
                    found[1..],
                    "{name}: distribution of vertex {v}"
                );
            }
            _ => panic!("{name}: only one has a distribution at vertex {v}"),
        }
    }
}

#[test]
fn lengths_times_a_power_of_two_leave_radiance_bitwise_the_same() {
    for (name, scene) in subjects() {
        let plain = solved(&scene, None);
        assert!(plain.radiance.iter().any(|c| !c.is_black()));
        assert!(!plain.distribution_words.is_empty());
        for exponent in [20, -20] {
            let length = 2f32.powi(exponent);
            let scaled = solved(&scenes::longer(&scene, length), None);
            assert_scaled(
                &format!("{name}, 2^{exponent} m"),
                &plain,
                &scaled,
                length,
                1.0,
            );
        }
    }
}

#[test]
fn lights_times_a_power_of_two_scale_radiance_bit_for_bit() {
    for (name, scene) in subjects() {
        let plain = solved(&scene, None);
        for exponent in [30, -30] {
            let factor = 2f32.powi(exponent);
            let scaled = solved(&scenes::brighter(&scene, factor), None);
            assert_scaled(
                &format!("{name}, lights times 2^{exponent}"),
                &plain,
                &scaled,
                1.0,
                factor,
            );
        }
    }
}
