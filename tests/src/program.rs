//! The program as a person starts it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The binary `sheen` of this build.
///
/// `cargo test --workspace` has built it, since the viewer's own tests use it; otherwise it is built now.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| {
        let test = std::env::current_exe().unwrap_or_default();
        // .../target/debug/deps/cli-0123456789abcdef
        let folder = test.ancestors().nth(2).unwrap_or(Path::new("."));
        let binary = folder.join(format!("sheen{}", std::env::consts::EXE_SUFFIX));
        if !binary.is_file() {
            let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
            let mut build = Command::new(cargo);
            build
                .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
                .args(["build", "--locked", "-p", "sheen-viewer", "--bin", "sheen"])
                .args(["--profile", "test"]);
            if let Some(target) = folder.parent() {
                build.arg("--target-dir").arg(target);
            }
            let status = build.status();
            assert!(
                status.is_ok_and(|status| status.success()),
                "the binary sheen could not be built"
            );
        }
        assert!(binary.is_file(), "no binary at {}", binary.display());
        binary
    })
}

/// Runs `sheen` in `folder`, without a display.
pub fn sheen(folder: &Path, arguments: &[&str]) -> Ran {
    let output = Command::new(binary())
        .current_dir(folder)
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output();
    Ran {
        output: output.unwrap_or_else(|error| panic!("{}: {error}", binary().display())),
    }
}

/// What a run left.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Status and both streams.
    pub output: Output,
}

impl Ran {
    /// Exit status; `None` when a signal ended it.
    pub fn status(&self) -> Option<i32> {
        self.output.status.code()
    }

    /// Standard output.
    pub fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    /// Standard error.
    pub fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    /// Lines of standard error that say what went wrong: notes of what was repaired are none.
    pub fn errors(&self) -> Vec<String> {
        self.stderr()
            .lines()
            .filter(|line| line.starts_with("sheen: ") && !line.starts_with("sheen: note: "))
            .map(str::to_owned)
            .collect()
    }
}
