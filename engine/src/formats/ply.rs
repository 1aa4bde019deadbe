//! The PLY reader (Turk 1994): ASCII and binary of either endianness. Only the first element `vertex` is read; the elements
//! before it are skipped, those after it are not read.

use super::cloud::CloudFile;
use super::columns::Columns;
use super::error::FormatError;
use super::number::parse_number;
use super::ply_header::{FORMAT, PlyElement, PlyEncoding, PlyProperty, line_error, read_header};
use super::scalar::{Endian, Scalar};
use super::text::{LineReader, quoted, words};
use nalgebra::{Point3, Vector3};

/// Whether the first line is `ply`, in either case.
pub(super) fn looks_like_ply(bytes: &[u8]) -> bool {
    LineReader::new(bytes.get(..16.min(bytes.len())).unwrap_or_default())
        .next_line()
        .is_some_and(|line| line.eq_ignore_ascii_case(b"ply"))
}

/// Reads a PLY.
///
/// # Errors
/// [`FormatError`] if the header is broken, has no `vertex` with scalar `x y z`, or the data end early.
pub(super) fn read(bytes: &[u8]) -> Result<CloudFile, FormatError> {
    let mut lines = LineReader::new(bytes);
    let header = read_header(&mut lines)?;
    let Some(index) = header.elements.iter().position(|e| e.name == "vertex") else {
        return Err(line_error(
            &lines,
            "an element `vertex` in the header",
            "none",
        ));
    };
    let (before, vertex) = match header.elements.get(..=index) {
        Some([before @ .., vertex]) => (before, vertex),
        _ => {
            return Err(line_error(
                &lines,
                "an element `vertex` in the header",
                "none",
            ));
        }
    };
    let columns = PlyColumns::new(vertex, &lines)?;
    match header.encoding {
        PlyEncoding::Ascii => {
            for element in before {
                skip_ascii(&mut lines, element)?;
            }
            read_ascii(&mut lines, vertex, &columns)
        }
        PlyEncoding::Binary(endian) => {
            let mut at = lines.offset;
            for element in before {
                at = skip_binary(bytes, at, element, endian)?;
            }
            read_binary(bytes, at, vertex, &columns, endian)
        }
    }
}

/// The properties with coordinates and normal.
struct PlyColumns {
    xyz: [usize; 3],
    normal: Option<[usize; 3]>,
}

impl PlyColumns {
    fn new(vertex: &PlyElement, lines: &LineReader<'_>) -> Result<Self, FormatError> {
        let scalars = vertex.properties.iter().map(|(name, property)| {
            matches!(property, PlyProperty::Scalar(_)).then_some(name.as_str())
        });
        let Columns { xyz, normal, .. } = Columns::find(scalars).ok_or_else(|| {
            let names: Vec<&str> = vertex.properties.iter().map(|(n, _)| n.as_str()).collect();
            line_error(
                lines,
                "scalar properties x y z of `vertex` in the header",
                quoted(names.join(" ").as_bytes()),
            )
        })?;
        Ok(Self { xyz, normal })
    }

    /// Offset and type of x y z and the normal within one vertex; `None` for vertices with lists.
    fn offsets(&self, vertex: &PlyElement) -> Option<Vec<(usize, Scalar)>> {
        let mut offsets = Vec::with_capacity(vertex.properties.len());
        let mut at = 0;
        for (_, property) in &vertex.properties {
            let PlyProperty::Scalar(scalar) = property else {
                return None;
            };
            offsets.push((at, *scalar));
            at += scalar.size();
        }
        let wanted = self
            .xyz
            .into_iter()
            .chain(self.normal.into_iter().flatten());
        wanted.map(|i| offsets.get(i).copied()).collect()
    }

    /// The points of `body`, a whole number of vertices of `stride` bytes.
    fn read_vertices(
        &self,
        body: &[u8],
        stride: usize,
        offsets: &[(usize, Scalar)],
        endian: Endian,
    ) -> CloudFile {
        let mut cloud = self.empty_cloud(body.len() / stride);
        for vertex in body.chunks_exact(stride) {
            let value = |i: usize| {
                offsets
                    .get(i)
                    .and_then(|(at, scalar)| scalar.read(vertex, *at, endian))
                    .unwrap_or(f64::NAN)
            };
            cloud.points.push(Point3::new(value(0), value(1), value(2)));
            if let Some(normals) = &mut cloud.normals {
                normals.push(Vector3::new(value(3), value(4), value(5)));
            }
        }
        cloud
    }

