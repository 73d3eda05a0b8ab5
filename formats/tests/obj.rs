//! OBJ and MTL: what is read, what is refused and where, what is noted.
#![allow(clippy::unwrap_used, reason = "tests")]

use sheen_formats::{FormatError, LoadOptions, Loaded, load_scene};
use sheen_solver::{Gloss, Rgb};
use std::path::{Path, PathBuf};

const MTL: &str = "newmtl white\nKd .7 .7 .7\n\nnewmtl lamp\nKe 2 2 2\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("m.mtl", MTL);
        folder
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    fn load(&self, obj: impl AsRef<[u8]>) -> Result<Loaded, FormatError> {
        load_scene(&self.put("a.obj", obj), &LoadOptions::default())
    }

    fn load_lenient(&self, obj: impl AsRef<[u8]>) -> Result<Loaded, FormatError> {
        load_scene(&self.put("a.obj", obj), &LoadOptions { lenient: true })
    }
}

fn one_line(error: FormatError) -> String {
    let text = error.to_string();
    assert!(
        !text.contains(['\n', '\r']) && text.len() < 1500,
        "not one line: {text}"
    );
    text
}

#[track_caller]
fn refused(obj: impl AsRef<[u8]>, expected: &[&str]) {
    let text = one_line(Folder::new().load(obj).unwrap_err());
    for part in expected {
        assert!(text.contains(part), "'{text}' lacks '{part}'");
    }
}

#[track_caller]
fn noted(loaded: &Loaded, part: &str) {
    assert!(
        loaded.notes.iter().any(|note| note.contains(part)),
        "{:?} lacks '{part}'",
        loaded.notes
    );
}

/// The shared folder, or `None` after saying so; must be there when `SHEEN_REQUIRE_SHARED=1`.
fn shared(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SHEEN_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    if folder.join("reference/scenes").is_dir() {
        return Some(folder);
    }
    assert!(
        std::env::var_os("SHEEN_REQUIRE_SHARED").is_none_or(|v| v != "1"),
        "no {}",
        folder.display()
    );
    eprintln!("SKIPPED: {test}: no shared folder, set SHEEN_SHARED");
    None
}

const SQUARE: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl white\n";

