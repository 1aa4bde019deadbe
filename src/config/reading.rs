//! From values by name to the typed settings, degrees to radians.

use super::check::waypoint_parts;
use super::layers::Layers;
use super::settings::{
    AlarmSettings, ApiSettings, EngineMode, LaserSettings, LogSettings, MixtureSettings,
    MountSettings, NoveltySettings, PtuSettings, RobotSettings, Settings, ShapeSettings,
    StoreSettings, SweepMode, SweepSettings, WaypointSettings,
};
use super::value::Value;
use patrold_engine::distance::Ground;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The settings that checked layers hold.
pub(super) fn read(layers: &Layers) -> Settings {
    let get = Getter(layers);
    let waypoints = read_waypoints(layers);
    Settings {
        robot: RobotSettings {
            name: get.text("robot.name"),
        },
        laser: LaserSettings {
            port: get.text("laser.port"),
            serial: get.unit("laser.serial"),
            baud: get.whole("laser.baud") as u32,
        },
        ptu: PtuSettings {
            port: get.text("ptu.port"),
            version: get.unit("ptu.version"),
            baud: get.whole("ptu.baud") as u32,
            pan_sign: get.whole("ptu.pan_sign") as f64,
            tilt_sign: get.whole("ptu.tilt_sign") as f64,
            pan_zero_rad: get.radians("ptu.pan_zero_deg"),
            tilt_zero_rad: get.radians("ptu.tilt_zero_deg"),
            tilt_backlash_rad: get.radians("ptu.tilt_backlash_deg"),
            home_at_start: get.flag("ptu.home_at_start"),
            suspect_pan_rad: get.radians("ptu.suspect_pan_deg"),
            suspect_tilt_rad: get.radians("ptu.suspect_tilt_deg"),
        },
        mount: MountSettings {
            pan_axis_m: get.triple("mount.pan_axis_xyz_m"),
            tilt_axis_m: get.triple("mount.tilt_axis_xyz_m"),
            plate_m: get.triple("mount.plate_xyz_m"),
            laser_m: get.triple("mount.xyz_m"),
            laser_rpy_rad: get.triple("mount.rpy_deg").map(f64::to_radians),
        },
        sweep: SweepSettings {
            mode: match get.text("sweep.mode").as_str() {
                "step" => SweepMode::Step,
                _ => SweepMode::Continuous,
            },
            tilt_from_rad: get.radians("sweep.tilt_from_deg"),
            tilt_to_rad: get.radians("sweep.tilt_to_deg"),
            speed_rad_s: get.radians("sweep.speed_deg_s"),
            step_rad: get.radians("sweep.step_deg"),
            time_offset_s: 1e-3 * get.float("sweep.time_offset_ms"),
            pans_rad: to_radians(&get.list("sweep.pans_deg")),
            max_missing_lines: get.float("sweep.max_missing_lines"),
        },
        mixture: MixtureSettings {
            seed: get.whole("mixture.seed") as u64,
        },
        novelty: NoveltySettings {
            engine: match get.text("novelty.engine").as_str() {
                "paper" => EngineMode::Paper,
                _ => EngineMode::Standard,
            },
            u_th_m: get.float("novelty.u_th_m"),
            u_th_fm: get.float("novelty.u_th_fm"),
            ground: match get.text("novelty.ground").as_str() {
                "euclid" => Ground::Euclid,
                "fm" => Ground::Fm,
                _ => Ground::W2,
            },
            max_range_m: Some(get.float("novelty.max_range_m")).filter(|m| *m > 0.0),
        },
        shape: ShapeSettings {
            method: get.text("shape.method"),
        },
        store: StoreSettings {
            dir: PathBuf::from(get.text("store.dir")),
            keep_days: get.float("store.keep_days"),
            keep_gib: get.float("store.keep_gib"),
        },
        alarms: AlarmSettings {
            same_place_m: get.float("alarms.same_place_m"),
        },
        api: ApiSettings {
            socket: PathBuf::from(get.text("api.socket")),
            socket_mode: get.whole("api.socket_mode") as u32,
        },
        log: LogSettings {
            level: get.text("log.level"),
            to: get.text("log.to"),
        },
        waypoints,
    }
}

fn read_waypoints(layers: &Layers) -> BTreeMap<String, WaypointSettings> {
    let mut waypoints: BTreeMap<String, WaypointSettings> = BTreeMap::new();
    for (name, (value, _)) in &layers.values {
        let Some((waypoint, key)) = waypoint_parts(name) else {
            continue;
        };
        let own = waypoints.entry(waypoint.to_owned()).or_default();
        match (key, value) {
            ("u_th_m", Value::Float(x)) => own.u_th_m = Some(*x),
            ("u_th_fm", Value::Float(x)) => own.u_th_fm = Some(*x),
            ("pans_deg", Value::Floats(list)) => own.pans_rad = Some(to_radians(list)),
            ("map_pose", Value::Floats(list)) => {
                own.map_pose = <[f64; 3]>::try_from(list.as_slice())
                    .ok()
                    .map(|[x, y, yaw_deg]| [x, y, yaw_deg.to_radians()]);
            }
            _ => {}
        }
    }
    waypoints
}

fn to_radians(degrees: &[f64]) -> Vec<f64> {
    degrees.iter().map(|d| d.to_radians()).collect()
}

/// Typed look-ups; every key has a default of its kind, so each finds its value.
struct Getter<'a>(&'a Layers);

impl Getter<'_> {
    fn value(&self, name: &str) -> Option<&Value> {
        self.0.values.get(name).map(|(value, _)| value)
    }

    fn text(&self, name: &str) -> String {
        match self.value(name) {
            Some(Value::Text(text)) => text.clone(),
            _ => String::new(),
        }
    }

    /// Which unit is meant; `None` for `any`.
    fn unit(&self, name: &str) -> Option<String> {
        Some(self.text(name)).filter(|unit| unit != "any")
    }

    fn float(&self, name: &str) -> f64 {
        match self.value(name) {
            Some(Value::Float(x)) => *x,
            _ => f64::NAN,
        }
    }

    fn radians(&self, name: &str) -> f64 {
        self.float(name).to_radians()
    }

    fn whole(&self, name: &str) -> i64 {
        match self.value(name) {
            Some(Value::Integer(n)) => *n,
            _ => 0,
        }
    }

    fn flag(&self, name: &str) -> bool {
        self.value(name) == Some(&Value::Flag(true))
    }

    fn list(&self, name: &str) -> Vec<f64> {
        match self.value(name) {
            Some(Value::Floats(list)) => list.clone(),
            _ => Vec::new(),
        }
    }

    fn triple(&self, name: &str) -> [f64; 3] {
        <[f64; 3]>::try_from(self.list(name).as_slice()).unwrap_or([f64::NAN; 3])
    }
}
