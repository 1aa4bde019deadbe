//! Errors of a comparison.

/// Why two views cannot be compared. Everything milder is a verdict.
#[derive(Debug, thiserror::Error)]
pub enum NoveltyError {
    /// A view with too few points.
    #[error("{name}: got {got} points, expected at least {expected}")]
    TooFewPoints {
        /// Name of the view.
        name: &'static str,
        /// Number of its points.
        got: usize,
        /// Number of points needed.
        expected: usize,
    },
    /// A coordinate that is not finite.
    #[error("{name}: point {index} is not finite")]
    NotFinite {
        /// Name of the view.
        name: &'static str,
        /// Index of the point.
        index: usize,
    },
    /// A stored mixture without components, or without beams for each.
    #[error(
        "reference mixture: got {components} components and beams of {beams}, expected as many, at least 1"
    )]
    BadReferenceMixture {
        /// Number of components.
        components: usize,
        /// Number of components whose beams are known.
        beams: usize,
    },
    /// A mixture that cannot be fitted.
    #[error("mixture: {0}")]
    Mixture(#[from] crate::mixture::MixtureError),
    /// Mixtures that cannot be compared.
    #[error("distance: {0}")]
    Distance(#[from] crate::distance::DistanceError),
}
