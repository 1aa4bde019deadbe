//! Takes raw sweeps of one place, gives what of mount, clock and head can be told from them, and how surely
//! (sweep-geometry section 5): flat surfaces must be flat, whichever sweep saw them.
//!
//! | file | takes | gives |
//! |---|---|---|
//! | `beams` | raw sweeps | every hit with the tilt, the speed and the way of its own instant |
//! | `unknowns` | values of the unknowns | places, and how they move with each unknown |
//! | `planes` | places | the surfaces that several legs saw |
//! | `normal` | residuals with their derivatives | sums, a step, covariances |
//! | `solve` | beams and surfaces | the values that make the surfaces flat |
//! | `spread` | residuals | how much they scatter, and how much of that neighbours share |
//! | `answer` | all of it | estimates, and what cannot be told |

mod answer;
mod beams;
mod constants;
mod normal;
mod planes;
mod solve;
mod spread;
mod unknowns;

pub use answer::{Calibration, CalibrationError, Estimate, calibrate};
pub use beams::{CalibrationBeam, of_sweeps as calibration_beams};
pub use unknowns::{Parameter, Present};
