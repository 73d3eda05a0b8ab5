//! The window under a virtual display: scene in the middle, panel beside it, keys that move the eye.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use glam::{DVec3, Vec3};
use image::RgbImage;
use sheen_solver::{Camera, Quality, Rgb, Solution, SolveConfig};
use sheen_viewer::camera::{View, Walker};
use sheen_viewer::script::FRAME_S;
use sheen_viewer::tonemap;
use sheen_viewer::ways::{Shading, cpu};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Longest that a window may take [s]: a second or two is usual, and a window that never closes is a failure too.
const PATIENCE_S: &str = "300";
/// Columns of the panel, at the right [pixels].
const PANEL: u32 = 300;

/// True when there is a virtual display and an adapter that draws on it; says loudly when not. With
/// SHEEN_REQUIRE_GPU=1 their absence is a failure.
fn has_display(test: &str) -> bool {
    let has_xvfb = Command::new("xvfb-run")
        .arg("--help")
        .output()
        .is_ok_and(|output| output.status.success());
    if has_xvfb && common::gpu(test).is_some() {
        return true;
    }
    assert!(
        std::env::var_os("SHEEN_REQUIRE_GPU").is_none_or(|v| v != "1"),
        "{test}: xvfb-run is missing (Debian: apt-get install xvfb xauth)"
    );
    eprintln!("\n######## SKIPPED: {test}: no xvfb-run or no adapter ########\n");
    false
}