#[test]
fn a_square_is_two_triangles_that_share_a_diagonal() {
    let loaded = Folder::new().load(format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let triangles = loaded.scene.triangles();
    assert_eq!(
        (triangles[0].points, triangles[1].points),
        ([0, 1, 2], [0, 2, 3])
    );
    assert_eq!(loaded.scene.points().len(), 4);
    noted(&loaded, "nothing emits: the solution is black");
    noted(&loaded, "default camera");
}

#[test]
fn materials_follow_the_conventions() {
    let folder = Folder::new();
    folder.put(
        "m.mtl",
        "newmtl a\nKd .1 .2 .3\nKs .4 .5 .6\nNs 30\nKe 1 2 3\nnewmtl b\nKd 0.25\nKs 0 0 0\nNs 9\n",
    );
    let loaded = folder.load(
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n",
    );
    let scene = loaded.unwrap().scene;
    let [a, b] = scene.materials() else {
        panic!("{:?}", scene.materials())
    };
    assert_eq!(
        (a.name.as_str(), a.diffuse, a.emission),
        ("a", Rgb::new(0.1, 0.2, 0.3), Rgb::new(1.0, 2.0, 3.0))
    );
    assert_eq!(
        a.gloss,
        Gloss::Phong {
            specular: Rgb::new(0.4, 0.5, 0.6),
            exponent: 30.0
        }
    );
    assert!(a.two_sided && !a.emits_from_back);
    assert_eq!((b.diffuse, b.gloss), (Rgb::splat(0.25), Gloss::None));
    assert_eq!(
        (scene.triangles()[0].material, scene.triangles()[1].material),
        (0, 1)
    );
}

#[test]
fn the_last_definition_of_a_material_counts() {
    let folder = Folder::new();
    folder.put(
        "m.mtl",
        "newmtl white\nKd .1 .1 .1\nnewmtl x\nnewmtl white\nKd .2 .2 .2\n",
    );
    let loaded = folder.load(format!("{SQUARE}f 1 2 3\n")).unwrap();
    assert_eq!(loaded.scene.materials().len(), 2);
    assert_eq!(
        loaded.scene.materials()[loaded.scene.triangles()[0].material as usize].diffuse,
        Rgb::splat(0.2)
    );
    noted(&loaded, "'white' is defined again");
}

#[test]
fn equal_positions_become_one_point() {
    let loaded = Folder::new()
        .load("mtllib m.mtl\nusemtl white\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nv -0 0 0\nv 1 1 0\nv 0 1 0\nusemtl lamp\nf -3 -2 -1\n")
        .unwrap();
    assert_eq!(loaded.scene.points().len(), 4);
    assert_eq!(loaded.scene.triangles()[1].points, [0, 2, 3]);
}

#[test]
fn smooth_normals_are_kept_and_flat_ones_are_not() {
    let loaded = Folder::new()
        .load(
            format!("{SQUARE}vn 0 0 1\nvn .6 0 .8\nf 1//1 2//1 3//1\nf 1//2 3//1 4//1\nf 2 4 3\n")
                .replace("f 2 4 3", "v 2 2 2\nf 1 2 5"),
        )
        .unwrap();
    let normals: Vec<_> = loaded.scene.triangles().iter().map(|t| t.normals).collect();
    assert_eq!(normals, [None, Some([1, 0, 0]), None]);
}

#[test]
fn polygons_of_any_shape_are_covered_once() {
    let folder = Folder::new();
    // An L with a hole in its outline's order, seen along each axis and from behind.
    for (axis, reverse) in [
        (0, false),
        (1, false),
        (2, false),
        (0, true),
        (1, true),
        (2, true),
    ] {
        let mut outline = vec![(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)];
        if reverse {
            outline.reverse();
        }
        let mut text = "mtllib m.mtl\nusemtl white\n".to_owned();
        for (x, y) in outline {
            let mut p = [x, y, 0];
            p.rotate_right(axis);
            text.push_str(&format!("v {} {} {}\n", p[0], p[1], p[2]));
        }
        let scene = folder.load(text + "f 1 2 3 4 5 6\n").unwrap().scene;
        let mut sum = glam::Vec3::ZERO;
        let mut total = 0.0;
        for triangle in scene.triangles() {
            let [a, b, c] = scene.corners(triangle);
            sum += (b - a).cross(c - a) * 0.5;
            total += (b - a).cross(c - a).length() * 0.5;
        }
        // 3 + 2 squares; the triangles do not overlap when their areas add up like their vectors.
        assert_eq!(
            (scene.triangles().len(), total, sum.length()),
            (4, 5.0, 5.0),
            "axis {axis}"
        );
    }
}

#[test]
fn a_polygon_with_100000_corners_is_read() {
    let count = 100_000;
    let mut text = "mtllib m.mtl\nusemtl white\n".to_owned();
    let mut face = "f".to_owned();
    for i in 0..count {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        // A wavy outline: neither convex nor a star seen from a corner.
        let radius = 1.0 + 0.2 * (angle * 40.0).sin();
        text.push_str(&format!(
            "v {} 0 {}\n",
            radius * angle.sin(),
            radius * angle.cos()
        ));
        face.push_str(&format!(" {}", i + 1));
    }
    let scene = Folder::new().load(text + &face).unwrap().scene;
    let area: f64 = scene
        .triangles()
        .iter()
        .map(|t| scene.corners(t).map(|p| p.as_dvec3()))
        .map(|[a, b, c]| (b - a).cross(c - a).length() * 0.5)
        .sum();
    // The integral of r²/2; positions are rounded to f32.
    let expected = std::f64::consts::PI * (1.0 + 0.02);
    assert!((area / expected - 1.0).abs() < 1e-4, "{area} {expected}");
}

#[test]
fn line_ends_encodings_comments_and_continuations_are_read() {
    let folder = Folder::new();
    let text = format!("{SQUARE}f 1 2 3 4\n");
    let expected = folder.load(&text).unwrap();
    for variant in [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace("1 2 3 4", "1 2 \\\n 3 4 # a square"),
        format!("\u{FEFF}#comment\n{text}"),
        text.replace(' ', "\t"),
        format!("# {}\n{text}", "x".repeat(10_000_000)),
        format!("{}# {}\n", text, "x".repeat(10_000_000)),
    ] {
        assert_eq!(folder.load(variant).unwrap(), expected);
    }
    let mut latin1 = text.replace("white", "wei?").into_bytes();
    latin1
        .iter_mut()
        .filter(|byte| **byte == b'?')
        .for_each(|byte| *byte = 0xDF);
    let mut library = MTL.replace("white", "wei?").into_bytes();
    library
        .iter_mut()
        .filter(|byte| **byte == b'?')
        .for_each(|byte| *byte = 0xDF);
    folder.put("m.mtl", library);
    let loaded = folder.load(latin1).unwrap();
    noted(&loaded, "Latin-1");
    assert_eq!(loaded.scene.materials()[0].name, "weiß");
}

#[test]
fn row_1_files_that_cannot_be_opened() {
    let folder = Folder::new();
    let options = LoadOptions::default();
    let text = one_line(load_scene(&folder.0.path().join("no.obj"), &options).unwrap_err());
    assert!(text.contains("no.obj: No such file"), "{text}");
    std::fs::create_dir(folder.0.path().join("dir.obj")).unwrap();
    let text = one_line(load_scene(&folder.0.path().join("dir.obj"), &options).unwrap_err());
    assert!(text.contains("dir.obj: is a directory"), "{text}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        symlink("loop.obj", folder.0.path().join("loop.obj")).unwrap();
        one_line(load_scene(&folder.0.path().join("loop.obj"), &options).unwrap_err());
        symlink("/dev/zero", folder.0.path().join("zero.obj")).unwrap();
        let text = one_line(load_scene(&folder.0.path().join("zero.obj"), &options).unwrap_err());
        assert!(text.contains("expected a regular file"), "{text}");
        let secret = folder.put("secret.obj", SQUARE);
        std::fs::set_permissions(&secret, std::fs::Permissions::from_mode(0o0)).unwrap();
        // The administrator may read everything: nothing to test then.
        if std::fs::File::open(&secret).is_err() {
            let text = one_line(load_scene(&secret, &options).unwrap_err());
            assert!(text.contains("ermission denied"), "{text}");
        }
    }
}

#[test]
fn rows_2_and_3_files_that_are_no_scenes() {
    let folder = Folder::new();
    for (name, content, expected) in [
        ("a.obj", "".as_bytes(), "a.obj: empty scene file"),
        ("a.obj", b"x", "empty scene file"),
        ("a.obj", b"\xEF\xBB\xBF", "empty scene file"),
        ("a.MGF", b" \n\n", "empty scene file"),
        ("a.OBJ", b"\x89PNG\r\n\x1a\n", "a PNG image"),
        ("a.obj", b"glTF\x02\0\0\0", "a binary glTF scene"),
        ("a.obj", b"\x89SHEEN\r\n\x01\0\0\0", "a .sheen solution"),
        ("a.mgf", b"{\"asset\": 1}", "JSON"),
        (
            "a.gltf",
            b"{\"asset\": 1}",
            "expected .obj or .mgf: it looks like JSON",
        ),
        ("a", b"v 0 0 0", "expected .obj or .mgf"),
        ("a.png", b"\x89PNG\r\n\x1a\n", "it looks like a PNG image"),
    ] {
        let path = folder.put(name, content);
        let text = one_line(load_scene(&path, &LoadOptions::default()).unwrap_err());
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn rows_7_and_20_faces_that_point_nowhere() {
    for (face, expected) in [
        ("f 0 1 2", "a.obj:7: corner 1: the position index is 0"),
        (
            "f 1 2 9",
            "a.obj:7: corner 3: the position index 9 is out of range, 4 stand before",
        ),
        (
            "f -100 1 2",
            "a.obj:7: corner 1: the position index -100 is out of range",
        ),
        (
            "f 1// 2// 3//",
            "a.obj:7: corner 1: expected v, v/vt, v//vn or v/vt/vn, found '1//'",
        ),
        ("f 1/ 2/ 3/", "a.obj:7: corner 1"),
        (
            "f 1//1 2//1 3//1",
            "a.obj:7: corner 1: the normal index 1 is out of range, 0 stand",
        ),
        (
            "f 1/1 2/1 3/1",
            "a.obj:7: corner 1: the texture coordinate index 1",
        ),
        (
            "f 1 2",
            "a.obj:7: expected at least 3 corners after f, found 2",
        ),
        ("f", "a.obj:7: expected at least 3 corners"),
        ("f 1 2 x", "a.obj:7: corner 3: expected v, v/vt"),
        ("f 1 2 3.5", "found '3.5'"),
        ("f 1 2 99999999999999999999", "a.obj:7: corner 3"),
        ("f 1/1/1/1 2 3", "a.obj:7: corner 1"),
        (
            "vn 0 0 1\nf 1//1 2 3",
            "a.obj:8: 1 of 3 corners have a normal",
        ),
        (
            "f 1 3 2 4",
            "a.obj:7: the outline of the face with 4 corners crosses itself",
        ),
        (
            "usemtl whit\nf 1 2 3",
            "a.obj:7: usemtl 'whit': no mtllib defines it, did you mean 'white'?",
        ),
        ("usemtl", "a.obj:7: expected a material name"),
    ] {
        refused(format!("{SQUARE}{face}\n"), &[expected]);
    }
    refused(
        format!("{SQUARE}f 1 2 {}\n", "x".repeat(10_000_000)),
        &["a.obj:7: corner 3"],
    );
}

#[test]
fn numbers_that_are_none() {
    for (statement, expected) in [
        ("v 1 2", "a.obj:7: expected 3 numbers after v, found 2"),
        ("v 1 2 zwei", "a.obj:7: expected a number, found 'zwei'"),
        ("v 1,5 2 3", "found '1,5'"),
        ("v 1 2 3 0", "weight w"),
        ("v 1 2 3 4 5", "expected 3 numbers after v, found 5"),
        ("vn 1 2", "a.obj:7: expected 3 numbers after vn, found 2"),
    ] {
        refused(format!("{SQUARE}{statement}\n"), &[expected]);
    }
}

#[test]
fn row_12_positions_that_are_not_finite() {
    for bad in ["nan 0 0", "0 inf 0", "0 0 -1e39"] {
        let text = format!("{SQUARE}v {bad}\nf 1 2 3\nf 1 2 5\n");
        refused(&text, &["a.obj:9: ", "a corner is not finite", "--lenient"]);
        let loaded = Folder::new().load_lenient(&text).unwrap();
        assert_eq!(loaded.scene.triangles().len(), 1);
        noted(
            &loaded,
            "1 triangles with corners that are not finite dropped",
        );
    }
}

#[test]
fn row_13_degenerate_and_duplicate_triangles() {
    let text = format!("{SQUARE}f 1 2 3\nf 1 2 2\nf 2 3 1\n");
    refused(&text, &["a.obj:8: ", "span no area"]);
    refused(
        text.replace("f 1 2 2\n", ""),
        &["a.obj:8: ", "same corners", "line 7"],
    );
    let loaded = Folder::new().load_lenient(&text).unwrap();
    assert_eq!(loaded.scene.triangles().len(), 1);
    noted(&loaded, "1 triangles without area dropped");
    noted(&loaded, "1 duplicate triangles dropped");
}

#[test]
fn row_14_normals_that_are_wrong() {
    for (normal, reason) in [
        ("0 0 0", "has no direction"),
        ("nan 0 1", "has no direction"),
        ("0 0 2", "not of unit length"),
        ("0 0 -1", "points away from its face"),
    ] {
        let text = format!("{SQUARE}vn {normal}\nvn 0 0 1\nf 1//1 2//2 3//2\n");
        refused(&text, &["a.obj:9: ", reason]);
        let loaded = Folder::new().load_lenient(&text).unwrap();
        assert_eq!(loaded.scene.triangles()[0].normals, None);
        noted(&loaded, "bad shading normals made flat");
    }
}

#[test]
fn rows_25_to_27_materials_out_of_range() {
    for (material, expected) in [
        (
            "Kd 1.5 0 0",
            "m.mtl:1: material 'white': diffuse + specular + transmitted reflectance is 1.5",
        ),
        (
            "Kd -0.5 0 0",
            "m.mtl:1: material 'white': diffuse reflectance is -0.5",
        ),
        ("Kd nan 0 0", "m.mtl:1: material 'white': diffuse"),
        (
            "Kd .6 0 0\nKs .6 0 0",
            "m.mtl:1: material 'white': diffuse + specular",
        ),
        (
            "Ks .5 .5 .5\nNs -1",
            "m.mtl:1: material 'white': the Phong exponent is -1",
        ),
        ("Ke -1 0 0", "m.mtl:1: material 'white': emission"),
        ("Ke 0 1e38 0", "m.mtl:1: material 'white': emission"),
        ("Ke 0 nan 0", "m.mtl:1: material 'white': emission"),
        ("Kd 1 2", "m.mtl:2: expected 3 numbers after Kd, found 2"),
        (
            "Kd spectral f.rfl",
            "m.mtl:2: expected a number, found 'spectral'",
        ),
        ("Ns", "m.mtl:2: expected 1 number after Ns, found 0"),
        ("newmtl", "m.mtl:2: expected a name after newmtl"),
    ] {
        let folder = Folder::new();
        folder.put("m.mtl", format!("newmtl white\n{material}\n"));
        let text = one_line(folder.load(format!("{SQUARE}f 1 2 3\n")).unwrap_err());
        assert!(text.contains(expected), "'{text}' lacks '{expected}'");
    }
    let folder = Folder::new();
    folder.put("m.mtl", "newmtl white\nKd .9 .9 .9\nKs .9 .9 .9\nNs 10\n");
    let loaded = folder.load_lenient(format!("{SQUARE}f 1 2 3\n")).unwrap();
    noted(&loaded, "material 'white': reflectances scaled by 0.5556");
    folder.put("m.mtl", "Kd 1 1 1\n");
    let text = one_line(folder.load(format!("{SQUARE}f 1 2 3\n")).unwrap_err());
    assert!(
        text.contains("m.mtl:1: 'Kd' stands before the first newmtl"),
        "{text}"
    );
}

#[test]
fn row_28_scenes_without_surfaces_or_light() {
    refused(SQUARE, &["a.obj: ", "no surface"]);
    refused("This is a letter.\nDear reader\n", &["no surface"]);
    let loaded = Folder::new()
        .load(format!("{SQUARE}usemtl lamp\nf 1 2 3\n"))
        .unwrap();
    assert!(
        !loaded
            .notes
            .iter()
            .any(|note| note.contains("nothing emits")),
        "{:?}",
        loaded.notes
    );
}

#[test]
fn libraries_that_are_missing_or_elsewhere() {
    let square = format!("{SQUARE}f 1 2 3\n");
    let text = square.replace("m.mtl", "no.mtl");
    refused(
        &text,
        &["a.obj:1: material library", "no.mtl", "No such file"],
    );
    let loaded = Folder::new().load_lenient(&text).unwrap();
    noted(&loaded, "no.mtl");
    noted(
        &loaded,
        "undefined materials become grey (diffuse 0.5): 'white'",
    );
    assert_eq!(loaded.scene.materials()[0].diffuse, Rgb::splat(0.5));
    for outside in [
        "../../etc/passwd",
        "/etc/passwd",
        "C:\\m.mtl",
        "http://a/b.mtl",
    ] {
        refused(
            square.replace("m.mtl", outside),
            &[
                "a.obj:1: ",
                "is refused: expected a file in the scene's folder",
            ],
        );
    }
    refused(
        square.replace("mtllib m.mtl\n", ""),
        &["a.obj:5: usemtl 'white': the file names no mtllib"],
    );
    let folder = Folder::new();
    folder.put("with space.mtl", MTL);
    folder.put("n.mtl", "newmtl other\n");
    folder
        .load(square.replace("m.mtl", "with space.mtl"))
        .unwrap();
    assert_eq!(
        folder
            .load(square.replace("m.mtl", ".\\n.mtl m.mtl"))
            .unwrap()
            .scene
            .materials()
            .len(),
        3
    );
    folder.put("m.mtl", b"\x89PNG\r\n");
    let text = one_line(folder.load(&square).unwrap_err());
    assert!(
        text.contains("a.obj:1: ") && text.contains("looks like a PNG"),
        "{text}"
    );
}

#[test]
fn what_is_not_represented_is_listed_with_counts() {
    let folder = Folder::new();
    folder.put("m.mtl", "newmtl white\nmap_Kd a.png\nmap_Bump b.png\nd .5\nTf 0 1 0\nNi 1.5\nillum 2\nKa 0 0 0\nnewmtl b\nmap_Kd c.png\nd 1\n");
    let loaded = folder
        .load(format!("{SQUARE}vt 0 0\nvt 1\nl 1 2 3\np 1\ns 1\ncurv 0 1 1 2\nfoo\nf 1/1 2/-1 3/2\nv 0 0 0 1 0 0\ng x\no y\n"))
        .unwrap();
    for note in [
        "textures are not read, the constant values are used: map_Bump (1), map_Kd (2)",
        "transparent materials are opaque here: Tf (1), d (1)",
        "ignored in materials: Ni (1), illum (1)",
        "lines and points have no surface and are left out: l (1), p (1)",
        "smoothing groups are ignored, only normals (vn) make a surface smooth: s (1)",
        "colours at vertices are ignored",
        "free-form curves and surfaces are left out: curv (1)",
        "ignored statements: foo (1)",
    ] {
        noted(&loaded, note);
    }
    let loaded = folder.load(
        SQUARE.replace("usemtl white\n", "") + "f 1 2 3\nf 1 3 4\nusemtl white\nv 1 1 1\nf 1 2 5\n",
    );
    let loaded = loaded.unwrap();
    noted(&loaded, "2 faces without a material become grey");
    let names: Vec<_> = loaded
        .scene
        .triangles()
        .iter()
        .map(|t| t.material)
        .collect();
    assert!(names[0] == names[1] && names[1] != names[2]);
}

#[test]
fn the_reference_scenes_load_in_strict_mode() {
    let Some(shared) = shared("the_reference_scenes_load_in_strict_mode") else {
        return;
    };
    let mut seen = 0;
    let mut failures = Vec::new();
    for entry in std::fs::read_dir(shared.join("reference/scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "obj") {
            seen += 1;
            match load_scene(&path, &LoadOptions::default()) {
                Ok(loaded) => {
                    assert!(
                        loaded.notes.is_empty(),
                        "{}: {:?}",
                        path.display(),
                        loaded.notes
                    );
                    assert!(loaded.scene.cameras()[0].name != "default");
                }
                Err(error) => failures.push(one_line(error)),
            }
        }
    }
    assert!(
        seen >= 7 && failures.is_empty(),
        "{seen} scenes; {failures:#?}"
    );
    let count = |name: &str| {
        let path = shared.join("reference/scenes").join(name);
        load_scene(&path, &LoadOptions::default())
            .unwrap()
            .scene
            .triangles()
            .len()
    };
    assert_eq!((count("cornell.obj"), count("soda_phong.obj")), (38, 30295));
}

#[test]
fn the_reference_mgf_scenes_load_with_their_sidecar() {
    let Some(shared) = shared("the_reference_mgf_scenes_load_with_their_sidecar") else {
        return;
    };
    let scenes = shared.join("reference/scenes");
    let soda = load_scene(&scenes.join("soda.mgf"), &LoadOptions::default()).unwrap();
    assert_eq!(soda.scene.cameras().len(), 2);
    noted(
        &soda,
        "mirrors become the sharpest lobe that the quality resolves",
    );
    noted(
        &soda,
        "clear glass lets visibility rays pass, tinted, and is drawn blended",
    );
    let features = load_scene(&scenes.join("mgf_features.mgf"), &LoadOptions::default()).unwrap();
    noted(&features, "default camera");
}
