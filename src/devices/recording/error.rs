//! Errors of a container.

use super::constants::VERSION;

/// Why bytes are no dialogue that this program can read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DialogueError {
    /// Of another kind.
    #[error("no recorded dialogue: it begins with {got}, expected \"PTRD\"")]
    OtherKind {
        /// The first bytes.
        got: String,
    },
    /// Of a newer program.
    #[error(
        "recorded dialogue of version {got}, this patrold reads version {VERSION}; use the newer one"
    )]
    Newer {
        /// Its version.
        got: u8,
    },
    /// Cut short or changed.
    #[error("recorded dialogue: expected {expected} at byte {at}; it is cut short or was changed")]
    Damaged {
        /// What was expected.
        expected: &'static str,
        /// Offset of it.
        at: usize,
    },
}
