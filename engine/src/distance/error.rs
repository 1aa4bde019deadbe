//! Errors of masses and costs.

/// Why a distance could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DistanceError {
    /// One side has no mass.
    #[error("the {side} side has no mass")]
    NoMass {
        /// `left` or `right`.
        side: &'static str,
    },
    /// A mass is NaN, infinite or negative.
    #[error("{side} mass {index}: got {got}, expected a finite number >= 0")]
    BadMass {
        /// `left` or `right`.
        side: &'static str,
        /// Index of the mass, from 0.
        index: usize,
        /// Its value.
        got: f64,
    },
    /// The sums of the masses differ; normalise them first.
    #[error("masses are unbalanced: left sums to {left}, right to {right}")]
    Unbalanced {
        /// Sum on the left.
        left: f64,
        /// Sum on the right.
        right: f64,
    },
    /// A cost is NaN or infinite.
    #[error("cost of ({row}, {column}) is not finite")]
    BadCost {
        /// Index on the left.
        row: usize,
        /// Index on the right.
        column: usize,
    },
    /// The size of the cost matrix is not that of the masses.
    #[error("cost matrix is {rows} x {columns}, expected {left} x {right} as the masses")]
    SizeMismatch {
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
        /// Masses on the left.
        left: usize,
        /// Masses on the right.
        right: usize,
    },
    /// No optimum after more pivots than any known problem needs.
    #[error("no optimum after {pivots} pivots")]
    NotConverged {
        /// Pivots made.
        pivots: usize,
    },
}
