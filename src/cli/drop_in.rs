//! A file in the folder of the configuration that a command writes; what is refused with it is taken back.

use super::failure::Failure;
use super::files;
use crate::config::drop_in_folder;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Writes the file `name` beside the configuration and asks `check` whether it can stay. Returns its path and the answer.
///
/// # Errors
/// A file that cannot be written, or the failure of `check`: the folder is as before then.
pub(super) fn put<T>(
    config: Option<&Path>,
    name: &str,
    text: &str,
    check: impl FnOnce() -> Result<T, Failure>,
) -> Result<(PathBuf, T), Failure> {
    let folder = drop_in_folder(config);
    let path = folder.join(name);
    let before = match fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(files::file_error(&path, error)),
    };
    fs::create_dir_all(&folder).map_err(|error| files::file_error(&folder, error))?;
    replace(&path, text.as_bytes())?;
    match check() {
        Ok(answer) => Ok((path, answer)),
        Err(failure) => {
            match &before {
                Some(bytes) => replace(&path, bytes)?,
                None => fs::remove_file(&path).map_err(|error| files::file_error(&path, error))?,
            }
            Err(failure)
        }
    }
}

/// Written aside and renamed: a reload never sees half of it.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let aside = path.with_extension("toml.tmp");
    files::write(&aside, bytes)?;
    fs::rename(&aside, path).map_err(|error| files::file_error(path, error))
}
