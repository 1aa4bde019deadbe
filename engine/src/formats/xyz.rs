//! XYZ text: one point per line, numbers separated by blanks, commas or semicolons, with a decimal point or comma.
//!
//! `#`, `%`, `//` and `;` begin a comment. A first line with the names of the columns (also within a comment) says where x y z
//! and a normal stand; without one they are the first three columns. A line with one whole number before points is their number
//! (PTS, CloudCompare).

use super::cloud::CloudFile;
use super::error::FormatError;
use super::table_layout::{TableLayout, is_comment, without_comment};
use super::text::{LineReader, parse_count, quoted};
use nalgebra::{Point3, Vector3};
use std::borrow::Cow;

const FORMAT: &str = "XYZ text";
/// A blank that is not broken at the end of a line, in UTF-8: text copied from a page has it.
const NO_BREAK_SPACE: &[u8] = b"\xc2\xa0";

/// Reads XYZ text.
///
/// # Errors
/// [`FormatError::Line`] at the first line without its numbers, if there are fewer or more points than the file announces, or
/// none at all.
pub(super) fn read(bytes: &[u8]) -> Result<CloudFile, FormatError> {
    let mut lines = LineReader::new(bytes);
    let mut table = Table::default();
    while let Some(line) = lines.next_line() {
        table.read_line(&with_plain_blanks(line), lines.line)?;
    }
    table.finish(lines.line.max(1))
}

fn with_plain_blanks(line: &[u8]) -> Cow<'_, [u8]> {
    let at = |line: &[u8]| line.windows(2).position(|pair| pair == NO_BREAK_SPACE);
    if at(line).is_none() {
        return Cow::Borrowed(line);
    }
    let mut plain = line.to_vec();
    while let Some(start) = at(&plain) {
        plain.splice(start..start + NO_BREAK_SPACE.len(), [b' ']);
    }
    Cow::Owned(plain)
}

/// What was read so far.
#[derive(Default)]
struct Table {
    header: Option<TableLayout>,
    /// Known from the first line of numbers on.
    layout: Option<TableLayout>,
    /// Points that were announced and have not come.
    announced: Option<u64>,
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
}

impl Table {
    fn read_line(&mut self, line: &[u8], number: usize) -> Result<(), FormatError> {
        if self.layout.is_none()
            && let Some(header) = TableLayout::of_header(line)
        {
            self.header = Some(header);
            return Ok(());
        }
        if is_comment(line) {
            return Ok(());
        }
        let line = without_comment(line);
        if line.is_empty() {
            return Ok(());
        }
        let error = |expected: String, got: String| FormatError::Line {
            format: FORMAT,
            line: number,
            expected,
            got,
        };
        let may_announce = match self.announced {
            None => self.points.is_empty(),
            Some(left) => left == 0,
        };
        if may_announce && let Some(count) = parse_count(Some(line)) {
            self.announced = Some(count);
            return Ok(());
        }
        if let Some(announced) = &mut self.announced {
            let Some(left) = announced.checked_sub(1) else {
                return Err(error(
                    "no more points than announced".to_owned(),
                    quoted(line),
                ));
            };
            *announced = left;
        }
        let header = &mut self.header;
        let layout = self
            .layout
            .get_or_insert_with(|| TableLayout::of_first_line(line, header.take()));
        let mut cells = Vec::new();
        layout.cut(line, &mut cells);
        let three = |columns: [usize; 3], names: [&str; 3]| {
            let mut numbers = [0.0; 3];
            for ((out, column), name) in numbers.iter_mut().zip(columns).zip(names) {
                let cell = cells.get(column);
                *out = cell.and_then(|cell| layout.number(cell)).ok_or_else(|| {
                    error(
                        format!("a number for {name}"),
                        cell.map_or_else(|| "the end of the line".to_owned(), |cell| quoted(cell)),
                    )
                })?;
            }
            Ok(numbers)
        };
        let mut xyz = three(layout.columns.xyz, ["x", "y", "z"])?;
        for (coordinate, unit_m) in xyz.iter_mut().zip(layout.columns.unit_m) {
            *coordinate *= unit_m;
        }
        if let Some(columns) = layout.columns.normal {
            let normal = three(columns, ["nx", "ny", "nz"])?;
            self.normals.push(Vector3::from(normal));
        }
        self.points.push(Point3::from(xyz));
        Ok(())
    }

    fn finish(self, last_line: usize) -> Result<CloudFile, FormatError> {
        let error = |expected: String, got: String| FormatError::Line {
            format: FORMAT,
            line: last_line,
            expected,
            got,
        };
        if let Some(missing @ 1..) = self.announced {
            return Err(error(
                "as many points as announced".to_owned(),
                format!("the end of the file, {missing} short"),
            ));
        }
        if self.points.is_empty() {
            let got = "comments only".to_owned();
            return Err(error("at least one point".to_owned(), got));
        }
        let has_normals = self.normals.len() == self.points.len();
        Ok(CloudFile {
            points: self.points,
            normals: has_normals.then_some(self.normals),
            viewpoint: None,
        })
    }
}

#[cfg(test)]
mod tests;
