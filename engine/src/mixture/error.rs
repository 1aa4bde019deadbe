//! What can be wrong with points, mixtures and their records.

/// Why a mixture could not be built, fitted or read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MixtureError {
    /// Nothing to fit.
    #[error("no points to fit a mixture to")]
    NoPoints,
    /// Nothing to fit with.
    #[error("a mixture needs at least one component")]
    NoComponents,
    /// More components than distinct points.
    #[error("{components} components asked for, but the cloud has only {distinct} distinct points")]
    TooFewPoints {
        /// Components asked for.
        components: usize,
        /// Distinct points there are.
        distinct: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} has a coordinate that is not finite")]
    PointNotFinite {
        /// Which point, from 0.
        index: usize,
    },
    /// A point's weight is NaN, infinite or negative, or all are zero.
    #[error("weight of point {index}: got {got}, expected a finite number >= 0")]
    BadPointWeight {
        /// Which point, from 0.
        index: usize,
        /// What stood there.
        got: f64,
    },
    /// All points weigh nothing.
    #[error("the weights of the points sum to {got}, expected more than 0 and finite")]
    NoPointWeight {
        /// The sum.
        got: f64,
    },
    /// An index points past the end.
    #[error("point index {index} given, but the cloud has {len} points")]
    NoSuchPoint {
        /// The index.
        index: usize,
        /// Points there are.
        len: usize,
    },
    /// Arrays that belong together have different lengths.
    #[error("`{array}` has {got} entries, expected {expected} as `{like}`")]
    LengthsDiffer {
        /// The array at fault.
        array: &'static str,
        /// Its length.
        got: usize,
        /// The array it must match.
        like: &'static str,
        /// That one's length.
        expected: usize,
    },
    /// A mixing probability breaks Eq. 2.
    #[error("weight of component {component}: got {got}, expected a finite number >= 0")]
    BadWeight {
        /// Which component, from 0.
        component: usize,
        /// What stood there.
        got: f64,
    },
    /// Mixing probabilities do not sum to one.
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
        /// Which component, from 0.
        component: usize,
    },
    /// A covariance is no covariance.
    #[error(
        "covariance of component {component} is not symmetric positive semi-definite (smallest eigenvalue {smallest}, largest {largest})"
    )]
    NotSemiDefinite {
        /// Which component, from 0.
        component: usize,
        /// Its smallest eigenvalue, square metres.
        smallest: f64,
        /// Its largest eigenvalue, square metres.
        largest: f64,
    },
    /// A density was asked of a covariance with no volume.
    #[error(
        "covariance of component {component} is singular: no density; give a regularisation above 0"
    )]
    Singular {
        /// Which component, from 0.
        component: usize,
    },
    /// Distances in sigmas overflow.
    #[error("points lie too many sigmas from every component for the likelihood to be a number")]
    OutOfReach,
    /// A setting outside its range.
    #[error("setting `{name}`: got {got}, expected {expected}")]
    BadSetting {
        /// Which setting.
        name: &'static str,
        /// What was given.
        got: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// The record is no JSON of the expected form.
    #[error("mixture record: {0}")]
    Record(String),
    /// The threads could not be started.
    #[error("could not start {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}
