//! Settings that contradict each other, reported at the line of the file that sets one of them.

use super::engine::ground_name;
use super::error::{ConfigError, ConfigProblem};
use super::layers::{ConfigLayers, ValueOrigin};
use super::settings::Settings;
use crate::patrol::name::waypoint_name_error;
use patrold_engine::distance::GroundDistance;

/// One degree, radians.
const MIN_TILT_RANGE_RAD: f64 = std::f64::consts::PI / 180.0;

pub(super) fn contradictions(settings: &Settings, layers: &ConfigLayers) -> Vec<ConfigError> {
    let mut found = Vec::new();
    let mut report = |keys: &[&str], what: String| {
        let (file, line) = layers.location(keys);
        found.push(ConfigError {
            file,
            line,
            problem: ConfigProblem::Contradiction(what),
        });
    };
    let sweep = &settings.sweep;
    if (sweep.tilt_from_rad - sweep.tilt_to_rad).abs() < MIN_TILT_RANGE_RAD {
        report(
            &["sweep.tilt_to_deg", "sweep.tilt_from_deg"],
            "sweep.tilt_from_deg and sweep.tilt_to_deg must be at least 1 deg apart".to_owned(),
        );
    }
    if settings.laser.port == settings.ptu.port {
        report(
            &["ptu.port", "laser.port"],
            format!("laser.port and ptu.port are both {}", settings.laser.port),
        );
    }
    for name in settings.waypoints.keys() {
        if let Some(why) = waypoint_name_error(name) {
            let prefix = format!("waypoint.{name}.");
            let keys = layers.values.keys().filter(|key| key.starts_with(&prefix));
            report(&keys.map(String::as_str).collect::<Vec<_>>(), why);
        }
    }
    for (unused, effective) in unused_thresholds(settings, layers) {
        let what = format!(
            "{unused} has no effect while novelty.ground is {}; set {effective}",
            ground_name(settings.novelty.ground)
        );
        report(&[&unused], what);
    }
    found
}

/// Thresholds that a file sets for a ground distance not in force, each with the key that would take effect and is not set.
fn unused_thresholds(settings: &Settings, layers: &ConfigLayers) -> Vec<(String, String)> {
    let (unused, effective) = match settings.novelty.ground {
        GroundDistance::Fm => ("u_th_m", "u_th_fm"),
        GroundDistance::W2 | GroundDistance::Euclid => ("u_th_fm", "u_th_m"),
    };
    let is_set = |key: &str| {
        let value = layers.values.get(key);
        value.is_some_and(|(_, origin)| *origin != ValueOrigin::Default)
    };
    layers
        .values
        .iter()
        .filter(|(_, (_, origin))| matches!(origin, ValueOrigin::File(..)))
        .filter_map(|(key, _)| {
            let section = key.strip_suffix(unused)?.strip_suffix('.')?;
            Some((key.clone(), format!("{section}.{effective}")))
        })
        .filter(|(_, effective)| !is_set(effective))
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::config::{ConfigFile, ConfigLayers, Settings};
    use std::path::PathBuf;

    fn errors(text: &str) -> Vec<String> {
        let mut layers = ConfigLayers::defaults();
        let path = PathBuf::from("t.toml");
        let text = text.to_owned();
        assert_eq!(layers.add(&ConfigFile { path, text }), []);
        let errors = Settings::from_layers(&layers).err().unwrap_or_default();
        errors.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_contradiction_has_the_line_of_a_key_that_the_file_sets() {
        let both = errors("[sweep]\ntilt_from_deg = 10\ntilt_to_deg = 10\n");
        assert!(
            both[0].starts_with("t.toml:3: sweep.tilt_from_deg"),
            "{both:?}"
        );
        let one = errors("[sweep]\n\ntilt_from_deg = 25\n");
        assert!(
            one[0].starts_with("t.toml:3: sweep.tilt_from_deg"),
            "{one:?}"
        );
        let port = errors("[laser]\nport = \"/dev/patrold-ptu\"\n");
        assert!(
            port[0].starts_with("t.toml:2: laser.port and ptu.port"),
            "{port:?}"
        );
    }

    #[test]
    fn a_threshold_in_the_wrong_unit_is_reported() {
        let fm = errors("[novelty]\nground = \"fm\"\nu_th_m = 0.001\n");
        assert_eq!(
            fm,
            [
                "t.toml:3: novelty.u_th_m has no effect while novelty.ground is fm; set novelty.u_th_fm"
            ]
        );
        let place = errors("[waypoint.hall]\nu_th_fm = 0.001\n");
        assert_eq!(
            place,
            [
                "t.toml:2: waypoint.hall.u_th_fm has no effect while novelty.ground is w2; set waypoint.hall.u_th_m"
            ]
        );
        assert_eq!(
            errors("[novelty]\nground = \"fm\"\nu_th_m = 0.001\nu_th_fm = 0.01\n"),
            [""; 0]
        );
    }
}
