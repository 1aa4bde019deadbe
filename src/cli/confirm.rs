//! Asks a person on a terminal before something is done.

use super::failure::Failure;
use super::output;
use std::io::{self, IsTerminal as _};

/// Whether somebody is there to be asked.
pub(super) fn can_ask() -> bool {
    io::stdin().is_terminal()
}

/// Asks, on standard error; whether the answer is yes. No answer is no.
pub(super) fn confirm(question: &str) -> Result<bool, Failure> {
    output::question(&format!("{question} [y/N]"));
    let mut answer = String::new();
    io::stdin()
        .read_line(&mut answer)
        .map_err(Failure::failed)?;
    Ok(matches!(answer.trim(), "y" | "yes"))
}
