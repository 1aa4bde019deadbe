//! The error of decoding stored views and mixtures.

/// Bytes that do not decode.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what}: expected {expected}, got {got}")]
pub struct BlobError {
    /// What was decoded.
    pub what: String,
    /// What the format requires.
    pub expected: String,
    /// What was found.
    pub got: String,
}
