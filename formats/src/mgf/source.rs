//! The lines of an MGF file and the words in them. No meaning yet, save that every `xf` block is closed.

use crate::error::{FormatError, quote};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// One entity as written, continuation lines joined.
pub(super) struct Line {
    /// First line of it in the file, from 1.
    pub(super) number: usize,
    /// The keyword, then its arguments; never empty.
    pub(super) words: Vec<String>,
    /// Of an `xf` that opens a block: index of the line that closes it. Of all others: its own index.
    pub(super) end: usize,
}

/// A file, split.
pub(super) struct Source {
    pub(super) path: PathBuf,
    pub(super) lines: Vec<Line>,
}

impl Source {
    /// Splits the content of `path`; every `xf` must find its end.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, FormatError> {
        let mut source = Self {
            path: path.to_owned(),
            lines: split_lines(&decode(bytes)),
        };
        let mut open: Vec<usize> = Vec::new();
        for index in 0..source.lines.len() {
            if source.lines[index].words[0] != "xf" {
                continue;
            }
            if source.lines[index].words.len() > 1 {
                open.push(index);
            } else if let Some(start) = open.pop() {
                source.lines[start].end = index;
            } else {
                return Err(source
                    .entity(index)
                    .fault("'xf' ends a transform, but none is open"));
            }
        }
        match open.pop() {
            Some(index) => Err(source
                .entity(index)
                .fault("this 'xf' is still open at the end of the file: expected a line 'xf'")),
            None => Ok(source),
        }
    }

    /// The entity at a line index.
    pub(super) fn entity(&self, index: usize) -> Entity<'_> {
        Entity {
            source: self,
            line: &self.lines[index],
        }
    }
}

/// An entity with its place, for messages.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a> {
    source: &'a Source,
    line: &'a Line,
}

impl<'a> Entity<'a> {
    pub(super) fn keyword(self) -> &'a str {
        &self.line.words[0]
    }

    pub(super) fn arguments(self) -> &'a [String] {
        &self.line.words[1..]
    }

    /// Folder that file names in this entity are relative to.
    pub(super) fn folder(self) -> &'a Path {
        self.source.path.parent().unwrap_or(Path::new(""))
    }

    /// `file:line`.
    pub(super) fn place(self) -> String {
        format!("{}:{}", self.source.path.display(), self.line.number)
    }

    /// An error at this line.
    pub(super) fn fault(self, message: impl Display) -> FormatError {
        FormatError::Line {
            path: self.source.path.clone(),
            line: self.line.number,
            message: message.to_string(),
        }
    }

    /// Refuses any other number of arguments; `form` shows how the entity is written.
    pub(super) fn expect_count(self, count: usize, form: &str) -> Result<(), FormatError> {
        if self.arguments().len() == count {
            Ok(())
        } else {
            Err(self.wrong_count(form))
        }
    }

    /// The error for a wrong number of arguments.
    pub(super) fn wrong_count(self, form: &str) -> FormatError {
        self.fault(format!(
            "expected '{form}', found {} arguments",
            self.arguments().len()
        ))
    }

    /// Argument `index` as a finite number; `what` names it in the error.
    pub(super) fn number(self, index: usize, what: &str) -> Result<f64, FormatError> {
        let word = self.arguments().get(index).map_or("", String::as_str);
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ if word.is_empty() => {
                Err(self.fault(format!("{}: expected a number for {what}", self.keyword())))
            }
            _ => Err(self.fault(format!(
                "{}: expected a finite number for {what}, found {}",
                self.keyword(),
                quote(word)
            ))),
        }
    }
}

/// UTF-8, and where that fails Latin-1, as Radiance's own tools take any byte.
fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

fn split_lines(text: &str) -> Vec<Line> {
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines = Vec::new();
    let mut pending: Option<(usize, String)> = None;
    let mut finish = |(number, text): (usize, String)| {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            return;
        }
        let end = lines.len();
        lines.push(Line {
            number,
            words: split_words(text),
            end,
        });
    };
    for (index, raw) in text.split('\n').enumerate() {
        let (number, mut joined) = pending.take().unwrap_or((index + 1, String::new()));
        if let Some(continued) = raw.strip_suffix('\\') {
            joined.push_str(continued);
            joined.push(' ');
            pending = Some((number, joined));
        } else {
            joined.push_str(raw);
            finish((number, joined));
        }
    }
    if let Some(unfinished) = pending {
        finish(unfinished);
    }
    lines
}

/// Words between white space; one that starts with a quote reaches to the next quote of its kind.
fn split_words(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let (word, after) = if first == '"' || first == '\'' {
            rest[1..].split_once(first).unwrap_or((&rest[1..], ""))
        } else {
            rest.split_at(rest.find(char::is_whitespace).unwrap_or(rest.len()))
        };
        words.push(word.to_owned());
        rest = after.trim_start();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_quotes_and_continuations() {
        let text = "# c\\\n still c\r\nm \"two words\" =\rp 1 \\\n 2 'x y'z\n\\\n";
        let lines = split_lines(text);
        let words: Vec<(usize, Vec<&str>)> = lines
            .iter()
            .map(|l| (l.number, l.words.iter().map(String::as_str).collect()))
            .collect();
        assert_eq!(
            words,
            [
                (3, vec!["m", "two words", "="]),
                (4, vec!["p", "1", "2", "x y", "z"])
            ]
        );
    }

    #[test]
    fn bytes_that_are_not_utf8_are_latin1() {
        assert_eq!(decode(b"caf\xe9"), "café");
        assert_eq!(decode("\u{feff}café".as_bytes()), "café");
    }
}
