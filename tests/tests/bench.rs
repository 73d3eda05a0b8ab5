//! The commands that measure: `sheen verify` and `sheen bench`.
#![allow(clippy::unwrap_used, reason = "tests")]

use serde_json::Value;
use sheen_tests::program::sheen;
use sheen_tests::scenes::own_path;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn verify_measures_a_stored_solution_as_a_new_one() {
    let desk = tempfile::tempdir().unwrap();
    let scene = own_path("furnace");
    let scene = scene.to_str().unwrap();
    let run = |arguments: &[&str]| {
        let ran = sheen(desk.path(), arguments);
        assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
        ran.stdout()
    };
    run(&["solve", scene, "-o", "f.sheen", "--quality", "preview"]);
    let stored = run(&[
        "verify",
        scene,
        "--solution",
        "f.sheen",
        "--probes",
        "20000",
        "--json",
    ]);
    let solved = run(&[
        "verify",
        scene,
        "--quality",
        "preview",
        "--probes",
        "20000",
        "--json",
    ]);
    assert_eq!(stored, solved);
    let found: Value = serde_json::from_str(&stored).unwrap();
    assert_eq!(found["all"]["probes"], 20_000);
    // What is reflected is 1 inside and nothing outside.
    let radiance = found["all"]["radiance"].as_f64().unwrap();
    assert!((radiance - 0.5).abs() < 0.02, "{radiance}");
    assert!(
        found["all"]["bias"]["value"].as_f64().unwrap().abs() < 0.02,
        "{stored}"
    );
    assert_eq!(found["materials"].as_array().unwrap().len(), 1);
    let table = run(&["verify", scene, "--solution", "f.sheen", "--probes", "2000"]);
    assert!(
        table.starts_with("material") && table.contains("\nall ") && table.contains("\nshell "),
        "{table}"
    );
    assert_eq!(names(desk.path()), ["f.sheen"]);
}

#[test]
fn what_cannot_be_verified_is_refused() {
    let desk = tempfile::tempdir().unwrap();
    let furnace = own_path("furnace");
    let plates = own_path("parallel_plates");
    let (furnace, plates) = (furnace.to_str().unwrap(), plates.to_str().unwrap());
    let solved = sheen(
        desk.path(),
        &["solve", plates, "-o", "p.sheen", "--quality", "draft"],
    );
    assert_eq!(solved.status(), Some(0), "{}", solved.stderr());
    for (arguments, expected) in [
        (vec!["verify", "p.sheen"], "expected the scene"),
        (
            vec!["verify", furnace, "--solution", "p.sheen"],
            "other materials",
        ),
        (
            vec!["verify", furnace, "--solution", "none.sheen"],
            "none.sheen",
        ),
        (vec!["bench", "convergence", "none.obj"], "none.obj"),
        (
            vec!["bench", "convergence", furnace, "--camera", "none"],
            "expected one of",
        ),
        (
            vec!["bench", "convergence", furnace, "-o", "p.sheen"],
            "p.sheen",
        ),
    ] {
        let ran = sheen(desk.path(), &arguments);
        assert_eq!(ran.status(), Some(1), "{arguments:?}: {}", ran.stderr());
        assert_eq!(ran.errors().len(), 1, "{arguments:?}: {}", ran.stderr());
        assert!(
            ran.stderr().contains(expected),
            "{arguments:?}: {}",
            ran.stderr()
        );
    }
    assert_eq!(
        sheen(
            desk.path(),
            &["bench", "convergence", furnace, "--qualities", "best"]
        )
        .status(),
        Some(2)
    );
    assert_eq!(names(desk.path()), ["p.sheen"]);
}

