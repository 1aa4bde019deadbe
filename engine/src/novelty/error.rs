//! Errors of a comparison.

use super::constants::MAX_COMPONENTS;

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
    /// The points of a view spread over kilometres.
    #[error(
        "{name}: its points spread over {:.1} km; are these millimetres? convert the cloud to metres", spread_m / 1e3
    )]
    Spread {
        /// Name of the view.
        name: &'static str,
        /// Diagonal of the box around the middle of the points, metres.
        spread_m: f64,
    },
    /// No mixture of bounded size stands for a view.
    #[error(
        "its {points} cells need {components} Gaussians or more, expected at most {MAX_COMPONENTS}; it shows no surfaces (a volume, noise, another unit?)"
    )]
    NoSurfaces {
        /// Number of cells.
        points: usize,
        /// Number of components so far.
        components: usize,
    },
    /// The sensor would have looked through most of what its view shows.
    #[error(
        "{name}: the sensor at ({:.1}, {:.1}, {:.1}) would stand {outside_m:.1} m outside of what the cloud shows and look through it; its middle is ({:.1}, {:.1}, {:.1}): give the position of the sensor in the cloud's frame",
        origin[0], origin[1], origin[2], middle[0], middle[1], middle[2]
    )]
    Origin {
        /// Name of the view.
        name: &'static str,
        /// Position of the sensor, metres.
        origin: [f64; 3],
        /// Its distance from the points, metres.
        outside_m: f64,
        /// Middle of the points, metres.
        middle: [f64; 3],
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
