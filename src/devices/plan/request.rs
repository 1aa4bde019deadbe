//! The request of a sweep: mode, angles, speed, mount.

use crate::config::{Settings, SweepMode};
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
    /// The keys of the pans and of the tilt's two ends, and where they were set: for errors.
    pub angle_settings: AngleSettings,
}

/// Keys of the angles of a sweep, each with the place that set it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AngleSettings {
    /// Of the pans.
    pub pans: String,
    /// Of the first and the last tilt.
    pub tilt: String,
}

impl SweepRequest {
    /// The configured sweep at a waypoint, or a bare one.
    pub fn new(settings: &Settings, waypoint: Option<&str>) -> Self {
        let (sweep, origins) = (&settings.sweep, &settings.origins);
        let ends = ["sweep.tilt_from_deg", "sweep.tilt_to_deg"].map(|key| origins.quote(key));
        Self {
            mode: sweep.mode,
            tilt_from_rad: sweep.tilt_from_rad,
            tilt_to_rad: sweep.tilt_to_rad,
            speed_rad_s: sweep.speed_rad_s,
            step_rad: sweep.step_rad,
            time_offset_s: sweep.time_offset_s,
            pans_rad: settings.pans_rad(waypoint).to_vec(),
            mount: settings.mount.chain(),
            angle_settings: AngleSettings {
                pans: origins.quote(&settings.pans_key(waypoint)),
                tilt: ends.join("; "),
            },
        }
    }
}
