//! The sidecar: cameras, lamps, changes to materials; what is refused, and in which line.
#![allow(clippy::unwrap_used, reason = "tests")]

use glam::Vec3;
use sheen_formats::{FormatError, LoadOptions, Loaded, load_scene};
use sheen_solver::{Gloss, Rgb};

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl floor\nf 1 2 3\n";
const CAMERA: &str = "[[camera]]\nname = \"front\"\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_y = 45\nwidth = 64\nheight = 48\n";

fn load(toml: &str) -> Result<Loaded, FormatError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), OBJ).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl floor\nKd .5 .5 .5\n").unwrap();
    std::fs::write(folder.path().join("a.toml"), toml).unwrap();
    load_scene(&folder.path().join("a.obj"), &LoadOptions::default())
}

#[track_caller]
fn refused(toml: &str, expected: &[&str]) {
    let text = load(toml).unwrap_err().to_string();
    assert!(!text.contains('\n'), "not one line: {text}");
    for part in expected {
        assert!(text.contains(part), "'{text}' lacks '{part}'");
    }
}

#[test]
fn cameras_lamps_and_materials_are_read() {
    let toml = format!(
        "{CAMERA}\n[[point_light]]\nposition = [1, 2, 3.5]\nintensity = [10, 20, 30]\n\n\
         [material.floor]\nspecular = [0.25, 0.25, 0.25]\nexponent = 20\nemission = [1, 1, 1]\n"
    );
    let scene = load(&toml).unwrap().scene;
    let camera = &scene.cameras()[0];
    assert_eq!(
        (camera.name.as_str(), camera.eye, camera.fov_y_degrees),
        ("front", Vec3::new(0.0, 0.0, 5.0), 45.0)
    );
    assert_eq!((camera.width, camera.height), (64, 48));
    assert_eq!(scene.point_lights()[0].position, Vec3::new(1.0, 2.0, 3.5));
    assert_eq!(
        scene.point_lights()[0].intensity,
        Rgb::new(10.0, 20.0, 30.0)
    );
    let floor = &scene.materials()[0];
    assert_eq!(
        floor.gloss,
        Gloss::Phong {
            specular: Rgb::splat(0.25),
            exponent: 20.0
        }
    );
    assert_eq!(
        (floor.diffuse, floor.emission),
        (Rgb::splat(0.5), Rgb::WHITE)
    );
}

#[test]
fn an_empty_sidecar_and_a_short_camera_are_fine() {
    assert_eq!(
        load("# nothing\n").unwrap().scene.cameras()[0].name,
        "default"
    );
    let loaded =
        load("[[camera]]\nname = \"a\"\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_y = 30.5\n")
            .unwrap();
    assert_eq!(
        (
            loaded.scene.cameras()[0].up,
            loaded.scene.cameras()[0].width
        ),
        (Vec3::Y, 640)
    );
}

#[test]
fn a_mirror_is_noted() {
    let loaded = load("[material.floor]\nspecular = [0.5, 0.5, 0.5]\nroughness = 0\n").unwrap();
    let note = "mirrors become the sharpest lobe that the quality resolves: 'floor'";
    assert!(loaded.notes.iter().any(|n| n == note), "{:?}", loaded.notes);
}

#[test]
fn unknown_keys_come_with_the_nearest_known_one() {
    refused(
        &CAMERA.replace("fov_y", "fovy"),
        &["a.toml:6: ", "fovy", "did you mean 'fov_y'?"],
    );
    refused("[[camra]]\n", &["a.toml:1: ", "did you mean 'camera'?"]);
    refused(
        "[material.floor]\nspekular = [0, 0, 0]\n",
        &["a.toml:2: ", "did you mean 'specular'?"],
    );
    refused(
        "\n[material.flor]\ndiffuse = [0, 0, 0]\n",
        &["a.toml:2: no material 'flor'", "did you mean 'floor'?"],
    );
    refused(
        "[material.\"fl\\noor\"]\n",
        &["a.toml:1: no material 'fl\\noor'"],
    );
}

