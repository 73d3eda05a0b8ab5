//! Reference scenes and images that are not part of the repository.

use std::path::{Path, PathBuf};

/// The folder of reference scenes and images: `SHEEN_SHARED`, or `../shared` beside the repository.
///
/// `None` where there is none: the test that asked is skipped and says so. Panics instead when
/// `SHEEN_REQUIRE_SHARED` is 1.
pub fn shared(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SHEEN_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    if folder.join("reference/scenes").is_dir() {
        return Some(folder);
    }
    let required = std::env::var_os("SHEEN_REQUIRE_SHARED").is_some_and(|value| value == "1");
    assert!(
        !required,
        "{test}: no reference scenes at {}, and SHEEN_REQUIRE_SHARED is 1",
        folder.display()
    );
    #[expect(clippy::print_stderr, reason = "a skipped test says so")]
    {
        eprintln!(
            "SKIPPED: {test}: no reference scenes at {}",
            folder.display()
        );
    }
    None
}