    fn empty_cloud(&self, capacity: usize) -> CloudFile {
        CloudFile {
            points: Vec::with_capacity(capacity),
            normals: self.normal.map(|_| Vec::with_capacity(capacity)),
            viewpoint: None,
        }
    }

    /// Adds one point from the values of its properties (NaN for lists).
    fn push(&self, cloud: &mut CloudFile, values: &[f64]) {
        let value = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        let [x, y, z] = self.xyz.map(value);
        cloud.points.push(Point3::new(x, y, z));
        if let (Some(normal), Some(normals)) = (self.normal, &mut cloud.normals) {
            normals.push(Vector3::from(normal.map(value)));
        }
    }
}

fn skip_ascii(lines: &mut LineReader<'_>, element: &PlyElement) -> Result<(), FormatError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for read in 0..element.count {
        if lines.next_filled().is_none() {
            let expected = format!(
                "{} lines of element `{}`",
                element.count,
                quoted(element.name.as_bytes())
            );
            return Err(line_error(
                lines,
                &expected,
                format!("the end of the file after {read}"),
            ));
        }
    }
    Ok(())
}

fn read_ascii(
    lines: &mut LineReader<'_>,
    vertex: &PlyElement,
    columns: &PlyColumns,
) -> Result<CloudFile, FormatError> {
    // A point takes at least six bytes of text, so the length of the file bounds the number of points.
    let max_points = lines.rest().len() / 6 + 1;
    let mut cloud = columns.empty_cloud(
        usize::try_from(vertex.count)
            .unwrap_or(max_points)
            .min(max_points),
    );
    let mut values = Vec::with_capacity(vertex.properties.len());
    for read in 0..vertex.count {
        let Some(line) = lines.next_filled() else {
            let expected = format!("{} vertices", vertex.count);
            return Err(line_error(
                lines,
                &expected,
                format!("the end of the file after {read}"),
            ));
        };
        values.clear();
        let mut words = words(line);
        for (name, property) in &vertex.properties {
            let word = words.next();
            let Some(value) = word.and_then(parse_number) else {
                let expected = format!("a number for {}", quoted(name.as_bytes()));
                let got = word.map_or_else(|| "the end of the line".to_owned(), quoted);
                return Err(line_error(lines, &expected, got));
            };
            match property {
                PlyProperty::Scalar(_) => values.push(value),
                PlyProperty::List { .. } => {
                    let mut remaining = value;
                    while remaining >= 1.0 && words.next().is_some() {
                        remaining -= 1.0;
                    }
                    values.push(f64::NAN);
                }
            }
        }
        columns.push(&mut cloud, &values);
    }
    Ok(cloud)
}

fn truncated(bytes: &[u8], element: &PlyElement, read: u64) -> FormatError {
    FormatError::Byte {
        format: FORMAT,
        byte: bytes.len(),
        expected: format!(
            "{} of element {}",
            element.count,
            quoted(element.name.as_bytes())
        ),
        got: format!(
            "the end of the file within number {}",
            read.saturating_add(1)
        ),
    }
}

/// Size of one record in bytes, if it has no lists.
fn stride(element: &PlyElement) -> Option<usize> {
    element
        .properties
        .iter()
        .try_fold(0usize, |sum, (_, p)| match p {
            PlyProperty::Scalar(scalar) => Some(sum + scalar.size()),
            PlyProperty::List { .. } => None,
        })
}

/// Reads one record from `at`, calling `visit` with every scalar and NaN for every list; returns the offset of its end.
fn read_record(
    bytes: &[u8],
    mut at: usize,
    element: &PlyElement,
    endian: Endian,
    mut visit: impl FnMut(f64),
) -> Option<usize> {
    for (_, property) in &element.properties {
        match property {
            PlyProperty::Scalar(scalar) => {
                visit(scalar.read(bytes, at, endian)?);
                at += scalar.size();
            }
            PlyProperty::List { count, item } => {
                let length = count.read(bytes, at, endian)?;
                // A negative or huge length saturates and then exceeds the file.
                let length = if length < 0.0 {
                    usize::MAX
                } else {
                    length as usize
                };
                at = (at + count.size()).checked_add(length.checked_mul(item.size())?)?;
                bytes.get(at..)?;
                visit(f64::NAN);
            }
        }
    }
    Some(at)
}

