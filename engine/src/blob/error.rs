//! Why bytes are no view or no mixture.

/// Bytes that do not decode.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what}: expected {expected}, got {got}")]
pub struct BlobError {
    /// What they should be.
    pub what: String,
    /// What the format asks for.
    pub expected: String,
    /// What was found.
    pub got: String,
}