/// What the window shows at the end of `sheen walk` with these arguments, run in `folder`.
#[track_caller]
fn walk(folder: &Path, arguments: &[&str]) -> RgbImage {
    let shot = folder.join("shot.png");
    let output = Command::new("timeout")
        .args(["--kill-after=10", PATIENCE_S])
        .args(["xvfb-run", "-a", "-s", "-screen 0 1280x800x24"])
        .args([env!("CARGO_BIN_EXE_sheen"), "walk", "--screenshot"])
        .arg(&shot)
        .args(arguments)
        .current_dir(folder)
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    // Where no window can be opened, the program writes a picture of another name.
    assert!(
        output.status.success() && shot.is_file(),
        "{arguments:?}: {}: {}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    let image = image::open(&shot).unwrap().to_rgb8();
    std::fs::remove_file(&shot).unwrap();
    let (width, height) = image.dimensions();
    assert!(width >= 800 && height >= 600, "{width}x{height}");
    image
}

#[test]
fn the_window_shows_the_scene_and_the_panel() {
    if !has_display("the_window_shows_the_scene_and_the_panel") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    sheen_formats::solution::write(&folder.path().join("room.sheen"), &common::room()).unwrap();
    let shot = walk(folder.path(), &["room.sheen", "--frames", "4"]);
    let (width, height) = shot.dimensions();
    // Left: the scene at the solution's first camera. The floor's highlight is bright at the bottom of the middle,
    // beside the back wall everything is black.
    let middle = (width - PANEL) / 2;
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

/// `solution` with all radiance times `factor`.
fn brighter(mut solution: Solution, factor: f32) -> Solution {
    solution.radiance.iter_mut().for_each(|r| *r *= factor);
    let offsets: BTreeSet<u32> = solution.distribution_offset.iter().copied().collect();
    for offset in offsets {
        // A distribution begins with its scale.
        if let Some(scale) = solution.distribution_words.get_mut(offset as usize) {
            *scale = (f32::from_bits(*scale) * factor).to_bits();
        }
    }
    solution
}

#[test]
fn any_unit_of_light_looks_the_same() {
    if !has_display("any_unit_of_light_looks_the_same") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let shot = |factor: f32| {
        let solution = brighter(common::room(), factor);
        sheen_formats::solution::write(&folder.path().join("room.sheen"), &solution).unwrap();
        scene_part(&walk(folder.path(), &["room.sheen", "--frames", "4"]))
    };
    // Far beyond what half floats hold, to both sides.
    let plain = shot(1.0);
    for exponent in [90, -90] {
        let found = shot(2f32.powi(exponent));
        let off = plain.as_raw().iter().zip(found.as_raw());
        let off = off.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(
            off <= Some(1),
            "radiance times 2^{exponent}: {off:?} of 255"
        );
    }
}

/// A small lamp over a glossy floor at y = 0; the sphere beside it stands in the way of some of the floor.
const SCENE: &str = "glossy_sphere";
/// Middle of the lamp [m].
const LAMP: DVec3 = DVec3::new(-0.95, 1.65, 0.8);
/// Half a side of the floor [m].
const FLOOR: f64 = 1.8;
/// Middle [m] and radius [m] of the sphere.
const SPHERE: (DVec3, f64) = (DVec3::new(0.0, 0.8, 0.0), 0.48);

/// Puts the scene's files into `folder`, with a camera of ours that sees the lamp's reflection in the floor.
fn put_scene(folder: &Path) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{SCENE}"));
    for extension in ["obj", "mtl"] {
        let name = format!("{SCENE}.{extension}");
        std::fs::copy(own.join(&name), folder.join(&name)).unwrap();
    }
    let camera = "[[camera]]\nname = \"highlight\"\neye = [-1.3, 1.2, -1.6]\ntarget = [-1.3, 0.1, 0.2]\nfov_y = 70\n";
    std::fs::write(folder.join(format!("{SCENE}.toml")), camera).unwrap();
}

/// Where `camera` stands after keys have moved it along `way` (right, up, forward) for these frames.
fn moved(camera: &Camera, solution: &Solution, way: [f32; 3]) -> Camera {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let speed = Walker::new(camera, solution.bounds()).usual_speed;
    let step = (right * way[0] + camera.up * way[1] + forward * way[2]) * speed * FRAME_S;
    Camera {
        eye: camera.eye + step,
        target: camera.target + step,
        ..camera.clone()
    }
}

/// The scene's part of the window.
fn scene_part(window: &RgbImage) -> RgbImage {
    let (width, height) = window.dimensions();
    image::imageops::crop_imm(window, 0, 0, width - PANEL, height).to_image()
}

/// The view of `camera` in the window.
fn view_of(camera: &Camera, solution: &Solution, shot: &RgbImage) -> View {
    let (width, height) = shot.dimensions();
    let camera = Camera {
        width,
        height,
        ..camera.clone()
    };
    View::new(&camera, solution.bounds()).unwrap()
}

/// Share of the pixels of `shot` that differ visibly from what the processor makes of `view`.
fn share_that_differs(shot: &RgbImage, solution: &Solution, view: &View, exposure: f64) -> f64 {
    // As software adapters draw it.
    let image = cpu::render_with(solution, view, 1, Shading::Vertices);
    let bytes = tonemap::display_bytes(&image.pixels, exposure);
    let pixels = shot.as_raw().chunks_exact(3).zip(bytes.chunks_exact(3));
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 8);
    pixels.filter(differs).count() as f64 / image.pixels.len() as f64
}

