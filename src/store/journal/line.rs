//! One line of the journal: a row of the database as JSON, after its checksum. The form is in docs/contract.md.

use super::super::checksum::sha256_hex;
use super::super::error::StoreError;
use rusqlite::Row;
use rusqlite::types::{Value, ValueRef};
use serde_json::{Map, json};
use std::fmt::Write as _;
use std::io::{self, BufRead};

/// Hexadecimal digits of SHA-256 before each line: a line torn or changed is found out with a chance of 1 in 2^64 to miss.
const CHECKSUM_DIGITS: usize = 16;

/// The columns of a row with their values.
pub(in crate::store) type RowValues = Vec<(String, Value)>;

/// A row as it was when the line was written.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::store) struct JournalLine {
    /// Rises with every change.
    pub(in crate::store) number: i64,
    pub(in crate::store) table: String,
    pub(in crate::store) id: i64,
    /// `None`: the row was deleted.
    pub(in crate::store) row: Option<RowValues>,
}

/// All columns of a row.
pub(in crate::store) fn row_values(row: &Row<'_>) -> rusqlite::Result<RowValues> {
    let names: Vec<String> = row
        .as_ref()
        .column_names()
        .into_iter()
        .map(str::to_owned)
        .collect();
    let value = |(at, name): (usize, String)| -> rusqlite::Result<(String, Value)> {
        Ok((name, row.get(at)?))
    };
    names.into_iter().enumerate().map(value).collect()
}

impl JournalLine {
    /// With its checksum and its end.
    pub(in crate::store) fn to_text(&self) -> Result<String, StoreError> {
        let row = self.row.as_ref().map(|values| {
            let entry = |(name, value): &(String, Value)| (name.clone(), to_json(value.into()));
            values.iter().map(entry).collect::<Map<_, _>>()
        });
        let json = json!({"n": self.number, "table": self.table, "id": self.id, "row": row});
        let text = serde_json::to_string(&json).map_err(|source| StoreError::Record {
            what: "journal line",
            source,
        })?;
        let sum = sha256_hex(text.as_bytes());
        Ok(format!("{} {text}\n", &sum[..CHECKSUM_DIGITS]))
    }

    /// `None`: torn, changed, or of another program.
    pub(super) fn from_text(line: &str) -> Option<Self> {
        let (sum, text) = line.trim_end_matches('\n').split_once(' ')?;
        if sum.len() != CHECKSUM_DIGITS || !sha256_hex(text.as_bytes()).starts_with(sum) {
            return None;
        }
        let json: serde_json::Value = serde_json::from_str(text).ok()?;
        let row = match json.get("row")? {
            serde_json::Value::Null => None,
            row => {
                let entry = |(name, value): (&String, _)| Some((name.clone(), from_json(value)?));
                Some(row.as_object()?.iter().map(entry).collect::<Option<_>>()?)
            }
        };
        Some(Self {
            number: json.get("n")?.as_i64()?,
            table: json.get("table")?.as_str()?.to_owned(),
            id: json.get("id")?.as_i64()?,
            row,
        })
    }
}

/// Calls `each` for every line; returns how many are damaged.
///
/// # Errors
/// Reading fails, or `each` does.
pub(in crate::store) fn read_lines<E: From<io::Error>>(
    mut journal: impl BufRead,
    mut each: impl FnMut(JournalLine) -> Result<(), E>,
) -> Result<usize, E> {
    let mut damaged = 0;
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        if journal.read_until(b'\n', &mut bytes)? == 0 {
            return Ok(damaged);
        }
        let line = std::str::from_utf8(&bytes).ok();
        match line.and_then(JournalLine::from_text) {
            Some(line) => each(line)?,
            None => damaged += 1,
        }
    }
}

