//! Facts about the scenes in this folder: they are what the generator writes, and they are sound input.
//!
//! The checks read the text of the files, not the generator's own data.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its input fails"
)]

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3, dvec2};
use sheen_scenes::GeneratedScene;

/// What the checks need of an MTL entry.
#[derive(Clone, Copy, Default)]
struct Material {
    kd: DVec3,
    ks: DVec3,
    ns: f64,
    ke: DVec3,
}

struct Face {
    object: usize,
    material: String,
    corners: Vec<usize>,
    normals: Vec<usize>,
}

/// One scene, read back from its text.
struct Parsed {
    name: &'static str,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    materials: HashMap<String, Material>,
    faces: Vec<Face>,
    cameras: usize,
}

impl Parsed {
    /// A face's triangles: corners and, where smooth, normals.
    fn triangles(&self) -> impl Iterator<Item = (&Face, [usize; 3])> {
        self.faces
            .iter()
            .flat_map(|face| (1..face.corners.len() - 1).map(move |k| (face, [0, k, k + 1])))
    }

    fn points_of(&self, face: &Face, triangle: [usize; 3]) -> [DVec3; 3] {
        triangle.map(|k| self.points[face.corners[k]])
    }

    fn glossy_patches(&self) -> usize {
        self.faces
            .iter()
            .filter(|f| self.materials[&f.material].ks != DVec3::ZERO)
            .count()
    }
}

fn text<'a>(scene: &'a GeneratedScene, extension: &str) -> &'a str {
    let name = format!("{}.{extension}", scene.name);
    &scene
        .files
        .iter()
        .find(|(file, _)| *file == name)
        .expect("every scene has this file")
        .1
}

fn vector(words: &[&str]) -> DVec3 {
    let x: Vec<f64> = words.iter().map(|w| w.parse().unwrap()).collect();
    DVec3::from_slice(&x)
}

fn parse(scene: &GeneratedScene) -> Parsed {
    let mut materials = HashMap::new();
    let mut name = String::new();
    for line in text(scene, "mtl").lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let Some((&key, values)) = words.split_first() else {
            continue;
        };
        if key == "newmtl" {
            name = values[0].to_owned();
        }
        let material: &mut Material = materials.entry(name.clone()).or_default();
        match key {
            "newmtl" => {}
            "Kd" => material.kd = vector(values),
            "Ks" => material.ks = vector(values),
            "Ke" => material.ke = vector(values),
            "Ns" => material.ns = values[0].parse().unwrap(),
            other => panic!("{}: {other} in the MTL", scene.name),
        }
    }
    let mut parsed = Parsed {
        name: scene.name,
        points: Vec::new(),
        normals: Vec::new(),
        materials,
        faces: Vec::new(),
        cameras: text(scene, "toml").matches("[[camera]]").count(),
    };
    let (mut object, mut material) = (0, String::new());
    for line in text(scene, "obj").lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        match words[0] {
            "v" => parsed.points.push(vector(&words[1..])),
            "vn" => parsed.normals.push(vector(&words[1..])),
            "o" => object += 1,
            "usemtl" => material = words[1].to_owned(),
            "f" => {
                let index = |word: &str| word.parse::<usize>().unwrap() - 1;
                let (corners, normals) = words[1..]
                    .iter()
                    .map(|w| w.split_once("//").unwrap_or((w, "")))
                    .unzip::<_, _, Vec<_>, Vec<_>>();
                parsed.faces.push(Face {
                    object,
                    material: material.clone(),
                    corners: corners.into_iter().map(index).collect(),
                    normals: normals
                        .into_iter()
                        .filter(|n| !n.is_empty())
                        .map(index)
                        .collect(),
                });
            }
            "#" | "mtllib" => {}
            other => panic!("{}: {other} in the OBJ", scene.name),
        }
    }
    parsed
}

fn all() -> Vec<Parsed> {
    sheen_scenes::all().iter().map(parse).collect()
}

#[test]
fn the_folder_holds_what_the_generator_writes() {
    for scene in sheen_scenes::all() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene.name);
        for (file, text) in &scene.files {
            let on_disk = fs::read_to_string(folder.join(file)).unwrap();
            assert!(
                on_disk == *text,
                "{}/{file} differs: run generate-scenes",
                scene.name
            );
        }
    }
}

