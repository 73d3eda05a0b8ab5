//! `.sheen`: the same comes back, the same gives the same bytes, and nothing damaged is taken.
#![allow(clippy::unwrap_used, reason = "tests")]

use glam::Vec3;
use sheen_formats::solution::{chunks, decode, read, write};
use sheen_solver::directional::packed;
use sheen_solver::solution::NO_DISTRIBUTION;
use sheen_solver::{Camera, Gloss, Material, Rgb, Solution};
use std::path::PathBuf;

/// Black but for one octant, whose first child is a leaf with one colour at a midpoint.
fn distribution() -> Vec<u32> {
    const FIRST_CHILD: u32 = 1 << 28;
    const SECOND_MIDPOINT: u32 = 1 << 22;
    let node = FIRST_CHILD | SECOND_MIDPOINT | 15;
    let mut words = vec![2.0f32.to_bits(), node, 0, 0, 0, 0, 0, 0, 0];
    let colours = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5].map(Rgb::splat);
    words.extend(colours.map(packed::encode));
    words
}

fn example() -> Solution {
    let mut solution = Solution {
        position: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.1, 0.2, 1e-30)],
        normal: vec![Vec3::Z; 4],
        radiance: [0.1, 0.0, 1e9, 3.0].map(Rgb::splat).to_vec(),
        material: vec![0, 0, 1, 2],
        distribution_offset: vec![NO_DISTRIBUTION, 0, NO_DISTRIBUTION, 16],
        distribution_words: [distribution(), distribution()].concat(),
        triangles: vec![[0, 1, 2], [2, 1, 3], [3, 1, 0]],
        element_edges: vec![7, 0, 5],
        glass_corners: vec![[Vec3::X, Vec3::Y, Vec3::Z]],
        glass_material: vec![2],
        materials: vec![Material::lambert("weiß \n", Rgb::new(0.1, 0.7, 0.3)); 3],
        cameras: vec![Camera {
            name: "front".to_owned(),
            eye: Vec3::new(0.1, 0.2, 3.3),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y_degrees: 39.3077,
            width: 512,
            height: 384,
        }],
        stats: Default::default(),
    };
    solution.materials[1].gloss = Gloss::Phong {
        specular: Rgb::splat(0.1),
        exponent: 33.3,
    };
    solution.materials[1].emission = Rgb::splat(1e-7);
    solution.materials[2].gloss = Gloss::Ward {
        specular: Rgb::splat(0.2),
        roughness: 0.0,
    };
    solution.materials[2].transmission = Rgb::splat(0.3);
    solution.stats.scene.triangles = 12;
    solution.stats.solve.links = u64::MAX;
    solution.stats.solve.emitted_w = 0.1 + 0.2;
    solution.stats.solve.absorbed_w = std::f64::consts::PI * 1e-7;
    solution
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }
    fn path(&self) -> PathBuf {
        self.0.path().join("s.sheen")
    }
    #[track_caller]
    fn refused(&self, bytes: &[u8], expected: &str) {
        let text = decode(&self.path(), bytes).unwrap_err().to_string();
        assert!(
            text.contains("s.sheen: ") && text.contains(expected),
            "'{text}' lacks '{expected}'"
        );
        assert!(
            !text.contains('\n') && text.len() < 1500,
            "not one line: {text}"
        );
    }
}

#[test]
fn a_solution_comes_back() {
    let place = Place::new();
    for solution in [
        example(),
        Solution {
            cameras: example().cameras,
            ..Default::default()
        },
    ] {
        write(&place.path(), &solution).unwrap();
        assert_eq!(read(&place.path()).unwrap(), solution);
    }
    assert_eq!(
        std::fs::read_dir(place.0.path()).unwrap().count(),
        1,
        "temporary files are left behind"
    );
}

#[test]
fn seconds_and_resident_memory_are_not_written() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let expected = std::fs::read(place.path()).unwrap();
    let mut other = example();
    other.stats.solve.wall_s = 1.5;
    other.stats.solve.cpu_s = 2.5;
    other.stats.solve.peak_rss_bytes = 12345;
    other.stats.solve.phases_s.propagate = 0.7;
    other.stats.solve.phases_s.load = f64::NAN;
    write(&place.path(), &other).unwrap();
    assert_eq!(std::fs::read(place.path()).unwrap(), expected);
    assert_eq!(read(&place.path()).unwrap(), example());
}

#[test]
fn statistics_that_are_not_finite_do_not_cost_the_solution() {
    let place = Place::new();
    let mut solution = example();
    solution.stats.solve.escaped_w = f64::NAN;
    write(&place.path(), &solution).unwrap();
    assert_eq!(read(&place.path()).unwrap().stats.solve.escaped_w, 0.0);
}

#[test]
fn the_chunks_are_listed() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let chunks = chunks(&place.path()).unwrap();
    assert_eq!(chunks.len(), 13);
    assert_eq!((chunks[0].tag.as_str(), chunks[0].bytes), ("POSI", 4 * 12));
    assert_eq!((chunks[6].tag.as_str(), chunks[6].bytes), ("TRIS", 3 * 12));
}

