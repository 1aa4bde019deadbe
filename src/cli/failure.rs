//! Exit codes (`docs/contract.md`) and the errors that lead to them.

use crate::config::ConfigError;
use crate::store::StoreError;
use patrold_engine::novelty::Verdict;
use std::fmt;
use std::process::ExitCode;

/// Done and quiet.
pub(super) const DONE: u8 = 0;
pub(super) const FAILED: u8 = 1;
/// Wrong usage or configuration.
pub(super) const USAGE: u8 = 2;
pub(super) const CHANGED: u8 = 10;
pub(super) const NOT_OBSERVED: u8 = 11;

/// Why a command failed, for standard error.
#[derive(Debug)]
pub(super) enum Failure {
    Failed(String),
    /// Wrong usage or configuration.
    Usage(String),
}

/// The exit code of a command, or why it failed.
pub(super) type CommandResult = Result<u8, Failure>;

impl Failure {
    pub(super) fn failed(error: impl fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    pub(super) fn exit_code(&self) -> ExitCode {
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

impl From<Vec<ConfigError>> for Failure {
    fn from(errors: Vec<ConfigError>) -> Self {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        Self::Usage(lines.join("\n"))
    }
}

pub(super) fn verdict_exit_code(verdict: Verdict) -> u8 {
    match verdict {
        Verdict::Quiet => DONE,
        Verdict::Changed => CHANGED,
        Verdict::NotObserved => NOT_OBSERVED,
    }
}
