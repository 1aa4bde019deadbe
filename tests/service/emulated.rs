//! The service on the emulated devices, over pseudo-terminals, at five times real speed.

use super::harness::{ScriptedScanner, ScriptedSweep, TestService, configure, parts};
use super::{process, schema};
use link::Clock;
use patrold::service::{ServiceParts, StationConnector};
use patrold_sim::emulator::{Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{Scene, World};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn scene(name: &str) -> Scene {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    Scene::resolve(name, &load).expect("a shipped scene")
}

fn world(name: &str) -> Arc<World> {
    Arc::new(scene(name).build(None).expect("builds"))
}

/// The bytes of the devices on disk give each visit's verdict again, to the last bit.
fn check_rejudged(dir: &Path, replies: &[&Value]) {
    for reply in replies {
        let id = reply["visit_id"].to_string();
        let output = process::patrold(dir, &["rejudge", &id, "--json"]).output();
        let output = output.expect("the program starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let again: Value = serde_json::from_str(&text)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
        schema::check("rejudge", &again);
        assert_eq!(
            again["source"]["from"], "device_bytes",
            "{}",
            again["source"]
        );
        let judged = &again["judged"];
        assert_eq!(judged["verdict"], reply["verdict"]);
        // As text, every digit.
        let [now, then] = [&judged["d_gmm"], &reply["d_gmm"]].map(Value::to_string);
        assert_eq!(now, then, "visit {id}");
        let novelties = judged["novelties"].as_array().expect("a list");
        let seen = reply["novelties"].as_array().expect("a list");
        let centres = |list: &[Value]| -> Vec<String> {
            list.iter().map(|n| n["centre"].to_string()).collect()
        };
        assert_eq!(centres(novelties), centres(seen), "visit {id}");
    }
    let output = process::patrold(dir, &["rejudge", "--since", "1h", "--json"]).output();
    let text = String::from_utf8(output.expect("the program starts").stdout).expect("text");
    let summary: Value =
        serde_json::from_str(text.lines().last().expect("a summary")).expect("JSON");
    schema::check("rejudge-summary", &summary);
    assert_eq!(summary["failed"], 0, "{summary}");
    assert_eq!(summary["judged"], summary["from_device_bytes"], "{summary}");
    assert!(summary["judged"].as_u64() >= Some(3), "{summary}");
}

#[test]
fn a_round_with_the_emulated_devices() {
    let clock = Clock::paced(5.0);
    let map_from_base = scene("storeroom.toml").map_from_base;
    let emulation = Emulation::new(
        EmulationOptions::seeded(3),
        world("storeroom.toml"),
        map_from_base,
        clock.now(),
    );
    let emulator = Emulator::start(emulation, &EmulatorPorts::default(), clock.clone())
        .expect("pseudo-terminals");

    let dir = tempfile::tempdir().expect("temp dir");
    let (laser, head) = (emulator.laser_port(), emulator.head_port());
    configure(
        dir.path(),
        &format!("laser.port = {laser:?}\nptu.port = {head:?}\n"),
    );
    let unused = ScriptedScanner::new(ScriptedSweep::Frozen);
    let parts = ServiceParts {
        clock: clock.clone(),
        connector: Box::new(StationConnector::new(clock)),
        ..parts(dir.path(), &unused)
    };
    let service = TestService::start_with(dir.path(), &unused, parts);

    let taught = service.post("/teach", "hall");
    assert_eq!(taught.status, 200, "{}", taught.json());
    assert!(!emulator.laser_on());
    // The head returns after the sweep; the reply does not wait for it.
    service.until("the head has returned", |s| {
        s.status()["devices"]["return_ms"].is_number()
    });
    let return_ms = service.status()["devices"]["return_ms"].as_f64();
    assert!(return_ms.is_some_and(|ms| ms > 1000.0), "{return_ms:?}");
    assert!(!emulator.head_moving());
    let identity = service.status()["devices"]["identity"].clone();
    assert_eq!(identity["laser"]["serial"], "H0706400", "{identity}");

    let quiet = service.post("/visit", "hall").json();
    eprintln!(
        "quiet: {} {}, lag {:?}",
        quiet["verdict"],
        quiet["sweep"],
        emulator.take_lag()
    );
    assert_ne!(quiet["verdict"], "changed", "{quiet}");

    emulator.set_world(world("storeroom-box-left.toml"));
    let changed = service.post("/visit", "hall").json();
    eprintln!(
        "changed: {} d {} {}",
        changed["verdict"], changed["d_gmm"], changed["sweep"]
    );
    assert_ne!(changed["verdict"], "quiet", "{changed}");

    emulator.inject("laser.silence:for=60".parse().expect("a fault"));
    let silent = service.post("/visit", "hall").json();
    eprintln!("silent: {}", silent["reason"]);
    assert_eq!(silent["verdict"], "not_observed", "{silent}");

    // A stop during a sweep.
    service.until("the devices are ready again", |s| {
        s.status()["devices"]["state"] == "ready"
    });
    let socket = service.socket();
    let client = std::thread::spawn(move || super::post_visit(&socket, "{\"waypoint\": \"hall\"}"));
    while !emulator.laser_on() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = service.stop();
    assert!(took < Duration::from_secs(3), "{took:?}");
    assert!(!emulator.laser_on() && !emulator.head_moving());
    let reply = client.join().expect("no panic");
    assert!(reply.contains("not_observed"), "{reply}");
    check_rejudged(dir.path(), &[&quiet, &changed, &silent]);
}
