//! What can be wrong with a file.

use std::path::PathBuf;

/// A file that could not be read or written. Its text is one line that names file, place and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The operating system refused.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// The content of a text file is wrong at a line.
    #[error("{path}:{line}: {message}", path = path.display())]
    Line {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what was expected.
        message: String,
    },
    /// The content of a file is wrong.
    #[error("{path}: {message}", path = path.display())]
    Content {
        /// File.
        path: PathBuf,
        /// What is wrong and what was expected.
        message: String,
    },
    /// The scene that the file describes is wrong.
    #[error("{path}: {source}", path = path.display())]
    Scene {
        /// File.
        path: PathBuf,
        /// What is wrong.
        source: sheen_solver::SceneError,
    },
}