fn skip_binary(
    bytes: &[u8],
    mut at: usize,
    element: &PlyElement,
    endian: Endian,
) -> Result<usize, FormatError> {
    if let Some(stride) = stride(element) {
        let end = usize::try_from(element.count)
            .ok()
            .and_then(|n| n.checked_mul(stride))
            .and_then(|n| n.checked_add(at))
            .filter(|end| *end <= bytes.len());
        let complete = bytes.len().saturating_sub(at) / stride.max(1);
        return end.ok_or_else(|| truncated(bytes, element, complete as u64));
    }
    for read in 0..element.count {
        at = read_record(bytes, at, element, endian, |_| ())
            .ok_or_else(|| truncated(bytes, element, read))?;
    }
    Ok(at)
}

fn read_binary(
    bytes: &[u8],
    mut at: usize,
    vertex: &PlyElement,
    columns: &PlyColumns,
    endian: Endian,
) -> Result<CloudFile, FormatError> {
    if let (Some(stride), Some(offsets)) = (stride(vertex), columns.offsets(vertex)) {
        let end = skip_binary(bytes, at, vertex, endian)?;
        let body = bytes.get(at..end).unwrap_or_default();
        return Ok(columns.read_vertices(body, stride, &offsets, endian));
    }
    // A vertex takes at least three bytes, so the length of the file bounds the number of points.
    let max_points = bytes.len().saturating_sub(at) / 3;
    let mut cloud = columns.empty_cloud(
        usize::try_from(vertex.count)
            .unwrap_or(max_points)
            .min(max_points),
    );
    let mut values = Vec::with_capacity(vertex.properties.len());
    for read in 0..vertex.count {
        values.clear();
        at = read_record(bytes, at, vertex, endian, |v| values.push(v))
            .ok_or_else(|| truncated(bytes, vertex, read))?;
        columns.push(&mut cloud, &values);
    }
    Ok(cloud)
}

#[cfg(test)]
mod tests {
    use super::read;
    use nalgebra::{Point3, Vector3};
    use patrold_test_support::data;
    use proptest::prelude::*;

    const TYPES: [&str; 8] = [
        "char", "uchar", "short", "ushort", "int", "uint", "float", "double",
    ];

    fn put(out: &mut Vec<u8>, kind: &str, value: i8, encoding: usize) {
        if encoding == 0 {
            out.extend(format!("{value} ").bytes());
            return;
        }
        let mut bytes = match kind {
            "char" => value.to_le_bytes().to_vec(),
            "uchar" => value.unsigned_abs().to_le_bytes().to_vec(),
            "short" => i16::from(value).to_le_bytes().to_vec(),
            "ushort" => u16::from(value.unsigned_abs()).to_le_bytes().to_vec(),
            "int" => i32::from(value).to_le_bytes().to_vec(),
            "uint" => u32::from(value.unsigned_abs()).to_le_bytes().to_vec(),
            "float" => f32::from(value).to_le_bytes().to_vec(),
            _ => f64::from(value).to_le_bytes().to_vec(),
        };
        if encoding == 2 {
            bytes.reverse();
        }
        out.extend(bytes);
    }

