//! `patrold emulate`: both devices on pseudo-terminals, until interrupted.

use super::failure::{CommandResult, DONE, Failure};
use super::signals::TerminationSignals;
use super::{output, scenes, value_parsers};
use crate::config::Settings;
use clap::Args;
use link::Clock;
use nalgebra::Point3;
use patrold_engine::geometry::RollPitchYaw;
use patrold_sim::emulator::{
    EmulatedFault, EmulatedFaultError, Emulation, EmulationOptions, Emulator, EmulatorPorts,
};
use patrold_sim::world::{MountGeometry, Pose2d, World};
use scip::emulator::LaserProfile;
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::{self, BufRead};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

#[derive(Debug, Args)]
pub(super) struct EmulateArgs {
    /// Scene file of the surroundings
    #[arg(long, value_name = "FILE")]
    scene: PathBuf,
    /// Link to the laser's pseudo-terminal
    #[arg(long, value_name = "PATH")]
    laser: Option<PathBuf>,
    /// Link to the pan-tilt's pseudo-terminal
    #[arg(long, value_name = "PATH")]
    ptu: Option<PathBuf>,
    /// TCP address of the laser instead of a pseudo-terminal (HOST:PORT; port 0 takes a free one)
    #[arg(long, value_name = "ADDR", conflicts_with = "laser")]
    laser_tcp: Option<SocketAddr>,
    /// TCP address of the pan-tilt, as behind a serial server, instead of a pseudo-terminal (HOST:PORT)
    #[arg(long, value_name = "ADDR", conflicts_with = "ptu")]
    ptu_tcp: Option<SocketAddr>,
    /// Model of the laser: urg-04lx, urg-04lx-ug01, utm-30lx or ust-20lx
    #[arg(long, value_name = "NAME", default_value = "urg-04lx", value_parser = parse_profile)]
    laser_profile: LaserProfile,
    /// Option of the emulated laser: start=streaming, link=19200, timer=16770, serial=H0001 ...
    #[arg(long = "laser-option", value_name = "KEY=VALUE")]
    laser_options: Vec<String>,
    /// Option of the emulated pan-tilt: model=d46-70, velocity=on, baud=19200, line-end=cr, pan=-500 ...
    #[arg(long = "ptu-option", value_name = "KEY=VALUE")]
    ptu_options: Vec<String>,
    /// True orientation of the laser on the plate: roll,pitch,yaw in degrees
    #[arg(long, value_name = "R,P,Y", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    mount_rpy_deg: Option<Point3<f64>>,
    /// True position of the laser on the plate: x,y,z in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::parse_point, allow_hyphen_values = true)]
    mount_xyz_m: Option<Point3<f64>>,
    /// Device seconds per second of wall time
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = value_parsers::parse_time_scale)]
    time_scale: f64,
    /// Seed of noise, jitter and corrupted bytes
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Fault: device.kind[:key=value,...] with device laser or ptu, keys at=, for=, count=, every= and those of the kind
    #[arg(long = "fault", value_name = "SPEC")]
    faults: Vec<String>,
}

fn parse_profile(name: &str) -> Result<LaserProfile, String> {
    LaserProfile::by_name(name)
        .ok_or_else(|| format!("expected one of {}", LaserProfile::NAMES.join(", ")))
}

fn parse_fault(text: &str) -> Result<EmulatedFault, String> {
    text.parse()
        .map_err(|error: EmulatedFaultError| error.to_string())
}

pub(super) fn run(args: &EmulateArgs) -> CommandResult {
    let emulator = start(args)?;
    // Before the ready line: its reader may interrupt at once.
    let signals = TerminationSignals::new()?;
    output::json(&json!({"laser": emulator.laser_port(), "ptu": emulator.head_port()}))?;
    let running = Arc::new(Mutex::new(Some(emulator)));
    let shared = Arc::clone(&running);
    let (answers, written) = mpsc::channel();
    thread::spawn(move || write_answers(&written));
    thread::spawn(move || run_stdin_commands(&shared, &answers));
    signals.wait();
    // Dropped here with its links, while the other thread may still read.
    let emulator = running
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    drop(emulator);
    Ok(DONE)
}

fn start(args: &EmulateArgs) -> Result<Emulator, Failure> {
    let faults: Result<Vec<_>, _> = args.faults.iter().map(|spec| parse_fault(spec)).collect();
    let faults = faults.map_err(Failure::Usage)?;
    if let (Some(laser), Some(head)) = (&args.laser, &args.ptu)
        && laser == head
    {
        let path = laser.display();
        return Err(Failure::Usage(format!(
            "--laser and --ptu are both {path}: give each device its own link"
        )));
    }
    let scene = scenes::load(&args.scene)?;
    let clock = Clock::scaled(args.time_scale);
    let mut options = EmulationOptions::seeded(args.seed);
    options.laser.set_profile(args.laser_profile.clone());
    for option in &args.laser_options {
        let set = options.laser.set(option);
        set.map_err(|error| Failure::Usage(format!("--laser-option: {error}")))?;
    }
    for option in &args.ptu_options {
        let set = options.head.set(option);
        set.map_err(|error| Failure::Usage(format!("--ptu-option: {error}")))?;
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
        head_tcp: args.ptu_tcp,
    };
    Emulator::start(emulation, &ports, clock).map_err(Failure::failed)
}

