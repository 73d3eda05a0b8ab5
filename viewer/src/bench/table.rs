//! A table that is printed and written: Markdown, CSV, JSON.

use std::fmt::Write;

/// What stands in a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Words.
    Text(String),
    /// A count, exact.
    Count(u64),
    /// A number and its decimals.
    Fixed(f64, usize),
    /// Nothing to tell.
    None,
}

impl serde::Serialize for Value {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Count(count) => serializer.serialize_u64(*count),
            Self::Fixed(number, _) => serializer.serialize_f64(*number),
            Self::None => serializer.serialize_none(),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Count(count) => write!(f, "{count}"),
            Self::Fixed(number, decimals) => write!(f, "{number:.decimals$}"),
            Self::None => Ok(()),
        }
    }
}

/// Rows of values under named columns.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Table {
    /// Short name, as of a file.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// One value a column.
    pub rows: Vec<Vec<Value>>,
    /// What is to be said about all rows, a paragraph each.
    pub notes: Vec<String>,
}

impl Table {
    /// Without rows.
    pub fn new(name: &str, title: &str, columns: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            rows: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// As Markdown: words to the left, numbers to the right.
    pub fn markdown(&self) -> String {
        let mut text = format!("{}\n\n| {} |\n|", self.title, self.columns.join(" | "));
        for column in 0..self.columns.len() {
            let is_text = |row: &Vec<Value>| matches!(row.get(column), Some(Value::Text(_)));
            text.push_str(if self.rows.iter().any(is_text) {
                ":--|"
            } else {
                "--:|"
            });
        }
        text.push('\n');
        for row in &self.rows {
            text.push('|');
            for value in row {
                // Writing to a String does not fail.
                let _ = write!(text, " {value} |");
            }
            text.push('\n');
        }
        for note in &self.notes {
            let _ = write!(text, "\n{note}\n");
        }
        text
    }

    /// As CSV (RFC 4180).
    pub fn csv(&self) -> String {
        let quoted = |text: String| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text
            }
        };
        let line =
            |cells: Vec<String>| cells.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\n";
        let mut text = line(self.columns.clone());
        for row in &self.rows {
            text += &line(row.iter().map(Value::to_string).collect());
        }
        text
    }

    /// As JSON: name, title, columns, rows. Errors: none but those of the writer.
    pub fn json(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_values_in_every_form() {
        let mut table = Table::new("t", "A title", &["what", "count", "s"]);
        table.rows.push(vec![
            Value::Text("a, \"b\"".into()),
            Value::Count(12),
            Value::Fixed(1.25, 1),
        ]);
        table.rows.push(vec![
            Value::Text("c".into()),
            Value::None,
            Value::Fixed(3.0, 1),
        ]);
        let expected = "A title\n\n| what | count | s |\n|:--|--:|--:|\n| a, \"b\" | 12 | 1.2 |\n| c |  | 3.0 |\n";
        assert_eq!(table.markdown(), expected);
        assert_eq!(
            table.csv(),
            "what,count,s\n\"a, \"\"b\"\"\",12,1.2\nc,,3.0\n"
        );
        let json: serde_json::Value =
            serde_json::from_str(&table.json().expect("text")).expect("JSON");
        assert_eq!(json["rows"][0][2], 1.25);
        assert!(json["rows"][1][1].is_null());
    }
}
