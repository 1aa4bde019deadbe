//! The commands that need devices or the service: on emulated ports, and where nothing answers.

use crate::harness::program::{command, patrold};
use crate::harness::schema;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};

/// A running `patrold emulate`, killed when dropped.
pub(crate) struct EmulatorProcess(Child);

impl Drop for EmulatorProcess {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub(crate) fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let config = "laser.port = \"laser\"\nptu.port = \"ptu\"\napi.socket = \"p.sock\"\nstore.dir = \"store\"\n";
    fs::write(dir.path().join("c.toml"), config).expect("written");
    dir
}

/// Emulates the devices in the office, on the ports of the configuration of `folder`.
pub(crate) fn start_emulator(dir: &Path, options: &[&str]) -> EmulatorProcess {
    start_emulator_at(dir, &["--laser", "laser", "--ptu", "ptu"], options).0
}

/// Emulates the devices in the office on `ports`; with its first line, which names them.
pub(crate) fn start_emulator_at(
    dir: &Path,
    ports: &[&str],
    options: &[&str],
) -> (EmulatorProcess, serde_json::Value) {
    let scene = patrold_test_support::workspace_root().join("config/scenes/office.toml");
    let scene = scene.to_string_lossy();
    let args = ["emulate", "--scene", &scene];
    let mut child = command(dir, &[&args[..], ports, options].concat())
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let out = child.stdout.take().expect("piped");
    let emulator = EmulatorProcess(child);
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line).expect("a line");
    let ready = serde_json::from_str(&line).expect("JSON");
    schema::check("emulate-ready", &ready);
    (emulator, ready)
}

/// Whether a parameter is observable. If so, it is right; if not, it has no value.
fn assert_right_if_observable(calibration: &serde_json::Value, name: &str, truth: f64) -> bool {
    let all = calibration["parameters"].as_array().into_iter().flatten();
    let found = all.clone().find(|p| p["name"] == name);
    let found = found.unwrap_or_else(|| panic!("no {name} in {calibration}"));
    let value = found["value"].as_f64();
    assert_eq!(found["observable"], value.is_some(), "{name}: {found}");
    if let Some(value) = value {
        let sigma = found["sigma"].as_f64().expect("a sigma");
        assert!((value - truth).abs() < 4.0 * sigma, "{name}: {found}");
    }
    value.is_some()
}

/// How many beams each surface gets depends on the load of the machine, and with it what is observable; that all offsets
/// are found is tested on virtual time, in `devices::lockstep::calibration`.
#[test]
fn what_a_calibration_finds_is_right_and_its_kept_sweeps_give_the_same() {
    let dir = folder();
    let hidden = [
        "--time-scale",
        "3",
        "--mount-rpy-deg",
        "0.4,-0.6,0.8",
        "--laser-option",
        "stamp-offset=4",
        "--ptu-option",
        "backlash=3/3",
    ];
    let _emulator = start_emulator(dir.path(), &hidden);
    let asked = ["--one-pan", "--time-scale", "3", "--keep", "kept"];
    let asked = [&["calibrate", "--config", "c.toml", "--json"], &asked[..]].concat();
    let ran = patrold(dir.path(), &asked);
    assert_eq!(ran.code, 0, "{ran:?}");
    let found = ran.json();
    schema::check("calibrate", &found);
    // One count of the head is 0.0514 deg; late stamps need a negative offset.
    let hidden = [
        ("roll", 0.4),
        ("yaw", 0.8),
        ("backlash", 3.0 * 0.0514),
        ("time_offset", -4.0),
    ];
    let observable: usize = hidden
        .iter()
        .map(|&(name, truth)| usize::from(assert_right_if_observable(&found, name, truth)))
        .sum();
    assert!(observable > 0, "{found}");
    // At one pan the pitch is not observable.
    let pitch = assert_right_if_observable(&found, "pitch", -0.6);
    assert!(!pitch, "{found}");

    let kept = found["sweeps"].as_u64().expect("a number");
    let kept: Vec<String> = (1..=kept).map(|k| format!("kept/sweep-{k}.raw")).collect();
    let mut again = vec!["calibrate", "--json"];
    again.extend(kept.iter().map(String::as_str));
    assert_eq!(patrold(dir.path(), &again).json(), found);

    // With a level floor the same sweeps determine the pitch.
    again.extend(["--level-floor", "0.05"]);
    let ran = patrold(dir.path(), &again);
    assert_eq!(ran.code, 0, "{ran:?}");
    let levelled = ran.json();
    schema::check("calibrate", &levelled);
    assert_right_if_observable(&levelled, "pitch", -0.6);
    again.truncate(again.len() - 1);
    again.push("0");
    assert_eq!(
        patrold(dir.path(), &again).code,
        2,
        "a level floor needs a standard deviation above 0"
    );
}

