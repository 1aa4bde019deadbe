//! Settings that cannot both be meant, told at the line that a person wrote.

use super::check::{Mistake, Problem};
use super::engine::ground_word;
use super::layers::{Layers, Origin};
use super::settings::Settings;
use patrold_engine::distance::Ground;

/// Least tilt range of a sweep, radians: one degree.
const LEAST_TILT_RANGE_RAD: f64 = std::f64::consts::PI / 180.0;

/// Every contradiction between settings.
pub(super) fn contradictions(settings: &Settings, layers: &Layers) -> Vec<Mistake> {
    let mut found = Vec::new();
    let mut tell = |keys: &[&str], what: String| {
        let (file, line) = layers.place(keys);
        found.push(Mistake {
            file,
            line,
            problem: Problem::Contradiction(what),
        });
    };
    let sweep = &settings.sweep;
    if (sweep.tilt_from_rad - sweep.tilt_to_rad).abs() < LEAST_TILT_RANGE_RAD {
        tell(
            &["sweep.tilt_to_deg", "sweep.tilt_from_deg"],
            "sweep.tilt_from_deg and sweep.tilt_to_deg must be at least 1 deg apart".to_owned(),
        );
    }
    if settings.laser.port == settings.ptu.port {
        tell(
            &["ptu.port", "laser.port"],
            format!("laser.port and ptu.port are both {}", settings.laser.port),
        );
    }
    if settings.ptu.port.starts_with("tcp:") {
        tell(
            &["ptu.port"],
            "ptu.port must be a serial device, not tcp".to_owned(),
        );
    }
    for (idle, heeded) in idle_thresholds(settings, layers) {
        let what = format!(
            "{idle} has no effect while novelty.ground is {}; set {heeded}",
            ground_word(settings.novelty.ground)
        );
        tell(&[&idle], what);
    }
    found
}

/// Thresholds that a file sets for the unit that is not in force, and the keys that are heeded instead and not set.
fn idle_thresholds(settings: &Settings, layers: &Layers) -> Vec<(String, String)> {
    let (idle, heeded) = match settings.novelty.ground {
        Ground::Fm => ("u_th_m", "u_th_fm"),
        Ground::W2 | Ground::Euclid => ("u_th_fm", "u_th_m"),
    };
    let is_set = |key: &str| {
        let value = layers.values.get(key);
        value.is_some_and(|(_, origin)| *origin != Origin::Default)
    };
    layers
        .values
        .iter()
        .filter(|(_, (_, origin))| matches!(origin, Origin::File(..)))
        .filter_map(|(key, _)| {
            let section = key.strip_suffix(idle)?.strip_suffix('.')?;
            Some((key.clone(), format!("{section}.{heeded}")))
        })
        .filter(|(_, heeded)| !is_set(heeded))
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::config::{Layers, Settings, Source};
    use std::path::PathBuf;

    fn told(text: &str) -> Vec<String> {
        let mut layers = Layers::defaults();
        let path = PathBuf::from("t.toml");
        let text = text.to_owned();
        assert_eq!(layers.add(&Source { path, text }), []);
        let mistakes = Settings::build(&layers).err().unwrap_or_default();
        mistakes.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn the_line_is_that_of_a_key_which_the_file_sets() {
        let both = told("[sweep]\ntilt_from_deg = 10\ntilt_to_deg = 10\n");
        assert!(
            both[0].starts_with("t.toml:3: sweep.tilt_from_deg"),
            "{both:?}"
        );
        let one = told("[sweep]\n\ntilt_from_deg = 25\n");
        assert!(
            one[0].starts_with("t.toml:3: sweep.tilt_from_deg"),
            "{one:?}"
        );
        let port = told("[laser]\nport = \"/dev/patrold-ptu\"\n");
        assert!(
            port[0].starts_with("t.toml:2: laser.port and ptu.port"),
            "{port:?}"
        );
    }

    #[test]
    fn a_threshold_in_the_wrong_unit_is_told() {
        let fm = told("[novelty]\nground = \"fm\"\nu_th_m = 0.001\n");
        assert_eq!(
            fm,
            [
                "t.toml:3: novelty.u_th_m has no effect while novelty.ground is fm; set novelty.u_th_fm"
            ]
        );
        let place = told("[waypoint.hall]\nu_th_fm = 0.001\n");
        assert_eq!(
            place,
            [
                "t.toml:2: waypoint.hall.u_th_fm has no effect while novelty.ground is w2; set waypoint.hall.u_th_m"
            ]
        );
        assert_eq!(
            told("[novelty]\nground = \"fm\"\nu_th_m = 0.001\nu_th_fm = 0.01\n"),
            [""; 0]
        );
    }
}
