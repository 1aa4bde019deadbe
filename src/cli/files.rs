//! Files named on the command line, with errors that name the file and what to do.

use super::failure::Failure;
use crate::bounded_file::{MAX_DATA_BYTES, read_text_up_to, read_up_to};
use std::cell::RefCell;
use std::fmt::Display;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

thread_local! {
    /// Device and inode of each file that this command has read.
    static INPUTS: RefCell<Vec<[u64; 2]>> = const { RefCell::new(Vec::new()) };
}

fn identity(path: &Path) -> Option<[u64; 2]> {
    let metadata = fs::metadata(path).ok()?;
    metadata.is_file().then(|| [metadata.dev(), metadata.ino()])
}

/// Notes that the command reads `path`.
pub(super) fn note_input(path: &Path) {
    INPUTS.with_borrow_mut(|inputs| inputs.extend(identity(path)));
}

/// Refuses to write over a file that the command has read, by whatever name or link.
fn check_output(path: &Path) -> Result<(), Failure> {
    let is_input = |id| INPUTS.with_borrow(|inputs| inputs.contains(&id));
    if identity(path).is_some_and(is_input) {
        let text = "is an input of this command and would be overwritten; choose another file";
        return Err(file_error(path, text));
    }
    Ok(())
}

pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    note_input(path);
    read_up_to(path, MAX_DATA_BYTES).map_err(|error| io_error(path, &error, "read"))
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    note_input(path);
    let text = read_text_up_to(path, MAX_DATA_BYTES);
    let mut text = text.map_err(|error| io_error(path, &error, "read"))?;
    // Some editors put a byte-order mark in front of text.
    if text.starts_with('\u{feff}') {
        text.remove(0);
    }
    Ok(text)
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    check_output(path)?;
    fs::write(path, bytes).map_err(|error| io_error(path, &error, "write"))
}

/// Writes lines to a file or to standard output, as they come.
pub(super) struct LineWriter<'a> {
    path: Option<&'a Path>,
    out: Box<dyn Write>,
    /// The reader of standard output is gone.
    closed: bool,
}

impl<'a> LineWriter<'a> {
    /// To standard output where `path` is `None`.
    pub(super) fn create(path: Option<&'a Path>) -> Result<Self, Failure> {
        path.map_or(Ok(()), check_output)?;
        let out: Box<dyn Write> = match path {
            Some(path) => Box::new(io::BufWriter::new(
                fs::File::create(path).map_err(|error| io_error(path, &error, "write"))?,
            )),
            None => Box::new(io::BufWriter::new(io::stdout().lock())),
        };
        Ok(Self {
            path,
            out,
            closed: false,
        })
    }

    pub(super) fn line(&mut self, text: &str) -> Result<(), Failure> {
        if self.closed {
            return Ok(());
        }
        let written = writeln!(self.out, "{text}");
        self.check(written)
    }

    pub(super) fn finish(mut self) -> Result<(), Failure> {
        let flushed = self.out.flush();
        self.check(flushed)
    }

    /// A closed reader (`| head`) is no failure.
    fn check(&mut self, written: io::Result<()>) -> Result<(), Failure> {
        match (written, self.path) {
            (Ok(()), _) => Ok(()),
            (Err(error), None) if error.kind() == ErrorKind::BrokenPipe => {
                self.closed = true;
                Ok(())
            }
            (Err(error), None) => Err(Failure::Failed(format!("standard output: {error}"))),
            (Err(error), Some(path)) => Err(io_error(path, &error, "write")),
        }
    }
}

pub(super) fn file_error(path: &Path, error: impl Display) -> Failure {
    Failure::Failed(format!("{}: {error}", path.display()))
}

fn io_error(path: &Path, error: &io::Error, verb: &str) -> Failure {
    let text = match error.kind() {
        ErrorKind::NotFound if verb == "write" => {
            "its folder does not exist; create it or choose another".to_owned()
        }
        ErrorKind::NotFound => "no such file; check the path".to_owned(),
        ErrorKind::IsADirectory => "is a folder; choose a file".to_owned(),
        ErrorKind::PermissionDenied => {
            format!("this user may not {verb} it; check its owner and mode")
        }
        ErrorKind::FileTooLarge => format!("{error}; check that it is the right file"),
        ErrorKind::InvalidData => "is not text; check that it is the right file".to_owned(),
        _ => format!("cannot {verb} it: {error}"),
    };
    file_error(path, text)
}

#[cfg(test)]
mod tests {
    use super::{Failure, LineWriter, read, read_text, write};
    use std::path::Path;

    fn text(failure: Failure) -> String {
        failure.to_string()
    }

    #[test]
    fn every_error_names_the_file_and_what_to_do() {
        let dir = tempfile::tempdir().expect("temp dir");
        let missing = read(Path::new("no/such.ply")).expect_err("missing");
        assert_eq!(text(missing), "no/such.ply: no such file; check the path");
        let folder = read(dir.path()).expect_err("a folder");
        assert!(text(folder).ends_with(": is a folder; choose a file"));
        let nowhere = write(&dir.path().join("no/l.txt"), b"").expect_err("no folder");
        assert!(text(nowhere).contains("its folder does not exist"));
        let bytes = dir.path().join("bytes");
        write(&bytes, &[0xff]).expect("written");
        assert!(text(read_text(&bytes).expect_err("no text")).contains("is not text"));
        let endless = read_text(Path::new("/dev/zero")).expect_err("no end");
        assert!(text(endless).contains("is larger than 1024 MiB"));
    }

    #[test]
    fn a_byte_order_mark_is_no_text() {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("marked");
        write(&path, "\u{feff}{}".as_bytes()).expect("written");
        assert_eq!(read_text(&path).expect("text"), "{}");
    }

    #[test]
    fn no_input_is_overwritten_by_any_name() {
        let dir = tempfile::tempdir().expect("temp dir");
        let [input, other] = ["input", "other"].map(|name| dir.path().join(name));
        write(&input, b"kept").expect("not read yet");
        write(&other, b"old").expect("written");
        read(&input).expect("read");
        let [symbolic, hard] = ["symbolic", "hard"].map(|name| dir.path().join(name));
        std::os::unix::fs::symlink(&input, &symbolic).expect("a link");
        std::fs::hard_link(&input, &hard).expect("a link");
        for name in [&input, &symbolic, &hard] {
            let refused = write(name, b"lost").expect_err("an input");
            assert!(text(refused).contains("is an input of this command"));
            assert!(LineWriter::create(Some(name)).is_err());
        }
        assert_eq!(read(&input).expect("still there"), b"kept");
        write(&other, b"new").expect("another file");
    }
}