#[test]
fn faces_are_flat_and_not_degenerate() {
    for scene in all() {
        for (face, triangle) in scene.triangles() {
            let [a, b, c] = scene.points_of(face, triangle);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let height = (b - a).cross(c - a).length() / longest;
            // Ten times the grid on which positions are rounded.
            assert!(
                height > 1e-4,
                "{}: sliver {a} {b} {c}, height {height}",
                scene.name
            );
        }
        for face in scene.faces.iter().filter(|f| f.corners.len() == 4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| scene.points[face.corners[k]]);
            let off = (b - a).cross(c - a).normalize().dot(d - a).abs();
            assert!(
                off < 5e-5,
                "{}: bent quad {a} {b} {c} {d} by {off}",
                scene.name
            );
            // Convex: both diagonals' triangles look the same way.
            let n = (c - a).cross(d - b);
            assert!((b - a).cross(c - b).dot(n) > 0.0 && (d - c).cross(a - d).dot(n) > 0.0);
        }
    }
}

#[test]
fn normals_are_unit_and_on_the_side_of_their_face() {
    for scene in all() {
        for n in &scene.normals {
            assert!(
                (n.length() - 1.0).abs() < 2e-5,
                "{}: normal {n}",
                scene.name
            );
        }
        for (face, triangle) in scene.triangles().filter(|(f, _)| !f.normals.is_empty()) {
            let [a, b, c] = scene.points_of(face, triangle);
            let front = (b - a).cross(c - a).normalize();
            for n in triangle.map(|k| scene.normals[face.normals[k]]) {
                assert!(
                    n.dot(front) > 0.3,
                    "{}: {n} on a face of normal {front} at {a}",
                    scene.name
                );
            }
        }
    }
}

#[test]
fn equal_positions_are_one_vertex_and_all_are_used() {
    for scene in all() {
        let distinct: HashSet<_> = scene
            .points
            .iter()
            .map(|p| p.to_array().map(f64::to_bits))
            .collect();
        assert_eq!(distinct.len(), scene.points.len(), "{}", scene.name);
        let used: HashSet<_> = scene.faces.iter().flat_map(|f| &f.corners).collect();
        assert_eq!(used.len(), scene.points.len(), "{}", scene.name);
    }
}

/// Neighbours within an object run along their common edge in opposite directions.
#[test]
fn objects_are_consistently_oriented() {
    for scene in all() {
        let mut edges = HashSet::new();
        for face in &scene.faces {
            for k in 0..face.corners.len() {
                let (from, to) = (face.corners[k], face.corners[(k + 1) % face.corners.len()]);
                let new = edges.insert((face.object, from, to));
                assert!(
                    new,
                    "{}: edge from {} to {} twice",
                    scene.name, scene.points[from], scene.points[to]
                );
            }
        }
        let closed = edges
            .iter()
            .all(|&(object, from, to)| edges.contains(&(object, to, from)));
        assert_eq!(closed, scene.name == "furnace", "{}", scene.name);
    }
}

/// No two triangles share a plane and a part of their area, whichever way they face.
#[test]
fn coplanar_faces_do_not_overlap() {
    for scene in all() {
        let mut planes: HashMap<[i64; 4], Vec<[DVec3; 3]>> = HashMap::new();
        for (face, triangle) in scene.triangles() {
            let points = scene.points_of(face, triangle);
            let mut n = (points[1] - points[0])
                .cross(points[2] - points[0])
                .normalize();
            let largest = n.abs().max_position();
            n *= n[largest].signum();
            // Planes as wide as the rounding of positions; near pairs in different cells are missed.
            let key = [n.x * 1e3, n.y * 1e3, n.z * 1e3, n.dot(points[0]) * 2e3];
            planes
                .entry(key.map(|x| x.round() as i64))
                .or_default()
                .push(points);
        }
        for triangles in planes.values() {
            for (k, a) in triangles.iter().enumerate() {
                for b in &triangles[k + 1..] {
                    assert!(!overlap(a, b), "{}: {a:?} and {b:?} overlap", scene.name);
                }
            }
        }
    }
}