/// Where on the floor the highlight is [m]: the middle of what is at least nine tenths as bright as the floor's
/// brightest pixel, averaged over the floor and not over the image.
fn highlight(shot: &RgbImage, view: &View) -> DVec3 {
    let eye = view.eye.as_dvec3();
    let on_floor = |x: u32, y: u32| {
        let direction = view.direction(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let distance = -eye.y / direction.y;
        let point = eye + direction * distance;
        let to_sphere = SPHERE.0 - eye;
        let passes_sphere = to_sphere.reject_from(direction).length() > SPHERE.1;
        let is_floor = distance > 0.0 && point.abs().max_element() < FLOOR && passes_sphere;
        // A pixel covers this much of the floor, but for a factor that all have in common.
        let area = distance * distance / direction.y.abs();
        is_floor.then_some((point, area))
    };
    let luminance = |rgb: [u8; 3]| {
        let [r, g, b] = rgb.map(|c| tonemap::linear(f64::from(c) / 255.0) as f32);
        tonemap::luminance(Rgb::new(r, g, b))
    };
    let floor: Vec<(DVec3, f64, f64)> = shot
        .enumerate_pixels()
        .filter_map(|(x, y, pixel)| {
            on_floor(x, y).map(|(point, area)| (point, area, luminance(pixel.0)))
        })
        .collect();
    assert!(floor.len() > 10_000, "{} pixels of floor", floor.len());
    let most = floor.iter().map(|&(_, _, l)| l).fold(0.0, f64::max);
    let bright = floor.iter().filter(|&&(_, _, l)| l >= 0.9 * most);
    let (sum, area) = bright.fold((DVec3::ZERO, 0.0), |(sum, whole), &(point, area, _)| {
        (sum + point * area, whole + area)
    });
    sum / area
}

/// The point of the floor that mirrors the lamp into `eye`.
fn mirror_point(eye: Vec3) -> DVec3 {
    let eye = eye.as_dvec3();
    let image = DVec3::new(LAMP.x, -LAMP.y, LAMP.z);
    eye + (image - eye) * (eye.y / (eye.y - image.y))
}

#[test]
fn keys_move_the_eye_and_the_highlight_moves_with_it() {
    if !has_display("keys_move_the_eye_and_the_highlight_moves_with_it") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    put_scene(folder.path());
    let file = format!("{SCENE}.obj");
    // The same solution as in the window: equal solves give equal bytes.
    let scene = sheen_formats::load_scene(&folder.path().join(&file), &Default::default());
    let config = SolveConfig {
        quality: Quality::DRAFT,
        ..SolveConfig::default()
    };
    let solution = sheen_solver::solve(&scene.unwrap().scene, &config, &mut ()).unwrap();

    let walk = |keys: &[&str]| {
        let common = [&file[..], "--quality", "draft", "--frames", "3"];
        scene_part(&walk(folder.path(), &[&common[..], keys].concat()))
    };
    let before = walk(&[]);
    let after = walk(&["--keys", "a:36,w:10"]);

    let start = solution.cameras[0].clone();
    let end = moved(&start, &solution, [-36.0, 0.0, 10.0]);
    // The window picks its exposure before the first key.
    let small = Camera {
        width: 160,
        height: 120,
        ..start.clone()
    };
    let small = View::new(&small, solution.bounds()).unwrap();
    let small = cpu::render(&solution, &small, 1);
    let exposure = tonemap::default_exposure(&small.pixels);
    let views = [&start, &end].map(|camera| view_of(camera, &solution, &before));
    let differs = |shot, view| share_that_differs(shot, &solution, view, exposure);
    let shares = [
        differs(&before, &views[0]),
        differs(&after, &views[1]),
        differs(&after, &views[0]),
    ];
    eprintln!(
        "pixels that differ: {:.3} % before, {:.3} % after, {:.1} % from start to end",
        shares[0] * 100.0,
        shares[1] * 100.0,
        shares[2] * 100.0
    );
    // The window shows what is seen from where the keys lead to. Its pixels are the processor's but at silhouettes: one
    // in 1,000, as in `images.rs`. From the start, nothing but the black around the floor stays as it was.
    assert!(shares[0] < 1e-3 && shares[1] < 1e-3 && shares[2] > 0.3);

    let found = [highlight(&before, &views[0]), highlight(&after, &views[1])];
    let expected = [start.eye, end.eye].map(mirror_point);
    eprintln!("highlight: {found:.3?}, lamp mirrored: {expected:.3?}");
    for (found, expected) in found.iter().zip(expected) {
        // The light is as strong as the distance to the lamp lets it be: the brightest point lies nearer to it than
        // the mirror's, and at draft quality the mesh of the floor is coarse.
        assert!(found.distance(expected) < 0.2);
    }
    let (way, expected_way) = (found[1] - found[0], expected[1] - expected[0]);
    // A painted spot would stay, one that keeps its place before the eye would go as far as the eye.
    assert!(expected_way.length() > 0.3 && way.distance(expected_way) < 0.1);
    let eye_way = f64::from(end.eye.distance(start.eye));
    assert!(eye_way - way.length() > 0.15, "{eye_way}");
}
