//! The header of a PLY: the elements that follow, their properties, their encoding.

use super::error::FormatError;
use super::scalar::{Endian, Scalar};
use super::text::{LineReader, parse_count, quoted, words};

/// Name of the format in messages.
pub(super) const FORMAT: &str = "PLY";

/// Encoding of the elements.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    /// As text, one element per line.
    Ascii,
    Binary(Endian),
}

/// The type of a property.
pub(super) enum PlyProperty {
    /// One number.
    Scalar(Scalar),
    /// A count and that many numbers.
    List { count: Scalar, item: Scalar },
}

/// An element of the file.
pub(super) struct PlyElement {
    /// `vertex`, `face`, ...
    pub(super) name: String,
    /// Number of records, not yet compared with the size of the file.
    pub(super) count: u64,
    /// Name and type, in file order.
    pub(super) properties: Vec<(String, PlyProperty)>,
}

pub(super) struct PlyHeader {
    pub(super) encoding: PlyEncoding,
    /// In file order.
    pub(super) elements: Vec<PlyElement>,
}

/// An error at the line that was read last.
pub(super) fn line_error(
    lines: &LineReader<'_>,
    expected: &str,
    got: impl Into<String>,
) -> FormatError {
    FormatError::Line {
        format: FORMAT,
        line: lines.line.max(1),
        expected: expected.to_owned(),
        got: got.into(),
    }
}

fn scalar_type(name: Option<&[u8]>) -> Option<Scalar> {
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

/// Reads the header up to and including `end_header`.
///
/// # Errors
/// [`FormatError::Line`] at the first line that is no PLY header line.
pub(super) fn read_header(lines: &mut LineReader<'_>) -> Result<PlyHeader, FormatError> {
    let first = lines.next_line().unwrap_or_default();
    if !first.eq_ignore_ascii_case(b"ply") {
        return Err(line_error(lines, "`ply`", quoted(first)));
    }
    // Lines that end in LF CR: the CR is no byte of the data.
    let ends_in_cr = lines.rest().starts_with(b"\r");
    let mut encoding = None;
    let mut elements: Vec<PlyElement> = Vec::new();
    loop {
        let Some(line) = lines.next_line() else {
            return Err(line_error(lines, "`end_header`", "the end of the file"));
        };
        // Some writers use capitals.
        let lower = line.to_ascii_lowercase();
        let mut words = words(&lower);
        let bad =
            |lines: &LineReader<'_>, expected: &str| Err(line_error(lines, expected, quoted(line)));
        match words.next() {
            None | Some(b"comment" | b"obj_info") => {}
            Some(b"format") => {
                encoding = Some(match words.next() {
                    Some(b"ascii") => PlyEncoding::Ascii,
                    Some(b"binary_little_endian") => PlyEncoding::Binary(Endian::Little),
                    Some(b"binary_big_endian") => PlyEncoding::Binary(Endian::Big),
                    _ => {
                        return bad(
                            lines,
                            "`format ascii|binary_little_endian|binary_big_endian 1.0`",
                        );
                    }
                });
            }
            Some(b"element") => {
                let (Some(name), Some(count)) = (words.next(), parse_count(words.next())) else {
                    return bad(lines, "`element NAME COUNT`");
                };
                elements.push(PlyElement {
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
                    match (scalar_type(words.next()), scalar_type(words.next())) {
                        (Some(count), Some(item)) => Some(PlyProperty::List { count, item }),
                        _ => None,
                    }
                } else {
                    scalar_type(kind).map(PlyProperty::Scalar)
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
            Some(b"end_header") => {
                if ends_in_cr && lines.rest().starts_with(b"\r") {
                    lines.offset += 1;
                }
                break;
            }
            Some(_) => return bad(lines, "a PLY header line"),
        }
    }
    match encoding {
        Some(encoding) => Ok(PlyHeader { encoding, elements }),
        None => Err(line_error(lines, "a `format` line in the header", "none")),
    }
}
