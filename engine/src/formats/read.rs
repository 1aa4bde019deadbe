//! The reader of every cloud format: decides by content, then by extension, which one it is.

use super::cloud::CloudFile;
use super::error::FormatError;
use super::{pcd, ply, xyz};

/// Reads a cloud. Content decides first: bytes that begin like a PLY or a PCD are one, whatever the extension. Then
/// `extension` (without dot, any case) decides: `ply` or `pcd` without its first line is an error, anything else is read as
/// XYZ text.
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
    if ply::looks_like_ply(bytes) || (has_extension("ply") && !pcd::looks_like_pcd(bytes)) {
        ply::read(bytes)
    } else if pcd::looks_like_pcd(bytes) || has_extension("pcd") {
        pcd::read(bytes)
    } else {
        xyz::read(bytes)
    }
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
