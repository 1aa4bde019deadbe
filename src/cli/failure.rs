//! Exit codes (a contract with other programs) and the errors that lead to them.

use crate::config::Mistake;
use crate::store::StoreError;
use patrold_engine::novelty::Verdict;
use std::fmt;
use std::process::ExitCode;

/// Done, and quiet.
pub const DONE: u8 = 0;
/// Failed.
pub const FAILED: u8 = 1;
/// Wrong usage or configuration.
pub const USAGE: u8 = 2;
/// `compare` and `visit`: the place has changed.
pub const CHANGED: u8 = 10;
/// `compare` and `visit`: no honest answer was possible.
pub const NOT_OBSERVED: u8 = 11;

/// Why a command did not do what it was asked; one line that names the thing and what to do.
#[derive(Debug)]
pub enum Failure {
    /// It was tried and failed.
    Failed(String),
    /// It was asked wrongly, or configured wrongly.
    Usage(String),
}

/// What every command gives back: the exit code of what it found, or why it failed.
pub type Outcome = Result<u8, Failure>;

impl Failure {
    /// A failure that any displayable error tells.
    pub fn failed(error: impl fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    /// The exit code.
    pub fn code(&self) -> ExitCode {
        match self {
            Self::Failed(_) => ExitCode::from(FAILED),
            Self::Usage(_) => ExitCode::from(USAGE),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(text) | Self::Usage(text) => f.write_str(text),
        }
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        Self::failed(error)
    }
}

impl From<Vec<Mistake>> for Failure {
    fn from(mistakes: Vec<Mistake>) -> Self {
        let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
        Self::Usage(lines.join("\n"))
    }
}

/// The exit code of a verdict.
pub fn verdict_code(verdict: Verdict) -> u8 {
    match verdict {
        Verdict::Quiet => DONE,
        Verdict::Changed => CHANGED,
        Verdict::NotObserved => NOT_OBSERVED,
    }
}
