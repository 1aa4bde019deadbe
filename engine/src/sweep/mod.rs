//! Takes scans, head positions and clocks, gives one view of the place with its quality (sweep-geometry).

mod assemble;
mod attitude;
mod blind;
mod calibration;
mod clock;
mod constants;
mod leg_tilt;
mod lines;
mod origin;
mod quality;
mod raw;
mod record;

pub use assemble::{LegPart, Sweep, SweepError, assemble, assemble_with};
pub use attitude::{Attitude, AttitudeError};
pub use calibration::{
    Calibration, CalibrationBeam, CalibrationError, Estimate, Parameter, Present, calibrate,
    calibration_beams,
};
pub use clock::{ClockError, SensorClock};
pub use constants::{FREE_RANGE_M, URG_NOISE};
pub use lines::LegLines;
pub use quality::Quality;
pub use raw::{Leg, Motion, Poll, RawScan, RawSweep, TimeSample};
pub use record::{RecordError, decode, encode};
