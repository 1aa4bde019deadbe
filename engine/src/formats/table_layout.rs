//! How the lines of a text table are cut into cells, and where its coordinates stand.

use super::columns::Columns;
use super::number::{parse_decimal_comma, parse_number};

/// Marks in front of a comment. A semicolon may also separate cells.
const COMMENT_MARKS: [&[u8]; 4] = [b"#", b"%", b"//", b";"];

/// What stands between the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Blanks,
    Tab,
    Comma,
    Semicolon,
}

/// How a table is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TableLayout {
    separator: Separator,
    pub(super) columns: Columns,
    /// Number of names of columns; 0 without. Where they have names, an empty cell is a cell.
    names: usize,
    /// The names stood in a comment: prose may have an x, a y and a z too.
    in_comment: bool,
}

impl TableLayout {
    /// The layout that a line with the names of the columns announces; `None` if it names no x y z. Marks of a comment before
    /// the names are no part of them.
    pub(super) fn of_header(line: &[u8]) -> Option<Self> {
        let marks = COMMENT_MARKS.iter().take(3);
        let names = marks.fold(line, |line, mark| line.strip_prefix(*mark).unwrap_or(line));
        let separator = match names {
            names if names.contains(&b';') => Separator::Semicolon,
            names if names.contains(&b',') => Separator::Comma,
            names if names.contains(&b'\t') => Separator::Tab,
            _ => Separator::Blanks,
        };
        let mut cells = Vec::new();
        cut(names, separator, &mut cells);
        // Units after blanks are words of their own.
        cells.retain(|cell| separator != Separator::Blanks || !cell.starts_with(b"["));
        let columns = Columns::find(cells.iter().map(|cell| std::str::from_utf8(cell).ok()))?;
        Some(Self {
            separator,
            columns,
            names: cells.len(),
            in_comment: is_comment(line),
        })
    }

    /// The layout of a table whose first line of numbers is `line`; `header` is what a line before it announced.
    pub(super) fn of_first_line(line: &[u8], header: Option<Self>) -> Self {
        let mut cells = Vec::new();
        if let Some(header) = header {
            // A table of blanks may have a header of commas, and the other way round.
            let separator = match header.separator {
                Separator::Comma if !line.contains(&b',') => Separator::Blanks,
                Separator::Blanks if line.contains(&b',') => Separator::Comma,
                separator => separator,
            };
            cut(line, separator, &mut cells);
            let is_trusted = !header.in_comment || header.columns == Columns::IN_ORDER;
            if is_trusted || cells.len() == header.names {
                return Self {
                    separator,
                    ..header
                };
            }
        }
        cut(line, Separator::Blanks, &mut cells);
        let are_numbers = |cells: &[&[u8]]| {
            let first = cells.iter().take(3);
            first
                .filter(|cell| number(cell, Separator::Blanks).is_some())
                .count()
                == 3
        };
        let separator = match line {
            line if line.contains(&b';') => Separator::Semicolon,
            // Otherwise the commas are decimal.
            line if line.contains(&b',') && !are_numbers(&cells) => Separator::Comma,
            _ => Separator::Blanks,
        };
        Self {
            separator,
            columns: Columns::IN_ORDER,
            names: 0,
            in_comment: false,
        }
    }

    /// The cells of `line`, in `cells`.
    pub(super) fn cut<'a>(&self, line: &'a [u8], cells: &mut Vec<&'a [u8]>) {
        cut(line, self.separator, cells);
        if self.names > 0 || matches!(self.separator, Separator::Blanks | Separator::Tab) {
            return;
        }
        // Without names, blanks within a cell separate too: `1,2,3 0.5 7`.
        let mut words: Vec<&[u8]> = Vec::with_capacity(cells.len());
        for cell in cells.iter() {
            if cell.is_empty() {
                words.push(cell);
            }
            words.extend(
                cell.split(u8::is_ascii_whitespace)
                    .filter(|w| !w.is_empty()),
            );
        }
        *cells = words;
    }

    /// The number of a cell.
    pub(super) fn number(&self, cell: &[u8]) -> Option<f64> {
        number(cell, self.separator)
    }
}

fn number(cell: &[u8], separator: Separator) -> Option<f64> {
    parse_number(cell).or_else(|| match separator {
        Separator::Comma => None,
        _ => parse_decimal_comma(cell),
    })
}

/// Whether `line` is a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    COMMENT_MARKS.iter().any(|mark| line.starts_with(mark))
}

/// `line` without a comment at its end, which `#` begins; within a word (`1.#IND`) it begins none.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    let begins = |at: &usize| {
        line.get(*at) == Some(&b'#')
            && !line
                .get(at.wrapping_sub(1))
                .is_some_and(u8::is_ascii_graphic)
    };
    let end = (0..line.len()).find(begins).unwrap_or(line.len());
    line.get(..end).unwrap_or_default().trim_ascii()
}

/// Cells between separators, without blanks and quotes around them.
fn cut<'a>(line: &'a [u8], separator: Separator, cells: &mut Vec<&'a [u8]>) {
    cells.clear();
    let mark = match separator {
        Separator::Blanks => {
            let words = line.split(u8::is_ascii_whitespace);
            cells.extend(words.filter(|w| !w.is_empty()).map(unquoted));
            return;
        }
        Separator::Tab => b'\t',
        Separator::Comma => b',',
        Separator::Semicolon => b';',
    };
    let mut is_quoted = false;
    let between = line.split(|b| {
        is_quoted ^= *b == b'"';
        *b == mark && !is_quoted
    });
    cells.extend(between.map(<[u8]>::trim_ascii).map(unquoted));
}

fn unquoted(cell: &[u8]) -> &[u8] {
    match cell {
        [b'"', inside @ .., b'"'] => inside.trim_ascii(),
        cell => cell,
    }
}
