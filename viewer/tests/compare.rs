//! Figures of comparisons, by hand and as the reference implementation gives them.
#![allow(clippy::unwrap_used, reason = "tests")]

use sheen_formats::image::Image;
use sheen_solver::Rgb;
use sheen_viewer::compare::{CompareError, compare};

fn image(width: u32, height: u32, colour: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let at = |i: u32| Rgb::from(colour(i % width, i / width));
    Image {
        width,
        height,
        pixels: (0..width * height).map(at).collect(),
    }
}

/// Exact in f32 and f64 alike.
fn pattern() -> (Image, Image) {
    let reference = |x: u32, y: u32| {
        [
            ((x * 7 + y * 13) % 32) as f32 / 16.0,
            ((x * 3 + y * 5) % 16) as f32 / 16.0,
            ((x / 8 + y / 8) % 2) as f32,
        ]
    };
    let test = move |x: u32, y: u32| {
        if (20..26).contains(&x) && (10..14).contains(&y) {
            return [0.0; 3];
        }
        reference(x, y).map(|c| c * 1.25 + ((x * 5 + y * 3) % 8) as f32 / 64.0)
    };
    (image(48, 32, test), image(48, 32, reference))
}

fn assert_close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (value - expected).abs() <= tolerance * expected.abs(),
        "{what}: {value}, expected {expected}"
    );
}

#[test]
fn figures_are_those_of_the_reference_implementation() {
    let (test, reference) = pattern();
    // From the Python script that defines these figures (NumPy in f64) and its FLIP package (f32), version 1.7.
    let rows = [
        (
            1,
            None,
            [
                0.27542102065807217,
                0.3973942092570198,
                0.39447631194542004,
                1.3226131117672957,
                0.8117809713466686,
                16.02066614999712,
                0.3648706376552582,
            ],
        ),
        (
            2,
            None,
            [
                0.25615159706559215,
                0.26146584010009094,
                0.25955417919174845,
                1.3226131117672957,
                1.1224131883549633,
                15.427006214601729,
                0.5246551036834717,
            ],
        ),
        (
            1,
            Some(0.5),
            [
                0.27542102065807217,
                0.3973942092570198,
                0.39447631194542004,
                1.3226131117672957,
                0.5,
                17.453968764468527,
                0.3106519877910614,
            ],
        ),
    ];
    for (downsample, exposure, expected) in rows {
        let comparison = compare(&test, &reference, downsample, exposure).unwrap();
        for ((name, value), expected) in comparison.rows().into_iter().zip(expected) {
            // The package computes FLIP in single precision, and its script hands it single-precision images.
            let tolerance = if name == "flip" { 1e-3 } else { 1e-6 };
            assert_close(value, expected, tolerance, name);
        }
    }
}

#[test]
fn equal_images_have_no_error() {
    let (test, _) = pattern();
    let comparison = compare(&test, &test, 1, None).unwrap();
    assert_eq!(
        (comparison.rmse, comparison.relmse, comparison.mean_ratio),
        (0.0, 0.0, 1.0)
    );
    assert_eq!((comparison.flip, comparison.psnr_db), (0.0, f64::INFINITY));
    let json = serde_json::to_value(&comparison).unwrap();
    assert_eq!(json["psnr_db"], "inf");
    assert_eq!(json["rmse"], 0.0);
}

#[test]
fn a_constant_offset_by_hand() {
    let reference = image(10, 10, |_, _| [2.0; 3]);
    let test = image(10, 10, |_, _| [3.0; 3]);
    let comparison = compare(&test, &reference, 1, None).unwrap();
    assert_close(comparison.rmse, 1.0, 1e-12, "rmse");
    // 1 / (2² + 0.01 · 2²)
    assert_close(comparison.relmse, 1.0 / 4.04, 1e-12, "relmse");
    assert_close(comparison.mean_ratio, 1.5, 1e-12, "mean ratio");
    assert_close(comparison.exposure, 0.4, 1e-6, "exposure");
}

#[test]
fn black_against_white_is_the_largest_flip() {
    let (black, white) = (image(8, 8, |_, _| [0.0; 3]), image(8, 8, |_, _| [1.0; 3]));
    let comparison = compare(&black, &white, 1, Some(1.0)).unwrap();
    assert!(
        comparison.flip > 0.95 && comparison.flip <= 1.0,
        "{}",
        comparison.flip
    );
    // 1.055 - 0.055 is not quite 1.
    assert!(comparison.psnr_db.abs() < 1e-12);
}

#[test]
fn images_that_cannot_be_compared_are_refused() {
    let small = image(4, 4, |_, _| [1.0; 3]);
    let wide = image(5, 4, |_, _| [1.0; 3]);
    assert!(matches!(
        compare(&small, &wide, 1, None),
        Err(CompareError::Size { .. })
    ));
    assert!(matches!(
        compare(&small, &small, 5, None),
        Err(CompareError::TooSmall { .. })
    ));
    let broken = image(4, 4, |x, _| [if x == 1 { f32::NAN } else { 1.0 }, 1.0, 1.0]);
    let error = compare(&broken, &small, 1, None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the test image holds NaN or infinity in 4 pixels"
    );
}
