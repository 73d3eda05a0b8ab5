//! Whoever stops a long solve keeps what it has; what is no solve ends at once.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn send(signal: &str, to: &Child) {
    let command = format!("kill {signal} {}", to.id());
    let sent = Command::new("sh").args(["-c", &command]).status();
    assert!(sent.unwrap().success());
}

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
        send(signal, &solve);
        let said: Vec<String> = said.map(Result::unwrap).collect();
        assert_eq!(solve.wait().unwrap().code(), Some(0), "{signal}: {said:?}");
        let kept = |line: &String| line.contains("interrupted: keeping");
        assert!(said.iter().any(kept), "{signal}: {said:?}");
        let solution = sheen_formats::solution::read(&file).unwrap();
        assert!(!solution.triangles.is_empty());
        assert!(solution.radiance.iter().any(|&light| !light.is_black()));
    }
}

#[test]
fn one_request_ends_what_comes_after_a_solve() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/furnace/furnace.obj");
    let folder = tempfile::tempdir().unwrap();
    // A solve of a tenth of a second, then minutes of a picture.
    let mut render = Command::new(env!("CARGO_BIN_EXE_sheen"))
        .args(["render", "--cpu", "--quality", "draft", "--spp", "1024"])
        .args(["--size", "4000x4000", "-o"])
        .args([&folder.path().join("furnace.exr"), &scene])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(5));
    assert!(render.try_wait().unwrap().is_none(), "still at work");
    let sent = Instant::now();
    send("-TERM", &render);
    assert_eq!(render.wait().unwrap().code(), Some(130));
    assert!(sent.elapsed() < Duration::from_secs(30));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
