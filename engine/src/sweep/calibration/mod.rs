//! Calibration: mount, clock and head from raw sweeps of one room, with standard deviations (sweep-geometry section 5).
//! Flat surfaces must be flat, whichever sweep saw them.
//!
//! | file | from | to |
//! |---|---|---|
//! | `beams` | raw sweeps | every hit with tilt, speed and direction of travel at its own time |
//! | `parameters` | values of the parameters | end points of beams, and their derivatives |
//! | `planes` | end points | the planes that the pan segments saw |
//! | `normal_equations` | residuals with their derivatives | a step, covariances |
//! | `solve` | beams and planes | the values that make the planes flat |
//! | `residual_scatter` | residuals | their scale, and the correlation between neighbours |
//! | `calibrate` | all of it | estimates, and which of them are observable |

mod beams;
mod calibrate;
mod constants;
mod normal_equations;
mod parameters;
mod planes;
mod residual_scatter;
mod solve;

pub use beams::{CalibrationBeam, calibration_beams};
pub use calibrate::{Calibration, CalibrationError, ParameterEstimate, calibrate};
pub use parameters::CalibrationParameter;
