//! Damaged input of every kind: no reader may panic, and every error is one line. The cases are the same in every
//! run; `SHEEN_FUZZ_CASES` sets how many there are of each kind (default 1000).
#![allow(clippy::unwrap_used, reason = "tests")]

use sheen_formats::{FormatError, LoadOptions, load_scene};
use std::path::Path;

/// SplitMix64: small, and the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Pieces that parsers stumble over.
const PIECES: [&[u8]; 28] = [
    b"0",
    b"-1",
    b"nan",
    b"inf",
    b"-inf",
    b"1e39",
    b"1e-50",
    b"99999999999999999999",
    b"-9223372036854775808",
    b"/",
    b"//",
    b"\n",
    b"\r",
    b"\\\n",
    b"#",
    b"\0",
    b"\xFF",
    b"\xEF\xBB\xBF",
    b" ",
    b"\"",
    b"[",
    b"]",
    b"{",
    b"=",
    b"f ",
    b"v ",
    b"\n\n\n",
    b"\xE2\x80\xA8",
];

fn mutate(random: &mut Random, corpus: &[u8]) -> Vec<u8> {
    let mut bytes = corpus.to_vec();
    for _ in 0..=random.below(5) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(24)).min(bytes.len());
        match random.below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.next() as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = PIECES[random.below(PIECES.len())];
                drop(bytes.splice(at..at, piece.iter().copied()));
            }
            4 => {
                let piece = PIECES[random.below(PIECES.len())];
                drop(bytes.splice(at..end, piece.iter().copied()));
            }
            5 => {
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len() + 1);
                drop(bytes.splice(to..to, copy));
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

fn check<T>(
    kind: &str,
    case: usize,
    input: &[u8],
    result: std::thread::Result<Result<T, FormatError>>,
) -> bool {
    let Ok(result) = result else {
        panic!("{kind}, case {case}: panic on {}", input.escape_ascii())
    };
    if let Err(error) = &result {
        let text = error.to_string();
        let line_end = |c: char| matches!(c, '\n' | '\r' | '\u{85}' | '\u{2028}' | '\u{2029}');
        assert!(
            !text.contains(line_end),
            "{kind}, case {case}: {text:?} is not one line"
        );
        assert!(
            text.len() < 5000 && !text.is_empty(),
            "{kind}, case {case}: {text:?} is too long"
        );
    }
    result.is_ok()
}

/// Runs `read` on mutations of the corpus; some must pass and some must fail, or the mutator is no use.
fn fuzz<T>(
    kind: &str,
    corpus: &[&[u8]],
    all_fail: bool,
    read: impl Fn(&[u8]) -> Result<T, FormatError>,
) {
    let cases = std::env::var("SHEEN_FUZZ_CASES")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(1000);
    for good in corpus {
        if let Err(error) = read(good) {
            panic!("{kind}: the corpus is not good: {error}");
        }
    }
    let mut random = Random(0x5EED);
    let mut passed = 0;
    for case in 0..cases {
        let input = mutate(&mut random, corpus[case % corpus.len()]);
        if corpus.contains(&input.as_slice()) {
            passed += usize::from(!all_fail);
            continue;
        }
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| read(&input)));
        passed += usize::from(check(kind, case, &input, result));
    }
    assert!(
        passed < cases && (all_fail == (passed == 0)),
        "{kind}: {passed} of {cases} passed"
    );
}

const OBJ: &[u8] = b"# room\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\nvt 0 0\nvn 0 0 1\nvn 0 -0.6 0.8\n\
    usemtl white\nf 1 2 3 4\nf 1//1 2//2 5//2\nusemtl lamp\nf 1/1/1 -4/1/1 -3/1/1\ng a\nf 1 2 5 3 4\n";
const MTL: &[u8] = b"newmtl white\nKd 0.5 0.4 0.3\nKs 0.1 0.1 0.1\nNs 20\n\nnewmtl lamp\nKd 0 0 0\nKe 3 3 3\nmap_Kd a.png\nd 0.5\n";
const SIDECAR: &[u8] = b"[[camera]]\nname = \"front\"\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_y = 45.5\n\
    width = 64\nheight = 48\n\n[[point_light]]\nposition = [1, 2, 3]\nintensity = [1, 1, 1]\n\n\
    [material.white]\ndiffuse = [0.1, 0.2, 0.3]\nspecular = [0.1, 0.1, 0.1]\nroughness = 0.2\n";
