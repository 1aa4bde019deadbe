//! Formats that are known and not read, so that the message can name them.

use super::error::FormatError;

/// What to do with a file of another format, an archive, another encoding.
const CONVERT: &str = "convert it to PLY, PCD or XYZ text";
const UNPACK: &str = "unpack it first";
const ENCODE: &str = "save it as UTF-8";
/// How the files of a format begin.
const BY_CONTENT: [(&[u8], &str, &str); 13] = [
    (b"LASF", "LAS", CONVERT),
    (b"ASTM-E57", "E57", CONVERT),
    (b"\x89HDF", "HDF5", CONVERT),
    (b"\x93NUMPY", "NumPy", CONVERT),
    (b"OFF", "OFF", CONVERT),
    (b"COFF", "OFF", CONVERT),
    (b"\x1f\x8b", "gzip", UNPACK),
    (b"PK\x03\x04", "zip", UNPACK),
    (b"BZh", "bzip2", UNPACK),
    (b"\xfd7zXZ", "xz", UNPACK),
    (b"\x28\xb5\x2f\xfd", "zstd", UNPACK),
    (b"\xff\xfe", "UTF-16", ENCODE),
    (b"\xfe\xff", "UTF-16", ENCODE),
];
/// Extensions of the files of a format.
const BY_EXTENSION: [(&str, &str); 11] = [
    ("las", "LAS"),
    ("laz", "LAZ"),
    ("e57", "E57"),
    ("obj", "OBJ"),
    ("off", "OFF"),
    ("stl", "STL"),
    ("ptx", "PTX"),
    ("bag", "a ROS bag"),
    ("db3", "a ROS bag"),
    ("mcap", "MCAP"),
    ("npy", "NumPy"),
];
/// A file with a zero byte among this many at its start is binary.
const TEXT_SAMPLE: usize = 1024;

/// The error for `bytes` that begin like a file of another format.
pub(super) fn unread_by_content(bytes: &[u8]) -> Option<FormatError> {
    let mut known = BY_CONTENT.iter();
    let (_, what, advice) = known.find(|(start, ..)| bytes.starts_with(start))?;
    Some(FormatError::Unread { what, advice })
}

/// The error for `bytes` that can be no text: by the extension of the file, or because they are binary.
pub(super) fn unread_as_text(bytes: &[u8], extension: Option<&str>) -> Option<FormatError> {
    let extension = extension.unwrap_or_default().to_ascii_lowercase();
    let by_extension = BY_EXTENSION.iter().find(|(known, _)| *known == extension);
    let sample = bytes.get(..TEXT_SAMPLE).unwrap_or(bytes);
    let what = match by_extension {
        Some((_, what)) => what,
        None if sample.contains(&0) => "binary data without a header (as KITTI's .bin)",
        None => return None,
    };
    Some(FormatError::Unread {
        what,
        advice: CONVERT,
    })
}

#[cfg(test)]
mod tests {
    use super::{unread_as_text, unread_by_content};

    #[test]
    fn what_is_not_read_is_named() {
        let by_content = |bytes: &[u8]| unread_by_content(bytes).map(|e| e.to_string());
        let las = "LAS is not read; convert it to PLY, PCD or XYZ text";
        assert_eq!(by_content(b"LASF\0\0").as_deref(), Some(las));
        let gzip = "gzip is not read; unpack it first";
        assert_eq!(by_content(b"\x1f\x8b\x08").as_deref(), Some(gzip));
        assert_eq!(by_content(b"1 2 3\n"), None);
        let as_text =
            |bytes: &[u8], extension| unread_as_text(bytes, extension).map(|e| e.to_string());
        let laz = as_text(b"anything", Some("LAZ")).expect("an error");
        assert!(laz.starts_with("LAZ is not read"), "{laz}");
        let bin = as_text(b"1 2 3\0", Some("bin")).expect("an error");
        assert!(bin.starts_with("binary data without a header"), "{bin}");
        for extension in [None, Some("xyz"), Some("txt")] {
            assert_eq!(as_text(b"v 1 2 3\n", extension), None);
        }
    }
}
