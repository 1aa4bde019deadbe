//! Simulated sensors: their beams, what the beams hit, and the errors of the readings.

mod beam_hit;
mod beam_pattern;
mod field_of_view;
mod range_error;
mod ring_scanner;
mod sensor_kind;
mod sensor_setup;

pub(crate) use beam_hit::{BeamHit, cast_pattern, cast_ray};
pub(crate) use sensor_kind::BEAMS_PER_PROBE;
pub use sensor_kind::SensorKind;
pub(crate) use sensor_setup::{SensorSetup, SensorSweep};
