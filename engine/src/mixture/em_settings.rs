//! Settings of EM.

use super::constants::{DEFAULT_MAX_ITERATIONS, DEFAULT_TOLERANCE, REGULARISATION_M2};
use super::{InstructionSet, MixtureError};

/// Settings of a run of EM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmSettings {
    /// Maximum number of M steps.
    pub iterations: usize,
    /// Stop when the mean log-likelihood rises by less than this, nats per point. 0 runs exactly `iterations`.
    pub tolerance: f64,
    /// Added to the diagonal of every covariance after each M step, square metres.
    pub regularisation_m2: f64,
    /// Worker threads; 1 uses the caller's thread, 0 the caller's rayon pool.
    pub threads: usize,
    /// Instruction set of the inner loops; portable code where the processor lacks it.
    pub instructions: InstructionSet,
}

impl Default for EmSettings {
    fn default() -> Self {
        Self {
            iterations: DEFAULT_MAX_ITERATIONS,
            tolerance: DEFAULT_TOLERANCE,
            regularisation_m2: REGULARISATION_M2,
            threads: 1,
            instructions: InstructionSet::best(),
        }
    }
}

impl EmSettings {
    pub(super) fn check(&self) -> Result<(), MixtureError> {
        for (name, got) in [
            ("tolerance", self.tolerance),
            ("regularisation_m2", self.regularisation_m2),
        ] {
            if !got.is_finite() || got < 0.0 {
                return Err(MixtureError::BadSetting {
                    name,
                    got,
                    expected: "a finite number >= 0",
                });
            }
        }
        Ok(())
    }
}
