//! The request of a sweep: mode, angles, speed, mount.

use crate::config::{MountConfig, SweepConfig, SweepMode};
use patrold_engine::geometry::Mount;

/// A sweep in radians and metres.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRequest {
    /// Continuous or step-and-stare.
    pub mode: SweepMode,
    /// First tilt, radians.
    pub tilt_from_rad: f64,
    /// Last tilt, radians; the head moves from the first to the last, always.
    pub tilt_to_rad: f64,
    /// Speed of a continuous sweep, radians per second.
    pub speed_rad_s: f64,
    /// Distance between lines of step-and-stare, radians.
    pub step_rad: f64,
    /// Added to the laser's timestamps, seconds; stored with the sweep.
    pub time_offset_s: f64,
    /// Pans in this order, radians.
    pub pans_rad: Vec<f64>,
    /// Chain from base to laser; stored with the sweep.
    pub mount: Mount,
}

impl SweepRequest {
    /// The configured sweep at these pans, radians; `Settings::pans_rad` has those of a waypoint.
    pub fn new(settings: &SweepConfig, mount: &MountConfig, pans_rad: &[f64]) -> Self {
        Self {
            mode: settings.mode,
            tilt_from_rad: settings.tilt_from_rad,
            tilt_to_rad: settings.tilt_to_rad,
            speed_rad_s: settings.speed_rad_s,
            step_rad: settings.step_rad,
            time_offset_s: settings.time_offset_s,
            pans_rad: pans_rad.to_vec(),
            mount: mount.chain(),
        }
    }
}
