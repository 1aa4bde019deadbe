//! What can be wrong with one reply.

use thiserror::Error;

use crate::status::{ScipCommand, StatusMeaning};

/// Bytes from the device; printing escapes those that are not printable ASCII.
#[derive(Clone, PartialEq, Eq)]
pub struct EscapedBytes(Vec<u8>);

impl From<&[u8]> for EscapedBytes {
    fn from(bytes: &[u8]) -> Self {
        Self(bytes.to_vec())
    }
}

impl std::fmt::Display for EscapedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", self.0.escape_ascii())
    }
}

impl std::fmt::Debug for EscapedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Display::fmt(self, f)
    }
}

/// A reply that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs, reason = "each message shows what its fields are")]
pub enum ReplyError {
    /// The reply belongs to another request.
    #[error("reply to {expected} expected, got one to {got}")]
    Echo {
        expected: EscapedBytes,
        got: EscapedBytes,
    },
    #[error("no status after the echo {echo}")]
    NoStatus { echo: EscapedBytes },
    /// Damage on the line.
    #[error("sum '{}' expected, got '{}' in line {line}", char::from(*.expected), .got.escape_ascii())]
    Sum {
        line: EscapedBytes,
        expected: u8,
        got: u8,
    },
    /// A byte that no encoded number has.
    #[error("character in '0'..='o' expected, got '{}'", .got.escape_ascii())]
    Character { got: u8 },
    #[error("{what}: length {expected} expected, got {got}")]
    Length {
        what: &'static str,
        expected: usize,
        got: usize,
    },
    /// The scan has another number of values than was asked for (rounded down to whole clusters).
    #[error("{expected} values expected, got {got}")]
    ValueCount { expected: usize, got: usize },
    /// The echo's field of scans remaining does not follow from the request.
    #[error("remaining scans {expected} expected, got {got}")]
    Remaining { expected: u8, got: u8 },
    #[error("no {key} in the reply to {command}, which has {got}")]
    MissingKey {
        key: &'static str,
        command: ScipCommand,
        got: EscapedBytes,
    },
    #[error("{key}: {expected} expected, got {got}")]
    Value {
        key: &'static str,
        expected: &'static str,
        got: EscapedBytes,
    },
    /// The device answered with an error status.
    #[error("{command} refused: {meaning}")]
    Refused {
        command: ScipCommand,
        meaning: StatusMeaning,
    },
}

impl ReplyError {
    pub(crate) fn sum(line: &[u8], expected: u8, got: u8) -> Self {
        Self::Sum {
            line: line.into(),
            expected,
            got,
        }
    }

    /// What the device's error status means, if this is one.
    #[must_use]
    pub fn refusal(&self) -> Option<StatusMeaning> {
        match self {
            Self::Refused { meaning, .. } => Some(*meaning),
            _ => None,
        }
    }
}
