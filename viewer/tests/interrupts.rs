//! Whoever stops a long solve keeps what it has.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_stopped_solve_leaves_a_solution() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/cafe/cafe.obj");
    for signal in ["-INT", "-TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cafe.sheen");
        // A minute's work and more.
        let mut solve = Command::new(env!("CARGO_BIN_EXE_sheen"))
            .args(["solve", "--quality", "default", "-o"])
            .args([&file, &scene])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(solve.stderr.take().unwrap()).lines();
        let is_progress = |line: &String| line.contains(" %, ");
        let first = said.by_ref().map(Result::unwrap).find(is_progress);
        first.expect("a line of progress");
        let send = format!("kill {signal} {}", solve.id());
        let sent = Command::new("sh").args(["-c", &send]).status();
        assert!(sent.unwrap().success());
        let said: Vec<String> = said.map(Result::unwrap).collect();
        assert_eq!(solve.wait().unwrap().code(), Some(0), "{signal}: {said:?}");
        let kept = |line: &String| line.contains("interrupted: keeping");
        assert!(said.iter().any(kept), "{signal}: {said:?}");
        let solution = sheen_formats::solution::read(&file).unwrap();
        assert!(!solution.triangles.is_empty());
        assert!(solution.radiance.iter().any(|&light| !light.is_black()));
    }
}
