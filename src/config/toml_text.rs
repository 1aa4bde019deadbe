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