    proptest! {
        #[test]
        fn every_type_and_encoding_is_read(
            encoding in 0usize..3,
            kinds in proptest::array::uniform7(0usize..8),
            points in proptest::collection::vec(proptest::array::uniform6(0i8..=127), 0..20),
            list in 0u8..5,
            lists in any::<bool>(),
        ) {
            let name = ["ascii", "binary_little_endian", "binary_big_endian"][encoding];
            let k = kinds.map(|i| TYPES[i]);
            let mut bytes = format!(
                "ply\r\nformat {name} 1.0\ncomment made for a test\nelement camera 2\nproperty {} f\n\
                 element face 1\nproperty list uchar short at\nelement vertex {}\nproperty {} y\n{}property {} x\nproperty {} nx\nproperty {} ny\nproperty {} nz\nproperty {} z\n\
                 element tail 1000000000000\nproperty int i\nend_header\n",
                k[0], points.len(), k[1], if lists { "property list uchar int l\n" } else { "" }, k[2], k[3], k[4], k[5], k[6]
            ).into_bytes();
            let end = |out: &mut Vec<u8>| if encoding == 0 { out.push(b'\n') };
            for value in [1, 2] {
                put(&mut bytes, k[0], value, encoding);
                end(&mut bytes);
            }
            put(&mut bytes, "uchar", 2, encoding);
            put(&mut bytes, "short", -3, encoding);
            put(&mut bytes, "short", -4, encoding);
            end(&mut bytes);
            for p in &points {
                put(&mut bytes, k[1], p[1], encoding);
                if lists {
                    put(&mut bytes, "uchar", i8::try_from(list).expect("small"), encoding);
                }
                for i in 0..if lists { list } else { 0 } {
                    put(&mut bytes, "int", i8::try_from(i).expect("small"), encoding);
                }
                for (kind, value) in [(k[2], p[0]), (k[3], p[3]), (k[4], p[4]), (k[5], p[5]), (k[6], p[2])] {
                    put(&mut bytes, kind, value, encoding);
                }
                end(&mut bytes);
            }
            let cloud = read(&bytes).expect("a well-formed PLY");
            let expected: Vec<_> = points.iter().map(|p| Point3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))).collect();
            let normals: Vec<_> = points.iter().map(|p| Vector3::new(f64::from(p[3]), f64::from(p[4]), f64::from(p[5]))).collect();
            prop_assert_eq!(cloud.points, expected);
            prop_assert_eq!(cloud.normals, Some(normals));
        }
    }

    fn with_count(format: &str, element: &str, properties: &str, body: &[u8]) -> String {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement {element} 1000000000000\n{properties}element vertex \
             1000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        )
        .into_bytes();
        bytes.extend(body);
        read(&bytes)
            .expect_err("a file that ends early")
            .to_string()
    }

    #[test]
    fn a_huge_count_is_an_error_and_not_an_allocation() {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for (element, properties) in [
                (
                    "vertex",
                    "property float x\nproperty float y\nproperty float z\n",
                ),
                ("face", "property list uint int v\n"),
                ("face", "property int v\n"),
                ("nothing", ""),
            ] {
                let message = with_count(format, element, properties, b"1 1 1\n1 1 1\n");
                assert!(message.contains("1000000000000"), "{message}");
            }
        }
        let list = with_count(
            "binary_little_endian",
            "face",
            "property list int double v\n",
            &[0xFF; 64],
        );
        assert!(list.contains("within number 1"), "{list}");
    }

    #[test]
    fn mistakes_are_reported_with_their_line() {
        let cases: [(&str, &str); 7] = [
            (
                "ply\nformat ascii 1.0\nelement vertex many\n",
                "PLY line 3: expected `element NAME COUNT`, got \"element vertex many\"",
            ),
            (
                "ply\nformat utf 1.0\n",
                "PLY line 2: expected `format ascii|binary_little_endian|binary_big_endian 1.0`, got \"format utf 1.0\"",
            ),
            (
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                "PLY line 5: expected scalar properties x y z of `vertex` in the header, got \"x\"",
            ),
            (
                "ply\nformat ascii 1.0\nelement vertex 1\n",
                "PLY line 3: expected `end_header`, got the end of the file",
            ),
            (
                "ply\nend_header\n",
                "PLY line 2: expected a `format` line in the header, got none",
            ),
            (
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n1 b 3\n",
                "PLY line 9: expected a number for \"y\", got \"b\"",
            ),
            (
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
                "PLY line 8: expected 2 vertices, got the end of the file after 1",
            ),
        ];
        for (text, message) in cases {
            assert_eq!(read(text.as_bytes()).expect_err(text).to_string(), message);
        }
    }

    #[test]
    fn a_truncated_binary_is_reported_with_its_byte() {
        let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n".to_vec();
        let start = bytes.len();
        bytes.extend([0; 23]);
        let error = read(&bytes).expect_err("one byte short").to_string();
        assert_eq!(
            error,
            format!(
                "PLY byte {}: expected 2 of element \"vertex\", got the end of the file within number 2",
                start + 23
            )
        );
    }

    #[test]
    fn recorded_clouds_have_the_points_their_headers_count() {
        let Some(path) = data("semisynthetic/dev/dev01_person_cur.ply") else {
            return;
        };
        let bytes = std::fs::read(path).expect("readable");
        let cloud = read(&bytes).expect("a recorded cloud");
        let counted: usize = String::from_utf8_lossy(&bytes[..300])
            .lines()
            .find_map(|l| l.strip_prefix("element vertex "))
            .and_then(|n| n.parse().ok())
            .expect("a count");
        assert_eq!(cloud.points.len(), counted);
        assert!(cloud.points.iter().all(|p| p.coords.norm() < 1000.0));
    }
}
