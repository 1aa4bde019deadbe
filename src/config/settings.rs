//! The typed settings. Angles are radians, lengths metres, times seconds.

use super::origins::SettingOrigins;
use patrold_engine::distance::GroundDistance;
use patrold_engine::inspect::Engine;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// All settings in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// `[robot]`
    pub robot: RobotConfig,
    /// `[laser]`
    pub laser: LaserConfig,
    /// `[ptu]`
    pub ptu: PtuConfig,
    /// `[mount]`
    pub mount: MountConfig,
    /// `[sweep]`
    pub sweep: SweepConfig,
    /// `[mixture]`
    pub mixture: MixtureConfig,
    /// `[novelty]`
    pub novelty: NoveltyConfig,
    /// `[shape]`
    pub shape: ShapeConfig,
    /// `[store]`
    pub store: StoreConfig,
    /// `[alarms]`
    pub alarms: AlarmConfig,
    /// `[api]`
    pub api: ApiConfig,
    /// `[log]`
    pub log: LogConfig,
    /// `[waypoint.NAME]`
    pub waypoints: BTreeMap<String, WaypointConfig>,
    /// Where each value was set.
    pub origins: SettingOrigins,
}

/// `[robot]`
#[derive(Debug, Clone, PartialEq)]
pub struct RobotConfig {
    /// Robot's name in alarms and status.
    pub name: String,
}

/// `[laser]`
#[derive(Debug, Clone, PartialEq)]
pub struct LaserConfig {
    /// Device path, `usb:VVVV:PPPP[:SERIAL]` or `tcp:HOST:PORT`.
    pub port: String,
    /// Required serial number; `None`: any.
    pub serial: Option<String>,
    /// Line rate on RS-232, bit/s.
    pub baud: u32,
}

/// `[ptu]`
#[derive(Debug, Clone, PartialEq)]
pub struct PtuConfig {
    /// Device path or `usb:VVVV:PPPP[:SERIAL]`.
    pub port: String,
    /// Text that the version string must contain; `None`: any.
    pub version: Option<String>,
    /// Line rate, bit/s.
    pub baud: u32,
    /// +1 where positive pan counts turn left, else -1.
    pub pan_sign: f64,
    /// +1 where positive tilt counts turn up, else -1.
    pub tilt_sign: f64,
    /// Pan at count 0, radians.
    pub pan_zero_rad: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Tilt difference between moving up and moving down to the same count, radians.
    pub tilt_backlash_rad: f64,
    /// Home when connecting.
    pub home_at_start: bool,
    /// Pan rotation of one view against the reference from which steps may be lost, before the robot's errors are known, radians.
    pub suspect_pan_rad: f64,
    /// The same for tilt, radians.
    pub suspect_tilt_rad: f64,
}

/// `[mount]`: the kinematic chain of sweep-geometry section 2, metres and radians.
#[derive(Debug, Clone, PartialEq)]
pub struct MountConfig {
    /// o_pan: pan axis in the base frame.
    pub pan_axis_m: [f64; 3],
    /// o_tilt: tilt axis in the pan frame.
    pub tilt_axis_m: [f64; 3],
    /// o_mount: mounting plate in the tilt frame.
    pub plate_m: [f64; 3],
    /// t_L: optical centre of the laser on the plate.
    pub laser_m: [f64; 3],
    /// Roll, pitch, yaw of R_L.
    pub laser_rpy_rad: [f64; 3],
}

/// How the head moves while the laser scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SweepMode {
    /// Tilting while scans stream.
    Continuous,
    /// Stopping for each line.
    Step,
}

/// `[sweep]`
#[derive(Debug, Clone, PartialEq)]
pub struct SweepConfig {
    /// Continuous or step-and-stare.
    pub mode: SweepMode,
    /// First tilt, radians.
    pub tilt_from_rad: f64,
    /// Last tilt, radians.
    pub tilt_to_rad: f64,
    /// Tilt speed, radians per second.
    pub speed_rad_s: f64,
    /// Pitch of the lines in step mode, radians.
    pub step_rad: f64,
    /// Added to the laser's timestamps, seconds.
    pub time_offset_s: f64,
    /// Pans of one visit, radians.
    pub pans_rad: Vec<f64>,
    /// Fraction of missing lines above which a sweep is refused.
    pub max_missing_lines: f64,
}

