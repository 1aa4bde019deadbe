//! Result of a run of EM.

use super::{InstructionSet, Mixture};

/// Why EM ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StopReason {
    /// The likelihood rose by less than the tolerance.
    Converged,
    /// The maximum number of M steps was reached.
    IterationCap,
}

/// How a component degenerated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Collapse {
    /// No point is left: weight 0, mean and covariance unchanged since.
    NoMass,
    /// Its points lie on a plane, a line or a spot: its thickness is the regularisation alone.
    NoVolume,
}

/// Start of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FitStart {
    /// A given mixture.
    Given,
    /// The cells of k-means++.
    KMeans {
        /// Number of the draw, from 0.
        restart: u64,
    },
    /// The parts of the cloud, split until all were flat.
    Flat,
}

/// A fitted mixture, and how it was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct EmFit {
    /// The mixture after the last M step; component k is from component k of the start.
    pub mixture: Mixture,
    /// Weighted mean over the points of ln f under `mixture`, nats.
    pub mean_log_likelihood: f64,
    /// Number of M steps.
    pub iterations: usize,
    /// Why it stopped.
    pub stopped: StopReason,
    /// Collapsed components, by index.
    pub collapsed: Vec<(usize, Collapse)>,
    /// Where it started.
    pub start: FitStart,
    /// Number of EM runs; this is the best of them.
    pub runs: usize,
    /// Instruction set of the inner loops.
    pub instructions: InstructionSet,
    /// Worker threads used.
    pub threads: usize,
}
