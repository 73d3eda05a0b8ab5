//! The window under a virtual display: scene in the middle, panel beside it.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::process::Command;

#[test]
fn the_window_shows_the_scene_and_the_panel() {
    let is_required = std::env::var_os("SHEEN_REQUIRE_GPU").is_some_and(|v| v == "1");
    let has_xvfb = Command::new("xvfb-run")
        .arg("--help")
        .output()
        .is_ok_and(|output| output.status.success());
    if !has_xvfb || common::gpu("the_window_shows_the_scene_and_the_panel").is_none() {
        assert!(
            !is_required,
            "xvfb-run is missing (Debian: apt-get install xvfb xauth)"
        );
        eprintln!(
            "\n######## SKIPPED: the_window_shows_the_scene_and_the_panel: no xvfb-run or no adapter ########\n"
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    sheen_formats::solution::write(&folder.path().join("room.sheen"), &common::room()).unwrap();
    let output = Command::new("xvfb-run")
        .current_dir(folder.path())
        .args([
            "-a",
            "-s",
            "-screen 0 1280x800x24",
            env!("CARGO_BIN_EXE_sheen"),
        ])
        .args([
            "walk",
            "room.sheen",
            "--screenshot",
            "shot.png",
            "--frames",
            "4",
        ])
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let shot = image::open(folder.path().join("shot.png"))
        .unwrap()
        .to_rgb8();
    let (width, height) = shot.dimensions();
    assert!(width >= 800 && height >= 600, "{width}x{height}");
    // Left: the scene at the solution's first camera. The floor's highlight is bright at the bottom of the middle,
    // beside the back wall everything is black.
    let middle = (width - 300) / 2;
    let mean = |x: u32, y: u32| -> u32 {
        let near = (x - 10..x + 10).flat_map(|x| (y - 10..y + 10).map(move |y| (x, y)));
        near.map(|(x, y)| {
            shot.get_pixel(x, y)
                .0
                .iter()
                .map(|&c| u32::from(c))
                .sum::<u32>()
        })
        .sum::<u32>()
            / 1200
    };
    assert!(
        mean(middle, height - 20) > 180,
        "{}",
        mean(middle, height - 20)
    );
    assert_eq!(mean(20, 20), 0);
    // Right: the panel, text on a dark ground.
    let panel = || (width - 280..width).flat_map(|x| (0..height).map(move |y| (x, y)));
    let bright = panel()
        .filter(|&(x, y)| shot.get_pixel(x, y).0.iter().all(|&c| c > 100))
        .count();
    let all = panel().count();
    assert!(bright > all / 200 && bright < all / 3, "{bright} of {all}");
}
