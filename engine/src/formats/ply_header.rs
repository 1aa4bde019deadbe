//! The header of a PLY: which elements follow, of which properties, written how.

use super::cloud::FormatError;
use super::scalar::{Endian, Scalar};
use super::text::{Lines, count, quoted, words};

/// Name of the format in messages.
pub const FORMAT: &str = "PLY";

/// How the data are written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// As text, one element per line.
    Ascii,
    /// As bytes.
    Binary(Endian),
}

/// A property: one number, or a counted list of them.
pub enum Property {
    /// One number.
    Scalar(Scalar),
    /// A counted list of numbers.
    List {
        /// Type of the count.
        count: Scalar,
        /// Type of the items.
        item: Scalar,
    },
}

/// A kind of thing in the file.
pub struct Element {
    /// `vertex`, `face`, ...
    pub name: String,
    /// As the header claims.
    pub count: u64,
    /// Name and type, in file order.
    pub properties: Vec<(String, Property)>,
}

/// What the header says.
pub struct Header {
    /// How the data are written.
    pub encoding: Encoding,
    /// In file order.
    pub elements: Vec<Element>,
}

/// An error at the line that was read last.
pub fn line_error(lines: &Lines<'_>, expected: &str, got: impl Into<String>) -> FormatError {
    FormatError::Line {
        format: FORMAT,
        line: lines.line.max(1),
        expected: expected.to_owned(),
        got: got.into(),
    }
}

fn scalar(name: Option<&[u8]>) -> Option<Scalar> {
    Some(match name? {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"int64" => Scalar::I64,
        b"uint64" => Scalar::U64,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return None,
    })
}

/// Reads the header up to and with `end_header`.
///
/// # Errors
/// [`FormatError::Line`] at the first line that is no PLY header line.
pub fn read_header(lines: &mut Lines<'_>) -> Result<Header, FormatError> {
    let first = lines.next_line().unwrap_or_default();
    if first != b"ply" {
        return Err(line_error(lines, "`ply`", quoted(first)));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(line) = lines.next_line() else {
            return Err(line_error(lines, "`end_header`", "the end of the file"));
        };
        let mut words = words(line);
        let bad =
            |lines: &Lines<'_>, expected: &str| Err(line_error(lines, expected, quoted(line)));
        match words.next() {
            None | Some(b"comment" | b"obj_info") => {}
            Some(b"format") => {
                encoding = Some(match words.next() {
                    Some(b"ascii") => Encoding::Ascii,
                    Some(b"binary_little_endian") => Encoding::Binary(Endian::Little),
                    Some(b"binary_big_endian") => Encoding::Binary(Endian::Big),
                    _ => {
                        return bad(
                            lines,
                            "`format ascii|binary_little_endian|binary_big_endian 1.0`",
                        );
                    }
                });
            }
            Some(b"element") => {
                let (Some(name), Some(count)) = (words.next(), count(words.next())) else {
                    return bad(lines, "`element NAME COUNT`");
                };
                elements.push(Element {
                    name: String::from_utf8_lossy(name).into_owned(),
                    count,
                    properties: Vec::new(),
                });
            }
            Some(b"property") => {
                let Some(element) = elements.last_mut() else {
                    return bad(lines, "an `element` before its properties");
                };
                let kind = words.next();
                let property = if kind == Some(b"list") {
                    match (scalar(words.next()), scalar(words.next())) {
                        (Some(count), Some(item)) => Some(Property::List { count, item }),
                        _ => None,
                    }
                } else {
                    scalar(kind).map(Property::Scalar)
                };
                let (Some(property), Some(name)) = (property, words.next()) else {
                    return bad(
                        lines,
                        "`property TYPE NAME` or `property list TYPE TYPE NAME`",
                    );
                };
                let name = String::from_utf8_lossy(name).into_owned();
                element.properties.push((name, property));
            }
            Some(b"end_header") => break,
            Some(_) => return bad(lines, "a PLY header line"),
        }
    }
    match encoding {
        Some(encoding) => Ok(Header { encoding, elements }),
        None => Err(line_error(lines, "a `format` line in the header", "none")),
    }
}
