//! The program as a person types it: exit status, messages, files.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::path::Path;
use std::process::{Command, Output};

fn sheen(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sheen"))
        .current_dir(folder)
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// What the program says itself: the graphics driver may add lines of its own.
fn messages(output: &Output) -> Vec<String> {
    text(&output.stderr)
        .lines()
        .filter(|line| line.starts_with("sheen: "))
        .map(str::to_owned)
        .collect()
}

fn folder_with_room() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    sheen_formats::solution::write(&folder.path().join("room.sheen"), &common::room()).unwrap();
    folder
}

#[test]
fn usage_errors_exit_with_2() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &[][..],
        &["frobnicate"],
        &["solve", "a.obj"],
        &["solve", "a.obj", "-o", "a.sheen", "--quality", "splendid"],
        &["solve", "a.obj", "-o", "a.sheen", "--levels", "9"],
        &["render", "a.sheen", "-o", "a.jpg"],
        &["render", "a.sheen", "-o", "a.png", "--eye", "1,2"],
        &["render", "a.sheen", "-o", "a.png", "--eye", "1,2,3"],
        &[
            "render", "a.sheen", "-o", "a.png", "--camera", "x", "--eye", "1,2,3", "--target",
            "0,0,0",
        ],
        &["render", "a.sheen", "-o", "a.png", "--way", "magic"],
        &["render", "a.sheen", "-o", "a.png", "--size", "640"],
        &["walk", "a.sheen", "--keys", "w:3"],
        &["walk", "a.sheen", "--screenshot", "a.png", "--keys", "w3"],
        &["walk", "a.sheen", "--screenshot", "a.png", "--frames", "0"],
        &["compare", "a.exr"],
    ] {
        let output = sheen(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
}

#[test]
fn bad_input_is_one_line_and_exits_with_1() {
    let folder = folder_with_room();
    std::fs::write(folder.path().join("broken.sheen"), b"not a solution").unwrap();
    let cases: [(&[&str], &str); 10] = [
        (&["info", "missing.sheen"], "missing.sheen"),
        (&["info", "broken.sheen"], "broken.sheen"),
        (
            &["render", "room.sheen", "-o", "nowhere/a.png"],
            "nowhere: no such folder",
        ),
        (
            &["render", "room.sheen", "-o", "a.png", "--camera", "back"],
            "expected one of: front",
        ),
        (
            &[
                "render",
                "room.sheen",
                "-o",
                "a.png",
                "--eye",
                "1,2,3",
                "--target",
                "1,2,3",
            ],
            "same point",
        ),
        (
            &["render", "room.sheen", "--way", "path", "-o", "a.exr"],
            "is a solution, expected a scene",
        ),
        (
            &["render", "room.sheen", "--spp", "2000", "-o", "a.exr"],
            "expected at most 1024",
        ),
        (&["compare", "missing.exr", "missing.exr"], "missing.exr"),
        (&["walk", "missing.sheen"], "missing.sheen"),
        (&["solve", "room.obj", "-o", "room.txt"], "ends in .sheen"),
    ];
    for (arguments, expected) in cases {
        let output = sheen(folder.path(), arguments);
        let messages = messages(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {messages:?}");
        assert!(
            messages.len() == 1 && messages[0].contains(expected),
            "{arguments:?}: {messages:?}"
        );
        assert!(output.stdout.is_empty());
        let mut parts: Vec<&str> = messages[0].split(": ").collect();
        let count = parts.len();
        parts.sort_unstable();
        parts.dedup();
        assert_eq!(parts.len(), count, "said twice: {messages:?}");
    }
    // Nothing half-written, no probe of the output folder.
    let mut names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["broken.sheen", "room.sheen"]);
}

#[test]
fn a_solution_is_described() {
    let folder = folder_with_room();
    let output = sheen(folder.path(), &["info", "room.sheen"]);
    assert!(output.status.success());
    let lines = text(&output.stdout);
    for expected in [
        "  glossy         201",
        "'glass': 2 triangles",
        "'front': 160x120",
        "emits (20.0000",
        "solve.links",
    ] {
        assert!(lines.contains(expected), "{expected} in\n{lines}");
    }
}

#[test]
fn the_processor_renders_what_the_device_renders() {
    let folder = folder_with_room();
    let output = sheen(folder.path(), &["render", "room.sheen", "-o", "device.exr"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = sheen(
        folder.path(),
        &["render", "room.sheen", "-o", "processor.exr", "--cpu"],
    );
    assert!(text(&output.stdout).contains("160x120, camera 'front', on the processor"));
    let compare = [
        "compare",
        "device.exr",
        "processor.exr",
        "--json",
        "--heatmap",
        "map.png",
    ];
    let output = sheen(folder.path(), &compare);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let figures: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        (figures["mean_ratio"].as_f64().unwrap() - 1.0).abs() < 1e-4,
        "{figures}"
    );
    assert!(figures["flip"].as_f64().unwrap() < 1e-3, "{figures}");
    let map = image::open(folder.path().join("map.png")).unwrap();
    assert_eq!((map.width(), map.height()), (160, 120));
}

#[test]
fn paths_give_the_same_picture_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../scenes/cornell_box_glossy/cornell_box_glossy.obj"
    );
    let traced = |name: &str, more: &[&str]| {
        let arguments = [
            "render", scene, "--way", "path", "--size", "40x30", "-o", name,
        ];
        let output = sheen(folder.path(), &[&arguments[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        (
            text(&output.stdout),
            std::fs::read(folder.path().join(name)).unwrap(),
        )
    };
    let (said, one) = traced("1.exr", &["--spp", "16", "--threads", "1"]);
    assert!(said.contains("16 paths a pixel"), "{said}");
    for threads in ["2", "8"] {
        let (_, other) = traced("n.exr", &["--spp", "16", "--threads", threads]);
        assert!(one == other, "{threads} threads");
    }
    let (_, other) = traced("s.exr", &["--spp", "16", "--seed", "1"]);
    assert!(one != other, "another seed");
    // The picture, and the variance beside it.
    let holds = |bytes: &[u8], name: &[u8]| bytes.windows(name.len()).any(|part| part == name);
    assert!(holds(&one, b"variance"));
    let image = sheen_formats::image::read_exr(&folder.path().join("1.exr")).unwrap();
    assert_eq!((image.width, image.height), (40, 30));
    assert!(image.pixels.iter().any(|pixel| !pixel.is_black()));
    let (said, _) = traced("t.exr", &["--time-limit", "0.2s"]);
    assert!(said.contains("paths a pixel"), "{said}");
}

#[test]
fn a_camera_from_the_command_line_and_a_picture() {
    let folder = folder_with_room();
    let arguments = [
        "render",
        "room.sheen",
        "-o",
        "a.png",
        "--eye",
        "-1,1,3",
        "--target",
        "0,0.5,0",
        "--size",
        "40x30",
    ];
    let output = sheen(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (40, 30));
    assert!(picture.pixels().any(|p| p.0.iter().any(|&c| c > 200)));
}

#[test]
fn a_plan_needs_no_up() {
    // Straight down on the room: what lay ahead lies up. To look along an `up` that is given has no meaning.
    let folder = folder_with_room();
    let plan = |name: &str, up: &[&str]| {
        let look = ["--eye", "0,2,0", "--target", "0,0,0", "--size", "30x30"];
        let arguments = [&["render", "room.sheen", "-o", name], &look[..], up].concat();
        sheen(folder.path(), &arguments)
    };
    let output = plan("plan.exr", &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let ahead = plan("ahead.exr", &["--up", "-0.3,-0.4,-3.4"]);
    assert!(ahead.status.success(), "{}", text(&ahead.stderr));
    let image = |name: &str| sheen_formats::image::read_exr(&folder.path().join(name)).unwrap();
    let (plan_image, ahead) = (image("plan.exr"), image("ahead.exr"));
    assert!(plan_image.pixels.iter().any(|pixel| !pixel.is_black()));
    assert_eq!(plan_image.pixels, ahead.pixels);
    let refused = plan("no.exr", &["--up", "0,1,0"]);
    assert_eq!(refused.status.code(), Some(1));
    let said = messages(&refused);
    assert!(
        said.iter()
            .any(|line| line.contains("up is parallel to the view")),
        "{said:?}"
    );
    assert!(!folder.path().join("no.exr").exists());
}

#[test]
fn without_a_display_walking_leaves_a_picture() {
    let folder = folder_with_room();
    let output = sheen(folder.path(), &["walk", "room.sheen"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let messages = messages(&output);
    assert!(
        messages
            .iter()
            .any(|line| line.contains("no display") && line.contains("room.png")),
        "{messages:?}"
    );
    assert!(image::open(folder.path().join("room.png")).is_ok());
}

#[test]
fn a_display_that_does_not_answer_is_no_panic() {
    let folder = folder_with_room();
    let output = Command::new(env!("CARGO_BIN_EXE_sheen"))
        .current_dir(folder.path())
        .args(["walk", "room.sheen"])
        .env_remove("WAYLAND_DISPLAY")
        .env("DISPLAY", ":7654")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        messages(&output)
            .iter()
            .any(|line| line.contains("no window could be opened"))
    );
    assert!(
        !text(&output.stderr).contains("panicked"),
        "{}",
        text(&output.stderr)
    );
    assert!(folder.path().join("room.png").is_file());
}

#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let folder = folder_with_room();
    let mut child = Command::new(env!("CARGO_BIN_EXE_sheen"))
        .current_dir(folder.path())
        .args(["info", "room.sheen"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        text(&output.stderr)
    );
}
