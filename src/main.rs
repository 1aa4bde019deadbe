//! The program `patrold`.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    patrold::cli::run(patrold::cli::Cli::parse())
}
