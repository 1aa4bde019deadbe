//! Errors in configuration files, each with its file and line.

use std::fmt;
use std::path::PathBuf;

/// One error in one file.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfigError {
    /// The file it is in; `command line` or `defaults` where no file set the value.
    pub file: PathBuf,
    /// Line, from 1; 0: the file as a whole.
    pub line: usize,
    /// What is wrong.
    pub problem: ConfigProblem,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum ConfigProblem {
    /// The file cannot be read.
    Unreadable(String),
    /// The file is not TOML.
    Syntax(String),
    /// No such key.
    UnknownKey {
        /// As written.
        key: String,
        /// The valid name with the smallest edit distance.
        nearest: String,
    },
    /// The key does not accept the value.
    BadValue {
        /// The key.
        key: String,
        /// What the key accepts.
        expected: String,
        /// What the file has.
        got: String,
    },
    /// Two settings contradict each other.
    Contradiction(String),
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl fmt::Display for ConfigProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "cannot be read: {why}"),
            Self::Syntax(why) => write!(f, "is not TOML: {why}"),
            Self::UnknownKey { key, nearest } => {
                write!(f, "unknown key {key}; did you mean {nearest}?")
            }
            Self::BadValue { key, expected, got } => {
                write!(f, "{key} wants {expected}, got {got}")
            }
            Self::Contradiction(what) => write!(f, "{what}"),
        }
    }
}
