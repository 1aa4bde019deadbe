//! The error of every cloud format.

use super::cloud::MAX_COORDINATE;

/// Why bytes are no cloud. Every message is one line: where, what was expected, what was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FormatError {
    /// No bytes but white space.
    #[error("empty file: expected a PLY, PCD or XYZ text cloud, got 0 bytes")]
    Empty,
    /// A known format that is not read.
    #[error("{what} is not read; {advice}")]
    Unread {
        /// Name of the format.
        what: &'static str,
        /// What to do with the file.
        advice: &'static str,
    },
    /// A coordinate that no place on Earth has in any unit.
    #[error(
        "point {point}: expected coordinates up to {MAX_COORDINATE:e}, got {got:e}; the file is damaged, or of the other byte order"
    )]
    Coordinate {
        /// Number of the point, from 1.
        point: usize,
        /// The coordinate.
        got: f64,
    },
    /// A line of text violates the format.
    #[error("{format} line {line}: expected {expected}, got {got}")]
    Line {
        /// Name of the format.
        format: &'static str,
        /// Line number, from 1.
        line: usize,
        /// What the format requires.
        expected: String,
        /// What was found, shortened to fit one line.
        got: String,
    },
    /// Binary data violate the format.
    #[error("{format} byte {byte}: expected {expected}, got {got}")]
    Byte {
        /// Name of the format.
        format: &'static str,
        /// Offset from the start of the file, from 0.
        byte: usize,
        /// What the format requires.
        expected: String,
        /// What was found.
        got: String,
    },
}
