//! The table of all configuration keys: name, accepted values, default, unit, description.

use super::value::{ConfigValue, ValueKind};
use ValueKind::{Flag, Float, Floats, Integer, OneOf, Port, Sign, Text};

/// One key of the configuration.
#[derive(Debug, Clone, Copy)]
pub struct ConfigKey {
    /// Dotted name, `section.key`.
    pub name: &'static str,
    /// Values it accepts.
    pub kind: ValueKind,
    /// Default, as TOML.
    pub default: &'static str,
    /// Unit; empty: none.
    pub unit: &'static str,
    /// What it does and when to change it.
    pub description: &'static str,
}

impl ConfigKey {
    /// The default as a value.
    pub fn default_value(&self) -> Option<ConfigValue> {
        let parsed = toml::de::DeValue::parse(self.default).ok()?;
        self.kind.parse(parsed.get_ref()).ok()
    }
}

pub(super) const fn key(
    name: &'static str,
    kind: ValueKind,
    default: &'static str,
    unit: &'static str,
    description: &'static str,
) -> ConfigKey {
    ConfigKey {
        name,
        kind,
        default,
        unit,
        description,
    }
}

pub(super) const MAX_M: f64 = 1000.0;
pub(super) const FULL_TURN_DEG: f64 = 360.0;

