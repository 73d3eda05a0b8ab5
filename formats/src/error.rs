//! What can be wrong with a file, as one line of text.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A file that could not be read or written. Its text is one line that names file, place and what was expected.
///
/// The text is whole: it holds that of the cause, made safe for a terminal. The cause is therefore a field and not the
/// error's `source()`, or whoever prints the chain of sources would print it twice.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The operating system refused.
    #[error("{path}: {reason}", path = shown(path), reason = one_line(cause))]
    Io {
        /// File.
        path: PathBuf,
        /// Its reason.
        cause: std::io::Error,
    },
    /// The content of a text file is wrong at a line.
    #[error("{path}:{line}: {text}", path = shown(path), text = one_line(message))]
    Line {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what was expected.
        message: String,
    },
    /// The content of a file is wrong.
    #[error("{path}: {text}", path = shown(path), text = one_line(message))]
    Content {
        /// File.
        path: PathBuf,
        /// What is wrong and what was expected.
        message: String,
    },
    /// The scene that the file describes is wrong.
    #[error("{path}: {reason}", path = shown(path), reason = one_line(cause))]
    Scene {
        /// File.
        path: PathBuf,
        /// What is wrong.
        cause: sheen_solver::SceneError,
    },
}

impl FormatError {
    pub(crate) fn line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Self::Line {
            path: path.to_owned(),
            line,
            message: message.into(),
        }
    }

    pub(crate) fn content(path: &Path, message: impl Into<String>) -> Self {
        Self::Content {
            path: path.to_owned(),
            message: message.into(),
        }
    }
}

/// For `map_err` on what the operating system answers about `path`.
pub(crate) fn io_error(path: &Path) -> impl Fn(std::io::Error) -> FormatError + '_ {
    |cause| FormatError::Io {
        path: path.to_owned(),
        cause,
    }
}

/// Longest message that is shown whole [characters].
const LONGEST_MESSAGE: usize = 1000;
/// Longest word from a file that is quoted whole [characters].
const LONGEST_QUOTE: usize = 60;

fn shown(path: &Path) -> String {
    escape(&path.display().to_string(), usize::MAX)
}

fn one_line(text: &impl Display) -> String {
    escape(&text.to_string(), LONGEST_MESSAGE)
}

/// `text` without control characters, cut after `longest` characters.
fn escape(text: &str, longest: usize) -> String {
    let mut line = String::with_capacity(text.len().min(longest.saturating_mul(4)));
    for (index, character) in text.chars().enumerate() {
        if index == longest {
            line.push('…');
            break;
        }
        // U+2028 and U+2029 end a line without being control characters.
        if character.is_control() || matches!(character, '\u{2028}' | '\u{2029}') {
            line.extend(character.escape_default());
        } else {
            line.push(character);
        }
    }
    line
}

/// A word from a file as it stands in a message: in quotes, on one line, not longer than the reader's patience.
pub(crate) fn quote(word: &str) -> String {
    format!("'{}'", escape(word, LONGEST_QUOTE))
}

/// Some names from a file for a message: the first few, and how many more there are.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 5;
    let mut names = names.into_iter();
    let mut text = names
        .by_ref()
        .take(SHOWN)
        .map(quote)
        .collect::<Vec<_>>()
        .join(", ");
    let more = names.count();
    if more > 0 {
        text.push_str(&format!(" and {more} more"));
    }
    text
}

/// ", did you mean 'x'?" with the candidate nearest to `word`; empty when none is near.
pub(crate) fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let word: String = word.chars().take(LONGEST_QUOTE).collect();
    let near = word.chars().count().div_ceil(2).max(2);
    candidates
        .into_iter()
        .map(|candidate| (edit_distance(&word, candidate), candidate))
        .min()
        .filter(|&(distance, _)| distance <= near)
        .map_or(String::new(), |(_, candidate)| {
            format!(", did you mean {}?", quote(candidate))
        })
}

/// Insertions, deletions and replacements that turn `a` into `b`; letter case counts for nothing.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b
        .chars()
        .take(2 * LONGEST_QUOTE)
        .flat_map(char::to_lowercase)
        .collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().flat_map(char::to_lowercase).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &other) in b.iter().enumerate() {
            let replace = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_and_a_far_one_is_not() {
        assert_eq!(
            suggestion("fovy", ["eye", "fov_y", "width"]),
            ", did you mean 'fov_y'?"
        );
        assert_eq!(suggestion("zzzzzz", ["eye", "up"]), "");
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn a_chain_of_sources_says_everything_once() {
        let path = Path::new("room.obj");
        let io = || std::io::Error::other("the disk is on fire");
        let scene = sheen_solver::SceneError::NoSurface;
        let errors = [
            (io_error(path)(io()), io().to_string()),
            (FormatError::content(path, "is torn"), "is torn".to_owned()),
            (FormatError::line(path, 7, "is torn"), "is torn".to_owned()),
            (
                FormatError::Scene {
                    path: path.to_owned(),
                    cause: scene.clone(),
                },
                scene.to_string(),
            ),
        ];
        for (error, reason) in errors {
            let first: &dyn std::error::Error = &error;
            let chain: Vec<String> = std::iter::successors(Some(first), |error| error.source())
                .map(ToString::to_string)
                .collect();
            let text = chain.join(": ");
            let times = |part: &str| text.matches(part).count();
            assert_eq!((times("room.obj"), times(&reason)), (1, 1), "{text}");
        }
    }

    #[test]
    fn every_text_is_one_line() {
        let error = FormatError::content(
            Path::new("a\nb.obj"),
            format!("x\ny\u{2028}{}", "z".repeat(5000)),
        );
        let text = error.to_string();
        assert!(
            !text.contains(['\n', '\r', '\u{2028}']) && text.len() < 1200,
            "{text}"
        );
    }
}
