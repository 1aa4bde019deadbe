//! One door for every cloud format: what a file holds, which reader it needs, how it can fail.

use super::{pcd, ply, xyz};
use nalgebra::{Point3, Vector3};

/// What a cloud file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudFile {
    /// Every point in file order, metres, including the non-finite ones (see [`split_finite`]).
    pub points: Vec<Point3<f64>>,
    /// One normal per point, as stored (not normalised), if the file has all of `nx ny nz` (PCD: `normal_x` ...).
    pub normals: Option<Vec<Vector3<f64>>>,
}

/// Why bytes are no cloud. Every message is one line: where, what was expected, what came.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// There is nothing to read.
    #[error("empty file: expected a PLY, PCD or XYZ text cloud, got 0 bytes")]
    Empty,
    /// A line of text is not what the format asks for.
    #[error("{format} line {line}: expected {expected}, got {got}")]
    Line {
        /// Name of the format.
        format: &'static str,
        /// Line number, from 1.
        line: usize,
        /// What the format asks for.
        expected: String,
        /// What stands there, shortened to fit one line.
        got: String,
    },
    /// A stretch of binary data is not what the format asks for.
    #[error("{format} byte {byte}: expected {expected}, got {got}")]
    Byte {
        /// Name of the format.
        format: &'static str,
        /// Offset from the start of the file, from 0.
        byte: usize,
        /// What the format asks for.
        expected: String,
        /// What stands there.
        got: String,
    },
}

/// Reads a cloud. Content decides first: a file that begins like a PLY or a PCD is one whatever it is called. Only
/// then does `extension` (without dot, any case) count: `ply` or `pcd` without its first line is an error, anything
/// else is read as XYZ text.
///
/// # Errors
/// [`FormatError`] with the line or byte at fault. A count in a header never makes an allocation that the file's own
/// length does not justify.
pub fn read_cloud(bytes: &[u8], extension: Option<&str>) -> Result<CloudFile, FormatError> {
    // Some editors put a UTF-8 byte-order mark in front of text.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(FormatError::Empty);
    }
    let named = |name: &str| extension.is_some_and(|e| e.eq_ignore_ascii_case(name));
    if ply::looks_like_ply(bytes) || (named("ply") && !pcd::looks_like_pcd(bytes)) {
        ply::read(bytes)
    } else if pcd::looks_like_pcd(bytes) || named("pcd") {
        pcd::read(bytes)
    } else {
        xyz::read(bytes)
    }
}

/// The finite points, and for each its index in `points`.
pub fn split_finite(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<usize>) {
    points
        .iter()
        .enumerate()
        .filter(|(_, p)| p.iter().all(|c| c.is_finite()))
        .map(|(i, p)| (*p, i))
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::{FormatError, read_cloud, split_finite};
    use crate::formats::write_ply;
    use nalgebra::Point3;
    use proptest::prelude::*;

    #[test]
    fn content_wins_over_extension() {
        let ply = write_ply(&[Point3::new(1.0, 2.0, 3.0)]);
        for extension in [None, Some("xyz"), Some("pcd"), Some("PLY")] {
            let cloud = read_cloud(&ply, extension).expect("a PLY by its first line");
            assert_eq!(cloud.points, vec![Point3::new(1.0, 2.0, 3.0)]);
        }
        let pcd = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";
        assert!(read_cloud(pcd, Some("ply")).is_ok());
    }

    #[test]
    fn an_extension_without_its_first_line_is_named() {
        let error = read_cloud(b"1 2 3\n", Some("ply")).expect_err("no PLY");
        assert_eq!(
            error.to_string(),
            "PLY line 1: expected `ply`, got \"1 2 3\""
        );
        let error = read_cloud(b"1 2 3\n", Some("pcd")).expect_err("no PCD");
        assert!(
            error.to_string().starts_with("PCD line 1: expected"),
            "{error}"
        );
    }

    #[test]
    fn nothing_is_an_error() {
        for empty in [&b""[..], b" \n\r\n", b"\xEF\xBB\xBF"] {
            for extension in [None, Some("ply"), Some("pcd"), Some("xyz")] {
                assert_eq!(read_cloud(empty, extension), Err(FormatError::Empty));
            }
        }
    }

    #[test]
    fn finite_points_keep_their_indices() {
        let points = [
            Point3::new(f64::NAN, 0.0, 0.0),
            Point3::new(1.0, 2.0, 3.0),
            Point3::new(0.0, f64::INFINITY, 0.0),
            Point3::new(4.0, 5.0, 6.0),
        ];
        let (finite, kept) = split_finite(&points);
        assert_eq!(finite, vec![points[1], points[3]]);
        assert_eq!(kept, vec![1, 3]);
    }

    const HEADERS: [&str; 6] = [
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "ply\nformat ascii 1.0\nelement face 9\nproperty list uchar int v\nelement vertex 1000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty list uint double l\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nDATA binary\n",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nDATA binary_compressed\n\x10\0\0\0\x18\0\0\0",
        "FIELDS x y z\nSIZE 4 8 4\nTYPE F F U\nCOUNT 1 1 9\nWIDTH 99\nHEIGHT 99\nDATA ascii\n",
    ];

    proptest! {
        #[test]
        fn hostile_bytes_give_an_error_of_one_line_or_a_cloud(
            header in 0..=HEADERS.len(),
            body in proptest::collection::vec(any::<u8>(), 0..200),
            cut in 0.0..1.0f64,
            flip in any::<(u16, u8)>(),
        ) {
            let mut bytes = HEADERS.get(header).map_or(&b""[..], |h| h.as_bytes()).to_vec();
            bytes.extend(body);
            if flip.1 & 1 == 1 && !bytes.is_empty() {
                let at = usize::from(flip.0) % bytes.len();
                bytes[at] ^= flip.1;
            }
            bytes.truncate((bytes.len() as f64 * (1.0 - cut * cut)) as usize);
            for extension in [None, Some("ply"), Some("pcd")] {
                if let Err(error) = read_cloud(&bytes, extension) {
                    let message = error.to_string();
                    prop_assert!(!message.contains('\n') && message.len() < 400, "{}", message);
                }
            }
        }
    }
}
