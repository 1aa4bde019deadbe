//! Why no shape can be retrieved.

/// Why no shape can be retrieved.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Fewer points than a shape needs.
    #[error("a shape needs at least {min} points, got {got}")]
    TooFewPoints {
        /// Points given.
        got: usize,
        /// Points needed.
        min: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("coordinates must be finite, got {value} in {input}")]
    NotFinite {
        /// The coordinate.
        value: f64,
        /// The argument that holds it.
        input: &'static str,
    },
    /// The points are on one line, or all at one position.
    #[error(
        "a shape needs points spread over a surface, got a width of {second_m} m (at least {min_m} m)"
    )]
    NoSurface {
        /// Standard deviation along the second principal axis, metres.
        second_m: f64,
        /// Standard deviation needed, metres.
        min_m: f64,
    },
    /// No primitive could be fitted.
    #[error("no primitive fits the {points} points")]
    NothingFits {
        /// Points given.
        points: usize,
    },
}
