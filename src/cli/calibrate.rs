//! `patrold calibrate`: mount, time offset and backlash from sweeps, taken now or kept from before, and the configuration
//! lines to change.

use super::calibration_report::{report_json, report_lines};
use super::failure::{CommandResult, DONE, Failure};
use super::progress::PlannedWork;
use super::sweep::{HOMING, park};
use super::{config, files, output, signals, value_parsers};
use crate::config::Settings;
use crate::devices::{Cancel, Station, SweepRequest, calibration_requests};
use crate::patrol::severity::Severity;
use crate::service::planned_sweep;
use clap::Args;
use link::Clock;
use patrold_engine::sweep::{RawSweep, calibrate, decode_raw_sweep, encode_raw_sweep};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct CalibrateArgs {
    /// Raw sweeps written by --keep, all from one place [default: take new sweeps]
    #[arg(value_name = "FILE", conflicts_with_all = ["keep", "one_pan", "time_scale"])]
    files: Vec<PathBuf>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Sweep at one pan only: faster, but the pitch of the laser is not observable unless --level-floor is given
    #[arg(long)]
    one_pan: bool,
    /// The floor is level under the robot's base, to this standard deviation in degrees
    #[arg(long, value_name = "DEG", value_parser = parse_level_sigma)]
    level_floor: Option<f64>,
    /// Keep the raw sweeps in this folder as sweep-1.raw, sweep-2.raw ...; it is created
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// For emulated devices: device seconds per second of wall time, as given to `emulate`
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = value_parsers::parse_time_scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

fn parse_level_sigma(text: &str) -> Result<f64, String> {
    let degrees = text.parse::<f64>().ok();
    degrees
        .filter(|x| (0.001..=10.0).contains(x))
        .ok_or_else(|| "expected a number from 0.001 to 10".to_owned())
}

/// Changes no configuration: it prints the lines to change.
pub(super) fn run(args: &CalibrateArgs) -> CommandResult {
    // A folder that cannot be created fails before the robot sweeps.
    if let Some(folder) = &args.keep {
        fs::create_dir_all(folder).map_err(|error| files::file_error(folder, error))?;
    }
    let sweeps = if args.files.is_empty() {
        let settings = config::load_settings(args.config.as_deref())?;
        let cancel = signals::cancel_on_signal()?;
        let clock = Clock::scaled(args.time_scale);
        take_sweeps(
            &settings,
            !args.one_pan,
            args.keep.as_deref(),
            clock,
            &cancel,
        )?
    } else {
        let read = |path: &PathBuf| {
            decode_raw_sweep(&files::read(path)?).map_err(|error| files::file_error(path, error))
        };
        args.files.iter().map(read).collect::<Result<_, _>>()?
    };
    let floor_level_rad = args.level_floor.map(f64::to_radians);
    let calibration = calibrate(&sweeps, floor_level_rad).map_err(Failure::failed)?;
    if args.json {
        output::json(&report_json(&calibration, sweeps.len()))?;
    } else {
        for line in report_lines(&calibration) {
            output::line(line)?;
        }
    }
    Ok(DONE)
}

/// Homes if needed, takes all sweeps, parks. Each is kept as soon as it is taken: what follows may fail. Warnings of the
/// devices go to standard error.
pub(super) fn take_sweeps(
    settings: &Settings,
    several_pans: bool,
    keep: Option<&Path>,
    clock: Clock,
    cancel: &Cancel,
) -> Result<Vec<RawSweep>, Failure> {
    let configured = SweepRequest::new(settings, None);
    let requests = calibration_requests(&configured, several_pans);
    let work = PlannedWork::start("calibration", phases(&requests, &clock));
    let (notes, received) = mpsc::channel();
    let mut station = Station::open(settings, clock, notes, cancel).map_err(Failure::failed)?;
    let sweeps = (|| {
        station.home_if_needed(cancel).map_err(Failure::failed)?;
        let mut sweeps = Vec::new();
        for (number, request) in (1..).zip(&requests) {
            work.next_phase();
            let sweep = station.sweep(request, cancel).map_err(Failure::failed)?;
            if let Some(folder) = keep {
                let path = folder.join(format!("sweep-{number}.raw"));
                files::write(&path, &encode_raw_sweep(&sweep))?;
            }
            sweeps.push(sweep);
        }
        park(&mut station);
        Ok(sweeps)
    })();
    drop((station, work));
    for note in received.try_iter().filter(|n| n.severity > Severity::Info) {
        eprintln!("patrold: {}: {}", note.device, note.text);
    }
    sweeps
}

/// Homing, then each sweep, wall time.
fn phases(requests: &[SweepRequest], clock: &Clock) -> Vec<(String, Duration)> {
    let count = requests.len();
    let sweeps = (1..).zip(requests).map(|(number, request)| {
        let planned = planned_sweep(request, clock);
        (format!("sweep {number} of {count}"), planned)
    });
    std::iter::once(("homing".to_owned(), clock.wall_time(HOMING)))
        .chain(sweeps)
        .collect()
}
