//! Stations on threads and pseudo-terminals, in accelerated time.

use super::{Cancel, DeviceError, Station, SweepRequest, replay_sweep};
use crate::config::Settings;
use crate::devices::lockstep::rig::ROOM;
use link::Clock;
use patrold_engine::sweep::assemble;
use patrold_sim::emulator::{Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{NoiseOptions, Scene};
use scip::emulator::LaserLink;
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

fn options() -> EmulationOptions {
    EmulationOptions {
        noise: NoiseOptions::ideal(),
        ..EmulationOptions::seeded(11)
    }
}

fn emulator(clock: &Clock, ports: &EmulatorPorts<'_>) -> Emulator {
    emulator_with(options(), clock, ports)
}

fn emulator_with(options: EmulationOptions, clock: &Clock, ports: &EmulatorPorts<'_>) -> Emulator {
    let scene = Scene::parse(ROOM).expect("a scene");
    let world = Arc::new(scene.build(None).expect("no cloud in it"));
    let emulation = Emulation::new(options, world, scene.map_from_base, clock.now());
    Emulator::start(emulation, ports, clock.clone()).expect("terminals")
}

fn settings(emulator: &Emulator) -> Settings {
    let mut settings = Settings::defaults();
    settings.laser.port = emulator.laser_port().to_owned();
    settings.ptu.port = emulator.head_port().to_owned();
    settings
}

#[test]
fn a_station_homes_sweeps_is_cancelled_and_leaves_everything_at_rest() {
    // A request is given up after 1.5 s of the devices: so slow that this outlasts a stall of a loaded machine.
    let clock = Clock::paced(2.0);
    let emulator = emulator(&clock, &EmulatorPorts::default());
    let settings = settings(&emulator);
    let (notes, _heard) = mpsc::channel();
    let mut station =
        Station::open(&settings, clock.clone(), notes, &Cancel::new()).expect("both answer");
    let report = station.describe(&Cancel::new()).expect("both answer");
    assert_eq!(report.laser.serial, "H0706400");
    assert_eq!(report.ptu.supply_v, Some(24.0));
    let mut request = SweepRequest::new(&settings, None);
    request.pans_rad = vec![0.1];
    request.tilt_from_rad = -0.1;
    let refused = station.sweep(&request, &Cancel::new());
    assert!(matches!(refused, Err(DeviceError::PositionLost { .. })));
    station.home(&Cancel::new()).expect("homes");

    let raw = station.sweep(&request, &Cancel::new()).expect("a sweep");
    assert!(!emulator.laser_on() && !emulator.head_moving());
    let dialogue = station.take_dialogue().expect("recorded");
    eprintln!("{} bytes of dialogue", dialogue.len());
    let replayed = replay_sweep(&dialogue).expect("replayed").sweep;
    assert!(replayed.is_ok_and(|replayed| replayed == raw));
    let sweep = assemble(&raw).expect("assembles");
    eprintln!("{:?}, lag {:?}", sweep.quality, emulator.take_lag());
    // The accuracy depends on the load of the machine; the points lie in the room all the same.
    let far = sweep
        .view
        .points
        .iter()
        .filter(|p| p.x.abs() > 2.1 || p.y.abs() > 1.6);
    assert_eq!(far.count(), 0);

    let cancel = Cancel::new();
    let later = cancel.clone();
    let canceller = thread::spawn(move || {
        thread::sleep(Duration::from_millis(300));
        later.cancel();
    });
    request.tilt_from_rad = -0.6;
    assert_eq!(
        station.sweep(&request, &cancel),
        Err(DeviceError::Cancelled)
    );
    canceller.join().expect("no panic");
    let dialogue = station.take_dialogue().expect("recorded");
    let replayed = replay_sweep(&dialogue).expect("replayed").sweep;
    assert_eq!(replayed, Err(DeviceError::Cancelled));
    assert!(!emulator.laser_on() && !emulator.head_moving());
    station.park().expect("parks");
    drop(station);
    assert!(!emulator.laser_on());
}

#[test]
fn dropped_in_the_middle_the_laser_goes_off() {
    let clock = Clock::paced(10.0);
    let tcp = EmulatorPorts {
        laser_tcp: Some("127.0.0.1:0".parse().expect("an address")),
        head_tcp: Some("127.0.0.1:0".parse().expect("an address")),
        ..EmulatorPorts::default()
    };
    let emulator = emulator(&clock, &tcp);
    let mut settings = settings(&emulator);
    assert!(settings.ptu.port.starts_with("tcp:127.0.0.1:"));
    settings.ptu.home_at_start = false;
    let (notes, _heard) = mpsc::channel();
    let mut station =
        Station::open(&settings, clock.clone(), notes, &Cancel::new()).expect("both answer");
    station
        .home_if_needed(&Cancel::new())
        .expect("trusted as found");
    assert!(!emulator.head_moving());
    let cancel = Cancel::new();
    let later = cancel.clone();
    let sweeping = thread::spawn(move || {
        let settings = Settings::defaults();
        let request = SweepRequest::new(&settings, None);
        let outcome = station.sweep(&request, &later);
        drop(station);
        outcome
    });
    while !emulator.laser_on() {
        thread::sleep(Duration::from_millis(5));
    }
    cancel.cancel();
    assert_eq!(
        sweeping.join().expect("no panic"),
        Err(DeviceError::Cancelled)
    );
    assert!(!emulator.laser_on() && !emulator.head_moving());
}

#[test]
fn missing_and_exchanged_ports_are_reported() {
    let clock = Clock::paced(50.0);
    let (notes, _heard) = mpsc::channel();
    let mut absent = Settings::defaults();
    absent.laser.port = "/dev/no-such-laser".to_owned();
    absent.ptu.port = "/dev/no-such-ptu".to_owned();
    let survey = |settings: &Settings| {
        let survey = Station::survey(settings, clock.clone(), notes.clone(), &Cancel::new());
        let survey = survey.expect("threads");
        assert_eq!(survey.sweep_notes, [""; 0]);
        (survey.laser, survey.ptu)
    };
    let (laser, head) = survey(&absent);
    assert!(
        laser
            .expect_err("absent")
            .to_string()
            .contains("/dev/no-such-laser")
    );
    assert!(head.expect_err("absent").to_string().contains("ptu.port"));

    let emulator = emulator(&clock, &EmulatorPorts::default());
    let mut exchanged = settings(&emulator);
    std::mem::swap(&mut exchanged.laser.port, &mut exchanged.ptu.port);
    let (laser, head) = survey(&exchanged);
    for error in [laser.expect_err("a head"), head.expect_err("a laser")] {
        assert!(
            matches!(error, DeviceError::WrongDevice { readable: true, .. }),
            "{error}"
        );
        assert!(
            error.to_string().contains("exchange the two ports"),
            "{error}"
        );
    }
}

#[test]
fn other_line_rates_are_found_and_that_of_the_laser_is_raised() {
    let clock = Clock::paced(2.0);
    let mut options = options();
    options.laser.link = LaserLink::Serial { baud: 19_200 };
    options.head.start.baud = 19_200;
    let emulator = emulator_with(options, &clock, &EmulatorPorts::default());
    let settings = settings(&emulator);
    assert_eq!((settings.laser.baud, settings.ptu.baud), (115_200, 9600));
    let (notes, _heard) = mpsc::channel();
    let survey = Station::survey(&settings, clock, notes, &Cancel::new()).expect("threads");
    survey.ptu.expect("found at its rate");
    assert_eq!(survey.laser.expect("found").line_bit_s, Some(115_200));
    let told = survey.sweep_notes.join("; ");
    assert!(told.contains("115200 bit/s: 2 steps per value"), "{told}");
}

#[test]
fn waiting_for_a_silent_port_can_be_cancelled() {
    let clock = Clock::paced(1.0);
    let emulator = emulator(&clock, &EmulatorPorts::default());
    emulator.inject("ptu.silence:deaf=true,for=600".parse().expect("a fault"));
    let (notes, _heard) = mpsc::channel();
    let cancel = Cancel::new();
    cancel.cancel();
    let open = Station::open(&settings(&emulator), clock.clone(), notes, &cancel);
    assert!(matches!(open, Err(DeviceError::Cancelled)));
}

/// Whether `wanted` is read within five seconds, wall time.
fn heard(port: &mut dyn link::Link, wanted: &str) -> bool {
    let started = std::time::Instant::now();
    let mut text = String::new();
    let mut buffer = [0; 256];
    while started.elapsed() < Duration::from_secs(5) {
        match port.read(&mut buffer, Duration::from_millis(50)) {
            Ok(count) => {
                text.extend(buffer[..count].iter().map(|byte| char::from(*byte)));
            }
            Err(_) => return false,
        }
        if text.contains(wanted) {
            return true;
        }
    }
    false
}

#[test]
fn an_unplugged_port_comes_back_under_another_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let (first, second) = (path("laser"), path("laser-again"));
    let clock = Clock::paced(5.0);
    let ports = EmulatorPorts {
        laser: Some(&first),
        ..EmulatorPorts::default()
    };
    let emulator = emulator(&clock, &ports);
    let open = |path: &std::path::Path| link::SerialLink::open(&path.to_string_lossy(), 19_200);
    let mut port = open(&first).expect("it is there");
    link::Link::write_all(&mut port, b"SCIP2.0\n", Duration::from_secs(1)).expect("a live line");
    assert!(heard(&mut port, "SCIP2.0\n0\n\n"));
    let node = std::fs::read_link(&first).expect("a link");
    let fault = format!("laser.unplug:for=1,as={}", second.display());
    emulator.inject(fault.parse().expect("a fault"));
    assert!(!heard(&mut port, "never sent"), "closed");
    assert!(!first.exists());
    let mut again = None;
    for _ in 0..500 {
        thread::sleep(Duration::from_millis(10));
        again = open(&second).ok();
        if again.is_some() {
            break;
        }
    }
    let mut again = again.expect("it comes back");
    assert!(!first.exists(), "under the other name only");
    assert_ne!(
        std::fs::read_link(&second).expect("a link"),
        std::path::PathBuf::new()
    );
    drop((node, port));
    link::Link::write_all(&mut again, b"QT\n", Duration::from_secs(1)).expect("a live line");
    assert!(
        heard(&mut again, "QT\nE\n\n"),
        "it lost its power with its plug"
    );
}
