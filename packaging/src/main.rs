//! Writes manual pages and shell completions of patrold into a folder: `cargo run -p patrold-packaging -- target/package`.

#[cfg(test)]
mod contents;
mod generate;

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("patrold-packaging: no folder given; name the folder to write to");
        return ExitCode::from(2);
    };
    match generate::write_all(&folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("patrold-packaging: {}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}
