//! `patrold emulate`: both devices, byte for byte, on pseudo-terminals, until interrupted.

use super::failure::{DONE, Failure, Outcome};
use super::signals::Interruption;
use super::{output, scenes};
use crate::config::Settings;
use clap::Args;
use link::Clock;
use nalgebra::Point3;
use patrold_engine::geometry::RollPitchYaw;
use patrold_sim::emulator::{EmulatedFault, Emulation, EmulationOptions, Emulator, EmulatorPorts};
use patrold_sim::world::{MountGeometry, Stand};
use scip::twin::Profile;
use serde::Deserialize;
use serde_json::json;
use std::io::{self, BufRead};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Arguments of `emulate`.
///
/// Lines on standard input command it while it runs: {"at": [x, y, yaw]} (metres, radians) moves the robot, {"scene": FILE}
/// changes the world, {"fault": SPEC} injects.
#[derive(Debug, Args)]
pub struct EmulateArgs {
    /// What stands around: a scene file
    #[arg(long, value_name = "FILE")]
    scene: PathBuf,
    /// Link to the laser's pseudo-terminal
    #[arg(long, value_name = "PATH")]
    laser: Option<PathBuf>,
    /// Link to the pan-tilt's pseudo-terminal
    #[arg(long, value_name = "PATH")]
    ptu: Option<PathBuf>,
    /// The laser listens on this address instead (HOST:PORT; port 0 takes a free one)
    #[arg(long, value_name = "ADDR", conflicts_with = "laser")]
    laser_tcp: Option<SocketAddr>,
    /// Which laser: urg-04lx, urg-04lx-ug01, utm-30lx or ust-20lx
    #[arg(long, value_name = "NAME", default_value = "urg-04lx", value_parser = profile)]
    laser_profile: Profile,
    /// An option of the emulated laser: start=streaming, link=19200, timer=16770, serial=H0001 ...
    #[arg(long = "laser-option", value_name = "KEY=VALUE")]
    laser_options: Vec<String>,
    /// An option of the emulated pan-tilt: model=d46-70, velocity=on, baud=19200, line-end=cr, pan=-500 ...
    #[arg(long = "ptu-option", value_name = "KEY=VALUE")]
    ptu_options: Vec<String>,
    /// How the laser truly sits on the plate: roll,pitch,yaw in degrees
    #[arg(long, value_name = "R,P,Y", value_parser = super::clouds::parse_point, allow_hyphen_values = true)]
    mount_rpy_deg: Option<Point3<f64>>,
    /// Where the laser truly is on the plate: x,y,z in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = super::clouds::parse_point, allow_hyphen_values = true)]
    mount_xyz_m: Option<Point3<f64>>,
    /// Seconds of the devices per second of the wall
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = scale)]
    time_scale: f64,
    /// Seed of noise, jitter and spoilt bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// A fault: device.kind[:key=value,...], device laser or ptu, keys at=, for=, count= and its own
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<String>,
}

fn profile(name: &str) -> Result<Profile, String> {
    Profile::by_name(name).ok_or_else(|| format!("expected one of {}", Profile::NAMES.join(", ")))
}

/// Seconds of the devices per second of the wall, as a command takes it.
pub(super) fn scale(text: &str) -> Result<f64, String> {
    let scale = text.parse::<f64>().ok();
    scale
        .filter(|x| (0.001..=1000.0).contains(x))
        .ok_or_else(|| "expected a number from 0.001 to 1000".to_owned())
}

fn fault(text: &str) -> Result<EmulatedFault, String> {
    text.parse()
        .map_err(|error: patrold_sim::emulator::EmulatedFaultError| error.to_string())
}

/// Runs `emulate`.
pub fn run(args: &EmulateArgs) -> Outcome {
    let emulator = start(args)?;
    // Taken over before the ready line: whoever reads it may interrupt at once.
    let interruption = Interruption::new()?;
    output::json(&json!({"laser": emulator.laser_port(), "ptu": emulator.head_port()}))?;
    let running = Arc::new(Mutex::new(Some(emulator)));
    let commanded = Arc::clone(&running);
    thread::spawn(move || obey_lines(&commanded));
    interruption.wait();
    // Dropped here, with its links, whatever the other thread still reads.
    let emulator = running
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    drop(emulator);
    Ok(DONE)
}

