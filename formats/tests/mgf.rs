//! The MGF reader against an independent one (`mgf_stats.py`), against Radiance's converter, and against bad input.

#![allow(clippy::unwrap_used, reason = "tests")]

use glam::Vec3;
use proptest::prelude::*;
use sheen_formats::mgf::{self, MgfScene, MgfStats};
use sheen_solver::radiometry::Rgb;
use sheen_solver::scene::{Gloss, Material, Scene, SceneParts, Triangle};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The folder of reference scenes; `None`, loudly, where it is absent and not required.
fn reference_scenes() -> Option<PathBuf> {
    let shared = std::env::var_os("SHEEN_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let folder = shared.join("reference/scenes");
    match folder.canonicalize() {
        Ok(folder) => Some(folder),
        Err(reason) => {
            let required = std::env::var("SHEEN_REQUIRE_SHARED").is_ok_and(|value| value == "1");
            assert!(
                !required,
                "SHEEN_REQUIRE_SHARED=1, but {}: {reason}",
                folder.display()
            );
            eprintln!(
                "SKIPPED: no reference scenes at {}: {reason}",
                folder.display()
            );
            None
        }
    }
}

/// Writes files into a new folder.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

fn read(content: &str) -> MgfScene {
    let folder = folder(&[("scene.mgf", content)]);
    mgf::read(&folder.path().join("scene.mgf")).unwrap()
}

/// The error of reading `scene.mgf`, without the folder.
fn error_of(files: &[(&str, &str)]) -> String {
    let folder = folder(files);
    let error = mgf::read(&folder.path().join("scene.mgf"))
        .unwrap_err()
        .to_string();
    error.replace(
        &format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR),
        "",
    )
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs()) + 1e-300
}

/// By Radiance's primaries.
fn luminance(c: Rgb) -> f64 {
    0.2651 * f64::from(c.r) + 0.6701 * f64::from(c.g) + 0.0648 * f64::from(c.b)
}

fn corners(parts: &SceneParts, triangle: &Triangle) -> [Vec3; 3] {
    triangle.points.map(|index| parts.points[index as usize])
}

fn area(parts: &SceneParts, triangle: &Triangle) -> f64 {
    let [a, b, c] = corners(parts, triangle).map(|corner| corner.as_dvec3());
    (b - a).cross(c - a).length() / 2.0
}

fn total_area(parts: &SceneParts) -> f64 {
    parts
        .triangles
        .iter()
        .map(|triangle| area(parts, triangle))
        .sum()
}

/// Volume on the back of all faces; positive for a closed surface that faces outward.
fn volume(parts: &SceneParts) -> f64 {
    let signed = |triangle: &Triangle| {
        let [a, b, c] = corners(parts, triangle).map(|corner| corner.as_dvec3());
        a.dot(b.cross(c)) / 6.0
    };
    parts.triangles.iter().map(signed).sum()
}

