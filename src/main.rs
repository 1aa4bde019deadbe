//! The `patrold` program: parse, run, exit code.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    patrold::cli::run(patrold::cli::Cli::parse())
}
