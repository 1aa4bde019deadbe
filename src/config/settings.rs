//! The configuration as the program reads it: checked, typed, no more names to look up.

use super::check::Mistake;
use super::contradictions::contradictions;
use super::layers::Layers;
use super::reading::read;
use patrold_engine::distance::Ground;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Everything that is in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// `[robot]`
    pub robot: RobotSettings,
    /// `[laser]`
    pub laser: LaserSettings,
    /// `[ptu]`
    pub ptu: PtuSettings,
    /// `[mount]`
    pub mount: MountSettings,
    /// `[sweep]`
    pub sweep: SweepSettings,
    /// `[mixture]`
    pub mixture: MixtureSettings,
    /// `[novelty]`
    pub novelty: NoveltySettings,
    /// `[shape]`
    pub shape: ShapeSettings,
    /// `[store]`
    pub store: StoreSettings,
    /// `[alarms]`
    pub alarms: AlarmSettings,
    /// `[api]`
    pub api: ApiSettings,
    /// `[log]`
    pub log: LogSettings,
    /// `[waypoint.NAME]`
    pub waypoints: BTreeMap<String, WaypointSettings>,
}

/// `[robot]`
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSettings {
    /// Who signs the alarms.
    pub name: String,
}

/// `[laser]`
#[derive(Debug, Clone, PartialEq)]
pub struct LaserSettings {
    /// Device path, `usb:VVVV:PPPP[:SERIAL]` or `tcp:HOST:PORT`.
    pub port: String,
    /// Serial number that it must have; `None`: any.
    pub serial: Option<String>,
    /// Line rate on RS-232.
    pub baud: u32,
}

/// `[ptu]`
#[derive(Debug, Clone, PartialEq)]
pub struct PtuSettings {
    /// Device path or `usb:VVVV:PPPP[:SERIAL]`.
    pub port: String,
    /// Text that its version must contain; `None`: any.
    pub version: Option<String>,
    /// Line rate.
    pub baud: u32,
    /// +1 where positive pan counts turn left, else -1.
    pub pan_sign: f64,
    /// +1 where positive tilt counts turn up, else -1.
    pub tilt_sign: f64,
    /// Pan at count 0, radians.
    pub pan_zero_rad: f64,
    /// Tilt at count 0, radians.
    pub tilt_zero_rad: f64,
    /// Difference of the tilt between a travel up and one down, radians.
    pub tilt_backlash_rad: f64,
    /// Home when connecting.
    pub home_at_start: bool,
    /// Turn about the pan axis from which lost steps are suspected, radians.
    pub suspect_pan_rad: f64,
    /// The same about the tilt axis, radians.
    pub suspect_tilt_rad: f64,
}

/// `[mount]`: the kinematic chain of sweep-geometry section 2, metres and radians.
#[derive(Debug, Clone, PartialEq)]
pub struct MountSettings {
    /// o_pan.
    pub pan_axis_m: [f64; 3],
    /// o_tilt.
    pub tilt_axis_m: [f64; 3],
    /// o_mount.
    pub plate_m: [f64; 3],
    /// t_L.
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
pub struct SweepSettings {
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
    /// Added to the laser's instants, seconds.
    pub time_offset_s: f64,
    /// Pans of one visit, radians.
    pub pans_rad: Vec<f64>,
    /// Share of missing lines above which a sweep is refused.
    pub max_missing_lines: f64,
}

/// `[mixture]`
#[derive(Debug, Clone, PartialEq)]
pub struct MixtureSettings {
    /// Seed of everything random in the engine.
    pub seed: u64,
}

/// Which row of engine settings is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EngineMode {
    /// patrold's own.
    Standard,
    /// The published recipe.
    Paper,
}

/// `[novelty]`
#[derive(Debug, Clone, PartialEq)]
pub struct NoveltySettings {
    /// Which engine settings.
    pub engine: EngineMode,
    /// U_th, metres.
    pub u_th_m: f64,
    /// U_th where the ground distance is Foerstner-Moonen.
    pub u_th_fm: f64,
    /// Ground distance between Gaussians.
    pub ground: Ground,
    /// Range limit in metres, if any.
    pub max_range_m: Option<f64>,
}

/// `[shape]`
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeSettings {
    /// `auto`, `covariance` or `ransac`.
    pub method: String,
}