/// All keys of all sections but `[waypoint.NAME]`, in the order of the shipped file.
pub const KEYS: &[ConfigKey] = &[
    key(
        "robot.name",
        Text,
        "\"robot\"",
        "",
        "Name of the robot in its alarms; give each robot of a site its own.",
    ),
    key(
        "laser.port",
        Port,
        "\"/dev/patrold-laser\"",
        "",
        "Port of the laser. The shipped udev rules create the default name; usb: takes vendor, product and serial number as patrold devices lists them; tcp: is for an Ethernet sensor or a serial server.",
    ),
    key(
        "laser.serial",
        Text,
        "\"any\"",
        "",
        "Serial number that the laser must have (patrold devices shows it), or any. Set it where lasers could be exchanged; with several lasers on one usb:15d1 name it selects the right one.",
    ),
    key(
        "laser.baud",
        Integer(9600, 750_000),
        "115200",
        "bit/s",
        "Line rate on RS-232: a laser found at a slower one is raised to it. No effect over USB.",
    ),
    key(
        "ptu.port",
        Port,
        "\"/dev/patrold-ptu\"",
        "",
        "Port of the PTU-D46, named like the laser's; tcp: is for a serial server, which has its own line rate.",
    ),
    key(
        "ptu.version",
        Text,
        "\"any\"",
        "",
        "Text that the firmware's version must contain (patrold devices shows it), or any.",
    ),
    key(
        "ptu.baud",
        Integer(600, 115_200),
        "9600",
        "bit/s",
        "Line rate of the pan-tilt head; 9600 after power-up.",
    ),
    key(
        "ptu.pan_sign",
        Sign,
        "1",
        "",
        "1 where positive pan counts turn left (seen from above), -1 where they turn right; check it once when commissioning.",
    ),
    key(
        "ptu.tilt_sign",
        Sign,
        "1",
        "",
        "1 where positive tilt counts turn up, -1 where they turn down; check it once when commissioning.",
    ),
    key(
        "ptu.pan_zero_deg",
        Float(-FULL_TURN_DEG, FULL_TURN_DEG),
        "0.0",
        "deg",
        "Pan of the head at count 0, from calibration.",
    ),
    key(
        "ptu.tilt_zero_deg",
        Float(-90.0, 90.0),
        "0.0",
        "deg",
        "Tilt of the head at count 0, from calibration.",
    ),
    key(
        "ptu.tilt_backlash_deg",
        Float(-5.0, 5.0),
        "0.0",
        "deg",
        "Tilt difference between moving up and moving down to the same count; patrold calibrate finds it.",
    ),
    key(
        "ptu.home_at_start",
        Flag,
        "true",
        "",
        "Home the head (drive to its stops) when the service connects. The head has no encoders: switch this off only on a bench.",
    ),
    key(
        "ptu.suspect_pan_deg",
        Float(0.1, 180.0),
        "3.0",
        "deg",
        "Pan rotation of a view against the reference from which the head may have lost steps, as long as the robot's own errors are not known; afterwards it is three of their standard deviations. The head is then homed at the next idle moment.",
    ),
    key(
        "ptu.suspect_tilt_deg",
        Float(0.1, 90.0),
        "0.4",
        "deg",
        "The same for tilt; a sweep of several pans is taken again at once. Raise it where an uneven floor tilts the robot now and then.",
    ),
    key(
        "mount.pan_axis_xyz_m",
        Floats(3, 3, -MAX_M, MAX_M),
        "[0.0, -0.00955, 0.046774]",
        "m",
        "Pan axis in the base frame.",
    ),
    key(
        "mount.tilt_axis_xyz_m",
        Floats(3, 3, -MAX_M, MAX_M),
        "[0.0, 0.0, 0.043713]",
        "m",
        "Tilt axis in the pan frame.",
    ),
    key(
        "mount.plate_xyz_m",
        Floats(3, 3, -MAX_M, MAX_M),
        "[0.0, 0.0, 0.039116]",
        "m",
        "Mounting plate in the tilt frame.",
    ),
    key(
        "mount.xyz_m",
        Floats(3, 3, -10.0, 10.0),
        "[0.0, 0.0, 0.05]",
        "m",
        "Optical centre of the laser on the mounting plate: adapter plus height of the scan plane; measure yours.",
    ),
    key(
        "mount.rpy_deg",
        Floats(3, 3, -FULL_TURN_DEG, FULL_TURN_DEG),
        "[0.0, 0.0, 0.0]",
        "deg",
        "Roll, pitch, yaw of the laser on the plate. For a laser mounted upside down roll is 180: with 0 its clouds are mirrored, and what stands to the robot's left is on their right.",
    ),
    key(
        "sweep.mode",
        OneOf(&["continuous", "step"]),
        "\"continuous\"",
        "",
        "continuous: the head tilts while the laser scans; step: it stops for each line (slow, to verify the former).",
    ),
    key(
        "sweep.tilt_from_deg",
        Float(-90.0, 90.0),
        "-35.0",
        "deg",
        "First tilt of a sweep; negative looks down.",
    ),
    key(
        "sweep.tilt_to_deg",
        Float(-90.0, 90.0),
        "25.0",
        "deg",
        "Last tilt of a sweep.",
    ),
    key(
        "sweep.speed_deg_s",
        Float(0.1, 100.0),
        "5.0",
        "deg/s",
        "Tilt speed; at 10 scans a second 5 deg/s gives lines 0.5 deg apart.",
    ),
    key(
        "sweep.step_deg",
        Float(0.02, 30.0),
        "1.0",
        "deg",
        "Distance between lines in step mode.",
    ),
    key(
        "sweep.time_offset_ms",
        Float(-100.0, 100.0),
        "0.0",
        "ms",
        "Added to the laser's timestamps before the tilt at them is interpolated; patrold calibrate finds it.",
    ),
    key(
        "sweep.pans_deg",
        Floats(1, 16, -FULL_TURN_DEG, FULL_TURN_DEG),
        "[0.0]",
        "deg",
        "One sweep at each of these pans, merged into one cloud; with several pans the laser must stay within 15 cm of one place.",
    ),
    key(
        "sweep.max_missing_lines",
        Float(0.0, 1.0),
        "0.05",
        "share",
        "Refuse a sweep with more missing lines than this.",
    ),
    key(
        "mixture.seed",
        Integer(0, i64::MAX),
        "7",
        "",
        "Seed of the engine's random numbers; same seed, same result.",
    ),
    key(
        "novelty.engine",
        OneOf(&["standard", "paper", "paper-independent"]),
        "\"standard\"",
        "",
        "standard: patrold's own; paper: the paper's chain without rays; paper-independent: the recipe to the letter (docs/novelty.md section 10).",
    ),
    key(
        "novelty.u_th_m",
        Float(1e-9, MAX_M),
        "0.0005",
        "m",
        "U_th of paper Eq. 7: an alarm is raised when d_GMM reaches it. Lower finds smaller changes, higher gives fewer false alarms (docs/novelty.md section 8). The default is that of standard; the other engines have their own. Override it per waypoint in [waypoint.NAME].",
    ),
    key(
        "novelty.ground",
        OneOf(&["w2", "euclid", "fm"]),
        "\"w2\"",
        "",
        "Ground distance between Gaussians: w2 (Wasserstein-2), euclid (distance of the means), or fm (Foerstner-Moonen).",
    ),
    key(
        "novelty.u_th_fm",
        Float(1e-9, MAX_M),
        "0.002",
        "",
        "U_th when novelty.ground is fm, whose d_GMM has no unit.",
    ),
    key(
        "novelty.max_range_m",
        Float(0.0, MAX_M),
        "0.0",
        "m",
        "Ignore points farther than this from the sensor; 0 keeps all.",
    ),
    key(
        "novelty.min_coverage",
        Float(0.0, 1.0),
        "0.7",
        "",
        "Share of the solid angle in which the reference saw something that a visit must be able to judge to be quiet; with less it is not_observed. What is proved is changed however little was seen.",
    ),
    key(
        "shape.method",
        OneOf(&["auto", "covariance", "ransac"]),
        "\"auto\"",
        "",
        "How shapes are retrieved: covariance matching, RANSAC, or auto (the better of the two).",
    ),
    key(
        "store.dir",
        Text,
        "\"/var/lib/patrold\"",
        "",
        "Folder of the database, references and sweeps; a relative path starts at the folder of this file.",
    ),
    key(
        "store.keep_days",
        Float(0.0, 36_500.0),
        "30.0",
        "days",
        "Delete sweeps older than this, unless they are evidence of an alarm or a reference of a known waypoint; 0 keeps all.",
    ),
    key(
        "store.keep_gib",
        Float(0.0, 1e6),
        "20.0",
        "GiB",
        "Delete the oldest sweeps above this size; the same exceptions stay and are not counted; 0 sets no limit.",
    ),
    key(
        "store.keep_unnamed_days",
        Float(0.0, 36500.0),
        "0.0",
        "days",
        "Delete evidence files that no row of the database names (`patrold store check` lists them) when they are older than this; 0 keeps all. They may be all that is left of a lost database.",
    ),
    key(
        "alarms.same_place_m",
        Float(0.0, 100.0),
        "0.5",
        "m",
        "A thing of an alarm that is seen further than this from where it was has moved; less, if its place is known better.",
    ),
    key(
        "alarms.unseen_after",
        Float(0.0, 8760.0),
        "0.0",
        "h",
        "A waypoint that nobody visits for longer than this is a health incident; 0 expects no visits.",
    ),
    key(
        "api.socket",
        Text,
        "\"/run/patrold/patrold.sock\"",
        "",
        "Unix socket through which visit, teach and sweep reach the service; a relative path starts at the folder of this file.",
    ),
    key(
        "api.socket_mode",
        Integer(0, 0o777),
        "0o660",
        "",
        "File mode of the socket: who may command the robot.",
    ),
    key(
        "log.level",
        OneOf(&["error", "warn", "info", "debug", "trace"]),
        "\"info\"",
        "",
        "How much is logged.",
    ),
    key(
        "log.to",
        OneOf(&["auto", "journald", "stderr"]),
        "\"auto\"",
        "",
        "auto: journald if systemd started the service, else stderr.",
    ),
];

#[cfg(test)]
mod tests {
    use super::KEYS;
    use crate::config::waypoint_keys::WAYPOINT_KEYS;
    use std::collections::BTreeSet;

    #[test]
    fn every_default_is_accepted_by_its_own_key() {
        for key in KEYS.iter().chain(WAYPOINT_KEYS) {
            assert!(key.default_value().is_some(), "{}", key.name);
        }
    }

    #[test]
    fn no_key_is_defined_twice() {
        let names: BTreeSet<_> = KEYS.iter().map(|key| key.name).collect();
        assert_eq!(names.len(), KEYS.len());
    }
}
