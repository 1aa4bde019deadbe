//! The whole house: the service on the emulated devices, over pseudo-terminals, five times as fast as life.

use super::house::{Act, House, Scripted, configure, plan};
use link::Clock;
use patrold::service::{Plan, StationConnect};
use patrold_sim::emulator::{Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{Scene, World};
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

#[test]
fn a_round_with_the_emulated_devices() {
    let clock = Clock::scaled(5.0);
    let stand = scene("storeroom.toml").map_from_base;
    let emulation = Emulation::new(
        EmulationOptions::seeded(3),
        world("storeroom.toml"),
        stand,
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
    let nobody = Scripted::new(Act::Freeze);
    let plan = Plan {
        clock: clock.clone(),
        connect: Box::new(StationConnect::new(clock)),
        ..plan(dir.path(), &nobody)
    };
    let house = House::start_with(dir.path(), &nobody, plan);

    let taught = house.at("/teach", "hall");
    assert_eq!(taught.status, 200, "{}", taught.json());
    assert!(!emulator.laser_on());
    // The way back began when the sweep was over, and does not hold up the answer.
    house.until("the head is back", |h| {
        h.status()["devices"]["return_ms"].is_number()
    });
    let back_ms = house.status()["devices"]["return_ms"].as_f64();
    assert!(back_ms.is_some_and(|ms| ms > 1000.0), "{back_ms:?}");
    assert!(!emulator.head_moving());
    let identity = house.status()["devices"]["identity"].clone();
    assert_eq!(identity["laser"]["serial"], "H0706400", "{identity}");

    let quiet = house.at("/visit", "hall").json();
    eprintln!(
        "quiet: {} {}, lag {:?}",
        quiet["verdict"],
        quiet["sweep"],
        emulator.take_lag()
    );
    assert_ne!(quiet["verdict"], "changed", "{quiet}");

    emulator.set_world(world("storeroom-box-left.toml"));
    let changed = house.at("/visit", "hall").json();
    eprintln!(
        "changed: {} d {} {}",
        changed["verdict"], changed["d_gmm"], changed["sweep"]
    );
    assert_ne!(changed["verdict"], "quiet", "{changed}");

    emulator.inject("laser.silence:for=60".parse().expect("a fault"));
    let silent = house.at("/visit", "hall").json();
    eprintln!("silent: {}", silent["reason"]);
    assert_eq!(silent["verdict"], "not_observed", "{silent}");

    // A stop while the devices are at work again.
    house.until("they are tried again", |h| {
        h.status()["devices"]["state"] == "ready"
    });
    let socket = house.socket();
    let asker = std::thread::spawn(move || super::ask(&socket, "{\"waypoint\": \"hall\"}"));
    while !emulator.laser_on() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let took = house.stop();
    assert!(took < Duration::from_secs(3), "{took:?}");
    assert!(!emulator.laser_on() && !emulator.head_moving());
    let told = asker.join().expect("no panic");
    assert!(told.contains("not_observed"), "{told}");
}