#[test]
fn emulated_devices_report_their_identity() {
    let dir = folder();
    let _emulator = start_emulator(dir.path(), &[]);
    let ran = patrold(dir.path(), &["devices", "--config", "c.toml", "--json"]);
    let json = ran.json();
    schema::check("devices", &json);
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(
        json["laser"]["product"]
            .as_str()
            .is_some_and(|p| p.contains("URG")),
        "{json}"
    );
    assert_eq!(json["ptu"]["port"], "ptu");
    // Pseudo-terminals are not listed as serial ports.
    let ports = json["ports"].as_array().expect("a list");
    assert!(ports.iter().all(|p| p["path"] != "ptu"), "{json}");
}

#[test]
fn a_device_with_another_serial_or_version_is_refused_by_name() {
    let dir = folder();
    let _emulator = start_emulator(dir.path(), &["--laser-option", "serial=00900001"]);
    let config = fs::read_to_string(dir.path().join("c.toml")).expect("there");
    for (wanted, refused) in [
        (
            "laser.serial = \"H0900001\"\nptu.version = \"v2.12\"\n",
            None,
        ),
        ("laser.serial = \"H0706400\"\n", Some(("laser", "H0706400"))),
        ("ptu.version = \"v9.99\"\n", Some(("ptu", "v9.99"))),
    ] {
        fs::write(dir.path().join("c.toml"), format!("{config}{wanted}")).expect("written");
        let ran = patrold(dir.path(), &["devices", "--config", "c.toml", "--json"]);
        let json = ran.json();
        schema::check("devices", &json);
        assert_eq!(ran.code, i32::from(refused.is_some()), "{ran:?}");
        for device in ["laser", "ptu"] {
            let error = json[device]["error"].as_str();
            let Some((_, unit)) = refused.filter(|(who, _)| *who == device) else {
                assert_eq!(error, None, "{wanted}: {json}");
                continue;
            };
            let error = error.unwrap_or_default();
            let key = wanted.split(' ').next().unwrap_or_default();
            assert!(error.contains(unit) && error.contains(key), "{error}");
        }
    }
}

#[test]
fn a_missing_usb_port_is_an_error_with_the_ports_present() {
    let dir = folder();
    let config = "laser.port = \"usb:15d1:ffff:NONE\"\nptu.port = \"usb:0403:6001:NONE\"\n";
    fs::write(dir.path().join("c.toml"), config).expect("written");
    let ran = patrold(dir.path(), &["devices", "--config", "c.toml", "--json"]);
    let json = ran.json();
    schema::check("devices", &json);
    assert_eq!(ran.code, 1);
    for (device, name) in [
        ("laser", "usb:15d1:ffff:NONE"),
        ("ptu", "usb:0403:6001:NONE"),
    ] {
        let error = json[device]["error"].as_str().unwrap_or_default();
        assert!(error.contains(name) && error.contains("on USB"), "{error}");
    }
}

#[test]
fn every_port_without_a_device_has_its_error() {
    let dir = folder();
    let ran = patrold(dir.path(), &["devices", "--config", "c.toml", "--json"]);
    let json = ran.json();
    schema::check("devices", &json);
    assert_eq!(ran.code, 1);
    for device in ["laser", "ptu"] {
        assert!(
            json[device]["error"]
                .as_str()
                .is_some_and(|e| e.contains(device)),
            "{json}"
        );
    }
}

#[test]
fn without_service_and_devices_the_error_is_one_line() {
    let dir = folder();
    for (args, names) in [
        (
            &["visit", "hall"][..],
            &["p.sock", "systemctl start patrold"][..],
        ),
        (&["teach", "hall"], &["p.sock", "systemctl start patrold"]),
        // Both are absent: the error names the port that was opened first.
        (
            &["sweep", "--out", "s.ply"],
            &[".port, set by c.toml:", "): no device at"],
        ),
        (&["emulate", "--scene", "no.toml"], &["no.toml"]),
    ] {
        let config: &[&str] = if args[0] == "emulate" {
            &[]
        } else {
            &["--config", "c.toml"]
        };
        let ran = patrold(dir.path(), &[args, config].concat());
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{args:?}: {ran:?}");
        assert!(
            ran.err.starts_with("patrold: ") && ran.err.lines().count() == 1,
            "{args:?}: {ran:?}"
        );
        assert!(
            names.iter().all(|name| ran.err.contains(name)),
            "{args:?}: {ran:?}"
        );
    }
    assert!(!dir.path().join("s.ply").exists());
}

#[test]
fn a_service_without_a_usable_store_fails_with_the_path() {
    let dir = folder();
    fs::write(dir.path().join("store"), "a file").expect("written");
    let ran = patrold(dir.path(), &["run", "--config", "c.toml"]);
    assert_eq!(ran.code, 1, "{ran:?}");
    let last = ran.err.lines().last().unwrap_or_default();
    assert!(
        last.starts_with("patrold: ") && last.contains("store"),
        "{ran:?}"
    );
}
