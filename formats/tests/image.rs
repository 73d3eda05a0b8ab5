//! Images: what is written is read back, what others wrote is read, what is wrong is refused.
#![allow(clippy::unwrap_used, reason = "tests")]

use exr::prelude::{WritableImage, f16};
use sheen_formats::image::{Image, read_exr, write_exr, write_png};
use sheen_solver::Rgb;
use std::path::{Path, PathBuf};

fn gradient(width: u32, height: u32) -> Image {
    let pixel = |i: u32| Rgb::new(i as f32 * 0.37, 1e-6 * i as f32, 1e6 - i as f32);
    Image {
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
    }
}

#[track_caller]
fn refused<T: std::fmt::Debug>(result: Result<T, sheen_formats::FormatError>, expected: &str) {
    let text = result.unwrap_err().to_string();
    assert!(
        text.contains(expected) && !text.contains('\n'),
        "'{text}' lacks '{expected}'"
    );
}

#[test]
fn an_exr_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for (width, height) in [(1, 1), (37, 23), (3, 100)] {
        let image = gradient(width, height);
        write_exr(&path, &image).unwrap();
        assert_eq!(read_exr(&path).unwrap(), image);
    }
    let names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(names, ["a.exr"], "temporary files are left behind");
}

#[test]
fn images_that_cannot_be_written_are_refused_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut image = gradient(4, 4);
    image.pixels[3].g = f32::NAN;
    image.pixels[5].b = f32::INFINITY;
    refused(
        write_exr(&path, &image),
        "a.exr: 2 of 16 pixels are NaN or infinite",
    );
    image.pixels.pop();
    refused(
        write_exr(&path, &image),
        "a.exr: 15 pixels given, expected 4 x 4",
    );
    refused(
        write_exr(&path, &Image::default()),
        "a.exr: has 0 x 0 pixels",
    );
    refused(
        write_exr(&folder.path().join("no/a.exr"), &gradient(1, 1)),
        "a.exr: ",
    );
    refused(write_exr(folder.path(), &gradient(1, 1)), "is a directory");
    refused(
        write_png(&path, &[0; 11], 2, 2),
        "11 bytes given, expected 2 x 2 x 3",
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_png_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let bytes: Vec<u8> = (0..5 * 7 * 3).collect();
    write_png(&path, &bytes, 5, 7).unwrap();
    let back = image::open(&path).unwrap().into_rgb8();
    assert_eq!((back.dimensions(), back.into_raw()), ((5, 7), bytes));
}

#[test]
#[cfg(unix)]
fn a_device_or_link_stays_what_it_is() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    write_exr(Path::new("/dev/null"), &gradient(2, 2)).unwrap();
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    std::fs::write(folder.path().join("real.exr"), "old").unwrap();
    symlink("real.exr", folder.path().join("link.exr")).unwrap();
    write_exr(&folder.path().join("link.exr"), &gradient(2, 2)).unwrap();
    assert!(
        std::fs::symlink_metadata(folder.path().join("link.exr"))
            .unwrap()
            .is_symlink()
    );
    assert_eq!(
        read_exr(&folder.path().join("real.exr")).unwrap(),
        gradient(2, 2)
    );
    if Path::new("/dev/full").exists() {
        refused(
            write_exr(Path::new("/dev/full"), &gradient(2, 2)),
            "/dev/full: ",
        );
    }
}

/// Writes an image with the channels given, in half precision, PIZ compressed, in tiles.
fn write_channels(path: &Path, names: &[&str], value: f32) {
    let channel = |name: &&str| {
        exr::image::AnyChannel::new(
            *name,
            exr::image::FlatSamples::F16(vec![f16::from_f32(value); 20]),
        )
    };
    let encoding = exr::image::Encoding {
        compression: exr::compression::Compression::PIZ,
        blocks: exr::image::Blocks::Tiles(exr::prelude::Vec2(2, 2)),
        line_order: exr::meta::attribute::LineOrder::Increasing,
    };
    let channels = exr::image::AnyChannels::sort(names.iter().map(channel).collect());
    let layer = exr::image::Layer::new(
        (5, 4),
        exr::meta::header::LayerAttributes::default(),
        encoding,
        channels,
    );
    exr::image::Image::from_layer(layer)
        .write()
        .to_file(path)
        .unwrap();
}

