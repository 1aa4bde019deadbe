//! `patrold calibrate`: mount, time offset and backlash from sweeps of the room around the robot, straight from the devices
//! or stored before, and the lines of configuration that they ask for.

use super::calibration_report::{lines, report};
use super::failure::{DONE, Failure, Outcome};
use super::sweep::park;
use super::{config, files, output, signals};
use crate::config::Settings;
use crate::devices::{Cancel, DeviceError, NoteLevel, Station, SweepRequest, calibration_requests};
use clap::Args;
use link::Clock;
use patrold_engine::sweep::{RawSweep, calibrate, decode, encode};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc;

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArgs {
    /// Raw sweeps that --keep wrote, all from one place; without any they are taken now
    #[arg(value_name = "FILE", conflicts_with_all = ["keep", "one_pan", "time_scale"])]
    files: Vec<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Sweep at one pan only: faster, but the pitch of the laser stays unknown unless the floor is level
    #[arg(long)]
    one_pan: bool,
    /// The floor is level under the robot's base, to this standard deviation in degrees
    #[arg(long, value_name = "DEG", value_parser = level)]
    level_floor: Option<f64>,
    /// Keep the raw sweeps in this folder as sweep-1.raw, sweep-2.raw ...; it is made
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Seconds of the devices per second of the wall, for emulated devices that run at X times the wall's pace
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = super::emulate::scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

fn level(text: &str) -> Result<f64, String> {
    let degrees = text.parse::<f64>().ok();
    degrees
        .filter(|x| (0.001..=10.0).contains(x))
        .ok_or_else(|| "expected a number from 0.001 to 10".to_owned())
}

/// Runs `calibrate`. Nothing is changed: the lines are for a person to take over.
pub fn run(args: &CalibrateArgs) -> Outcome {
    // Before the robot has swept for nothing.
    if let Some(folder) = &args.keep {
        fs::create_dir_all(folder).map_err(|error| files::named(folder, error))?;
    }
    let sweeps = if args.files.is_empty() {
        let settings = config::settings(args.config.as_deref())?;
        let cancel = signals::cancel_on_signal()?;
        let clock = Clock::scaled(args.time_scale);
        take(&settings, !args.one_pan, clock, &cancel)?
    } else {
        let read =
            |path: &PathBuf| decode(&files::read(path)?).map_err(|error| files::named(path, error));
        args.files.iter().map(read).collect::<Result<_, _>>()?
    };
    if let Some(folder) = &args.keep {
        keep(folder, &sweeps)?;
    }
    let floor_level_rad = args.level_floor.map(f64::to_radians);
    let found = calibrate(&sweeps, floor_level_rad).map_err(Failure::failed)?;
    if args.json {
        output::json(&report(&found, sweeps.len()))?;
    } else {
        for line in lines(&found) {
            output::line(line)?;
        }
    }
    Ok(DONE)
}

/// Homes if the head needs it, takes all sweeps, parks. Notes of the devices go to standard error.
fn take(
    settings: &Settings,
    pans: bool,
    clock: Clock,
    cancel: &Cancel,
) -> Result<Vec<RawSweep>, Failure> {
    let (notes, heard) = mpsc::channel();
    let mut station = Station::open(settings, clock, notes, cancel).map_err(Failure::failed)?;
    let taken = (|| {
        if !station.position_trusted() {
            station.home(cancel)?;
        }
        let usual = SweepRequest::new(&settings.sweep, &settings.mount, &settings.sweep.pans_rad);
        let requests = calibration_requests(&usual, pans);
        let sweeps: Result<Vec<_>, DeviceError> = requests
            .iter()
            .map(|request| station.sweep(request, cancel))
            .collect();
        park(&mut station);
        sweeps
    })();
    drop(station);
    for note in heard.try_iter().filter(|n| n.level > NoteLevel::Info) {
        eprintln!("patrold: {}: {}", note.device, note.text);
    }
    taken.map_err(Failure::failed)
}

fn keep(folder: &Path, sweeps: &[RawSweep]) -> Result<(), Failure> {
    for (number, sweep) in (1..).zip(sweeps) {
        files::write(&folder.join(format!("sweep-{number}.raw")), &encode(sweep))?;
    }
    Ok(())
}
