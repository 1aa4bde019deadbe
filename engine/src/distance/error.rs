//! What can be wrong with masses and costs.

/// Why a distance has no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DistanceError {
    /// One side has no mass, so that nothing can be moved.
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
        /// Which, from 0.
        index: usize,
        /// What stood there.
        got: f64,
    },
    /// The two sides weigh differently; normalise them first.
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
    /// The cost matrix is of another size than the masses.
    #[error("cost matrix is {rows} x {columns}, expected {left} x {right} as the masses")]
    Shape {
        /// Rows there are.
        rows: usize,
        /// Columns there are.
        columns: usize,
        /// Masses on the left.
        left: usize,
        /// Masses on the right.
        right: usize,
    },
    /// The simplex made more pivots than any known problem needs.
    #[error("no optimum after {pivots} pivots")]
    Unfinished {
        /// Pivots made.
        pivots: usize,
    },
}