/// Edges that do not have exactly one partner running the other way.
fn open_edges(parts: &SceneParts) -> usize {
    let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for triangle in &parts.triangles {
        for i in 0..3 {
            let (a, b) = (triangle.points[i], triangle.points[(i + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    edges.values().filter(|&&count| count != 0).count()
}

/// Every figure of the independent reader's JSON.
fn assert_same_figures(stats: &MgfStats, expected: &serde_json::Value) {
    let ours = serde_json::to_value(stats).unwrap();
    // Sums run in other orders: only rounding may differ.
    fn compare(place: &str, ours: &serde_json::Value, theirs: &serde_json::Value) {
        use serde_json::Value;
        match (ours, theirs) {
            (Value::Object(ours), Value::Object(theirs)) => {
                let keys =
                    |map: &serde_json::Map<String, Value>| map.keys().cloned().collect::<Vec<_>>();
                assert_eq!(keys(ours), keys(theirs), "{place}");
                theirs
                    .iter()
                    .for_each(|(key, value)| compare(&format!("{place}.{key}"), &ours[key], value));
            }
            (Value::Array(ours), Value::Array(theirs)) => {
                assert_eq!(ours.len(), theirs.len(), "{place}");
                ours.iter()
                    .zip(theirs)
                    .for_each(|(a, b)| compare(place, a, b));
            }
            (Value::Number(a), Value::Number(b)) => {
                assert!(
                    close(a.as_f64().unwrap(), b.as_f64().unwrap(), 1e-9),
                    "{place}: {a} here, {b} there"
                );
            }
            _ => panic!("{place}: {ours} here, {theirs} there"),
        }
    }
    compare("stats", &ours, expected);
}

/// Facets keep the exact area of each material, up to single precision and polygons that are not quite flat.
fn assert_areas_kept(scene: &MgfScene, relative: f64) {
    let mut areas: BTreeMap<String, f64> = BTreeMap::new();
    for triangle in &scene.parts.triangles {
        let name = &scene.parts.materials[triangle.material as usize].name;
        let written = name
            .strip_suffix(".2")
            .or(name.strip_suffix(".3"))
            .unwrap_or(name);
        *areas.entry(written.to_owned()).or_default() += area(&scene.parts, triangle);
    }
    for (name, &exact) in &scene.stats.area_per_material {
        let found = areas.get(name).copied().unwrap_or(0.0);
        assert!(
            close(found, exact, relative),
            "{name}: {found} in triangles, {exact} exactly"
        );
    }
}

#[test]
fn reference_scenes_have_the_figures_of_the_independent_reader() {
    let Some(folder) = reference_scenes() else {
        return;
    };
    for name in ["mgf_features", "soda"] {
        let started = Instant::now();
        let scene = mgf::read(&folder.join(format!("{name}.mgf"))).unwrap();
        let expected = std::fs::read_to_string(folder.join(format!("{name}.stats.json"))).unwrap();
        assert_same_figures(&scene.stats, &serde_json::from_str(&expected).unwrap());
        assert_areas_kept(&scene, 1e-3);
        let count = scene.parts.triangles.len();
        let smooth = scene
            .parts
            .triangles
            .iter()
            .filter(|triangle| triangle.normals.is_some())
            .count();
        eprintln!(
            "{name}: {count} triangles ({smooth} smooth), {} points, {} materials, {:?}, notes {:#?}",
            scene.parts.points.len(),
            scene.parts.materials.len(),
            started.elapsed(),
            scene.notes
        );
        // Facets stay where their surfaces are: points lie outside by some per cent of a radius at most.
        let bounds = |fold: fn(Vec3, Vec3) -> Vec3| {
            scene
                .parts
                .points
                .iter()
                .copied()
                .reduce(fold)
                .unwrap()
                .to_array()
        };
        let diagonal =
            0.01 * (Vec3::from(bounds(Vec3::max)) - Vec3::from(bounds(Vec3::min))).length();
        for (found, exact) in [
            (bounds(Vec3::min), scene.stats.bbox_min),
            (bounds(Vec3::max), scene.stats.bbox_max),
        ] {
            for (found, exact) in found.into_iter().zip(exact) {
                assert!(
                    (found - exact as f32).abs() < diagonal,
                    "{name}: {found} {exact}"
                );
            }
        }
        // Strict: what the reader makes is valid as it is.
        let (_, repairs) = Scene::new(scene.parts, false).unwrap();
        assert_eq!(repairs, Vec::<String>::new());
        if name == "soda" {
            assert!((15_000..30_000).contains(&count), "{count} triangles");
        }
    }
}

/// `name → key → numbers` of an MTL file.
fn read_mtl(path: &Path) -> BTreeMap<String, BTreeMap<String, Vec<f64>>> {
    let mut materials: BTreeMap<String, BTreeMap<String, Vec<f64>>> = BTreeMap::new();
    let mut name = String::new();
    for line in std::fs::read_to_string(path).unwrap().lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("newmtl") => {
                name = words.next().unwrap().to_owned();
                materials.entry(name.clone()).or_default();
            }
            Some(key) => {
                let values = words.map(|word| word.parse().unwrap()).collect();
                materials
                    .get_mut(&name)
                    .unwrap()
                    .insert(key.to_owned(), values);
            }
            None => {}
        }
    }
    materials
}

#[test]
fn soda_has_the_materials_that_radiances_converter_makes() {
    let Some(folder) = reference_scenes() else {
        return;
    };
    let scene = mgf::read(&folder.join("soda.mgf")).unwrap();
    let ours: BTreeMap<&str, &Material> = scene
        .parts
        .materials
        .iter()
        .map(|material| (material.name.as_str(), material))
        .collect();
    let theirs = read_mtl(&folder.join("soda_phong.mtl"));
    // The MTL file leaves glass out.
    let glass: Vec<&str> = ours
        .values()
        .filter(|m| m.is_glass())
        .map(|m| m.name.as_str())
        .collect();
    assert_eq!(glass, ["clear_plastic", "normal_glass"]);
    let opaque: Vec<&str> = ours
        .values()
        .filter(|m| !m.is_glass())
        .map(|m| m.name.as_str())
        .collect();
    assert_eq!(
        opaque,
        theirs.keys().map(String::as_str).collect::<Vec<_>>()
    );
    for (name, values) in &theirs {
        let material = ours[name.as_str()];
        // Radiance's metals have one colour for rd and rs, which its converter averages. Here only this one has two:
        // compared without colour.
        let grey = name == "white_glaze";
        let same = |key: &str, found: Rgb| {
            let expected = values.get(key).cloned().unwrap_or(vec![0.0; 3]);
            let found = if grey {
                Rgb::splat(luminance(found) as f32)
            } else {
                found
            };
            for (found, expected) in found.to_array().into_iter().zip(expected) {
                // Their colours have passed through six decimals of text, twice.
                let ok = (f64::from(found) - expected).abs() <= 1e-3 * expected + 1e-6;
                assert!(ok, "{name} {key}: {found} here, {expected} there");
            }
        };
        same("Kd", material.diffuse);
        same("Ke", material.emission);
        assert!(material.two_sided && material.emits_from_back);
        match material.gloss {
            Gloss::Ward {
                specular,
                roughness,
            } => {
                same("Ks", specular);
                let roughness = f64::from(roughness).max(0.03);
                let exponent = 1.0 / (2.0 * roughness * roughness) - 2.0;
                assert!(close(exponent, values["Ns"][0], 1e-3), "{name}: {exponent}");
            }
            _ => assert!(!values.contains_key("Ks"), "{name}"),
        }
    }
}

#[test]
fn a_material_redefined_is_another_material() {
    let scene = read(
        "m a =\nrd .5\nv o =\nsph o 1\nm b = a\nrs .1 .05\nsph o 2\nm a =\nrd .2\nsph o 3\nm a =\nrd .5\nsph o 4\n\
         m\nrd .3\nsph o 5\nm b\nrs .1 .07\nsides 1\nsph o 6\n",
    );
    let names: Vec<&str> = scene
        .parts
        .materials
        .iter()
        .map(|m| m.name.as_str())
        .collect();
    assert_eq!(names, ["a", "b", "a.2", "(unnamed)", "b.2"]);
    let b = &scene.parts.materials[4];
    assert_eq!(
        b.gloss,
        Gloss::Ward {
            specular: Rgb::splat(0.1),
            roughness: 0.07
        }
    );
    assert_eq!(
        (b.diffuse, b.two_sided, b.emits_from_back),
        (Rgb::splat(0.5), false, false)
    );
    assert!(
        scene.parts.materials[0].two_sided,
        "the default is two sides"
    );
}

#[test]
fn units_and_colours() {
    let scene = read(
        "m lamp =\nc\ncct 2856\ned 1000\nv o =\nsph o 1\nm grey =\nc\ncspec 380 780 1 1 1\nrd .5\nsph o 2\n\
         c blue =\ncxy .2 .2\nc yellow =\ncxy .4 .45\nc\ncmix .5 blue .5 yellow\nm mixed =\nrd 0.4\nsph o 3\n\
         m glass =\nts .9 .1\nir 1.5 0\nsides 1\ntd .05\nsph o 4\n",
    );
    let [lamp, grey, mixed, glass] = &scene.parts.materials[..] else {
        panic!("{:?}", scene.parts.materials)
    };
    assert!(
        close(luminance(lamp.emission), 1000.0 / (179.0 * PI), 1e-4),
        "{lamp:?}"
    );
    assert!(lamp.emission.r > lamp.emission.g && lamp.emission.g > lamp.emission.b);
    assert!(
        (grey.diffuse.r - 0.5).abs() < 1e-6 && (grey.diffuse.b - 0.5).abs() < 1e-6,
        "{grey:?}"
    );
    assert!(close(luminance(mixed.diffuse), 0.4, 1e-4), "{mixed:?}");
    assert!(close(luminance(glass.transmission), 0.9, 1e-4), "{glass:?}");
    assert!((glass.transmission.g - 0.9).abs() < 0.5 && glass.is_glass());
    for expected in ["td 0.05", "roughness 0.1", "ir 1.5 0", "sides 1"] {
        assert!(
            scene.notes.iter().any(|note| note.contains(expected)),
            "{expected}: {:?}",
            scene.notes
        );
    }
}

#[test]
fn curved_surfaces_are_closed_and_face_outward() {
    let torus = "v c =\np 1 2 3\nn 0 1 1\ntorus c .2 .6\n";
    let prism = "v a =\nv b =\np 1 0 0\nv c =\np 1 1 0\nv d =\np .6 .3 0\nprism a b c d 2\n";
    let pot = "v a =\nn 0 0 -1\nring a 0 1\nv b =\np 0 0 1\nn 0 0 1\nv c =\np 0 0 3\ncyl a 1 b\ncone b 1 c 0\n";
    let exact = [
        ("v o =\np 1 2 3\nsph o .5\n", PI / 6.0),
        (torus, 2.0 * PI * PI * 0.4 * 0.04),
        (prism, 2.0 * 0.35),
        (pot, PI * (1.0 + 2.0 / 3.0)),
    ];
    for (content, volume_exact) in exact {
        for mirror in ["", "-mx", "-s -1", "-my -rx 30 -mz -mx -t 1 2 3 -s 100"] {
            let content = if mirror.is_empty() {
                content.to_owned()
            } else {
                format!("xf {mirror}\n{content}xf\n")
            };
            let scale = if mirror.contains("100") {
                100.0_f64
            } else {
                1.0
            };
            let scene = read(&content);
            assert_eq!(open_edges(&scene.parts), 0, "{content}");
            let relative = volume(&scene.parts) / (volume_exact * scale.powi(3));
            // Facets of the exact area enclose a little less than the exact volume.
            assert!((0.95..1.01).contains(&relative), "{content}: {relative}");
            assert!(
                close(total_area(&scene.parts), scene.stats.area_total, 1e-5),
                "{content}"
            );
            Scene::new(scene.parts, false).unwrap();
        }
    }
}

#[test]
fn negative_radii_and_lengths_face_inward() {
    for content in [
        "v o =\nsph o -1\n",
        "v c =\nn 0 1 1\ntorus c -.2 -.6\n",
        "v a =\nv b =\np 1 0 0\nv c =\np 1 1 0\nprism a b c -1\n",
        "v a =\nn 0 0 1\nring a 0 1\nv b =\np 0 0 1\nn 0 0 -1\ncyl a -1 b\nring b 0 1\n",
    ] {
        let scene = read(content);
        assert_eq!(open_edges(&scene.parts), 0, "{content}");
        assert!(volume(&scene.parts) < -0.1, "{content}");
        Scene::new(scene.parts, false).unwrap();
    }
}

#[test]
fn normals_are_exact() {
    let scene = read("v o =\np 1 2 3\nsph o -.5\n");
    for triangle in &scene.parts.triangles {
        for (point, normal) in triangle.points.into_iter().zip(triangle.normals.unwrap()) {
            let outward =
                (scene.parts.points[point as usize] - Vec3::new(1.0, 2.0, 3.0)).normalize();
            assert!((outward + scene.parts.normals[normal as usize]).length() < 1e-5);
        }
    }
    // A cone whose slope is one: normals at 45 degrees.
    let scene = read("v a =\nv b =\np 0 0 1\ncone a 2 b 1\n");
    assert!(
        scene
            .parts
            .normals
            .iter()
            .all(|normal| (normal.z - 0.5_f32.sqrt()).abs() < 1e-6)
    );
}

#[test]
fn vertex_normals_smooth_a_face_and_turn_it_where_they_oppose_it() {
    let face =
        |n: &str| format!("v a =\nn {n}\nv b =\np 1 0 0\nn {n}\nv c =\np 0 1 0\nn {n}\nf a b c\n");
    let up = read(&face("0 .5 1"));
    assert!(up.parts.triangles[0].normals.is_some() && up.parts.normals[0].z > 0.0);
    let down = read(&face("0 .5 -1"));
    let [a, b, c] = corners(&down.parts, &down.parts.triangles[0]);
    assert!((b - a).cross(c - a).z < 0.0 && down.parts.triangles[0].normals.is_some());
    assert!(
        read(&face("0 0 1")).parts.triangles[0].normals.is_none(),
        "flat as it is"
    );
    assert!(
        read(&face("1 0 0")).parts.triangles[0].normals.is_none(),
        "on neither side"
    );
}

#[test]
fn transforms_nest_as_radiances_do() {
    // -i ends an array: the last rotation applies once, whatever the index.
    let scene = read("v o =\np 1 0 0\nxf -a 3 -t 1 0 0 -i 1 -rz 90\nxf -s 2\nsph o .25\nxf\nxf\n");
    let stats = &scene.stats;
    assert_eq!(stats.surface_total, 3);
    for (found, expected) in stats
        .bbox_min
        .iter()
        .chain(&stats.bbox_max)
        .zip([-0.5, 1.5, -0.5, 0.5, 4.5, 0.5])
    {
        assert!((found - expected).abs() < 1e-12, "{stats:?}");
    }
}

#[test]
fn includes_are_relative_to_the_including_file() {
    let folder = folder(&[("scene.mgf", "i 'sub dir/a.mgf' -t 0 0 1 -a 2 -t 1 0 0\r\n")]);
    std::fs::create_dir(folder.path().join("sub dir")).unwrap();
    std::fs::write(folder.path().join("sub dir/a.mgf"), "i b.mgf\n").unwrap();
    std::fs::write(
        folder.path().join("sub dir/b.mgf"),
        b"m caf\xe9 =\nv o =\nsph o .5\n",
    )
    .unwrap();
    let scene = mgf::read(&folder.path().join("scene.mgf")).unwrap();
    assert_eq!(scene.stats.surfaces["sph"], 2);
    assert_eq!(scene.stats.entities["sph"], 1);
    assert_eq!(scene.parts.materials[0].name, "café");
    assert_eq!(
        (scene.stats.bbox_min, scene.stats.bbox_max),
        ([-0.5, -0.5, 0.5], [1.5, 0.5, 1.5])
    );
}

#[test]
fn what_is_left_out_is_noted_with_its_line() {
    let scene =
        read("# c\nv o =\nbsdf x\nies lamp.ies -m 2\no\nsph o 1\nsph o 0\no name\ncone o 1 o 2\n");
    let text = scene.notes.join("\n");
    for expected in [
        "scene.mgf:3: unknown entity 'bsdf'",
        "scene.mgf:4: luminaire file 'lamp.ies'",
        "scene.mgf:5: 'o' ends",
        "1 objects",
        "1 surfaces without area",
        "scene.mgf:9: a cone without height",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let mut many = String::from("v o =\nsph o 1\n");
    (0..1000).for_each(|i| writeln!(many, "unknown{i}").unwrap());
    let notes = read(&many).notes;
    assert_eq!(
        (notes.len(), notes[10].as_str()),
        (11, "990 more unknown entities ignored")
    );
}

#[test]
fn duplicates_and_slivers_are_dropped() {
    let scene = read(
        "v a =\nv b =\np 1 0 0\nv c =\np 0 1 0\nf a b c\nf b c a\nv d =\np 1e-30 0 0\nv e =\np 1 1e-30 0\nf d b c\n\
         v f =\np 5 5 5\nv g =\np 5 5.0000000001 5\nv h =\np 5 5 5.0000000001\nf f g h\n",
    );
    assert_eq!(scene.parts.triangles.len(), 2, "{:?}", scene.notes);
    assert!(
        scene.notes.iter().any(|note| note.contains("1 duplicate")),
        "{:?}",
        scene.notes
    );
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.contains("1 triangles without area")),
        "{:?}",
        scene.notes
    );
}

#[test]
fn faults_name_file_and_line() {
    let vertices = "v a =\nv b =\np 1 0 0\nv c =\np 0 1 0\nn 0 0 1\n";
    for (line, message) in [
        ("p 1 2", "expected 'p x y z', found 2 arguments"),
        (
            "p 1 2 nan",
            "p: expected a finite number for z, found 'nan'",
        ),
        (
            "p 1 inf 2",
            "p: expected a finite number for y, found 'inf'",
        ),
        (
            "n 1e999 0 0",
            "n: expected a finite number for x, found '1e999'",
        ),
        ("p 1 2 3x", "p: expected a finite number for z, found '3x'"),
        ("v x = y", "v: vertex 'y' is not defined above this line"),
        (
            "v x y",
            "expected 'v', 'v name' or 'v name = [template]', found 2 arguments and no '=' after the name",
        ),
        ("m x", "m: material 'x' is not defined above this line"),
        ("c x", "c: colour 'x' is not defined above this line"),
        ("rd", "expected 'rd reflectance', found 0 arguments"),
        (
            "rs .5",
            "expected 'rs reflectance roughness', found 1 arguments",
        ),
        (
            "ed bright",
            "ed: expected a finite number for the emittance, found 'bright'",
        ),
        ("sides 3", "sides: expected 1 or 2, found '3'"),
        ("cxy .5 0", "cxy: expected a chromaticity"),
        ("cxy .7 .7", "cxy: expected a chromaticity"),
        (
            "cct 300",
            "cct: expected a temperature of at least 1000 K, found 300",
        ),
        (
            "cspec .38 .78 1 1 1",
            "cspec: expected some visible light within 380..780 nm, found none in 0.38..0.78",
        ),
        (
            "cspec 700 400 1 1",
            "cspec: expected the shorter wavelength first",
        ),
        (
            "cspec 400 700 1",
            "expected 'cspec shortest longest value value ...', found 3 arguments",
        ),
        (
            "cmix 1 a",
            "expected 'cmix weight1 colour1 weight2 colour2 ...', found 2 arguments",
        ),
        (
            "cmix 1 a 1 b",
            "cmix: colour 'a' is not defined above this line",
        ),
        (
            "f a b",
            "expected 'f v1 v2 v3 ...' with at least 3 vertices a loop",
        ),
        ("f a b zz", "f: vertex 'zz' is not defined above this line"),
        (
            "fh a b c - a b",
            "expected 'fh v1 v2 v3 ... - h1 h2 h3 ...' with at least 3 vertices a loop",
        ),
        ("sph a", "expected 'sph centre radius', found 1 arguments"),
        (
            "cyl a b 1",
            "cyl: expected a finite number for the radius, found 'b'",
        ),
        (
            "cone a 1 b -1",
            "cone: expected radii of one sign, found both",
        ),
        (
            "ring a 0 1",
            "ring: expected vertex 'a' to have a normal (n)",
        ),
        (
            "ring c 2 1",
            "ring: expected 0 ≤ inner radius < outer radius",
        ),
        (
            "torus c 2 1",
            "torus: expected the inner radius first, then the outer one",
        ),
        ("prism a b c 0", "prism: expected a length other than 0"),
        (
            "prism a b 1",
            "expected 'prism v1 v2 v3 ... length', found 3 arguments",
        ),
        ("prism a a a 1", "prism: expected an end face with an area"),
        ("xf", "'xf' ends a transform, but none is open"),
        (
            "xf -t 1 2 3",
            "this 'xf' is still open at the end of the file: expected a line 'xf'",
        ),
        (
            "xf -q\nxf",
            "expected -t, -rx, -ry, -rz, -s, -mx, -my, -mz, -i or -a, found '-q'",
        ),
        ("xf -t 1 2\nxf", "xf: expected a number for -t"),
        ("xf -s 0\nxf", "-s: expected a scale factor other than 0"),
        (
            "xf -a 2.5\nxf",
            "-a: expected a whole number of at least 1, found '2.5'",
        ),
        (
            "xf -i -1\nxf",
            "-i: expected a whole number of at least 0, found '-1'",
        ),
        (
            "xf -i 1000000000000 -s 2\nxf",
            "the transform grows or shrinks beyond what numbers can hold",
        ),
        ("xf -s 1e39\nsph b 1\nxf", ""),
        (
            "sph a 1e39",
            "the radius becomes 1000000000000000000000000000000000000000: beyond what single precision holds",
        ),
        (
            "m brass =\nm bras",
            "m: material 'bras' is not defined above this line, did you mean 'brass'?",
        ),
        ("i", "expected 'i file [transform]', found 0 arguments"),
        ("i missing.mgf", "cannot read the included 'missing.mgf'"),
        ("i .", "cannot read the included '.': expected a file"),
        (
            "ies",
            "expected 'ies file [-m multiplier] [transform]', found 0 arguments",
        ),
    ] {
        let error = error_of(&[("scene.mgf", &format!("{vertices}{line}\n"))]);
        let number = if message.is_empty() || line.contains("brass") {
            8
        } else {
            7
        };
        assert!(
            error.starts_with(&format!("scene.mgf:{number}: {message}")),
            "{line}: {error}"
        );
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn include_recursion_is_refused_at_its_line() {
    let error = error_of(&[
        ("scene.mgf", "# x\ni a.mgf\n"),
        ("a.mgf", "v o =\n\ni ./scene.mgf -t 1 0 0\n"),
    ]);
    assert_eq!(
        error,
        "a.mgf:3: './scene.mgf' includes itself (recursion of 'i')"
    );
    let error = error_of(&[("scene.mgf", "i a.mgf\n"), ("a.mgf", "v o =\nsph o\n")]);
    assert_eq!(
        error,
        "a.mgf:2: expected 'sph centre radius', found 1 arguments"
    );
}

#[test]
fn endless_arrays_are_refused_quickly() {
    let started = Instant::now();
    for content in [
        "v o =\nxf -a 1000000000 -t 1 0 0\nsph o 1\nxf\n",
        "v o =\nxf -a 18446744073709551615 -t 1 0 0 -a 18446744073709551615\nxf\n",
        "v o =\nxf -a 3000 -a 3000\nxf -a 2\nsph o 1\nxf\nxf\n",
    ] {
        let error = error_of(&[("scene.mgf", content)]);
        assert!(error.starts_with("scene.mgf:2: an array of "), "{error}");
    }
    let nested = format!(
        "{}{}",
        "xf -t 1 0 0\n".repeat(100_000),
        "xf\n".repeat(100_000)
    );
    let error = error_of(&[("scene.mgf", &nested)]);
    assert_eq!(
        error,
        "scene.mgf:201: transforms and includes are nested more than 200 deep"
    );
    // Each file includes the next one twice.
    let chain: Vec<(String, String)> = (0..60)
        .map(|i| (format!("{i}.mgf"), format!("i {}.mgf\ni {0}.mgf\n", i + 1)))
        .collect();
    let mut files: Vec<(&str, &str)> = chain
        .iter()
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    files.extend([("60.mgf", "v o =\n"), ("scene.mgf", "i 0.mgf\n")]);
    let error = error_of(&files);
    assert!(error.contains(": more than 100000 includes"), "{error}");
    assert!(
        started.elapsed() < Duration::from_secs(60),
        "{:?}",
        started.elapsed()
    );
}

#[test]
fn a_large_scene_has_round_large_things_and_coarse_small_ones() {
    let count = |radius: f64| {
        let scene = read(&format!(
            "v o =\nv x =\np 100 0 0\nf o x x\nsph o {radius}\n"
        ));
        scene.parts.triangles.len()
    };
    assert_eq!(count(0.01), 24);
    assert!(count(1.0) > 24 && count(10.0) > count(1.0) && count(50.0) < 1200);
}

/// A file like the reference's checklist, so that mutations reach every entity.
const SEED: &str = "m grey =\nsides 1\nrd .5\nm lamp = grey\nc\ncct 3000\ned 1000\nc w =\ncspec 400 700 1 2 3\nc\n\
cmix 1 w 2 w\nrs .1 .05\nts .1 0\nxf -mx -t 1 0 0 -a 4 -rz 90 -a 3 -t 0 0 1\nv a =\np 0 0 0\nv b = a\np 1 0 0\nv c =\n\
p 1 1 0\nv d =\np 0 1 0\nf a b c d\no ball\nxf -t 0 0 .5\nsph a .1\nxf\ncyl a .05 c\ncone a .05 d .02\nv r =\n\
p .2 .2 .2\nn 1 1 1\nring r 0 .1\ntorus r .1 .2\no\nxf\nv h0 =\np .2 .2 0\nv h1 =\np .2 .8 0\nv h2 =\np .8 .5 0\n\
fh a b c d - h0 h1 h2\nprism a b c .7\nprism a c b -.3\nxf -i 3 -rz 10 -i 1 -s .5\nsph a .2\nxf\ni scene.mgf\nies x\n";

/// Reads whatever it is; only its duration and the absence of panics count.
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.mgf");
    std::fs::write(&path, bytes).unwrap();
    let started = Instant::now();
    match mgf::read(&path) {
        Ok(scene) => drop(Scene::new(scene.parts, true)),
        Err(error) => prop_assert!(!error.to_string().is_empty()),
    }
    prop_assert!(
        started.elapsed() < Duration::from_secs(20),
        "{:?}",
        started.elapsed()
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        survives(&bytes)?;
    }

    #[test]
    fn random_entities_never_panic(
        words in proptest::collection::vec(
            prop::sample::select(SEED.split(' ').flat_map(|w| w.split_inclusive('\n')).collect::<Vec<_>>()), 0..120),
    ) {
        survives(words.join(" ").as_bytes())?;
    }

    #[test]
    fn mutations_never_panic(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..12),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = SEED.replace("i scene.mgf\n", "").into_bytes();
        for (place, value, kind) in edits {
            let at = place.index(bytes.len());
            match kind {
                0 => bytes[at] = value,
                1 => bytes[at] = b"0123456789.-e \n"[usize::from(value) % 15],
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b"0123456789.-e \n"[usize::from(value) % 15]),
            }
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        survives(&bytes)?;
    }

    /// Outlines and holes whose corners go round their centre once do not cross, however concave they are.
    #[test]
    fn star_shaped_faces_with_holes_are_covered(
        outline in proptest::collection::vec(3..9_u8, 3..60),
        holes in proptest::collection::vec((proptest::collection::vec(1..8_u8, 3..12), any::<bool>()), 0..4),
        tilt in 0..360_u16,
    ) {
        let mut text = String::new();
        let mut face = String::from("fh");
        let mut add = |radii: &[u8], center: (f64, f64), scale: f64, reversed: bool| {
            let loop_index = text.len();
            let mut names: Vec<String> = Vec::new();
            for (index, &radius) in radii.iter().enumerate() {
                let (sine, cosine) = (2.0 * PI * index as f64 / radii.len() as f64).sin_cos();
                let (x, y) = (center.0 + scale * f64::from(radius) * cosine, center.1 + scale * f64::from(radius) * sine);
                writeln!(text, "v v{loop_index}.{index} =\np {x} {y} 1").unwrap();
                names.push(format!(" v{loop_index}.{index}"));
            }
            if reversed {
                names.reverse();
            }
            names.iter().for_each(|name| face.push_str(name));
            face.push_str(" -");
        };
        // Even three corners at radius 3 leave a circle of radius 1.5 around the centre: room for four holes.
        add(&outline, (0.0, 0.0), 1.0, false);
        for ((radii, reversed), (x, y)) in holes.iter().zip([(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)]) {
            add(radii, (x, y), 0.05, *reversed);
        }
        let face = face.trim_end_matches(" -");
        let scene = read(&format!("xf -rx {tilt} -ry 20\n{text}{face}\nxf\n"));
        prop_assert!(scene.notes.is_empty(), "{:?}", scene.notes);
        let (found, exact) = (total_area(&scene.parts), scene.stats.area_total);
        prop_assert!(close(found, exact, 1e-5), "{found} in triangles, {exact} exactly");
        prop_assert_eq!(open_edges(&scene.parts), outline.len() + holes.iter().map(|(radii, _)| radii.len()).sum::<usize>());
    }

    #[test]
    fn random_polygons_never_panic(
        points in proptest::collection::vec((-9..9_i8, -9..9_i8, -1..1_i8), 3..40),
        hole in proptest::collection::vec((-4..4_i8, -4..4_i8, 0..1_i8), 3..12),
    ) {
        let mut text = String::new();
        let mut names = |prefix: char, points: &[(i8, i8, i8)]| {
            let mut names = String::new();
            for (index, (x, y, z)) in points.iter().enumerate() {
                writeln!(text, "v {prefix}{index} =\np {x} {y} {z}").unwrap();
                write!(names, " {prefix}{index}").unwrap();
            }
            names
        };
        let (outline, hole) = (names('o', &points), names('h', &hole));
        write!(text, "f{outline}\nfh{outline} -{hole}\n").unwrap();
        survives(text.as_bytes())?;
    }
}
