//! Why raw data give no view.

use super::clock::ClockError;
use super::constants::MAX_ORIGIN_DISTANCE_M;
use super::tilt_motion::TiltMotionError;

/// Why raw data give no view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// No scans.
    #[error("sweep has no scans")]
    Empty,
    /// A value that no sweep can have.
    #[error("sweep has {what} {got}, expected {expected}")]
    InvalidValue {
        /// Name of the value.
        what: &'static str,
        /// The value.
        got: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// The laser moved too far for a view with one origin.
    #[error(
        "laser was up to {distance_m:.2} m from the mean of its positions, expected at most {MAX_ORIGIN_DISTANCE_M} m: use fewer pans, or mount the laser over the pan axis"
    )]
    OriginSpread {
        /// Largest distance of the laser from the mean of its positions, metres.
        distance_m: f64,
    },
    /// The laser's clock cannot be fitted.
    #[error("sweep at pan {pan_deg:.1} deg: {source}")]
    Clock {
        /// Pan of the segment, degrees.
        pan_deg: f64,
        /// The cause.
        source: ClockError,
    },
    /// The head's motion cannot be fitted.
    #[error("sweep at pan {pan_deg:.1} deg: {source}")]
    Motion {
        /// Pan of the segment, degrees.
        pan_deg: f64,
        /// The cause.
        source: TiltMotionError,
    },
}