#[test]
fn levels_deviations_and_memory_can_be_traded() {
    let desk = tempfile::tempdir().unwrap();
    let scene = own_path("cornell_box_glossy");
    let ladder = |option: &str, steps: &str| -> Value {
        let scene = scene.to_str().unwrap();
        let fixed = [
            "bench",
            "convergence",
            scene,
            "-o",
            "t",
            "--spp",
            "4",
            "--probes",
            "2",
        ];
        let arguments = [&fixed[..], &["--quality", "preview", option, steps]].concat();
        let ran = sheen(desk.path(), &arguments);
        assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
        let text = std::fs::read_to_string(desk.path().join("t/convergence.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let bytes = |ladder: &Value, row: usize| ladder["rows"][row]["bytes"].as_u64().unwrap();
    for (option, steps, dimension) in [
        ("--levels", "2,4", "levels"),
        ("--epsilons", "1,0.1", "epsilon"),
    ] {
        let found = ladder(option, steps);
        assert_eq!(found["dimension"], dimension);
        assert!(bytes(&found, 0) < bytes(&found, 1), "{found}");
    }
    let found = ladder("--memory-limits", "4MiB,1GiB");
    assert_eq!(found["rows"][1]["quality"], 1.0, "{found}");
    assert!(
        found["rows"][0]["quality"].as_f64().unwrap() < 1.0,
        "{found}"
    );
    assert!(bytes(&found, 0) < bytes(&found, 1), "{found}");
}

#[test]
fn more_work_means_less_error() {
    let desk = tempfile::tempdir().unwrap();
    let scene = own_path("glossy_sphere");
    let arguments = [
        "bench",
        "convergence",
        scene.to_str().unwrap(),
        "-o",
        "table",
        "--qualities",
        "draft,preview",
        "--spp",
        "32",
        "--probes",
        "65536",
    ];
    let ran = sheen(desk.path(), &arguments);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let folder = desk.path().join("table");
    assert_eq!(
        names(&folder),
        [
            "convergence.csv",
            "convergence.json",
            "convergence.md",
            "convergence.svg"
        ]
    );
    assert_eq!(
        ran.stdout(),
        std::fs::read_to_string(folder.join("convergence.md")).unwrap()
    );
    let text = std::fs::read_to_string(folder.join("convergence.json")).unwrap();
    let ladder: Value = serde_json::from_str(&text).unwrap();
    let figure = |row: usize, name: &str| ladder["rows"][row][name].as_f64().unwrap();
    for name in ["relmse", "flip"] {
        assert!(figure(1, name) < figure(0, name), "{name}: {text}");
    }
    for name in ["links", "elements", "bytes"] {
        assert!(figure(1, name) > figure(0, name), "{name}: {text}");
    }
    assert!(ladder["slope"].as_f64().unwrap() < 0.0, "{text}");
}

/// The rows of a table in `folder`, as JSON.
fn rows(folder: &Path, name: &str) -> Vec<Vec<Value>> {
    let text = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
    let table: Value = serde_json::from_str(&text).unwrap();
    serde_json::from_value(table["rows"].clone()).unwrap()
}

#[test]
fn the_reflection_of_a_sum_takes_fewer_basis_functions_and_evaluations() {
    let desk = tempfile::tempdir().unwrap();
    let scenes = own_path("furnace");
    let scenes = scenes.ancestors().nth(2).unwrap().to_str().unwrap();
    let ran = sheen(
        desk.path(),
        &["bench", "tables", "sum", "--scenes", scenes, "-o", "t"],
    );
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    assert!(ran.stdout().starts_with("Table 1"), "{}", ran.stdout());
    let folder = desk.path().join("t");
    assert_eq!(names(&folder), ["sum.csv", "sum.json", "sum.md"]);
    // Table 1 of the paper, where sums take more evaluations at 3 and at 30 degrees.
    for (row, least) in rows(&folder, "sum").iter().zip([1.4, 4.0, 7.0]) {
        let ratio = |column: usize| row[column].as_f64().unwrap();
        assert!(ratio(3) >= least && ratio(7) > 1.0, "{row:?}");
    }
    let ran = sheen(
        desk.path(),
        &["bench", "tables", "sum", "--scenes", "nowhere"],
    );
    assert_eq!(ran.status(), Some(1));
    assert!(ran.stderr().contains("nowhere"), "{}", ran.stderr());
}

#[test]
fn the_reflection_of_a_lamp_converges_and_is_shown() {
    let desk = tempfile::tempdir().unwrap();
    let scenes = own_path("furnace");
    let scenes = scenes.ancestors().nth(2).unwrap().to_str().unwrap();
    let tables = ["bench", "tables", "convergence4", "--scenes", scenes];
    let ran = sheen(desk.path(), &[&tables[..], &["-o", "t"]].concat());
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let folder = desk.path().join("t");
    let kinds = ["csv", "json", "md"].map(|kind| format!("convergence4.{kind}"));
    assert_eq!(names(&folder)[..3], kinds);
    assert_eq!(names(&folder)[3..], ["figure4.png"]);
    // At least 4, 16 and 64 samples of elements, then the default settings.
    let rows = rows(&folder, "convergence4");
    assert_eq!(rows.len(), 4);
    let figure = |row: usize, column: usize| rows[row][column].as_f64().unwrap();
    for (row, least) in [4.0, 16.0, 64.0].into_iter().enumerate() {
        assert!(figure(row, 1) >= least, "{rows:?}");
        for error in [6, 7] {
            assert!(figure(row + 1, error) < figure(row, error), "{rows:?}");
        }
    }
    let ran = sheen(desk.path(), &["bench", "tables", "soda"]);
    assert_eq!(ran.status(), Some(1));
    assert!(ran.stderr().contains("--soda"), "{}", ran.stderr());
}

#[test]
fn scaling_has_a_row_for_each_size() {
    let desk = tempfile::tempdir().unwrap();
    let arguments = [
        "bench",
        "scaling",
        "--triangles",
        "200,800",
        "--quality",
        "draft",
        "-o",
        ".",
    ];
    let ran = sheen(desk.path(), &arguments);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    assert!(ran.stdout().contains("to the power"), "{}", ran.stdout());
    let rows = rows(desk.path(), "scaling");
    assert_eq!(rows.len(), 2);
    assert!(rows[1][0].as_u64() > rows[0][0].as_u64());
}

#[test]
fn rays_are_counted_and_written() {
    let desk = tempfile::tempdir().unwrap();
    let scene = own_path("cornell_box");
    let scene = scene.to_str().unwrap();
    let arguments = [
        "bench",
        "rays",
        scene,
        "--rays",
        "5000",
        "--quality",
        "draft",
        "-o",
        "rays",
    ];
    let ran = sheen(desk.path(), &arguments);
    assert_eq!(ran.status(), Some(0), "{}", ran.stderr());
    let folder = desk.path().join("rays");
    let expected = [
        "random.npy",
        "rays.csv",
        "rays.json",
        "rays.md",
        "solve.npy",
    ];
    assert_eq!(names(&folder), expected);
    for row in rows(&folder, "rays") {
        let (name, count) = (row[0].as_str().unwrap(), row[1].as_u64().unwrap());
        assert!((1..=5000).contains(&count), "{name}: {count}");
        // Two boxes in an empty room: some rays are blocked, most are not.
        let blocked = row[2].as_f64().unwrap();
        assert!(blocked > 0.0 && blocked < 60.0, "{name}: {blocked} %");
        assert!(row[3].as_f64().unwrap() > 0.0, "{name}");
        // 24 bytes a ray after a header of a multiple of 64 bytes.
        let bytes = std::fs::metadata(folder.join(format!("{name}.npy"))).unwrap();
        assert_eq!((bytes.len() - 24 * count) % 64, 0, "{name}");
    }
}
