//! Reads a file that someone names, up to a size: it may be `/dev/zero`, or a disk.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Largest configuration or scene, bytes: the shipped ones have less than 20 kB.
pub const MAX_SETTINGS_BYTES: u64 = 4 << 20;
/// Largest cloud, sweep, mixture or manifest, bytes: ten million points as text have 500 MB.
pub const MAX_DATA_BYTES: u64 = 1 << 30;

/// The text of the file `path`, which has at most `max_bytes`.
///
/// # Errors
/// As of [`std::fs::read_to_string`]; [`ErrorKind::FileTooLarge`].
pub fn read_text_up_to(path: &Path, max_bytes: u64) -> io::Result<String> {
    let bytes = read_up_to(path, max_bytes)?;
    String::from_utf8(bytes).map_err(|error| io::Error::new(ErrorKind::InvalidData, error))
}

/// The bytes of the file `path`, at most `max_bytes`.
///
/// # Errors
/// As of [`std::fs::read`]; [`ErrorKind::FileTooLarge`].
pub fn read_up_to(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let size = file.metadata()?.len().min(max_bytes);
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    file.take(max_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let text = format!("is larger than {} MiB", max_bytes >> 20);
        return Err(io::Error::new(ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::read_up_to;
    use std::io::ErrorKind;
    use std::path::Path;

    #[test]
    fn a_file_is_read_up_to_its_bound_and_no_further() {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("file");
        std::fs::write(&path, b"1234").expect("written");
        assert_eq!(read_up_to(&path, 4).expect("four bytes"), b"1234");
        let kind = |path: &Path, max| read_up_to(path, max).expect_err("too large").kind();
        assert_eq!(kind(&path, 3), ErrorKind::FileTooLarge);
        assert_eq!(
            kind(Path::new("/dev/zero"), 1 << 20),
            ErrorKind::FileTooLarge
        );
        assert_eq!(kind(dir.path(), 9), ErrorKind::IsADirectory);
    }
}
