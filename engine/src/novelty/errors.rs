//! Why two views cannot be compared at all.

/// What is wrong with a view; everything milder is a verdict.
#[derive(Debug, thiserror::Error)]
pub enum NoveltyError {
    /// A view that says nothing.
    #[error("{which}: got {got} points, expected at least {expected}")]
    TooFewPoints {
        /// Which view.
        which: &'static str,
        /// Points it has.
        got: usize,
        /// Points it needs.
        expected: usize,
    },
    /// A coordinate that is no number.
    #[error("{which}: point {at} is not finite")]
    NotFinite {
        /// Which view.
        which: &'static str,
        /// Index of the point.
        at: usize,
    },
    /// A mixture that cannot be fitted.
    #[error("mixture: {0}")]
    Mixture(#[from] crate::mixture::MixtureError),
    /// Mixtures that cannot be compared.
    #[error("distance: {0}")]
    Distance(#[from] crate::distance::DistanceError),
}
