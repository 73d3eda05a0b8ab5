//! The program from scene to picture, and every bad input that readers exist for (hardening, section 2).
#![allow(clippy::unwrap_used, reason = "tests")]
#![allow(clippy::print_stdout, reason = "figures are read from the output")]

use sheen_tests::program::{Ran, sheen};
use sheen_tests::scenes;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const MTL: &str = "newmtl white\nKd .5 .5 .5\n\nnewmtl shiny\nKd .2 .2 .2\nKs .5 .5 .5\nNs 20\n\nnewmtl lamp\nKe 2 2 2\n";
const SQUARE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl white\n";
/// A floor and a lamp above it that looks down.
const SMALL: &str = "mtllib a.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv .3 1 .3\nv .6 1 .3\nv .6 1 .6\nv .3 1 .6\n\
                     usemtl shiny\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n";
const SIDECAR: &str = "[[camera]]\nname = \"front\"\neye = [0.5, 0.8, 2.5]\ntarget = [0.5, 0.2, 0.0]\nup = [0, 1, 0]\n\
                       fov_y = 40\nwidth = 48\nheight = 32\n";

/// A folder with scenes, and one for outputs.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(desk.path("out")).unwrap();
        desk.put("a.mtl", MTL);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Ran {
        sheen(self.0.path(), arguments)
    }

    /// Names in the output folder.
    fn outputs(&self) -> BTreeSet<String> {
        std::fs::read_dir(self.path("out"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    /// Panics unless `input` is refused, by each subcommand that reads it, with exit status 1 and one line that holds
    /// all of `expected`, and unless nothing is left behind.
    #[track_caller]
    fn refused(&self, case: &str, input: &str, expected: &[&str]) {
        let solve: &[&str] = &[
            "solve",
            input,
            "-o",
            "out/a.sheen",
            "--quality",
            "draft",
            "--stats",
            "out/a.json",
        ];
        let render: &[&str] = &[
            "render",
            input,
            "-o",
            "out/a.png",
            "--quality",
            "draft",
            "--cpu",
        ];
        let commands = if input.ends_with(".sheen") {
            [render, &["info", input]]
        } else {
            [solve, render]
        };
        for arguments in commands {
            let ran = self.run(arguments);
            let (stderr, errors) = (ran.stderr(), ran.errors());
            assert_eq!(ran.status(), Some(1), "row {case}: {arguments:?}: {stderr}");
            assert!(!stderr.contains("panicked"), "row {case}: {stderr}");
            assert_eq!(errors.len(), 1, "row {case}: {arguments:?}: {stderr}");
            for part in expected {
                assert!(
                    errors[0].contains(part),
                    "row {case}: '{}' lacks '{part}'",
                    errors[0]
                );
            }
            let parts: Vec<&str> = errors[0].split(": ").collect();
            let distinct: BTreeSet<&str> = parts.iter().copied().collect();
            assert_eq!(
                parts.len(),
                distinct.len(),
                "row {case}: said twice: {}",
                errors[0]
            );
            // The line that is left is the only one but notes: no second line belongs to the error.
            let notes = stderr
                .lines()
                .filter(|line| line.starts_with("sheen: note: "))
                .count();
            assert_eq!(stderr.lines().count(), 1 + notes, "row {case}: {stderr}");
            assert!(ran.stdout().is_empty(), "row {case}: {}", ran.stdout());
            assert!(
                self.outputs().is_empty(),
                "row {case}: left {:?}",
                self.outputs()
            );
        }
        println!("row {case}: {}", self.run(commands[1]).errors()[0]);
    }

    /// Panics unless `a.obj` with this text is refused.
    #[track_caller]
    fn refused_obj(&self, case: &str, text: impl AsRef<[u8]>, expected: &[&str]) {
        self.put("a.obj", text);
        self.refused(case, "a.obj", expected);
    }

    /// Panics unless `a.obj` with this text is solved with `--lenient`, with a note that holds `note`.
    #[track_caller]
    fn repaired(&self, case: &str, text: &str, note: &str) {
        self.put("a.obj", text);
        let ran = self.run(&[
            "solve",
            "a.obj",
            "-o",
            "out/a.sheen",
            "--quality",
            "draft",
            "--lenient",
        ]);
        assert_eq!(ran.status(), Some(0), "row {case}: {}", ran.stderr());
        assert!(ran.stderr().contains(note), "row {case}: {}", ran.stderr());
        assert_eq!(self.outputs(), ["a.sheen".to_owned()].into(), "row {case}");
        std::fs::remove_file(self.path("out/a.sheen")).unwrap();
    }
}

#[test]
fn row_1_files_that_cannot_be_read() {
    let desk = Desk::new();
    desk.refused("1, missing", "none.obj", &["none.obj", "No such file"]);
    desk.refused("1, missing", "none.mgf", &["none.mgf", "No such file"]);
    desk.refused("1, missing", "none.sheen", &["none.sheen", "No such file"]);
    for name in ["folder.obj", "folder.mgf", "folder.sheen"] {
        std::fs::create_dir(desk.path(name)).unwrap();
        desk.refused("1, a folder", name, &[name, "is a directory"]);
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        desk.put("locked.obj", SMALL);
        let locked = std::fs::Permissions::from_mode(0o000);
        std::fs::set_permissions(desk.path("locked.obj"), locked).unwrap();
        // The superuser may read everything.
        if std::fs::read(desk.path("locked.obj")).is_err() {
            desk.refused(
                "1, no permission",
                "locked.obj",
                &["locked.obj", "ermission"],
            );
        }
    }
}

#[test]
fn row_2_empty_files() {
    let desk = Desk::new();
    for content in [&b""[..], b"\n", b"\xEF\xBB\xBF"] {
        for name in ["empty.obj", "empty.mgf"] {
            desk.put(name, content);
            desk.refused("2", name, &[name, "empty scene file"]);
        }
        desk.put("empty.sheen", content);
        desk.refused("2", "empty.sheen", &["empty.sheen"]);
    }
}

#[test]
fn row_7_and_20_faces() {
    let desk = Desk::new();
    for (face, expected) in [
        ("f 0 1 2", "a.obj:7"),
        ("f 1 2 9", "a.obj:7"),
        ("f -100 1 2", "a.obj:7"),
        ("f 1// 2// 3//", "a.obj:7"),
        ("f 1 2", "a.obj:7"),
        ("f 1 2 x", "a.obj:7"),
    ] {
        desk.refused_obj("7, 20", format!("{SQUARE}{face}\n"), &[expected]);
    }
    desk.refused_obj(
        "20, library",
        SMALL.replace("a.mtl", "none.mtl"),
        &["none.mtl"],
    );
    let long = format!("{SQUARE}f 1 2 {}\n", "9".repeat(10_000_000));
    desk.refused_obj("20, long line", long, &["a.obj:7"]);
}

#[test]
fn row_20_faces_that_are_right() {
    let desk = Desk::new();
    desk.put("a.toml", SIDECAR);
    // A ring of 10⁴ corners, a concave arrow, Windows line ends, a name in Latin-1.
    let mut ring = String::from("mtllib a.mtl\nusemtl lamp\n");
    let count = 10_000;
    for i in 0..count {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        ring += &format!("v {} {} 0\n", angle.cos(), angle.sin());
    }
    ring += "f";
    (1..=count).for_each(|i| ring += &format!(" {i}"));
    ring += "\n";
    let arrow = "mtllib a.mtl\nusemtl lamp\nv 0 0 0\nv 1 1 0\nv 0 .4 0\nv -1 1 0\nf 1 2 3 4\n";
    let mut latin = format!("# caf\u{e9}\n{SMALL}").into_bytes();
    latin.retain(|&byte| byte != 0xC3);
    for (case, text) in [
        ("n-gon", ring.into_bytes()),
        ("concave", arrow.into()),
        ("CRLF", SMALL.replace('\n', "\r\n").into_bytes()),
        ("Latin-1", latin),
    ] {
        desk.put("a.obj", text);
        let ran = desk.run(&["info", "a.obj"]);
        assert_eq!(ran.status(), Some(0), "{case}: {}", ran.stderr());
    }
}

#[test]
fn rows_12_to_14_geometry() {
    let desk = Desk::new();
    for bad in ["nan 0 0", "0 inf 0", "0 0 -1e39"] {
        let text = format!("{SQUARE}v {bad}\nf 1 2 3\nf 1 2 5\n");
        desk.refused_obj("12", &text, &["a.obj:9", "not finite"]);
        desk.repaired(
            "12",
            &text,
            "1 triangles with corners that are not finite dropped",
        );
    }
    let text = format!("{SQUARE}f 1 2 3\nf 1 2 2\n");
    desk.refused_obj("13, degenerate", &text, &["a.obj:8", "no area"]);
    desk.repaired("13", &text, "1 triangles without area dropped");
    let text = format!("{SQUARE}f 1 2 3\nf 2 3 1\n");
    desk.refused_obj("13, duplicate", &text, &["a.obj:8", "same corners"]);
    desk.repaired("13", &text, "1 duplicate triangles dropped");
    for (normal, reason) in [
        ("0 0 0", "no direction"),
        ("0 0 2", "unit length"),
        ("0 0 -1", "away from its face"),
    ] {
        let text = format!("{SQUARE}vn {normal}\nvn 0 0 1\nf 1//1 2//2 3//2\n");
        desk.refused_obj("14", &text, &["a.obj:9", reason]);
        desk.repaired("14", &text, "bad shading normals made flat");
    }
}

#[test]
fn row_22_mgf() {
    let desk = Desk::new();
    let first = "m white =\nc\nrd .5\n";
    for (case, text, expected) in [
        ("arguments", "v a =\np 1 2\n", "a.mgf:2"),
        ("unknown vertex", "f a b c\n", "a.mgf:1"),
        ("include of itself", "i a.mgf\n", "a.mgf"),
        ("missing include", "i none.mgf\n", "none.mgf"),
        ("number", "m w =\nrd much\n", "a.mgf:2"),
        ("open transform", "xf -t 1 0 0\n", "a.mgf"),
    ] {
        desk.put("a.mgf", format!("{text}{first}"));
        desk.refused(&format!("22, {case}"), "a.mgf", &[expected]);
    }
    // Unknown entities are ignored, and said so.
    desk.put("a.mgf", "novelty 1 2 3\nm w =\nc\nrd .5\ned 10\nv a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 0 1 0\nf a b c\n");
    let ran = desk.run(&["info", "a.mgf"]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    assert!(ran.stderr().contains("novelty"), "{}", ran.stderr());
}

#[test]
fn rows_25_to_27_materials_and_lights() {
    let desk = Desk::new();
    desk.put("a.obj", SMALL);
    for (row, material) in [
        ("25", "Kd 1.5 0 0"),
        ("25", "Kd -.5 0 0"),
        ("25", "Kd .6 0 0\nKs .6 0 0"),
        ("26", "Kd .1 .1 .1\nKs .5 .5 .5\nNs -1"),
        ("26", "Kd .1 .1 .1\nKs .5 .5 .5\nNs nan"),
        ("27", "Ke nan 0 0"),
        ("27", "Ke -1 0 0"),
        ("27", "Ke 1e38 0 0"),
    ] {
        desk.put(
            "a.mtl",
            format!("newmtl lamp\nKe 2 2 2\n\nnewmtl shiny\n{material}\n"),
        );
        desk.refused(row, "a.obj", &["a.mtl:", "shiny"]);
    }
    desk.put("a.mtl", MTL.replace("Ks .5", "Ks .9"));
    desk.repaired("25", SMALL, "reflectances scaled by");
    // Roughness outside its range: MGF has it.
    desk.put(
        "a.mgf",
        "m w =\nc\nrd .5\nrs .2 1.5\nv a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 0 1 0\nf a b c\n",
    );
    desk.refused("26", "a.mgf", &["a.mgf"]);
    desk.put("a.mtl", MTL);
    for intensity in ["nan", "-1.0", "1e38"] {
        let light =
            format!("[[point_light]]\nposition = [0, 1, 0]\nintensity = [{intensity}, 0, 0]\n");
        desk.put("a.toml", light);
        desk.refused("27, point light", "a.obj", &["a."]);
    }
}

#[test]
fn row_28_nothing_to_see() {
    let desk = Desk::new();
    desk.refused_obj("28, no surface", SQUARE, &["a.obj", "no surface"]);
    for (case, text, note) in [
        ("no light", format!("{SQUARE}f 1 2 3 4\n"), "nothing emits"),
        ("no camera", SMALL.to_owned(), "default camera"),
    ] {
        desk.put("a.obj", text);
        let ran = desk.run(&[
            "render",
            "a.obj",
            "-o",
            "out/a.exr",
            "--quality",
            "draft",
            "--cpu",
            "--size",
            "32x24",
        ]);
        assert_eq!(ran.status(), Some(0), "{case}: {}", ran.stderr());
        assert!(ran.stderr().contains(note), "{case}: {}", ran.stderr());
        let image = sheen_formats::image::read_exr(&desk.path("out/a.exr")).unwrap();
        assert_eq!(
            image.pixels.iter().all(|p| p.is_black()),
            case == "no light",
            "{case}"
        );
    }
    // Black surfaces are surfaces.
    desk.put(
        "a.mtl",
        "newmtl shiny\nKd 0 0 0\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n",
    );
    let ran = desk.run(&["solve", "a.obj", "-o", "out/a.sheen", "--quality", "draft"]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
}

#[test]
fn row_33_damaged_solutions() {
    let desk = Desk::new();
    desk.put("a.obj", SMALL);
    let ran = desk.run(&["solve", "a.obj", "-o", "whole.sheen", "--quality", "draft"]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let whole = std::fs::read(desk.path("whole.sheen")).unwrap();
    // Some of every 1 KiB and every byte: the readers' own tests take them all.
    for length in [1, 8, 100, 1024, whole.len() / 2, whole.len() - 1] {
        desk.put("a.sheen", &whole[..length]);
        desk.refused(&format!("33, {length} bytes"), "a.sheen", &["a.sheen"]);
    }
    for at in [0, 8, 20, whole.len() / 3, whole.len() - 2] {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        desk.put("a.sheen", bytes);
        desk.refused(&format!("33, byte {at}"), "a.sheen", &["a.sheen"]);
    }
}

#[test]
fn a_scene_that_does_not_fit_into_memory() {
    let desk = Desk::new();
    desk.put("a.obj", SMALL);
    let solve = |limit: &str| {
        let arguments = [
            "solve",
            "a.obj",
            "-o",
            "out/a.sheen",
            "--memory-limit",
            limit,
        ];
        desk.run(&arguments)
    };
    let refused = solve("1KiB");
    assert_eq!(refused.status(), Some(1), "{}", refused.stderr());
    let errors = refused.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(
        errors[0].contains("a.obj") && errors[0].contains("--memory-limit"),
        "{errors:?}"
    );
    assert!(desk.outputs().is_empty());
    let fits = solve("1GiB");
    assert_eq!(fits.status(), Some(0), "{}", fits.stderr());
}

#[test]
fn usage_errors_exit_with_2() {
    let desk = Desk::new();
    desk.put("a.obj", SMALL);
    let cases: [&[&str]; 11] = [
        &[],
        &["fly", "a.obj"],
        &["solve", "a.obj"],
        &["solve", "-o", "out/a.sheen"],
        &["solve", "a.obj", "-o", "out/a.sheen", "--quality", "best"],
        &["solve", "a.obj", "-o", "out/a.sheen", "--quality", "nan"],
        &["solve", "a.obj", "-o", "out/a.sheen", "--threads", "0"],
        &["solve", "a.obj", "-o", "out/a.sheen", "--time-limit", "-1s"],
        &["solve", "a.obj", "-o", "out/a.sheen", "--memory-limit", "0"],
        &[
            "solve",
            "a.obj",
            "-o",
            "out/a.sheen",
            "--memory-limit",
            "4 pigs",
        ],
        &["render", "a.obj", "-o", "out/a.png", "--size", "0x10"],
    ];
    for arguments in cases {
        let ran = desk.run(arguments);
        assert_eq!(ran.status(), Some(2), "{arguments:?}: {}", ran.stderr());
        assert!(!ran.stderr().is_empty() && !ran.stderr().contains("panicked"));
        assert!(desk.outputs().is_empty(), "{arguments:?}");
    }
}

fn keys(value: &serde_json::Value) -> BTreeSet<&str> {
    let object = value.as_object().unwrap();
    object.keys().map(String::as_str).collect()
}

#[test]
fn from_scene_to_picture() {
    let desk = Desk::new();
    desk.put("a.obj", SMALL);
    desk.put("a.toml", SIDECAR);
    let solve = [
        "solve",
        "a.obj",
        "-o",
        "out/a.sheen",
        "--stats",
        "out/a.json",
        "--quality",
        "preview",
    ];
    let ran = desk.run(&solve);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    assert!(
        ran.stdout().starts_with("out/a.sheen: "),
        "{}",
        ran.stdout()
    );
    // The keys that the design lists (section 6); more are welcome.
    let text = std::fs::read_to_string(desk.path("out/a.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (path, wanted) in [
        ("/scene", "triangles patches glossy_patches"),
        (
            "/solve",
            "wall_s cpu_s iterations elements leaves clusters links rays illumination_samples distributions \
             basis_functions brdf_evaluations emitted_w absorbed_w unshot_w peak_rss_bytes bytes phases_s",
        ),
        (
            "/solve/bytes",
            "hierarchy illumination_samples distributions total",
        ),
        (
            "/solve/phases_s",
            "load hierarchy propagate visibility push reflect pull export",
        ),
    ] {
        let found = keys(stats.pointer(path).unwrap());
        for key in wanted.split_whitespace() {
            assert!(found.contains(key), "{path} has no {key}");
        }
    }
    assert_eq!(stats.pointer("/scene/triangles").unwrap(), 4);
    for path in [
        "/solve/wall_s",
        "/solve/links",
        "/solve/emitted_w",
        "/solve/distributions",
        "/solve/bytes/total",
    ] {
        assert!(
            stats.pointer(path).unwrap().as_f64().unwrap() > 0.0,
            "{path}"
        );
    }
    // π · 2 W/(sr m²) on 0.09 m², three channels.
    let watts = stats.pointer("/solve/emitted_w").unwrap().as_f64().unwrap();
    assert!(
        (watts / (std::f64::consts::PI * 2.0 * 0.09 * 3.0) - 1.0).abs() < 1e-4,
        "{watts} W"
    );

    let ran = desk.run(&["info", "out/a.sheen"]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    assert!(ran.stdout().contains("'front': 48x32"), "{}", ran.stdout());
    for output in ["out/a.exr", "out/a.png"] {
        let ran = desk.run(&[
            "render",
            "out/a.sheen",
            "-o",
            output,
            "--camera",
            "front",
            "--cpu",
        ]);
        assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    }
    let png = std::fs::read(desk.path("out/a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let image = sheen_formats::image::read_exr(&desk.path("out/a.exr")).unwrap();
    assert_eq!((image.width, image.height), (48, 32));
    assert!(image.pixels.iter().any(|p| !p.is_black()));

    // A solution, and the scene solved on the way, make the same picture.
    let ran = desk.run(&[
        "render",
        "a.obj",
        "-o",
        "out/b.exr",
        "--quality",
        "preview",
        "--cpu",
    ]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let ran = desk.run(&[
        "compare",
        "out/a.exr",
        "out/b.exr",
        "--json",
        "--heatmap",
        "out/map.png",
    ]);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let figures: serde_json::Value = serde_json::from_str(&ran.stdout()).unwrap();
    assert_eq!(figures["rmse"], 0.0, "{figures}");
    assert_eq!(figures["mean_ratio"], 1.0, "{figures}");
    let expected = ["a.sheen", "a.json", "a.exr", "a.png", "b.exr", "map.png"];
    assert_eq!(desk.outputs(), expected.map(str::to_owned).into());
    let ran = desk.run(&["compare", "out/a.exr", "out/none.exr"]);
    assert_eq!((ran.status(), ran.errors().len()), (Some(1), 1));
}

#[test]
fn our_scenes_are_described() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in ["cafe", "cornell_box_glossy", "three_lights"] {
        let path = scenes::own_path(name);
        let ran = sheen(folder, &["info", path.to_str().unwrap()]);
        assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
        assert!(ran.stdout().contains("triangles"), "{}", ran.stdout());
    }
}
