//! Errors of points, mixtures and their records.

/// Why a mixture could not be built, fitted or read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MixtureError {
    /// No points to fit a mixture to.
    #[error("no points to fit a mixture to")]
    NoPoints,
    /// A mixture without components.
    #[error("a mixture needs at least one component")]
    NoComponents,
    /// More components than distinct points.
    #[error("{components} components asked for, but the cloud has only {distinct} distinct points")]
    TooFewPoints {
        /// Number of components.
        components: usize,
        /// Number of distinct points.
        distinct: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} has a coordinate that is not finite")]
    PointNotFinite {
        /// Index of the point, from 0.
        index: usize,
    },
    /// A weight of a point is NaN, infinite or negative.
    #[error("weight of point {index}: got {got}, expected a finite number >= 0")]
    BadPointWeight {
        /// Index of the point, from 0.
        index: usize,
        /// The value found.
        got: f64,
    },
    /// The weights of the points sum to zero or overflow.
    #[error("the weights of the points sum to {got}, expected more than 0 and finite")]
    NoPointWeight {
        /// The sum.
        got: f64,
    },
    /// An index out of range.
    #[error("point index {index} given, but the cloud has {len} points")]
    NoSuchPoint {
        /// The index.
        index: usize,
        /// Number of points.
        len: usize,
    },
    /// Arrays that belong together have different lengths.
    #[error("`{array}` has {got} entries, expected {expected} as `{like}`")]
    LengthsDiffer {
        /// The array at fault.
        array: &'static str,
        /// Its length.
        got: usize,
        /// The array whose length it must have.
        like: &'static str,
        /// The length of that array.
        expected: usize,
    },
    /// A weight is NaN, infinite or negative (paper Eq. 2).
    #[error("weight of component {component}: got {got}, expected a finite number >= 0")]
    BadWeight {
        /// Index of the component, from 0.
        component: usize,
        /// The value found.
        got: f64,
    },
    /// The beams of a component are NaN, infinite or negative, or zero where it has weight.
    #[error("beams of component {component}: got {got}, expected a finite number > 0")]
    BadBeams {
        /// Index of the component, from 0.
        component: usize,
        /// The value found.
        got: f64,
    },
    /// The weights do not sum to one.
    #[error("weights sum to {got}, expected 1 within {slack}")]
    WeightSum {
        /// The sum.
        got: f64,
        /// The permitted difference.
        slack: f64,
    },
    /// A mean or covariance has an entry that is NaN or infinite.
    #[error("{what} of component {component} is not finite")]
    NotFinite {
        /// `mean` or `covariance`.
        what: &'static str,
        /// Index of the component, from 0.
        component: usize,
    },
    /// A covariance is not symmetric positive semi-definite.
    #[error(
        "covariance of component {component} is not symmetric positive semi-definite (smallest eigenvalue {smallest}, largest {largest})"
    )]
    NotSemiDefinite {
        /// Index of the component, from 0.
        component: usize,
        /// Its smallest eigenvalue, square metres.
        smallest: f64,
        /// Its largest eigenvalue, square metres.
        largest: f64,
    },
    /// A covariance has no volume, and so no density.
    #[error(
        "covariance of component {component} is singular: no density; give a regularisation above 0"
    )]
    Singular {
        /// Index of the component, from 0.
        component: usize,
    },
    /// A log-likelihood is not finite.
    #[error("log-likelihood underflow: points are too many sigmas from every component")]
    LogLikelihoodUnderflow,
    /// A setting outside its range.
    #[error("setting `{name}`: got {got}, expected {expected}")]
    BadSetting {
        /// Name of the setting.
        name: &'static str,
        /// The value given.
        got: f64,
        /// The values allowed.
        expected: &'static str,
    },
    /// The text is not a mixture in JSON.
    #[error("mixture record: {0}")]
    Record(String),
    /// The threads could not be started.
    #[error("could not start {threads} threads: {reason}")]
    Threads {
        /// Number of threads.
        threads: usize,
        /// Error of the system.
        reason: String,
    },
}