/// The mount of the default configuration.
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

/// One command on standard input.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum EmulatorCommand {
    At([f64; 3]),
    Scene(PathBuf),
    Fault(String),
}

fn parse_command(line: &str) -> Result<EmulatorCommand, String> {
    let command: EmulatorCommand = serde_json::from_str(line).map_err(|error| {
        format!("expected {{\"at\": [x, y, yaw]}}, {{\"scene\": FILE}} or {{\"fault\": SPEC}}, got {line}: {error}")
    })?;
    Ok(command)
}

/// A client that does not read the answers stops no command.
fn write_answers(answers: &Receiver<Value>) {
    for answer in answers {
        // Where nobody reads any more, the devices run on.
        let _ = output::json(&answer);
    }
}

fn run_stdin_commands(running: &Mutex<Option<Emulator>>, answers: &Sender<Value>) {
    for (number, command) in (1..).zip(read_commands(io::stdin().lock())) {
        let failed = command
            .and_then(|command| run_command(&command, running))
            .err();
        if let Some(error) = &failed {
            eprintln!("patrold: {}", output::printable(error));
        }
        // The other thread lives as long as this one.
        let _ = answers.send(json!({"command": number, "failed": failed}));
    }
}

/// All commands up to the end of the input; an error for a line that is none, even where it is not UTF-8.
fn read_commands(mut input: impl BufRead) -> impl Iterator<Item = Result<EmulatorCommand, String>> {
    std::iter::from_fn(move || {
        loop {
            let mut line = Vec::new();
            match input.read_until(b'\n', &mut line) {
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
            let line = String::from_utf8_lossy(&line);
            if !line.trim().is_empty() {
                return Some(parse_command(line.trim()));
            }
        }
    })
}

fn run_command(command: &EmulatorCommand, running: &Mutex<Option<Emulator>>) -> Result<(), String> {
    // A scene may take long to read, so it is read before the lock is taken.
    let world = match command {
        EmulatorCommand::Scene(path) => Some(load_world(path)?),
        _ => None,
    };
    let running = running.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(emulator) = running.as_ref() else {
        return Ok(());
    };
    match command {
        EmulatorCommand::At([x_m, y_m, yaw_rad]) => emulator.drive_to(Pose2d {
            x_m: *x_m,
            y_m: *y_m,
            yaw_rad: *yaw_rad,
        }),
        EmulatorCommand::Scene(_) => {
            if let Some(world) = world {
                emulator.set_world(world);
            }
        }
        EmulatorCommand::Fault(spec) => emulator.inject(parse_fault(spec)?),
    }
    Ok(())
}

fn load_world(path: &Path) -> Result<Arc<World>, String> {
    scenes::load(path)
        .map(|scene| scene.world)
        .map_err(|failure| failure.to_string())
}

#[cfg(test)]
mod tests {
    use super::{EmulatorCommand, parse_command, parse_fault, read_commands};
    use std::path::PathBuf;

    #[test]
    fn a_line_that_is_not_utf8_does_not_end_the_commands() {
        let input = b"\xff\xfe\n\n{\"at\": [0, 0, 0]}\r\n{\"at\": [1, 0, 0]}";
        let commands: Vec<_> = read_commands(&input[..]).collect();
        assert_eq!(commands.len(), 3);
        assert!(commands[0].is_err());
        assert_eq!(
            commands[1..],
            [
                Ok(EmulatorCommand::At([0.0; 3])),
                Ok(EmulatorCommand::At([1.0, 0.0, 0.0]))
            ]
        );
    }

    #[test]
    fn commands_are_parsed_and_other_lines_refused_in_one_line() {
        assert_eq!(
            parse_command("{\"at\": [1, 2.5, -0.3]}"),
            Ok(EmulatorCommand::At([1.0, 2.5, -0.3]))
        );
        assert_eq!(
            parse_command("{\"scene\": \"a.toml\"}"),
            Ok(EmulatorCommand::Scene(PathBuf::from("a.toml")))
        );
        assert!(matches!(
            parse_command("{\"fault\": \"laser.silence\"}"),
            Ok(EmulatorCommand::Fault(_))
        ));
        for line in [
            "{}",
            "at",
            "{\"at\": [1]}",
            "{\"go\": 1}",
            "{\"at\": [0,0,0], \"scene\": \"b\"}",
        ] {
            assert!(!parse_command(line).expect_err(line).contains('\n'));
        }
        assert!(
            parse_fault("laser.nothing")
                .expect_err("no fault")
                .contains("brown-out")
        );
    }
}
