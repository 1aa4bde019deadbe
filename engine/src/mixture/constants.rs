//! The numbers that decide something in this room, each with its unit and where it comes from.

/// Added to every covariance diagonal after the M step, square metres: (1 mm)^2, scikit-learn's `reg_covar`.
pub const REGULARISATION_M2: f64 = 1e-6;

/// Change of the mean log-likelihood below which EM has converged, nats per point: scikit-learn's `tol`.
pub const TOLERANCE: f64 = 1e-3;

/// M steps at most, where nothing else is asked for: scikit-learn's `max_iter`.
pub const ITERATIONS: usize = 100;

/// A component whose share of the points falls to this or less holds none of them: scikit-learn's
/// guard of its divisions, ten units of rounding.
pub const DEAD_SHARE: f64 = 10.0 * f64::EPSILON;

/// How far a component's log density may lie below the best of a point before it is left out, bits: 2^-56 is
/// an eighth of the rounding of the sum, and far below [`DEAD_SHARE`].
pub const NEGLIGIBLE_BITS: f64 = 56.0;

/// How far a sum of weights read from outside may lie from one before it is refused.
pub const WEIGHT_SUM_SLACK: f64 = 1e-6;

/// How negative an eigenvalue may be, relative to the largest, and still count as the rounding of zero.
pub const SEMI_DEFINITE_SLACK: f64 = 1e-9;

/// Lloyd steps at most after k-means++: they only prepare, EM does the rest.
pub const LLOYD_STEPS: usize = 10;

/// Restarts of k-means++ and EM where nothing else is asked for: one, as scikit-learn's `n_init`.
pub const RESTARTS: usize = 1;

/// Standard deviation across a component up to which it counts as flat, metres. Measured in the
/// slow prototype (design, section 5): 3 cm keeps recall of small things.
pub const FLAT_SIGMA_M: f64 = 0.03;

/// Widest component, metres, as the side of the uniform plate of the same variance (same source).
pub const FLAT_WIDTH_M: f64 = 1.5;

/// Fewest points that a component may be split down to: ten numbers describe one Gaussian.
pub const SPLIT_MIN_POINTS: usize = 10;

/// Mahalanobis distance beyond which a reference component does not explain a point (design, section 5: 5 sigma).
pub const UNEXPLAINED_SIGMAS: f64 = 5.0;

/// M steps of a refit: frozen shapes leave little to settle (design, section 5: "a few EM steps").
pub const REFIT_ITERATIONS: usize = 10;

/// A part counts as flat up to this many sigmas of range noise: the sample deviation of a flat wall of
/// ten points stays below it in 97 of 100 draws (chi-squared, 9 degrees of freedom).
pub const FLAT_SIGMAS_OF_NOISE: f64 = 1.5;

/// A part is at least this many point spacings wide: four by four points, more than [`SPLIT_MIN_POINTS`].
pub const FLAT_WIDTH_SPACINGS: f64 = 4.0;

/// Components at most that BIC and MML try where nothing else is asked for; BIC fits every number up to it.
pub const MOST_COMPONENTS: usize = 30;