const MGF: &[u8] = b"# room\nm white =\n\tsides 2\n\tc\n\tcxy 0.33 0.34\n\trd .5\n\trs .1 .05\nxf -s 2 -a 3 -t 1 0 0\n\
    v a =\n\tp 0 0 0\nv b =\n\tp 1 0 0\nv c =\n\tp 1 1 0\n\tn 0 0 1\nf a b c\nsph a .5\ncyl a .1 b\nring c .1 .5\nprism a b c .5\n\
    xf\nm lamp =\n\ted 100\nf c b a\nsph c 1\n";

/// Replaces a file by removing it first: some file systems wait for the disk when a file is emptied and rewritten.
fn put(path: &Path, content: &[u8]) {
    let _ = std::fs::remove_file(path);
    std::fs::write(path, content).unwrap();
}

/// Fuzzes one of the three files of an OBJ scene.
fn fuzz_obj_scene(kind: &str, name: &str, corpus: &[u8], lenient: bool) {
    let folder = tempfile::tempdir().unwrap();
    put(&folder.path().join("a.obj"), OBJ);
    put(&folder.path().join("a.mtl"), MTL);
    fuzz(kind, &[corpus], false, |input| {
        put(&folder.path().join(name), input);
        load_scene(&folder.path().join("a.obj"), &LoadOptions { lenient })
    });
}

#[test]
fn damaged_obj_files() {
    fuzz_obj_scene("OBJ", "a.obj", OBJ, false);
    fuzz_obj_scene("OBJ, lenient", "a.obj", OBJ, true);
}

#[test]
fn damaged_mtl_files() {
    fuzz_obj_scene("MTL", "a.mtl", MTL, false);
    fuzz_obj_scene("MTL, lenient", "a.mtl", MTL, true);
}

#[test]
fn damaged_sidecars() {
    fuzz_obj_scene("sidecar", "a.toml", SIDECAR, false);
}

#[test]
fn damaged_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.sheen");
    let mut solution = sheen_solver::Solution {
        position: vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y],
        normal: vec![glam::Vec3::Z; 3],
        radiance: vec![sheen_solver::Rgb::WHITE; 3],
        material: vec![0; 3],
        distribution_offset: vec![sheen_solver::solution::NO_DISTRIBUTION, 0, 15],
        distribution_words: [vec![1.0f32.to_bits()], vec![0; 14]].concat().repeat(2),
        triangles: vec![[0, 1, 2]],
        element_edges: vec![7],
        materials: vec![sheen_solver::Material::lambert(
            "a",
            sheen_solver::Rgb::BLACK,
        )],
        ..Default::default()
    };
    solution.cameras.push(sheen_solver::Camera {
        name: "a".to_owned(),
        eye: glam::Vec3::Z,
        target: glam::Vec3::ZERO,
        up: glam::Vec3::Y,
        fov_y_degrees: 45.0,
        width: 4,
        height: 4,
    });
    sheen_formats::solution::write(&path, &solution).unwrap();
    let good = std::fs::read(&path).unwrap();
    fuzz("solution", &[&good], true, |input| {
        sheen_formats::solution::decode(&path, input)
    });
    // With checksums made right, so that the checks behind them are reached. Damage that stays valid may pass.
    fuzz("solution, checksums right", &[&good], false, |input| {
        sheen_formats::solution::decode(&path, &with_right_checksums(input))
    });
}

fn with_right_checksums(input: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    let number = |bytes: &[u8], at: usize, size: usize| {
        bytes.get(at..at + size).map_or(0, |b| {
            b.iter()
                .rev()
                .fold(0u64, |n, &byte| n << 8 | u64::from(byte))
        })
    };
    let count = number(&bytes, 12, 4).min(64) as usize;
    let table_end = 32 * (1 + count);
    if bytes.len() < table_end {
        return bytes;
    }
    let length = bytes.len() as u64;
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    for entry in (32..table_end).step_by(32) {
        let (offset, size) = (
            number(&bytes, entry + 8, 8) as usize,
            number(&bytes, entry + 16, 8) as usize,
        );
        if let Some(chunk) = offset
            .checked_add(size)
            .and_then(|end| bytes.get(offset..end))
        {
            let checksum = crc32fast::hash(chunk);
            bytes[entry + 4..entry + 8].copy_from_slice(&checksum.to_le_bytes());
        }
    }
    bytes[24..28].fill(0);
    let checksum = crc32fast::hash(&bytes[..table_end]);
    bytes[24..28].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

#[test]
fn damaged_mgf_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mgf");
    fuzz("MGF", &[MGF], false, |input| {
        put(&path, input);
        load_scene(&path, &LoadOptions { lenient: true })
    });
}
