//! Constants of the mixtures: unit and origin of each.

/// Added to every covariance diagonal after the M step, square metres: (1 mm)^2, scikit-learn's `reg_covar`.
pub(crate) const REGULARISATION_M2: f64 = 1e-6;

/// Change of the mean log-likelihood below which EM has converged, nats per point: scikit-learn's `tol`.
pub(crate) const DEFAULT_TOLERANCE: f64 = 1e-3;

/// Maximum number of M steps: scikit-learn's `max_iter`.
pub(crate) const DEFAULT_MAX_ITERATIONS: usize = 100;

/// A component with this share of the points or less has none: ten units of rounding, with which scikit-learn guards its
/// divisions.
pub(crate) const DEAD_SHARE: f64 = 10.0 * f64::EPSILON;

/// A component is left out where its log density is this far below the best of a point, bits: 2^-56 is an eighth of the
/// rounding of the sum, and far below [`DEAD_SHARE`].
pub(crate) const NEGLIGIBLE_BITS: f64 = 56.0;

/// Largest difference from one of a sum of weights that is read from outside.
pub(crate) const WEIGHT_SUM_TOLERANCE: f64 = 1e-6;

/// An eigenvalue counts as zero down to this negative share of the largest: rounding.
pub(crate) const SEMI_DEFINITE_TOLERANCE: f64 = 1e-9;

/// Maximum number of Lloyd steps after k-means++: they only prepare EM.
pub(crate) const MAX_LLOYD_STEPS: usize = 10;

/// Restarts of k-means++ and EM: one, as scikit-learn's `n_init`.
pub const DEFAULT_RESTARTS: usize = 1;

/// Standard deviation across a flat component at most, metres. Measured on a prototype: keeps recall of small objects
/// (`docs/novelty.md section 3`).
pub(crate) const FLAT_SIGMA_M: f64 = 0.03;

/// Width of a component at most, metres, as the side of the uniform plate of the same variance (same source).
pub(crate) const FLAT_WIDTH_M: f64 = 1.5;

/// Parts of this many points or fewer are not split: ten numbers describe one Gaussian.
pub(crate) const SPLIT_MIN_POINTS: usize = 10;

/// Mahalanobis distance beyond which a component does not explain a point (`docs/novelty.md section 3`).
pub(crate) const UNEXPLAINED_SIGMAS: f64 = 5.0;

/// Maximum number of M steps of a refit: frozen shapes leave little to settle (`docs/novelty.md section 3`).
pub(crate) const REFIT_MAX_ITERATIONS: usize = 10;

/// A part is flat up to this many sigmas of range noise: the sample deviation of a flat wall of ten points stays below it in
/// 97 of 100 draws (chi-squared, 9 degrees of freedom).
pub(crate) const FLAT_SIGMAS_OF_NOISE: f64 = 1.5;

/// A part is at least this many point spacings wide: four by four points, more than [`SPLIT_MIN_POINTS`].
pub(crate) const FLAT_WIDTH_SPACINGS: f64 = 4.0;

/// Most components that BIC and MML try; BIC fits every number up to it.
pub const DEFAULT_MAX_COMPONENTS: usize = 30;

/// Most components that a fusion gives: some 350 describe a room (`docs/novelty.md section 3`), so that two visits fitted
/// alone stay below.
pub const DEFAULT_MAX_FUSED_COMPONENTS: usize = 1000;

/// Standard deviation by which a surface lies elsewhere at the second visit, metres: half the least last gate of a
/// registration (`docs/novelty.md section 4`).
pub(crate) const FUSION_SURFACE_SIGMA_M: f64 = 0.01;

/// Two components are twins where merging them costs this many nats per beam at most. Their means then lie within 0.3 % of
/// a standard deviation, 1 mm in the widest component of a flat mixture.
pub(crate) const TWIN_LOSS_NATS: f64 = 1e-6;

/// Points per side of a component's plate at which its own share is taken: the share of a plate that another one half
/// covers is then exact to an eighth of a side.
pub(crate) const OWN_SHARE_POINTS_PER_SIDE: usize = 4;

/// A component takes no part in the own share of another beyond this many of its standard deviations: its density is e^-32
/// of its peak there.
pub(crate) const OWN_SHARE_REACH_SIGMAS: f64 = 8.0;