/// `[store]`
#[derive(Debug, Clone, PartialEq)]
pub struct StoreSettings {
    /// Folder of the database and the files beside it.
    pub dir: PathBuf,
    /// Days after which a sweep may go; 0 keeps all.
    pub keep_days: f64,
    /// GiB of sweeps above which the oldest go; 0 sets no limit.
    pub keep_gib: f64,
}

/// `[alarms]`
#[derive(Debug, Clone, PartialEq)]
pub struct AlarmSettings {
    /// Distance within which a change seen again is the same, metres.
    pub same_place_m: f64,
}

/// `[api]`
#[derive(Debug, Clone, PartialEq)]
pub struct ApiSettings {
    /// Unix socket.
    pub socket: PathBuf,
    /// Its file mode.
    pub socket_mode: u32,
}

/// `[log]`
#[derive(Debug, Clone, PartialEq)]
pub struct LogSettings {
    /// error, warn, info, debug or trace.
    pub level: String,
    /// auto, journald or stderr.
    pub to: String,
}

/// `[waypoint.NAME]`
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WaypointSettings {
    /// U_th of this waypoint, metres.
    pub u_th_m: Option<f64>,
    /// U_th of this waypoint where the ground distance is Foerstner-Moonen.
    pub u_th_fm: Option<f64>,
    /// Pans of this waypoint, radians.
    pub pans_rad: Option<Vec<f64>>,
    /// x, y in metres and yaw in radians of the base on the map.
    pub map_pose: Option<[f64; 3]>,
}

impl Settings {
    /// The settings of an empty file.
    pub fn defaults() -> Self {
        read(&Layers::defaults())
    }

    /// Reads checked layers and looks for contradictions between them.
    ///
    /// # Errors
    /// Every contradiction found.
    pub fn build(layers: &Layers) -> Result<Self, Vec<Mistake>> {
        let settings = read(layers);
        let mistakes = contradictions(&settings, layers);
        if mistakes.is_empty() {
            Ok(settings)
        } else {
            Err(mistakes)
        }
    }

    /// U_th in force at a waypoint, in the unit of the ground distance in force (Eq. 7).
    pub fn u_th(&self, waypoint: Option<&str>) -> f64 {
        let own = waypoint.and_then(|name| self.waypoints.get(name));
        match self.novelty.ground {
            Ground::Fm => own.and_then(|w| w.u_th_fm).unwrap_or(self.novelty.u_th_fm),
            _ => own.and_then(|w| w.u_th_m).unwrap_or(self.novelty.u_th_m),
        }
    }

    /// Puts another U_th in force at a waypoint, in the unit of the ground distance in force.
    pub fn set_u_th(&mut self, waypoint: &str, u_th: f64) {
        let own = self.waypoints.entry(waypoint.to_owned()).or_default();
        match self.novelty.ground {
            Ground::Fm => own.u_th_fm = Some(u_th),
            Ground::W2 | Ground::Euclid => own.u_th_m = Some(u_th),
        }
    }

    /// Pans of one visit at a waypoint, radians.
    pub fn pans_rad(&self, waypoint: &str) -> &[f64] {
        self.waypoints
            .get(waypoint)
            .and_then(|w| w.pans_rad.as_deref())
            .unwrap_or(&self.sweep.pans_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::{Layers, Settings};
    use crate::config::Source;
    use std::path::PathBuf;

    fn layers(text: &str) -> Layers {
        let mut layers = Layers::defaults();
        let mistakes = layers.add(&Source {
            path: PathBuf::from("t.toml"),
            text: text.to_owned(),
        });
        assert!(mistakes.is_empty(), "{mistakes:?}");
        layers
    }

    #[test]
    fn an_empty_file_gives_the_defaults_and_no_number_is_missing() {
        let settings = Settings::build(&layers("")).expect("defaults do not contradict");
        assert_eq!(settings, Settings::defaults());
        assert!(!format!("{settings:?}").contains("NaN"));
    }

    #[test]
    fn a_waypoint_overrides_the_threshold() {
        let text = "novelty.u_th_m = 0.25\n[waypoint.hall]\nu_th_m = 0.5\n";
        let settings = Settings::build(&layers(text)).expect("valid");
        assert_eq!(settings.u_th(Some("hall")), 0.5);
        assert_eq!(settings.u_th(Some("dock")), 0.25);
        assert_eq!(settings.u_th(None), 0.25);
    }
}