/// `[mixture]`
#[derive(Debug, Clone, PartialEq)]
pub struct MixtureConfig {
    /// Seed of the engine's random numbers.
    pub seed: u64,
}

/// `[novelty]`
#[derive(Debug, Clone, PartialEq)]
pub struct NoveltyConfig {
    /// Which engine.
    pub engine: Engine,
    /// U_th (paper Eq. 7), metres.
    pub u_th_m: f64,
    /// U_th for the Foerstner-Moonen ground distance, no unit.
    pub u_th_fm: f64,
    /// Ground distance between Gaussians.
    pub ground: GroundDistance,
    /// Points farther away are ignored, metres.
    pub max_range_m: Option<f64>,
    /// Share of the reference's solid angle that must be judged for a visit to be quiet.
    pub min_coverage: f64,
}

/// `[shape]`
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeConfig {
    /// `auto`, `covariance` or `ransac`.
    pub method: String,
}

/// `[store]`
#[derive(Debug, Clone, PartialEq)]
pub struct StoreConfig {
    /// Folder of the database and the sweep files.
    pub dir: PathBuf,
    /// Days after which a sweep may be deleted; 0 keeps all.
    pub keep_days: f64,
    /// GiB of sweeps above which the oldest are deleted; 0 sets no limit.
    pub keep_gib: f64,
    /// Days after which a file that no row names is deleted; 0 keeps all.
    pub keep_unnamed_days: f64,
}

/// `[alarms]`
#[derive(Debug, Clone, PartialEq)]
pub struct AlarmConfig {
    /// A thing that is further from where it was has moved, metres.
    pub same_place_m: f64,
    /// Hours without a visit after which a waypoint is a health incident; 0: never.
    pub unseen_after_h: f64,
}

/// `[api]`
#[derive(Debug, Clone, PartialEq)]
pub struct ApiConfig {
    /// Unix socket.
    pub socket: PathBuf,
    /// Its file mode.
    pub socket_mode: u32,
}

/// `[log]`
#[derive(Debug, Clone, PartialEq)]
pub struct LogConfig {
    /// error, warn, info, debug or trace.
    pub level: String,
    /// auto, journald or stderr.
    pub to: String,
}

/// `[waypoint.NAME]`
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WaypointConfig {
    /// U_th of this waypoint, metres.
    pub u_th_m: Option<f64>,
    /// U_th of this waypoint for the Foerstner-Moonen ground distance.
    pub u_th_fm: Option<f64>,
    /// Pans of this waypoint, radians.
    pub pans_rad: Option<Vec<f64>>,
    /// x, y (metres) and yaw (radians) of the base on the map.
    pub map_pose: Option<[f64; 3]>,
}

impl Settings {
    /// U_th (paper Eq. 7) of a waypoint, in the unit of the ground distance in force.
    pub fn u_th(&self, waypoint: Option<&str>) -> f64 {
        let own = waypoint.and_then(|name| self.waypoints.get(name));
        match self.novelty.ground {
            GroundDistance::Fm => own.and_then(|w| w.u_th_fm).unwrap_or(self.novelty.u_th_fm),
            _ => own.and_then(|w| w.u_th_m).unwrap_or(self.novelty.u_th_m),
        }
    }

    /// Sets U_th of a waypoint, in the unit of the ground distance in force.
    pub fn set_u_th(&mut self, waypoint: &str, u_th: f64) {
        let own = self.waypoints.entry(waypoint.to_owned()).or_default();
        match self.novelty.ground {
            GroundDistance::Fm => own.u_th_fm = Some(u_th),
            GroundDistance::W2 | GroundDistance::Euclid => own.u_th_m = Some(u_th),
        }
    }

    /// Pans of one visit at a waypoint, or of a bare sweep, radians.
    pub fn pans_rad(&self, waypoint: Option<&str>) -> &[f64] {
        let own = waypoint.and_then(|name| self.own_pans_rad(name));
        own.unwrap_or(&self.sweep.pans_rad)
    }

    /// The key that sets them.
    pub fn pans_key(&self, waypoint: Option<&str>) -> String {
        match waypoint {
            Some(name) if self.own_pans_rad(name).is_some() => format!("waypoint.{name}.pans_deg"),
            _ => "sweep.pans_deg".to_owned(),
        }
    }

    fn own_pans_rad(&self, waypoint: &str) -> Option<&[f64]> {
        self.waypoints.get(waypoint)?.pans_rad.as_deref()
    }
}