/// Reals as text, because a parser of JSON may move their last bit; bytes in hexadecimal digits.
fn to_json(value: ValueRef<'_>) -> serde_json::Value {
    match value {
        ValueRef::Null => serde_json::Value::Null,
        ValueRef::Integer(number) => json!(number),
        ValueRef::Real(number) => json!({"real": number.to_string()}),
        ValueRef::Text(text) => json!(String::from_utf8_lossy(text)),
        ValueRef::Blob(bytes) => {
            let digits = bytes.iter().fold(String::new(), |mut text, byte| {
                // Writing to a String cannot fail.
                let _ = write!(text, "{byte:02x}");
                text
            });
            json!({"hex": digits})
        }
    }
}

fn from_json(value: &serde_json::Value) -> Option<Value> {
    match value {
        serde_json::Value::Null => Some(Value::Null),
        serde_json::Value::Number(number) => Some(Value::Integer(number.as_i64()?)),
        serde_json::Value::String(text) => Some(Value::Text(text.clone())),
        serde_json::Value::Object(typed) => match (typed.get("real"), typed.get("hex")) {
            (Some(real), None) => Some(Value::Real(real.as_str()?.parse().ok()?)),
            (None, Some(digits)) => bytes_of(digits.as_str()?).map(Value::Blob),
            _ => None,
        },
        _ => None,
    }
}

fn bytes_of(digits: &str) -> Option<Vec<u8>> {
    let byte = |at| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    (0..digits.len()).step_by(2).map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::{JournalLine, read_lines};
    use rusqlite::types::Value;
    use std::io;

    fn line(id: i64) -> JournalLine {
        let row = [
            ("id", Value::Integer(id)),
            ("figure", Value::Real(0.1 + 0.2)),
            ("whole", Value::Real(2.0)),
            ("text", Value::Text("a\n\"b\" ä".to_owned())),
            ("bytes", Value::Blob(vec![0, 255, 16])),
            ("nothing", Value::Null),
        ];
        JournalLine {
            number: 10 + id,
            table: "visit".to_owned(),
            id,
            row: Some(row.map(|(name, value)| (name.to_owned(), value)).into()),
        }
    }

    fn read(bytes: &[u8]) -> (Vec<JournalLine>, usize) {
        let mut lines = Vec::new();
        let damaged = read_lines(bytes, |line| -> io::Result<()> {
            lines.push(line);
            Ok(())
        });
        (lines, damaged.expect("read"))
    }

    fn sorted(mut line: JournalLine) -> JournalLine {
        line.row
            .iter_mut()
            .for_each(|row| row.sort_by(|a, b| a.0.cmp(&b.0)));
        line
    }

    #[test]
    fn a_row_is_read_back_to_the_last_bit() {
        let deleted = JournalLine {
            row: None,
            ..line(2)
        };
        let text = line(1).to_text().expect("text") + &deleted.to_text().expect("text");
        assert_eq!(text.lines().count(), 2);
        let (lines, damaged) = read(text.as_bytes());
        let lines: Vec<_> = lines.into_iter().map(sorted).collect();
        assert_eq!((lines, damaged), (vec![sorted(line(1)), deleted], 0));
    }

    #[test]
    fn a_torn_or_changed_line_is_counted_and_the_others_are_read() {
        let texts = [1, 2, 3].map(|id| line(id).to_text().expect("text"));
        let torn = &texts[1][..texts[1].len() / 2];
        let bytes = format!("{}{torn}\n{}", texts[0], texts[2]);
        let ids = |lines: &[JournalLine]| lines.iter().map(|line| line.id).collect::<Vec<_>>();
        let (lines, damaged) = read(bytes.as_bytes());
        assert_eq!((ids(&lines), damaged), (vec![1, 3], 1));
        for at in 0..texts[1].len() - 1 {
            let mut bytes = texts.concat().into_bytes();
            bytes[texts[0].len() + at] ^= 4;
            let (lines, damaged) = read(&bytes);
            assert_eq!((ids(&lines), damaged), (vec![1, 3], 1), "byte {at}");
        }
    }
}
