//! Values as lines of TOML: for files that the program writes itself.

use super::key_lookup::split_waypoint_key;
use super::settings::Settings;
use super::value::ConfigValue;
use patrold_engine::distance::GroundDistance;

/// A file for the folder of the configuration that sets the threshold of a waypoint, in the unit of the ground distance in force.
pub fn threshold_drop_in(settings: &Settings, waypoint: &str, u_th: f64) -> String {
    let key = match settings.novelty.ground {
        GroundDistance::Fm => "u_th_fm",
        GroundDistance::W2 | GroundDistance::Euclid => "u_th_m",
    };
    let line = toml_line(
        &format!("waypoint.{waypoint}.{key}"),
        &ConfigValue::Float(u_th),
    );
    format!("# Written by patrold tune --apply.\n{line}")
}

/// The text of a configuration file that names both devices.
pub fn devices_drop_in(settings: &Settings, laser_serial: &str) -> String {
    let lines = [
        ("laser.port", settings.laser.port.as_str()),
        ("laser.serial", laser_serial),
        ("ptu.port", settings.ptu.port.as_str()),
    ];
    let line = |(name, value): (&str, &str)| toml_line(name, &ConfigValue::Text(value.to_owned()));
    let lines: String = lines.into_iter().map(line).collect();
    format!("# Written by patrold setup.\n{lines}")
}

/// `KEY = VALUE`, with its line break.
pub(super) fn toml_line(name: &str, value: &ConfigValue) -> String {
    // The name of a waypoint may have dots.
    let name = match split_waypoint_key(name) {
        Some((waypoint, key)) => format!("waypoint.{}.{key}", quoted(waypoint)),
        None => name.to_owned(),
    };
    match value {
        ConfigValue::Text(text) => format!("{name} = {}\n", quoted(text)),
        other => format!("{name} = {other}\n"),
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::{devices_drop_in, threshold_drop_in};
    use crate::config::{ConfigFile, ConfigLayers, Settings};
    use patrold_engine::distance::GroundDistance;
    use std::path::PathBuf;

    fn read(texts: &[&str]) -> Settings {
        let mut layers = ConfigLayers::defaults();
        for text in texts {
            let path = PathBuf::from("t.toml");
            let text = (*text).to_owned();
            assert_eq!(layers.add(&ConfigFile { path, text }), []);
        }
        Settings::from_layers(&layers).expect("valid")
    }

    #[test]
    fn a_threshold_that_is_written_is_read_back_for_its_waypoint_alone() {
        let fm = "novelty.ground = \"fm\"\n";
        for (ground, main) in [(GroundDistance::Fm, fm), (GroundDistance::W2, "")] {
            let mut settings = Settings::defaults();
            settings.novelty.ground = ground;
            for waypoint in ["hall", "dock.2"] {
                let text = threshold_drop_in(&settings, waypoint, 0.0125);
                let got = read(&[main, &text]);
                assert_eq!(got.u_th(Some(waypoint)), 0.0125, "{text}");
                assert_ne!(got.u_th(Some("dock")), 0.0125);
            }
        }
    }

    #[test]
    fn the_devices_that_are_written_are_read_back() {
        let mut settings = Settings::defaults();
        settings.laser.port = "usb:15d1:0000".to_owned();
        settings.ptu.port = "/dev/serial/by-id/a\\b".to_owned();
        let got = read(&[&devices_drop_in(&settings, "H0706400")]);
        assert_eq!(got.laser.port, settings.laser.port);
        assert_eq!(got.ptu.port, settings.ptu.port);
        assert_eq!(got.laser.serial.as_deref(), Some("H0706400"));
        let got = read(&[&devices_drop_in(&settings, "any")]);
        assert_eq!(got.laser.serial, None);
    }
}