#[test]
fn row_19_foreign_images() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_channels(&path, &["R", "G", "B", "A", "Z"], 0.5);
    assert_eq!(
        read_exr(&path).unwrap(),
        Image {
            width: 5,
            height: 4,
            pixels: vec![Rgb::splat(0.5); 20]
        }
    );
    write_channels(&path, &["R", "G", "B"], -2.0);
    assert_eq!(read_exr(&path).unwrap().pixels[0], Rgb::splat(-2.0));
    write_channels(&path, &["R", "B"], 0.5);
    refused(
        read_exr(&path),
        "a.exr: has no channel G, expected R, G, B (it has B, R)",
    );
    write_channels(&path, &["Y"], 0.5);
    refused(read_exr(&path), "has no channel R");
    write_channels(&path, &["R", "G", "B"], f32::NAN);
    refused(
        read_exr(&path),
        "a.exr: 20 of 20 pixels are NaN or infinite",
    );
}

#[test]
fn rows_1_to_3_files_that_are_no_images() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    refused(read_exr(&path), "a.exr: No such file");
    refused(read_exr(folder.path()), "is a directory");
    for (content, expected) in [
        (&b""[..], "is empty, expected an OpenEXR image"),
        (
            b"\x89PNG\r\n\x1a\n",
            "looks like a PNG image, expected an OpenEXR image",
        ),
        (b"hello", "looks like something else"),
        (b"\x76\x2F\x31\x01", "is no readable OpenEXR image"),
    ] {
        std::fs::write(&path, content).unwrap();
        refused(read_exr(&path), expected);
    }
}

#[test]
fn rows_17_and_18_damaged_images_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, &gradient(16, 16)).unwrap();
    let good = std::fs::read(&path).unwrap();
    for length in (0..good.len()).step_by(16) {
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, &good[..length]).unwrap();
        refused(read_exr(&path), "a.exr: ");
    }
    // A flipped bit may still be a valid image: only panics and endless work are wrong.
    for at in (0..good.len()).step_by(3) {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, &bytes).unwrap();
        if let Err(error) = read_exr(&path) {
            assert!(!error.to_string().contains('\n'));
        }
    }
    // The data window's lower right corner at (99999, 99999): refused by its header.
    let mut bytes = good.clone();
    let name = b"dataWindow\0box2i\0";
    let at = bytes
        .windows(name.len())
        .position(|window| window == name)
        .unwrap()
        + name.len()
        + 4
        + 8;
    bytes[at..at + 8].copy_from_slice(&[99_999u32.to_le_bytes(), 99_999u32.to_le_bytes()].concat());
    std::fs::write(&path, &bytes).unwrap();
    refused(read_exr(&path), "a.exr: ");
}

#[test]
fn the_reference_images_are_read() {
    let shared = std::env::var_os("SHEEN_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let images = shared.join("reference/images");
    if !images.is_dir() {
        assert!(
            std::env::var_os("SHEEN_REQUIRE_SHARED").is_none_or(|v| v != "1"),
            "no {}",
            images.display()
        );
        eprintln!("SKIPPED: the_reference_images_are_read: no shared folder, set SHEEN_SHARED");
        return;
    }
    let mut seen = 0;
    for entry in std::fs::read_dir(&images).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "exr") {
            let image = read_exr(&path).unwrap();
            assert!(
                image.pixels.iter().any(|pixel| pixel.max_channel() > 0.0),
                "{} is black",
                path.display()
            );
            seen += 1;
        }
    }
    assert!(seen >= 10, "{seen} images");
    // Exact by construction: every surface emits 1 and reflects half.
    let furnace = read_exr(&images.join("furnace.inside.exr")).unwrap();
    assert!(furnace.pixels.iter().all(|pixel| *pixel == Rgb::splat(2.0)));
}
