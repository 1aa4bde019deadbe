//! Sweeps: scans, head positions and clocks to one view and its quality; calibration of the mount (sweep-geometry).

mod assemble;
mod blind;
mod calibration;
mod clock;
mod constants;
mod error;
mod lines;
mod origin;
mod pan_segment_tilt;
mod quality;
mod raw;
mod raw_codec;
mod tilt_motion;

pub use assemble::{PanSegmentPart, Sweep, assemble};
pub use calibration::{
    Calibration, CalibrationBeam, CalibrationError, CalibrationParameter, ParameterEstimate,
    calibrate, calibration_beams,
};
pub use clock::ClockError;
pub use constants::{FREE_RANGE_M, URG_NOISE};
pub use error::SweepError;
pub use lines::PanSegmentLines;
pub use quality::SweepQuality;
pub use raw::{HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, TimeSample};
pub use raw_codec::{RawSweepError, decode_raw_sweep, encode_raw_sweep};
pub use tilt_motion::TiltMotionError;
