//! The reader of every cloud format: decides by content, then by extension, which one it is.

use super::cloud::{CloudFile, MAX_COORDINATE};
use super::error::FormatError;
use super::unread::{unread_as_text, unread_by_content};
use super::{pcd, ply, xyz};

/// Scanners write the largest number of either precision where nothing came back.
const LARGEST_NUMBERS: [f64; 2] = [f32::MAX as f64, f64::MAX];

/// Reads a cloud. Content decides first: bytes that begin like a PLY or a PCD are one, whatever the extension. Then
/// `extension` (without dot, any case) decides: `ply` or `pcd` without its first line is an error, anything else is read as
/// XYZ text. Other known formats are refused by name.
///
/// # Errors
/// [`FormatError`] with the line or byte at fault. A count in a header never causes an allocation larger than the file
/// justifies.
pub fn read_cloud(bytes: &[u8], extension: Option<&str>) -> Result<CloudFile, FormatError> {
    // Some editors put a UTF-8 byte-order mark in front of text.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(FormatError::Empty);
    }
    let has_extension = |name: &str| extension.is_some_and(|e| e.eq_ignore_ascii_case(name));
    let mut cloud = if ply::looks_like_ply(bytes) {
        ply::read(bytes)
    } else if pcd::looks_like_pcd(bytes) {
        pcd::read(bytes)
    } else if let Some(error) = unread_by_content(bytes) {
        Err(error)
    } else if has_extension("ply") {
        ply::read(bytes)
    } else if has_extension("pcd") {
        pcd::read(bytes)
    } else if let Some(error) = unread_as_text(without_padding(bytes), extension) {
        Err(error)
    } else {
        xyz::read(without_padding(bytes))
    }?;
    for coordinate in cloud.points.iter_mut().flat_map(|p| p.iter_mut()) {
        if LARGEST_NUMBERS.contains(&coordinate.abs()) {
            *coordinate = f64::NAN;
        }
    }
    for (index, p) in cloud.points.iter().enumerate() {
        let is_too_large = |c: &&f64| c.is_finite() && c.abs() > MAX_COORDINATE;
        if let Some(got) = p.iter().find(is_too_large) {
            return Err(FormatError::Coordinate {
                point: index + 1,
                got: *got,
            });
        }
    }
    Ok(cloud)
}

/// Some editors and devices end a text with the end mark of DOS or with zeros.
fn without_padding(bytes: &[u8]) -> &[u8] {
    let is_text = |b: &u8| !matches!(b, 0 | 0x1a);
    let length = bytes.iter().rposition(is_text).map_or(0, |last| last + 1);
    bytes.get(..length).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{FormatError, read_cloud};
    use crate::formats::write_ply;
    use nalgebra::Point3;
    use proptest::prelude::*;

    #[test]
    fn content_takes_precedence_over_the_extension() {
        let ply = write_ply(&[Point3::new(1.0, 2.0, 3.0)]);
        for extension in [None, Some("xyz"), Some("pcd"), Some("PLY")] {
            let cloud = read_cloud(&ply, extension).expect("a PLY by its first line");
            assert_eq!(cloud.points, vec![Point3::new(1.0, 2.0, 3.0)]);
        }
        let pcd = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n";
        assert!(read_cloud(pcd, Some("ply")).is_ok());
    }

    #[test]
    fn an_extension_without_its_first_line_is_an_error() {
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
    fn an_empty_file_is_an_error() {
        for empty in [&b""[..], b" \n\r\n", b"\xEF\xBB\xBF"] {
            for extension in [None, Some("ply"), Some("pcd"), Some("xyz")] {
                assert_eq!(read_cloud(empty, extension), Err(FormatError::Empty));
            }
        }
    }

    const HEADERS: [&str; 6] = [
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "ply\nformat ascii 1.0\nelement face 9\nproperty list uchar int v\nelement vertex 1000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty list uint double l\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nDATA binary\n",
        "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nDATA binary_compressed\n\x10\0\0\0\x18\0\0\0",
        "FIELDS x y z\nSIZE 4 8 4\nTYPE F F U\nCOUNT 1 1 9\nWIDTH 99\nHEIGHT 99\nDATA ascii\n",
    ];

    #[test]
    fn coordinates_of_no_place_are_refused_and_the_largest_number_is_none() {
        let error = read_cloud(b"1 2 3\n4 -2e11 6\n", None).expect_err("too large");
        assert!(
            error
                .to_string()
                .starts_with("point 2: expected coordinates up to 1e11, got -2e11")
        );
        // Millimetres along the Earth's circumference.
        assert!(read_cloud(b"4e10 2 3\n", None).is_ok());
        let cloud = read_cloud(b"3.4028234663852886e38 2 3\n1 2 3\n", None).expect("a cloud");
        assert!(cloud.points[0].x.is_nan());
        assert_eq!(cloud.points[1], Point3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn other_formats_are_named_whatever_the_extension_says() {
        for extension in [None, Some("ply"), Some("las"), Some("xyz")] {
            let error = read_cloud(b"LASF\0\0\0\0", extension).expect_err("LAS");
            assert!(
                error.to_string().starts_with("LAS is not read; convert"),
                "{error}"
            );
        }
        let error = read_cloud(b"1\0\0\x002", Some("bin")).expect_err("binary");
        assert!(error.to_string().starts_with("binary data"), "{error}");
        // Zeros and the end mark of DOS after a text are none of it.
        assert!(read_cloud(b"1 2 3\n\x1a\0\0", Some("xyz")).is_ok());
    }

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
