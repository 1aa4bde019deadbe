//! Writes manual pages, shell completions and documents of patrold into a folder:
//! `cargo run --release -p patrold-packaging -- target/package`.

#[cfg(test)]
mod contents;
mod documents;
mod generate;
mod synopsis;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("patrold-packaging: no folder given; name the folder to write to");
        return ExitCode::from(2);
    };
    // The folder of this crate lies in that of the repository.
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    match generate::write_all(&repository, &folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("patrold-packaging: {}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}
