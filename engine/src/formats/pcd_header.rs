//! The header of a PCD: the fields of a point, the number of points, their encoding.

use super::error::FormatError;
use super::number::parse_number;
use super::scalar::Scalar;
use super::text::{LineReader, parse_count, quoted, words};
use nalgebra::Point3;

/// Name of the format in messages.
pub(super) const FORMAT: &str = "PCD";
/// Larger `COUNT`s are taken for damage: the widest known descriptor has 1980 numbers.
const MAX_FIELD_COUNT: u64 = 1 << 20;

/// A named field of a point, of one or more numbers.
pub(super) struct PcdField {
    pub(super) name: Vec<u8>,
    pub(super) scalar: Scalar,
    /// Numbers per point.
    pub(super) count: usize,
}

/// Encoding of the points.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdEncoding {
    /// As text, one point per line.
    Ascii,
    /// Point by point.
    Binary,
    /// LZF of the points field by field.
    Compressed,
}

pub(super) struct PcdHeader {
    /// In file order.
    pub(super) fields: Vec<PcdField>,
    /// Number of points, not yet compared with the size of the file.
    pub(super) points: u64,
    pub(super) encoding: PcdEncoding,
    /// Position of the sensor, metres.
    pub(super) viewpoint: Option<Point3<f64>>,
}

/// An error at the line that was read last.
pub(super) fn line_error(
    lines: &LineReader<'_>,
    expected: impl Into<String>,
    got: impl Into<String>,
) -> FormatError {
    FormatError::Line {
        format: FORMAT,
        line: lines.line.max(1),
        expected: expected.into(),
        got: got.into(),
    }
}

/// Reads the header up to and including `DATA`.
///
/// # Errors
/// [`FormatError::Line`] at the first line that is no PCD header line, or if lines contradict each other.
pub(super) fn read_header(lines: &mut LineReader<'_>) -> Result<PcdHeader, FormatError> {
    let mut names: Vec<&[u8]> = Vec::new();
    let (mut sizes, mut types, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut width, mut height, mut points) = (None, None, None);
    let mut viewpoint = None;
    let encoding = loop {
        let Some(line) = lines.next_filled() else {
            return Err(line_error(lines, "a `DATA` line", "the end of the file"));
        };
        if line.starts_with(b"#") {
            continue;
        }
        let mut words = words(line);
        // Some writers use small letters.
        let keyword = words.next().unwrap_or_default().to_ascii_uppercase();
        let numbers = |words: &mut dyn Iterator<Item = &[u8]>| -> Option<Vec<u64>> {
            words.map(|w| parse_count(Some(w))).collect()
        };
        let bad = |expected: &str| Err(line_error(lines, expected, quoted(line)));
        match keyword.as_slice() {
            b"VERSION" => {}
            b"VIEWPOINT" => {
                let position: Vec<f64> = words.take(3).filter_map(parse_number).collect();
                let is_finite = position.iter().all(|c| c.is_finite());
                let [x, y, z] = position[..] else {
                    return bad("a position and a rotation after `VIEWPOINT`");
                };
                viewpoint = is_finite.then(|| Point3::new(x, y, z));
            }
            b"FIELDS" | b"COLUMNS" => names = words.collect(),
            b"TYPE" => types = words.collect(),
            b"SIZE" => match numbers(&mut words) {
                Some(given) => sizes = given,
                None => return bad("whole numbers after `SIZE`"),
            },
            b"COUNT" => match numbers(&mut words) {
                Some(given) if given.iter().all(|n| *n <= MAX_FIELD_COUNT) => counts = given,
                _ => return bad("small whole numbers after `COUNT`"),
            },
            b"WIDTH" | b"HEIGHT" | b"POINTS" => {
                let Some(given) = parse_count(words.next()) else {
                    return bad("a whole number after `WIDTH`, `HEIGHT`, `POINTS`");
                };
                match keyword.as_slice() {
                    b"WIDTH" => width = Some(given),
                    b"HEIGHT" => height = Some(given),
                    _ => points = Some(given),
                }
            }
            b"DATA" => match words.next().map(<[u8]>::to_ascii_lowercase).as_deref() {
                Some(b"ascii") => break PcdEncoding::Ascii,
                Some(b"binary") => break PcdEncoding::Binary,
                Some(b"binary_compressed") => break PcdEncoding::Compressed,
                _ => return bad("`DATA ascii|binary|binary_compressed`"),
            },
            _ => return bad("a PCD header line"),
        }
    };
    if sizes.len() != names.len() || types.len() != names.len() {
        let got = format!(
            "{} FIELDS, {} SIZE, {} TYPE",
            names.len(),
            sizes.len(),
            types.len()
        );
        return Err(line_error(lines, "one SIZE and TYPE per field", got));
    }
    if counts.is_empty() {
        counts = vec![1; names.len()];
    }
    if counts.len() != names.len() {
        let got = format!("{} FIELDS, {} COUNT", names.len(), counts.len());
        return Err(line_error(lines, "one COUNT per field", got));
    }
    let mut fields = Vec::with_capacity(names.len());
    for (((name, size), kind), count) in names.iter().zip(&sizes).zip(&types).zip(&counts) {
        let scalar = match (kind.to_ascii_uppercase().as_slice(), size) {
            (b"I", 1) => Scalar::I8,
            (b"I", 2) => Scalar::I16,
            (b"I", 4) => Scalar::I32,
            (b"I", 8) => Scalar::I64,
            (b"U", 1) => Scalar::U8,
            (b"U", 2) => Scalar::U16,
            (b"U", 4) => Scalar::U32,
            (b"U", 8) => Scalar::U64,
            (b"F", 4) => Scalar::F32,
            (b"F", 8) => Scalar::F64,
            _ => {
                let got = format!("TYPE {} SIZE {size}", quoted(kind));
                return Err(line_error(
                    lines,
                    "types I, U of 1, 2, 4, 8 or F of 4, 8 bytes",
                    got,
                ));
            }
        };
        fields.push(PcdField {
            name: name.to_vec(),
            scalar,
            count: usize::try_from(*count).unwrap_or(usize::MAX),
        });
    }
    let area = width.map(|w| w.checked_mul(height.unwrap_or(1)));
    let points = match (points, area) {
        (Some(points), None) => points,
        (None, Some(Some(area))) => area,
        (Some(points), Some(Some(area))) if points == area => points,
        (points, area) => {
            let number = |n: Option<u64>| n.map_or_else(|| "none".to_owned(), |n| n.to_string());
            let (points, area) = (number(points), number(area.flatten()));
            let got = format!("POINTS {points}, WIDTH x HEIGHT {area}");
            return Err(line_error(lines, "POINTS equal to WIDTH x HEIGHT", got));
        }
    };
    Ok(PcdHeader {
        fields,
        points,
        encoding,
        viewpoint,
    })
}

impl PcdHeader {
    /// Offset of `field` within a point, bytes.
    pub(super) fn offset_in_point(&self, field: usize) -> usize {
        self.fields
            .iter()
            .take(field)
            .map(|f| f.scalar.size() * f.count)
            .sum()
    }
}
