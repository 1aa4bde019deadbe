//! Files that people name on the command line: what went wrong with which, and what to do.

use super::failure::Failure;
use std::fmt::Display;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Reads the file at `path`.
///
/// # Errors
/// It cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| told(path, &error, "read"))
}

/// Reads the text at `path`.
///
/// # Errors
/// It cannot be read, or is no UTF-8.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| told(path, &error, "read"))
}

/// Writes `bytes` to the file at `path`.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    fs::write(path, bytes).map_err(|error| told(path, &error, "write"))
}

/// A failure with the file it is about.
pub fn named(path: &Path, error: impl Display) -> Failure {
    Failure::Failed(format!("{}: {error}", path.display()))
}

fn told(path: &Path, error: &io::Error, verb: &str) -> Failure {
    let text = match error.kind() {
        ErrorKind::NotFound if verb == "write" => {
            "its folder does not exist; make it or name another".to_owned()
        }
        ErrorKind::NotFound => "no such file; check the path".to_owned(),
        ErrorKind::IsADirectory => "is a folder; name a file".to_owned(),
        ErrorKind::PermissionDenied => {
            format!("this user may not {verb} it; check its owner and mode")
        }
        ErrorKind::InvalidData => "is not text; check that it is the right file".to_owned(),
        _ => format!("cannot {verb} it: {error}"),
    };
    named(path, text)
}

#[cfg(test)]
mod tests {
    use super::{read, read_text, write};
    use std::path::Path;

    #[test]
    fn each_failure_names_the_file_and_what_to_do() {
        let dir = tempfile::tempdir().expect("temp dir");
        let told = |failure: super::Failure| failure.to_string();
        let missing = read(Path::new("no/such.ply")).expect_err("missing");
        assert_eq!(told(missing), "no/such.ply: no such file; check the path");
        let folder = read(dir.path()).expect_err("a folder");
        assert!(told(folder).ends_with(": is a folder; name a file"));
        let nowhere = write(&dir.path().join("no/l.txt"), b"").expect_err("no folder");
        assert!(told(nowhere).contains("its folder does not exist"));
        let bytes = dir.path().join("bytes");
        write(&bytes, &[0xff]).expect("written");
        assert!(told(read_text(&bytes).expect_err("no text")).contains("is not text"));
    }
}
