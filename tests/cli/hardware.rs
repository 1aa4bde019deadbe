//! The commands that talk to devices and to the service: on emulated ports, and where nobody answers.

use crate::harness::program::{command, patrold};
use crate::harness::schema;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};

/// An emulator that ends with the test.
struct Emulator(Child);

impl Drop for Emulator {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let config = "laser.port = \"laser\"\nptu.port = \"ptu\"\napi.socket = \"p.sock\"\nstore.dir = \"store\"\n";
    fs::write(dir.path().join("c.toml"), config).expect("written");
    dir
}

#[test]
fn emulated_devices_say_who_they_are() {
    let dir = folder();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenes/office.toml");
    let scene = scene.to_string_lossy();
    let args = [
        "emulate", "--scene", &scene, "--laser", "laser", "--ptu", "ptu",
    ];
    let mut child = command(dir.path(), &args)
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let out = child.stdout.take().expect("piped");
    let _emulator = Emulator(child);
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line).expect("a line");
    let ready = serde_json::from_str(&line).expect("JSON");
    schema::check("emulate-ready", &ready);

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
}

#[test]
fn ports_without_devices_are_told_each() {
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
fn without_a_service_and_without_devices_one_line_says_so() {
    let dir = folder();
    for (args, names) in [
        (
            &["visit", "hall"][..],
            &["p.sock", "systemctl start patrold"][..],
        ),
        (&["teach", "hall"], &["p.sock", "systemctl start patrold"]),
        (&["sweep", "--out", "s.ply"], &["laser"]),
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
fn a_service_whose_store_cannot_be_says_so() {
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
