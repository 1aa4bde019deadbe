//! The PCD reader (Point Cloud Library, versions .5 to .7): `ascii`, `binary`, `binary_compressed`. Points are returned as
//! stored; the position in `VIEWPOINT` is that of the sensor among them.

use super::cloud::CloudFile;
use super::columns::Columns;
use super::error::FormatError;
use super::lzf;
use super::number::parse_number;
use super::pcd_header::{FORMAT, PcdEncoding, PcdHeader, line_error, read_header};
use super::scalar::Endian;
use super::text::{LineReader, quoted, words};
use nalgebra::{Point3, Vector3};

/// Whether the first line that is no comment is a PCD header line, or a comment before it has the word `.PCD`.
pub(super) fn looks_like_pcd(bytes: &[u8]) -> bool {
    let mut lines = LineReader::new(bytes.get(..4096.min(bytes.len())).unwrap_or_default());
    while let Some(line) = lines.next_filled() {
        if line.starts_with(b"#") {
            if words(line).any(|w| w == b".PCD") {
                return true;
            }
            continue;
        }
        let keyword = words(line).next().map(<[u8]>::to_ascii_uppercase);
        return matches!(
            keyword.as_deref(),
            Some(b"VERSION" | b"FIELDS" | b"COLUMNS")
        );
    }
    false
}

/// Reads a PCD.
///
/// # Errors
/// [`FormatError`] if the header is broken or has no `x y z`, or the data end early or are damaged.
pub(super) fn read(bytes: &[u8]) -> Result<CloudFile, FormatError> {
    let mut lines = LineReader::new(bytes);
    let header = read_header(&mut lines)?;
    let columns = PcdColumns::new(&header, &lines)?;
    match header.encoding {
        PcdEncoding::Ascii => read_ascii(&mut lines, &header, &columns),
        PcdEncoding::Binary => {
            let stride: usize = header
                .fields
                .iter()
                .map(|f| f.scalar.size() * f.count)
                .sum();
            let (points, needed) = checked_size(bytes, lines.offset, &header, stride)?;
            let body = lines.rest().get(..needed).unwrap_or_default();
            Ok(columns.read_columns(
                points,
                |field| {
                    let start = header.offset_in_point(field);
                    (body, start, stride)
                },
                &header,
            ))
        }
        PcdEncoding::Compressed => read_compressed(bytes, lines.offset, &header, &columns),
    }
}

fn byte_error(byte: usize, expected: impl Into<String>, got: impl Into<String>) -> FormatError {
    FormatError::Byte {
        format: FORMAT,
        byte,
        expected: expected.into(),
        got: got.into(),
    }
}

/// The fields with coordinates and normal.
struct PcdColumns {
    xyz: [usize; 3],
    normal: Option<[usize; 3]>,
}

impl PcdColumns {
    fn new(header: &PcdHeader, lines: &LineReader<'_>) -> Result<Self, FormatError> {
        let names = header.fields.iter().map(|field| {
            let name = std::str::from_utf8(&field.name).ok()?;
            (field.count == 1).then_some(name)
        });
        let Columns { xyz, normal, .. } = Columns::find(names).ok_or_else(|| {
            let names: Vec<&[u8]> = header.fields.iter().map(|f| f.name.as_slice()).collect();
            line_error(lines, "fields x y z", quoted(&names.join(&b' ')))
        })?;
        Ok(Self { xyz, normal })
    }

    /// Reads `points` points from binary columns; `column` gives for a field its bytes, first offset and stride.
    fn read_columns<'a>(
        &self,
        points: usize,
        column: impl Fn(usize) -> (&'a [u8], usize, usize),
        header: &PcdHeader,
    ) -> CloudFile {
        let triples = |fields: [usize; 3]| {
            let columns = fields.map(|f| (column(f), header.fields.get(f).map(|f| f.scalar)));
            (0..points).map(move |i| {
                columns.map(|((bytes, start, step), scalar)| {
                    scalar
                        .and_then(|s| s.read(bytes, start + i * step, Endian::Little))
                        .unwrap_or(f64::NAN)
                })
            })
        };
        CloudFile {
            points: triples(self.xyz).map(Point3::from).collect(),
            normals: self.normal.map(|n| triples(n).map(Vector3::from).collect()),
            viewpoint: header.viewpoint,
        }
    }
}