fn start(args: &EmulateArgs) -> Result<Emulator, Failure> {
    let faults: Result<Vec<_>, _> = args.faults.iter().map(|spec| fault(spec)).collect();
    let faults = faults.map_err(Failure::Usage)?;
    if let (Some(laser), Some(head)) = (&args.laser, &args.ptu)
        && laser == head
    {
        let path = laser.display();
        return Err(Failure::Usage(format!(
            "--laser and --ptu are both {path}: give each device a link of its own"
        )));
    }
    let scene = scenes::load(&args.scene)?;
    let clock = Clock::scaled(args.time_scale);
    let mut options = EmulationOptions::seeded(args.seed);
    options.laser.set_profile(args.laser_profile.clone());
    for option in &args.laser_options {
        let taken = options.laser.set(option);
        taken.map_err(|error| Failure::Usage(format!("--laser-option: {error}")))?;
    }
    for option in &args.ptu_options {
        let taken = options.head.set(option);
        taken.map_err(|error| Failure::Usage(format!("--ptu-option: {error}")))?;
    }
    options.mount = default_mount();
    if let Some(rpy) = args.mount_rpy_deg {
        options.mount.laser_rpy = RollPitchYaw {
            roll_rad: rpy.x.to_radians(),
            pitch_rad: rpy.y.to_radians(),
            yaw_rad: rpy.z.to_radians(),
        };
    }
    if let Some(xyz) = args.mount_xyz_m {
        options.mount.laser_xyz_m = xyz.into();
    }
    let mut emulation = Emulation::new(options, scene.world, scene.map_from_base, clock.now());
    for fault in faults {
        emulation.inject(fault);
    }
    let ports = EmulatorPorts {
        laser: args.laser.as_deref(),
        head: args.ptu.as_deref(),
        laser_tcp: args.laser_tcp,
    };
    Emulator::start(emulation, &ports, clock).map_err(Failure::failed)
}

/// The robot carries its laser as a configuration that says nothing believes.
fn default_mount() -> MountGeometry {
    let mount = Settings::defaults().mount;
    let [roll_rad, pitch_rad, yaw_rad] = mount.laser_rpy_rad;
    MountGeometry {
        pan_origin_m: mount.pan_axis_m,
        tilt_origin_m: mount.tilt_axis_m,
        plate_origin_m: mount.plate_m,
        laser_xyz_m: mount.laser_m,
        laser_rpy: RollPitchYaw {
            roll_rad,
            pitch_rad,
            yaw_rad,
        },
    }
}

/// One line of standard input.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum Order {
    At([f64; 3]),
    Scene(PathBuf),
    Fault(String),
}

fn order(line: &str) -> Result<Order, String> {
    let order: Order = serde_json::from_str(line).map_err(|error| {
        format!("expected {{\"at\": [x, y, yaw]}}, {{\"scene\": FILE}} or {{\"fault\": SPEC}}, got {line}: {error}")
    })?;
    Ok(order)
}

fn obey_lines(running: &Mutex<Option<Emulator>>) {
    for told in orders(io::stdin().lock()) {
        if let Err(told) = told.and_then(|order| obey(&order, running)) {
            eprintln!("patrold: {told}");
        }
    }
}

/// Every order up to the end of the input; what is none, text or not, is told and the next line read.
fn orders(mut input: impl BufRead) -> impl Iterator<Item = Result<Order, String>> {
    std::iter::from_fn(move || {
        loop {
            let mut line = Vec::new();
            match input.read_until(b'\n', &mut line) {
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
            let line = String::from_utf8_lossy(&line);
            if !line.trim().is_empty() {
                return Some(order(line.trim()));
            }
        }
    })
}

fn obey(order: &Order, running: &Mutex<Option<Emulator>>) -> Result<(), String> {
    // Reading a scene may take long; the emulator is asked afterwards.
    let world = match order {
        Order::Scene(path) => Some(load_world(path)?),
        _ => None,
    };
    let running = running.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(emulator) = running.as_ref() else {
        return Ok(());
    };
    match order {
        Order::At([x_m, y_m, yaw_rad]) => emulator.drive_to(Stand {
            x_m: *x_m,
            y_m: *y_m,
            yaw_rad: *yaw_rad,
        }),
        Order::Scene(_) => {
            if let Some(world) = world {
                emulator.set_world(world);
            }
        }
        Order::Fault(spec) => emulator.inject(fault(spec)?),
    }
    Ok(())
}

fn load_world(path: &Path) -> Result<Arc<patrold_sim::world::World>, String> {
    scenes::load(path)
        .map(|scene| scene.world)
        .map_err(|failure| failure.to_string())
}

#[cfg(test)]
mod tests {
    use super::{Order, fault, order, orders};
    use std::path::PathBuf;

    #[test]
    fn a_line_that_is_no_text_does_not_end_the_orders() {
        let input = b"\xff\xfe\n\n{\"at\": [0, 0, 0]}\r\n{\"at\": [1, 0, 0]}";
        let told: Vec<_> = orders(&input[..]).collect();
        assert_eq!(told.len(), 3);
        assert!(told[0].is_err());
        assert_eq!(
            told[1..],
            [Ok(Order::At([0.0; 3])), Ok(Order::At([1.0, 0.0, 0.0]))]
        );
    }

    #[test]
    fn orders_are_read_and_others_refused_in_one_line() {
        assert_eq!(
            order("{\"at\": [1, 2.5, -0.3]}"),
            Ok(Order::At([1.0, 2.5, -0.3]))
        );
        assert_eq!(
            order("{\"scene\": \"a.toml\"}"),
            Ok(Order::Scene(PathBuf::from("a.toml")))
        );
        assert!(matches!(
            order("{\"fault\": \"laser.silence\"}"),
            Ok(Order::Fault(_))
        ));
        for line in [
            "{}",
            "at",
            "{\"at\": [1]}",
            "{\"go\": 1}",
            "{\"at\": [0,0,0], \"scene\": \"b\"}",
        ] {
            assert!(!order(line).expect_err(line).contains('\n'));
        }
        assert!(
            fault("laser.nothing")
                .expect_err("no fault")
                .contains("brown-out")
        );
    }
}