/// Whether two triangles of one plane overlap by more than their rounding: no edge separates them.
fn overlap(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let n = (a[1] - a[0]).cross(a[2] - a[0]);
    let axis = n.abs().max_position();
    let flat = |p: DVec3| dvec2(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    let (a, b) = (a.map(flat), b.map(flat));
    let separates = |p: DVec2, q: DVec2| {
        let side = (q - p).perp().normalize();
        let range = |t: &[DVec2; 3]| {
            let s = t.map(|x| side.dot(x));
            (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]))
        };
        let ((a0, a1), (b0, b1)) = (range(&a), range(&b));
        a1 < b0 + 5e-5 || b1 < a0 + 5e-5
    };
    let edges = [a, b]
        .into_iter()
        .flat_map(|t| (0..3).map(move |k| (t[k], t[(k + 1) % 3])));
    !edges.into_iter().any(|(p, q)| separates(p, q))
}

#[test]
fn materials_do_not_make_energy_and_are_all_used() {
    for scene in all() {
        let used: HashSet<_> = scene.faces.iter().map(|f| &f.material).collect();
        for (name, m) in &scene.materials {
            assert!((m.kd + m.ks).max_element() <= 1.0, "{}: {name}", scene.name);
            assert!(
                m.kd.min_element() >= 0.0 && m.ks.min_element() >= 0.0 && m.ke.min_element() >= 0.0
            );
            assert!(
                (1.0..=300.0).contains(&m.ns),
                "{}: {name} has Ns {}",
                scene.name,
                m.ns
            );
            assert!(
                used.contains(name),
                "{}: nothing is made of {name}",
                scene.name
            );
        }
        assert!(
            scene.materials.values().any(|m| m.ke != DVec3::ZERO),
            "{}: dark",
            scene.name
        );
        assert!(scene.cameras >= 1, "{}: no camera", scene.name);
    }
}

#[test]
fn the_cafe_is_of_the_size_it_is_meant_to_be() {
    let scene = all().into_iter().find(|s| s.name == "cafe").unwrap();
    let (patches, glossy, triangles) = (
        scene.faces.len(),
        scene.glossy_patches(),
        scene.triangles().count(),
    );
    assert!((1_500..15_000).contains(&patches), "{patches} patches");
    assert!(
        (8_000..21_000).contains(&triangles),
        "{triangles} triangles"
    );
    assert!(
        3 * glossy >= patches,
        "{glossy} of {patches} patches are glossy"
    );
    assert!(scene.cameras >= 3);
}

/// Only the reflector brings the lamps' light to the wall of `three_lights`.
#[test]
fn the_screen_hides_every_lamp_from_the_wall() {
    let scene = all()
        .into_iter()
        .find(|s| s.name == "three_lights")
        .unwrap();
    let quad = |name: &str| -> Vec<[DVec3; 4]> {
        let faces = scene.faces.iter().filter(|f| f.material.starts_with(name));
        faces
            .map(|f| [0, 1, 2, 3].map(|k| scene.points[f.corners[k]]))
            .collect()
    };
    let blockers: Vec<_> = scene
        .triangles()
        .map(|(f, t)| scene.points_of(f, t))
        .collect();
    let grid = |q: &[DVec3; 4], steps: u32| -> Vec<DVec3> {
        let (o, u, v) = (q[0], q[1] - q[0], q[3] - q[0]);
        let at = |k: u32| 1e-4 + (1.0 - 2e-4) * f64::from(k) / f64::from(steps);
        (0..=steps)
            .flat_map(|i| (0..=steps).map(move |j| o + at(i) * u + at(j) * v))
            .collect()
    };
    for lamp in quad("lamp_") {
        let front = (lamp[1] - lamp[0]).cross(lamp[3] - lamp[0]);
        for from in grid(&lamp, 3) {
            for to in quad("wall").iter().flat_map(|q| grid(q, 20)) {
                let seen =
                    front.dot(to - from) > 0.0 && !blockers.iter().any(|t| crosses(t, from, to));
                assert!(!seen, "{from} lights {to}");
            }
        }
    }
}

/// Whether the inside of the segment meets the triangle (Möller, Trumbore 1997).
fn crosses([a, b, c]: &[DVec3; 3], from: DVec3, to: DVec3) -> bool {
    let (d, e1, e2, s) = (to - from, b - a, c - a, from - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return false;
    }
    let (u, q) = (s.dot(p) / determinant, s.cross(e1));
    let (v, t) = (d.dot(q) / determinant, e2.dot(q) / determinant);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (1e-6..1.0 - 1e-6).contains(&t)
}