#[test]
fn row_33_a_truncated_file_is_refused() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let good = std::fs::read(place.path()).unwrap();
    for length in (0..good.len())
        .step_by(64)
        .chain([1, 7, 8, 31, 33, good.len() - 1])
    {
        place.refused(&good[..length], "");
        let path = place.0.path().join(format!("{length}.sheen"));
        std::fs::write(&path, &good[..length]).unwrap();
        let in_memory = decode(&path, &good[..length]).unwrap_err().to_string();
        assert_eq!(read(&path).unwrap_err().to_string(), in_memory);
    }
    place.refused(&[], "is empty");
    place.refused(&good[..good.len() / 2], "is truncated");
    place.refused(&[&good[..], b"x"].concat(), "1 bytes after its end");
}

#[test]
fn row_33_every_flipped_byte_is_noticed() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let good = std::fs::read(place.path()).unwrap();
    for at in 0..good.len() {
        for flip in [0x01, 0x80, 0xFF] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            place.refused(&bytes, "");
        }
    }
}

#[test]
fn other_files_and_versions_are_named() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let mut bytes = std::fs::read(place.path()).unwrap();
    bytes[8] = 7;
    place.refused(&bytes, "is of version 7, this program reads version 3");
    place.refused(
        b"\x89PNG\r\n\x1a\n123456789",
        "looks like a PNG image, expected a .sheen solution",
    );
    place.refused(b"v 0 0 0\n", "is no .sheen solution");
    let missing = read(&place.0.path().join("no.sheen"))
        .unwrap_err()
        .to_string();
    assert!(missing.contains("no.sheen: No such file"), "{missing}");
    assert!(
        read(place.0.path())
            .unwrap_err()
            .to_string()
            .contains("is a directory")
    );
}

/// The file with the number at `at` replaced and its head's checksum made right again, as an attacker would.
fn forge(bytes: &[u8], at: usize, value: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + value.len()].copy_from_slice(value);
    let chunks = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let end = (32 * (1 + chunks.min(60))).min(bytes.len());
    bytes[24..28].fill(0);
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[24..28].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

#[test]
fn row_33_forged_counts_allocate_nothing() {
    let place = Place::new();
    write(&place.path(), &example()).unwrap();
    let good = std::fs::read(place.path()).unwrap();
    assert!(
        forge(&good, 8, &[3]) == good,
        "the forger knows the checksum"
    );
    for value in [1u64 << 63, u64::MAX, 1 << 40, 0, 17] {
        let value = value.to_le_bytes();
        // Length of the file; offset and length of the first chunk and of the last.
        for at in [16, 32 + 8, 32 + 16, 13 * 32 + 8, 13 * 32 + 16] {
            place.refused(&forge(&good, at, &value), "");
        }
    }
    for count in [0u32, 1, 12, 14, 64, 65, u32::MAX] {
        place.refused(&forge(&good, 12, &count.to_le_bytes()), "");
    }
    place.refused(&forge(&good, 32, b"XXXX"), "chunk");
    // The second chunk under the first one's name.
    place.refused(&forge(&good, 64, b"POSI"), "");
}

#[test]
fn inconsistent_solutions_are_refused_before_they_are_written() {
    let place = Place::new();
    let check = |change: fn(&mut Solution), expected: &str| {
        let mut solution = example();
        change(&mut solution);
        let text = write(&place.path(), &solution).unwrap_err().to_string();
        assert!(text.contains(expected), "'{text}' lacks '{expected}'");
        assert!(!place.path().exists());
    };
    check(
        |s| s.triangles[1][2] = 4,
        "triangle 1 has corners [2, 1, 4], 4 vertices exist",
    );
    check(|s| s.material[0] = 3, "vertex 0 has material 3, 3 exist");
    check(
        |s| s.glass_material[0] = 3,
        "clear surface 0 has material 3",
    );
    check(|s| s.normal.truncate(3), "3 normals for 4 vertices");
    check(|s| s.position[2].x = f32::NAN, "position 2 is not finite");
    check(
        |s| s.radiance[3].b = f32::INFINITY,
        "radiance 3 is not finite",
    );
    check(|s| s.element_edges[0] = 8, "element edges 8");
    check(|s| s.distribution_offset[1] = 1, "vertex 1");
    check(|s| s.distribution_offset[3] = 0, "distribution of vertex 1");
    check(
        |s| s.distribution_offset[3] = 33,
        "distribution of vertex 1",
    );
    check(
        |s| s.distribution_offset[3] = NO_DISTRIBUTION - 1,
        "distribution of vertex 1",
    );
    check(|s| s.distribution_words[1] = 9, "not well formed");
    check(
        |s| s.distribution_words[16] = f32::NAN.to_bits(),
        "vertex 3 is not well formed",
    );
    check(
        |s| s.distribution_offset.fill(NO_DISTRIBUTION),
        "words that no vertex owns",
    );
    check(|s| s.cameras.clear(), "no camera");
    check(|s| s.cameras[0].fov_y_degrees = f32::NAN, "camera 'front'");
    check(|s| s.materials[0].diffuse.r = f32::NAN, "material 'weiß");
    check(|s| s.materials[1].emission.r = -1.0, "out of range");
}
