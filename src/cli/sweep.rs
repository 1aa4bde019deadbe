//! `patrold sweep --out FILE.ply`: one sweep, through the running service, else straight from the devices.

use super::failure::{DONE, Failure, Outcome};
use super::{client, config, files, output, signals};
use crate::config::Settings;
use crate::devices::{Cancel, Clock, NoteLevel, Station, SweepRequest};
use crate::formats::write_ply;
use crate::sweep::{Quality, Sweep, assemble};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::sync::mpsc;

/// Arguments of `sweep`.
#[derive(Debug, Args)]
pub struct SweepArgs {
    /// Where the cloud goes: PLY, metres, the frame of the pan-tilt's base
    #[arg(long, value_name = "FILE.ply")]
    out: PathBuf,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// What a sweep gave.
struct Taken {
    ply: Vec<u8>,
    points: usize,
    quality: Quality,
    /// Why it must not be judged.
    fault: Option<String>,
}

/// Runs `sweep`.
pub fn run(args: &SweepArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    let taken = match client::sweep(&settings.api.socket)? {
        Some((about, ply)) => Taken {
            ply,
            points: about.points,
            quality: about.sweep,
            fault: about.fault,
        },
        None => {
            let cancel = signals::cancel_on_signal()?;
            let sweep = sweep_direct(&settings, &Clock::real(), &cancel)?;
            Taken {
                ply: write_ply(&sweep.view.points),
                points: sweep.view.points.len(),
                fault: sweep.quality.fault(settings.sweep.max_missing_lines),
                quality: sweep.quality,
            }
        }
    };
    report(args, taken)
}

/// Homes if the head needs it, sweeps as configured, parks. Notes of the devices go to standard error.
///
/// # Errors
/// A device that does not do its part; a sweep that cannot be assembled.
pub fn sweep_direct(settings: &Settings, clock: &Clock, cancel: &Cancel) -> Result<Sweep, Failure> {
    let (notes, heard) = mpsc::channel();
    let mut station = Station::open(settings, clock.clone(), notes).map_err(Failure::failed)?;
    let taken = (|| {
        if !station.position_trusted() {
            station.home(cancel)?;
        }
        let request = SweepRequest::new(&settings.sweep, &settings.mount, &settings.sweep.pans_rad);
        let raw = station.sweep(&request, cancel)?;
        station.park()?;
        Ok(raw)
    })();
    drop(station);
    for note in heard.try_iter().filter(|n| n.level > NoteLevel::Info) {
        eprintln!("patrold: {}: {}", note.device, note.text);
    }
    let raw = taken.map_err(|error: crate::devices::DeviceError| Failure::failed(error))?;
    assemble(&raw).map_err(Failure::failed)
}

/// Writes the cloud and says what it is worth. A sweep that must not be judged is written all the same, and a failure.
fn report(args: &SweepArgs, taken: Taken) -> Outcome {
    let path = args.out.display();
    files::write(&args.out, &taken.ply)?;
    let quality = &taken.quality;
    if args.json {
        output::json(&json!({
            "out": args.out,
            "points": taken.points,
            "quality": quality,
            "fault": taken.fault,
        }))?;
    } else {
        output::line(format!(
            "{path}: {} points, {} of {} lines, {:.1} % of the beams with nothing there",
            taken.points,
            quality.lines_got,
            quality.lines_expected,
            100.0 * quality.no_return_share
        ))?;
    }
    match taken.fault {
        None => Ok(DONE),
        Some(why) => Err(Failure::Failed(why)),
    }
}