fn read_ascii(
    lines: &mut LineReader<'_>,
    header: &PcdHeader,
    columns: &PcdColumns,
) -> Result<CloudFile, FormatError> {
    // A point takes at least six bytes of text, so the length of the file bounds the number of points.
    let max_points = lines.rest().len() / 6 + 1;
    let capacity = usize::try_from(header.points)
        .unwrap_or(max_points)
        .min(max_points);
    let first_word = |field: usize| {
        header
            .fields
            .iter()
            .take(field)
            .map(|f| f.count)
            .sum::<usize>()
    };
    let xyz = columns.xyz.map(first_word);
    let normal = columns.normal.map(|n| n.map(first_word));
    let mut cloud = CloudFile {
        points: Vec::with_capacity(capacity),
        normals: normal.map(|_| Vec::with_capacity(capacity)),
        viewpoint: header.viewpoint,
    };
    let mut line_words: Vec<&[u8]> = Vec::new();
    for read in 0..header.points {
        let Some(line) = lines.next_filled() else {
            let expected = format!("{} points", header.points);
            return Err(line_error(
                lines,
                expected,
                format!("the end of the file after {read}"),
            ));
        };
        line_words.clear();
        line_words.extend(words(line));
        let numbers = |indices: [usize; 3]| -> Result<[f64; 3], FormatError> {
            let mut out = [0.0; 3];
            for (out, index) in out.iter_mut().zip(indices) {
                let word = line_words.get(index);
                *out = word.and_then(|w| parse_number(w)).ok_or_else(|| {
                    let got = word.map_or_else(|| "the end of the line".to_owned(), |w| quoted(w));
                    line_error(lines, format!("a number as word {}", index + 1), got)
                })?;
            }
            Ok(out)
        };
        cloud.points.push(Point3::from(numbers(xyz)?));
        if let (Some(normal), Some(normals)) = (normal, &mut cloud.normals) {
            normals.push(Vector3::from(numbers(normal)?));
        }
    }
    Ok(cloud)
}

/// The number of points and their size in bytes, if the file has that many after `at`.
fn checked_size(
    bytes: &[u8],
    at: usize,
    header: &PcdHeader,
    stride: usize,
) -> Result<(usize, usize), FormatError> {
    let rest = bytes.len().saturating_sub(at);
    usize::try_from(header.points)
        .ok()
        .and_then(|n| Some((n, n.checked_mul(stride)?)))
        .filter(|(_, needed)| *needed <= rest)
        .ok_or_else(|| {
            let expected = format!("{} points of {stride} bytes", header.points);
            byte_error(
                bytes.len(),
                expected,
                format!("the end of the file after {rest} bytes of data"),
            )
        })
}

fn read_compressed(
    bytes: &[u8],
    at: usize,
    header: &PcdHeader,
    columns: &PcdColumns,
) -> Result<CloudFile, FormatError> {
    let size = |offset: usize| -> Result<usize, FormatError> {
        let word = bytes.get(at + offset..).and_then(|b| b.first_chunk());
        let word = word.ok_or_else(|| {
            byte_error(bytes.len(), "two sizes of 4 bytes", "the end of the file")
        })?;
        Ok(u32::from_le_bytes(*word) as usize)
    };
    let (compressed_size, size_after) = (size(0)?, size(4)?);
    let stride: usize = header
        .fields
        .iter()
        .map(|f| f.scalar.size() * f.count)
        .sum();
    if Some(size_after as u64) != header.points.checked_mul(stride as u64) {
        let expected = format!("{} points of {stride} bytes after expansion", header.points);
        return Err(byte_error(at + 4, expected, format!("{size_after} bytes")));
    }
    let body = bytes.get(at + 8..).unwrap_or_default();
    let Some(body) = body.get(..compressed_size) else {
        let got = format!("the end of the file after {}", body.len());
        return Err(byte_error(
            bytes.len(),
            format!("{compressed_size} compressed bytes"),
            got,
        ));
    };
    let body = lzf::decompress(body, size_after).ok_or_else(|| {
        byte_error(
            at + 8,
            format!("LZF data of {size_after} bytes"),
            "damaged data",
        )
    })?;
    // Decompressed data are stored field by field, not point by point.
    let points = usize::try_from(header.points).unwrap_or(0);
    let column = |field: usize| {
        let size = header.fields.get(field).map_or(0, |f| f.scalar.size());
        (
            body.as_slice(),
            header.offset_in_point(field) * points,
            size,
        )
    };
    Ok(columns.read_columns(points, column, header))
}

#[cfg(test)]
mod tests {
    use super::read;
    use crate::formats::read_cloud;
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    fn header(points: usize, data: &str) -> Vec<u8> {
        format!(
            "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\nFIELDS x _ y normal_x normal_y normal_z z\n\
             SIZE 4 1 8 4 4 4 4\nTYPE F U F F F F F\nCOUNT 1 3 1 1 1 1 1\nWIDTH {points}\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
        )
        .into_bytes()
    }

