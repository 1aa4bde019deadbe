//! From values by name to the typed settings; degrees become radians, milliseconds seconds.

use super::contradictions::contradictions;
use super::error::ConfigError;
use super::key_lookup::split_waypoint_key;
use super::layers::ConfigLayers;
use super::origins::SettingOrigins;
use super::settings::{
    AlarmConfig, ApiConfig, LaserConfig, LogConfig, MixtureConfig, MountConfig, NoveltyConfig,
    PtuConfig, RobotConfig, Settings, ShapeConfig, StoreConfig, SweepConfig, SweepMode,
    WaypointConfig,
};
use super::value::ConfigValue;
use patrold_engine::distance::GroundDistance;
use patrold_engine::inspect::Engine;
use std::collections::BTreeMap;
use std::path::PathBuf;

impl Settings {
    /// The settings of an empty file.
    pub fn defaults() -> Self {
        read_settings(&ConfigLayers::defaults())
    }

    /// Reads the layers and checks that no two settings contradict each other.
    ///
    /// # Errors
    /// All contradictions found.
    pub fn from_layers(layers: &ConfigLayers) -> Result<Self, Vec<ConfigError>> {
        let (settings, errors) = Self::from_layers_leniently(layers);
        if errors.is_empty() {
            Ok(settings)
        } else {
            Err(errors)
        }
    }

    /// Reads the layers as they are; contradictions come with the settings.
    pub(super) fn from_layers_leniently(layers: &ConfigLayers) -> (Self, Vec<ConfigError>) {
        let settings = read_settings(layers);
        let errors = contradictions(&settings, layers);
        (settings, errors)
    }
}

