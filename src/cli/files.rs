//! Files named on the command line, with errors that name the file and what to do.

use super::failure::Failure;
use std::fmt::Display;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| io_error(path, &error, "read"))
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| io_error(path, &error, "read"))
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
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
        ErrorKind::InvalidData => "is not text; check that it is the right file".to_owned(),
        _ => format!("cannot {verb} it: {error}"),
    };
    file_error(path, text)
}

#[cfg(test)]
mod tests {
    use super::{read, read_text, write};
    use std::path::Path;

    #[test]
    fn every_error_names_the_file_and_what_to_do() {
        let dir = tempfile::tempdir().expect("temp dir");
        let text = |failure: super::Failure| failure.to_string();
        let missing = read(Path::new("no/such.ply")).expect_err("missing");
        assert_eq!(text(missing), "no/such.ply: no such file; check the path");
        let folder = read(dir.path()).expect_err("a folder");
        assert!(text(folder).ends_with(": is a folder; choose a file"));
        let nowhere = write(&dir.path().join("no/l.txt"), b"").expect_err("no folder");
        assert!(text(nowhere).contains("its folder does not exist"));
        let bytes = dir.path().join("bytes");
        write(&bytes, &[0xff]).expect("written");
        assert!(text(read_text(&bytes).expect_err("no text")).contains("is not text"));
    }
}