#[test]
fn wrong_values_are_named_with_their_line() {
    let camera = |from: &str, to: &str| CAMERA.replace(from, to);
    for (toml, expected) in [
        (
            camera("45", "nan"),
            "a.toml:1: camera 'front': fov_y must be between 0 and 180",
        ),
        (camera("45", "180"), "fov_y must be between"),
        (camera("45", "\"wide\""), "a.toml:6: "),
        (
            camera("[0, 0, 5]", "[0, nan, 5]"),
            "a.toml:1: camera 'front': eye, target and up must be finite",
        ),
        (camera("[0, 0, 5]", "[0, 5]"), "a.toml:3: "),
        (
            camera("[0, 0, 5]", "[0, 0, 0]"),
            "eye and target are the same point",
        ),
        (
            camera("up = [0, 1, 0]", "up = [0, 0, 2]"),
            "up is parallel to the view",
        ),
        (camera("= 64", "= -1"), "a.toml:7: "),
        (camera("= 64", "= 0"), "width and height must be within"),
        (camera("= 64", "= 99999"), "width and height must be within"),
        (camera("= 64", "= 1.5"), "a.toml:7: "),
        (camera("front", ""), "a.toml:1: the camera's name is empty"),
        (camera("name = \"front\"\n", ""), "missing field `name`"),
        (
            camera("= 64", "= 64\nwidth = 65"),
            "a.toml:8: duplicate key",
        ),
        (
            format!("{CAMERA}{CAMERA}"),
            "a.toml:9: camera 'front' stands here for the second time",
        ),
        ("[[camera]\n".to_owned(), "a.toml:1: "),
        ("= 1".to_owned(), "a.toml:1: "),
    ] {
        refused(&toml, &[expected]);
    }
}

#[test]
fn row_27_lamps_out_of_range() {
    for intensity in ["[nan, 0, 0]", "[-1, 0, 0]", "[1e38, 0, 0]", "[inf, 0, 0]"] {
        let toml = format!("\n\n[[point_light]]\nposition = [0, 0, 0]\nintensity = {intensity}\n");
        refused(
            &toml,
            &["a.toml:3: intensity", "must be finite, not negative"],
        );
    }
    refused(
        "[[point_light]]\nposition = [nan, 0, 0]\nintensity = [1, 1, 1]\n",
        &["a.toml:1: ", "not finite"],
    );
}

#[test]
fn rows_25_and_26_materials_out_of_range() {
    for (change, expected) in [
        (
            "diffuse = [1.5, 0, 0]",
            "a.toml:1: material 'floor': diffuse is",
        ),
        (
            "diffuse = [nan, 0, 0]",
            "a.toml:1: material 'floor': diffuse is",
        ),
        (
            "specular = [0.6, 0, 0]\nexponent = 5",
            "a.toml:1: material 'floor': diffuse + specular",
        ),
        ("specular = [0.1, 0, 0]\nexponent = -5", "exponent is -5"),
        (
            "specular = [0.1, 0, 0]\nroughness = 1.5",
            "roughness is 1.5",
        ),
        (
            "specular = [0.1, 0, 0]\nroughness = 0.5\nexponent = 5",
            "expected one of them",
        ),
        (
            "specular = [0.1, 0, 0]",
            "specular needs exponent (Phong) or roughness (Ward)",
        ),
        ("exponent = 3", "needs specular beside it"),
        (
            "emission = [-1, 0, 0]",
            "a.toml:1: material 'floor': emission",
        ),
    ] {
        refused(&format!("[material.floor]\n{change}\n"), &[expected]);
    }
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    std::fs::write(&path, b"# a\n# \xFF\n").unwrap();
    let text = sheen_formats::sidecar::read(&path).unwrap_err().to_string();
    assert!(text.ends_with("a.toml:2: is not UTF-8 text"), "{text}");
    // Deep nesting is a depth error, not an overflow of the stack.
    std::fs::write(&path, format!("a = {}", "[".repeat(100_000))).unwrap();
    assert!(
        !sheen_formats::sidecar::read(&path)
            .unwrap_err()
            .to_string()
            .contains('\n')
    );
}