    /// LZF with literals only.
    fn pack(data: &[u8]) -> Vec<u8> {
        data.chunks(32)
            .flat_map(|c| std::iter::once(c.len() as u8 - 1).chain(c.iter().copied()))
            .collect()
    }

    fn encode(points: &[[f32; 6]], data: &str) -> Vec<u8> {
        let mut out = header(points.len(), data);
        let column = |p: &[f32; 6], field: usize| match field {
            1 => vec![7, 8, 9],
            2 => f64::from(p[1]).to_le_bytes().to_vec(),
            _ => p[[0, 0, 0, 3, 4, 5, 2][field]].to_le_bytes().to_vec(),
        };
        match data {
            "ascii" => {
                for p in points {
                    out.extend(
                        format!(
                            "{} 7 8 9 {} {} {} {} {}\n",
                            p[0], p[1], p[3], p[4], p[5], p[2]
                        )
                        .bytes(),
                    );
                }
            }
            "binary" => {
                for p in points {
                    (0..7).for_each(|f| out.extend(column(p, f)));
                }
            }
            _ => {
                let flat: Vec<u8> = (0..7)
                    .flat_map(|f| points.iter().flat_map(move |p| column(p, f)))
                    .collect();
                let packed = pack(&flat);
                out.extend((packed.len() as u32).to_le_bytes());
                out.extend((flat.len() as u32).to_le_bytes());
                out.extend(packed);
            }
        }
        out
    }

    proptest! {
        #[test]
        fn every_encoding_is_read(
            points in proptest::collection::vec(proptest::array::uniform6(-1e6f32..1e6), 0..40),
            data in prop_oneof![Just("ascii"), Just("binary"), Just("binary_compressed")],
        ) {
            let cloud = read_cloud(&encode(&points, data), None).expect("a well-formed PCD");
            let xyz: Vec<_> = points.iter().map(|p| Point3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))).collect();
            let normals: Vec<_> = points.iter().map(|p| Vector3::new(f64::from(p[3]), f64::from(p[4]), f64::from(p[5]))).collect();
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= a.abs() * 1e-6);
            for (a, b) in cloud.points.iter().zip(&xyz) {
                prop_assert!(near(a.coords.as_slice(), b.coords.as_slice()));
            }
            prop_assert_eq!(cloud.points.len(), xyz.len());
            prop_assert_eq!(cloud.normals.map(|n| n.len()), Some(normals.len()));
            if data != "ascii" {
                let again = read(&encode(&points, data)).expect("the same");
                prop_assert_eq!(again.points, xyz);
                prop_assert_eq!(again.normals, Some(normals));
            }
        }
    }

    #[test]
    fn non_finite_points_keep_their_index() {
        let text = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 1\nDATA ascii\nnan nan nan\n1 2 3\n";
        let cloud = read(text).expect("a PCD");
        assert_eq!(cloud.points.len(), 2);
        assert!(cloud.points[0].x.is_nan());
        assert_eq!(cloud.normals, None);
    }

    #[test]
    fn mistakes_are_reported() {
        let start = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
        let cases = [
            (
                format!("{start}WIDTH 1000000000000\nHEIGHT 1\nDATA binary\nabc"),
                "expected 1000000000000 points of 12 bytes, got the end of the file after 3 bytes of data",
            ),
            (
                format!("{start}WIDTH 1000000000000\nHEIGHT 1000000000000\nDATA binary\n"),
                "expected POINTS equal to WIDTH x HEIGHT",
            ),
            (
                format!("{start}WIDTH 1000000000000\nHEIGHT 1\nDATA ascii\n1 2 3\n"),
                "expected 1000000000000 points, got the end of the file after 1",
            ),
            (
                format!(
                    "{start}WIDTH 1000000000000\nHEIGHT 1\nDATA binary_compressed\n\x01\0\0\0\x01\0\0\0a"
                ),
                "after expansion, got 1 bytes",
            ),
            (
                format!("{start}WIDTH 1\nHEIGHT 1\nDATA binary_compressed\n\x01\0\0\0\x0c\0\0\0a"),
                "expected LZF data of 12 bytes",
            ),
            (
                format!("{start}WIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 c\n"),
                "PCD line 7: expected a number as word 3, got \"c\"",
            ),
            (
                "FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n".to_owned(),
                "expected one SIZE and TYPE per field",
            ),
            (
                "FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA ascii\n".to_owned(),
                "PCD line 5: expected fields x y z, got \"x y\"",
            ),
            (
                "VERSION .7\nPOINTS 1\nGARBAGE\n".to_owned(),
                "PCD line 3: expected a PCD header line, got \"GARBAGE\"",
            ),
        ];
        for (text, part) in cases {
            let message = read(text.as_bytes()).expect_err(&text).to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