fn read_settings(layers: &ConfigLayers) -> Settings {
    let get = LayerValues(layers);
    let waypoints = read_waypoints(layers);
    Settings {
        robot: RobotConfig {
            name: get.text("robot.name"),
        },
        laser: LaserConfig {
            port: get.text("laser.port"),
            serial: get.required_unit("laser.serial"),
            baud: get.integer("laser.baud") as u32,
        },
        ptu: PtuConfig {
            port: get.text("ptu.port"),
            version: get.required_unit("ptu.version"),
            baud: get.integer("ptu.baud") as u32,
            pan_sign: get.integer("ptu.pan_sign") as f64,
            tilt_sign: get.integer("ptu.tilt_sign") as f64,
            pan_zero_rad: get.radians("ptu.pan_zero_deg"),
            tilt_zero_rad: get.radians("ptu.tilt_zero_deg"),
            tilt_backlash_rad: get.radians("ptu.tilt_backlash_deg"),
            home_at_start: get.flag("ptu.home_at_start"),
            suspect_pan_rad: get.radians("ptu.suspect_pan_deg"),
            suspect_tilt_rad: get.radians("ptu.suspect_tilt_deg"),
        },
        mount: MountConfig {
            pan_axis_m: get.triple("mount.pan_axis_xyz_m"),
            tilt_axis_m: get.triple("mount.tilt_axis_xyz_m"),
            plate_m: get.triple("mount.plate_xyz_m"),
            laser_m: get.triple("mount.xyz_m"),
            laser_rpy_rad: get.triple("mount.rpy_deg").map(f64::to_radians),
        },
        sweep: SweepConfig {
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
        mixture: MixtureConfig {
            seed: get.integer("mixture.seed") as u64,
        },
        novelty: NoveltyConfig {
            engine: get
                .text("novelty.engine")
                .parse()
                .unwrap_or(Engine::Standard),
            u_th_m: get.float("novelty.u_th_m"),
            u_th_fm: get.float("novelty.u_th_fm"),
            ground: match get.text("novelty.ground").as_str() {
                "euclid" => GroundDistance::Euclid,
                "fm" => GroundDistance::Fm,
                _ => GroundDistance::W2,
            },
            max_range_m: Some(get.float("novelty.max_range_m")).filter(|m| *m > 0.0),
            min_coverage: get.float("novelty.min_coverage"),
        },
        shape: ShapeConfig {
            method: get.text("shape.method"),
        },
        store: StoreConfig {
            dir: PathBuf::from(get.text("store.dir")),
            keep_days: get.float("store.keep_days"),
            keep_gib: get.float("store.keep_gib"),
            keep_unnamed_days: get.float("store.keep_unnamed_days"),
        },
        alarms: AlarmConfig {
            same_place_m: get.float("alarms.same_place_m"),
            unseen_after_h: get.float("alarms.unseen_after"),
        },
        api: ApiConfig {
            socket: PathBuf::from(get.text("api.socket")),
            socket_mode: get.integer("api.socket_mode") as u32,
        },
        log: LogConfig {
            level: get.text("log.level"),
            to: get.text("log.to"),
        },
        waypoints,
        origins: SettingOrigins::from_layers(layers),
    }
}

fn read_waypoints(layers: &ConfigLayers) -> BTreeMap<String, WaypointConfig> {
    let mut waypoints: BTreeMap<String, WaypointConfig> = BTreeMap::new();
    for (name, (value, _)) in &layers.values {
        let Some((waypoint, key)) = split_waypoint_key(name) else {
            continue;
        };
        let own = waypoints.entry(waypoint.to_owned()).or_default();
        match (key, value) {
            ("u_th_m", ConfigValue::Float(x)) => own.u_th_m = Some(*x),
            ("u_th_fm", ConfigValue::Float(x)) => own.u_th_fm = Some(*x),
            ("pans_deg", ConfigValue::Floats(list)) => own.pans_rad = Some(to_radians(list)),
            ("map_pose", ConfigValue::Floats(list)) => {
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

/// Typed look-up by name. Every key has a default of its kind, so each look-up succeeds.
struct LayerValues<'a>(&'a ConfigLayers);

impl LayerValues<'_> {
    fn value(&self, name: &str) -> Option<&ConfigValue> {
        self.0.values.get(name).map(|(value, _)| value)
    }

    fn text(&self, name: &str) -> String {
        match self.value(name) {
            Some(ConfigValue::Text(text)) => text.clone(),
            _ => String::new(),
        }
    }

    /// The required unit; `None` for `any`.
    fn required_unit(&self, name: &str) -> Option<String> {
        Some(self.text(name)).filter(|unit| unit != "any")
    }

    fn float(&self, name: &str) -> f64 {
        match self.value(name) {
            Some(ConfigValue::Float(x)) => *x,
            _ => f64::NAN,
        }
    }

    fn radians(&self, name: &str) -> f64 {
        self.float(name).to_radians()
    }

    fn integer(&self, name: &str) -> i64 {
        match self.value(name) {
            Some(ConfigValue::Integer(n)) => *n,
            _ => 0,
        }
    }

    fn flag(&self, name: &str) -> bool {
        self.value(name) == Some(&ConfigValue::Flag(true))
    }

    fn list(&self, name: &str) -> Vec<f64> {
        match self.value(name) {
            Some(ConfigValue::Floats(list)) => list.clone(),
            _ => Vec::new(),
        }
    }

    fn triple(&self, name: &str) -> [f64; 3] {
        <[f64; 3]>::try_from(self.list(name).as_slice()).unwrap_or([f64::NAN; 3])
    }
}

#[cfg(test)]
mod tests {
    use super::{ConfigLayers, Settings};
    use crate::config::{ConfigFile, SweepMode};
    use std::f64::consts::PI;
    use std::path::PathBuf;

    fn layers(text: &str) -> ConfigLayers {
        let mut layers = ConfigLayers::defaults();
        let mistakes = layers.add(&ConfigFile {
            path: PathBuf::from("t.toml"),
            text: text.to_owned(),
        });
        assert!(mistakes.is_empty(), "{mistakes:?}");
        layers
    }

    #[test]
    fn an_empty_file_gives_the_defaults_and_no_number_is_missing() {
        let settings = Settings::from_layers(&layers("")).expect("defaults do not contradict");
        assert_eq!(settings, Settings::defaults());
        assert!(!format!("{settings:?}").contains("NaN"));
    }

    #[test]
    fn a_waypoint_overrides_the_threshold() {
        let text = "novelty.u_th_m = 0.25\n[waypoint.hall]\nu_th_m = 0.5\n";
        let settings = Settings::from_layers(&layers(text)).expect("valid");
        assert_eq!(settings.u_th(Some("hall")), 0.5);
        assert_eq!(settings.u_th(Some("dock")), 0.25);
        assert_eq!(settings.u_th(None), 0.25);
    }

    #[test]
    fn a_waypoint_has_its_own_threshold_pans_and_pose() {
        let text = "sweep.pans_deg = [36]\nnovelty.ground = \"fm\"\nnovelty.u_th_fm = 0.5\n\
            [waypoint.hall]\nu_th_fm = 0.75\npans_deg = [-90, 45]\nmap_pose = [1, 2, 18]\n\
            [waypoint.dock]\nmap_pose = [3, 4, 0]\n";
        let mut settings = Settings::from_layers(&layers(text)).expect("valid");
        assert_eq!(settings.u_th(Some("hall")), 0.75);
        assert_eq!(settings.u_th(Some("dock")), 0.5);
        settings.set_u_th("dock", 1.5);
        assert_eq!(settings.u_th(Some("dock")), 1.5);
        assert_eq!(settings.u_th(Some("hall")), 0.75);
        assert_eq!(settings.pans_rad(Some("hall")), [-PI / 2.0, PI / 4.0]);
        assert_eq!(settings.pans_rad(Some("dock")), [PI / 5.0]);
        assert_eq!(settings.pans_rad(Some("yard")), [PI / 5.0]);
        assert_eq!(settings.pans_rad(None), [PI / 5.0]);
        assert_eq!(settings.pans_key(Some("hall")), "waypoint.hall.pans_deg");
        for bare in [Some("dock"), Some("yard"), None] {
            assert_eq!(settings.pans_key(bare), "sweep.pans_deg");
        }
        let pose = |name: &str| settings.waypoints.get(name).and_then(|own| own.map_pose);
        assert_eq!(pose("hall"), Some([1.0, 2.0, PI / 10.0]));
        assert_eq!(pose("dock"), Some([3.0, 4.0, 0.0]));
    }

    #[test]
    fn what_is_kept_logged_and_answered_is_read_by_its_name() {
        let text = "[robot]\nname = \"r2\"\n[laser]\nserial = \"H1\"\n[ptu]\nversion = \"v2\"\n\
            [mixture]\nseed = 9\n\
            [novelty]\nu_th_m = 0.25\nmax_range_m = 3.5\n[shape]\nmethod = \"ransac\"\n\
            [store]\ndir = \"/a\"\nkeep_days = 1\nkeep_gib = 2\nkeep_unnamed_days = 3\n\
            [alarms]\nsame_place_m = 4\nunseen_after = 5\n[api]\nsocket = \"/b\"\nsocket_mode = 0o600\n\
            [log]\nlevel = \"debug\"\nto = \"stderr\"\n";
        let settings = Settings::from_layers(&layers(text)).expect("valid");
        assert_eq!(settings.robot.name, "r2");
        assert_eq!(settings.laser.serial.as_deref(), Some("H1"));
        assert_eq!(settings.ptu.version.as_deref(), Some("v2"));
        assert_eq!(settings.mixture.seed, 9);
        assert_eq!(settings.novelty.u_th_m, 0.25);
        assert_eq!(settings.novelty.max_range_m, Some(3.5));
        assert_eq!(settings.shape.method, "ransac");
        let store = &settings.store;
        assert_eq!(store.dir, PathBuf::from("/a"));
        assert_eq!(
            (store.keep_days, store.keep_gib, store.keep_unnamed_days),
            (1.0, 2.0, 3.0)
        );
        let alarms = &settings.alarms;
        assert_eq!((alarms.same_place_m, alarms.unseen_after_h), (4.0, 5.0));
        assert_eq!(settings.api.socket, PathBuf::from("/b"));
        assert_eq!(settings.api.socket_mode, 0o600);
        let log = &settings.log;
        assert_eq!((log.level.as_str(), log.to.as_str()), ("debug", "stderr"));
        let defaults = Settings::defaults();
        assert_eq!((defaults.laser.serial, defaults.ptu.version), (None, None));
        assert_eq!(defaults.novelty.max_range_m, None, "0 keeps all");
    }

    #[test]
    fn the_numbers_of_devices_mount_and_sweep_are_read_in_si_units() {
        let text = "[laser]\nport = \"tcp:10.0.0.2:10940\"\nbaud = 57600\n\
            [ptu]\nport = \"tcp:server:4001\"\nbaud = 19200\npan_sign = -1\npan_zero_deg = 1.8\n\
            tilt_zero_deg = -3.6\ntilt_backlash_deg = 0.18\nsuspect_pan_deg = 0.9\nsuspect_tilt_deg = 0.36\n\
            home_at_start = false\n\
            [mount]\npan_axis_xyz_m = [1, 2, 3]\ntilt_axis_xyz_m = [4, 5, 6]\nplate_xyz_m = [7, 8, 9]\n\
            xyz_m = [0.1, 0.2, 0.3]\nrpy_deg = [180, 18, -36]\n\
            [sweep]\nmode = \"step\"\ntilt_from_deg = -18\ntilt_to_deg = 36\nspeed_deg_s = 7.2\nstep_deg = 0.72\n\
            time_offset_ms = -12.5\npans_deg = [-90, 45]\nmax_missing_lines = 0.25\n";
        let settings = Settings::from_layers(&layers(text)).expect("valid");
        let is_pi_over = |rad: f64, divisor: f64| {
            assert!(
                (rad - PI / divisor).abs() < 1e-12,
                "{rad}, not pi / {divisor}"
            );
        };
        let (laser, ptu, mount, sweep) = (
            &settings.laser,
            &settings.ptu,
            &settings.mount,
            &settings.sweep,
        );
        assert_eq!(
            (laser.port.as_str(), laser.baud),
            ("tcp:10.0.0.2:10940", 57_600)
        );
        assert_eq!((ptu.port.as_str(), ptu.baud), ("tcp:server:4001", 19_200));
        assert_eq!((ptu.pan_sign, ptu.tilt_sign), (-1.0, 1.0));
        assert!(!ptu.home_at_start);
        is_pi_over(ptu.pan_zero_rad, 100.0);
        is_pi_over(ptu.tilt_zero_rad, -50.0);
        is_pi_over(ptu.tilt_backlash_rad, 1000.0);
        is_pi_over(ptu.suspect_pan_rad, 200.0);
        is_pi_over(ptu.suspect_tilt_rad, 500.0);
        assert_eq!(mount.pan_axis_m, [1.0, 2.0, 3.0]);
        assert_eq!(mount.tilt_axis_m, [4.0, 5.0, 6.0]);
        assert_eq!(mount.plate_m, [7.0, 8.0, 9.0]);
        assert_eq!(mount.laser_m, [0.1, 0.2, 0.3]);
        for (rad, divisor) in mount.laser_rpy_rad.into_iter().zip([1.0, 10.0, -5.0]) {
            is_pi_over(rad, divisor);
        }
        assert_eq!(sweep.mode, SweepMode::Step);
        is_pi_over(sweep.tilt_from_rad, -10.0);
        is_pi_over(sweep.tilt_to_rad, 5.0);
        is_pi_over(sweep.speed_rad_s, 25.0);
        is_pi_over(sweep.step_rad, 250.0);
        assert!((sweep.time_offset_s + 0.0125).abs() < 1e-15, "milliseconds");
        let [first, second] = sweep.pans_rad[..] else {
            panic!("two pans")
        };
        is_pi_over(first, -2.0);
        is_pi_over(second, 4.0);
        assert_eq!(sweep.max_missing_lines, 0.25);
    }
}
