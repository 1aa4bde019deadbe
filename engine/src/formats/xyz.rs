//! XYZ text: one point per line, numbers separated by blanks, commas or semicolons. `#` begins a comment; further columns
//! are ignored; a first line with the names of the columns (`x y z`, `x,y,z,intensity`) is skipped.

use super::cloud::CloudFile;
use super::error::FormatError;
use super::text::{LineReader, parse_number, quoted};
use nalgebra::Point3;

const FORMAT: &str = "XYZ text";

/// Reads XYZ text, without normals: further columns have no names.
///
/// # Errors
/// [`FormatError::Line`] at the first line without three numbers, or if there is no point at all.
pub(super) fn read(bytes: &[u8]) -> Result<CloudFile, FormatError> {
    let mut lines = LineReader::new(bytes);
    let mut points = Vec::with_capacity(bytes.len() / 20);
    let mut first = true;
    while let Some(line) = lines.next_line() {
        let text = line.split(|b| *b == b'#').next().unwrap_or_default();
        let mut words = text
            .split(|b| b.is_ascii_whitespace() || matches!(b, b',' | b';'))
            .filter(|w| !w.is_empty());
        let xyz = [words.next(), words.next(), words.next()];
        if xyz == [None; 3] {
            continue;
        }
        let names = [b"x", b"y", b"z"];
        if std::mem::take(&mut first)
            && xyz
                .iter()
                .zip(names)
                .all(|(w, n)| w.is_some_and(|w| w.eq_ignore_ascii_case(n)))
        {
            continue;
        }
        let mut point = Point3::origin();
        for ((out, word), name) in point.iter_mut().zip(xyz).zip(["x", "y", "z"]) {
            *out = word
                .and_then(parse_number)
                .ok_or_else(|| FormatError::Line {
                    format: FORMAT,
                    line: lines.line,
                    expected: format!("a number for {name}"),
                    got: word.map_or_else(|| "the end of the line".to_owned(), quoted),
                })?;
        }
        points.push(point);
    }
    if points.is_empty() {
        return Err(FormatError::Line {
            format: FORMAT,
            line: lines.line.max(1),
            expected: "at least one point".to_owned(),
            got: "comments only".to_owned(),
        });
    }
    Ok(CloudFile {
        points,
        normals: None,
    })
}

#[cfg(test)]
mod tests {
    use super::read;
    use nalgebra::Point3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_separator_and_line_end_is_read(
            points in proptest::collection::vec(proptest::array::uniform3(-1e9f64..1e9), 1..40),
            separator in prop_oneof![Just(" "), Just(","), Just(";"), Just("\t"), Just(", "), Just(" ; ")],
            end in prop_oneof![Just("\n"), Just("\r\n"), Just(" # why\n"), Just(" 0.5 7\n\n")],
        ) {
            let mut text = String::from("# a cloud\n");
            for [x, y, z] in &points {
                text += &format!("{x}{separator}{y}{separator}{z}{end}");
            }
            let cloud = read(text.as_bytes()).expect("well-formed text");
            prop_assert_eq!(cloud.points, points.into_iter().map(Point3::from).collect::<Vec<_>>());
        }
    }

    #[test]
    fn column_names_on_the_first_line_are_skipped() {
        let cloud = read(b"X,Y,Z,intensity\n1,2,3,9\nnan,nan,nan,0\n").expect("a table");
        assert_eq!(cloud.points.len(), 2);
        assert_eq!(cloud.points[0], Point3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn prose_and_short_lines_are_errors() {
        let cases: [(&[u8], &str); 5] = [
            (
                b"It was a dark and stormy night.\n",
                "XYZ text line 1: expected a number for x, got \"It\"",
            ),
            (
                b"1 2 3\n\n4 5\n",
                "XYZ text line 3: expected a number for z, got the end of the line",
            ),
            (
                b"# nothing\n#\n",
                "XYZ text line 2: expected at least one point, got comments only",
            ),
            (
                b"1 2 3\nx y z\n",
                "XYZ text line 2: expected a number for x, got \"x\"",
            ),
            (
                b"\x00\xff\n",
                "XYZ text line 1: expected a number for x, got \"\\0\u{fffd}\"",
            ),
        ];
        for (bytes, message) in cases {
            assert_eq!(read(bytes).expect_err(message).to_string(), message);
        }
    }
}
