//! `patrold sweep --out FILE.ply`: one sweep, through the running service, else straight from the devices.

use super::failure::{CommandResult, DONE, Failure};
use super::progress::PlannedWork;
use super::{client, config, files, output, signals, value_parsers};
use crate::config::Settings;
use crate::devices::{Cancel, DeviceError, Station, SweepRequest};
use crate::patrol::severity::Severity;
use crate::service::planned_sweep;
use clap::Args;
use link::Clock;
use patrold_engine::formats::write_ply;
use patrold_engine::sweep::{Sweep, SweepQuality, assemble};
use rustix::fs::OFlags;
use serde_json::json;
use std::fs;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

#[derive(Debug, Args)]
pub(super) struct SweepArgs {
    /// Output file: PLY, metres, in the frame of the pan-tilt's base
    #[arg(long, value_name = "FILE.ply")]
    out: PathBuf,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// For emulated devices: device seconds per second of wall time, as given to `emulate`
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = value_parsers::parse_time_scale)]
    time_scale: f64,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Connecting and homing, as shown while it lasts: a calibration of the head and as much again (ptu-d46 section 7).
pub(super) const HOMING: Duration = Duration::from_secs(20);

struct TakenSweep {
    ply: Vec<u8>,
    points: usize,
    quality: SweepQuality,
    /// Why the service would not judge it.
    fault: Option<String>,
}

/// An output file that appears when it is complete: `FILE.tmp` beside it until then, removed on failure.
struct PartialFile {
    path: PathBuf,
    tmp_path: PathBuf,
    file: fs::File,
}

impl PartialFile {
    fn create(path: &Path) -> Result<Self, Failure> {
        let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
            return Err(files::file_error(path, "is a folder; choose a file"));
        };
        let mut name = name.to_owned();
        name.push(".tmp");
        let tmp_path = path.with_file_name(name);
        // A link in its place would lead the sweep over another file.
        let file = fs::OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(true)
            .custom_flags(OFlags::NOFOLLOW.bits().cast_signed())
            .open(&tmp_path);
        let file = file.map_err(|error| {
            let text = format!("cannot be created: {error}; check its folder or choose another");
            files::file_error(path, text)
        })?;
        Ok(Self {
            path: path.to_owned(),
            tmp_path,
            file,
        })
    }

    fn finish(mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file
            .write_all(bytes)
            .and_then(|()| fs::rename(&self.tmp_path, &self.path))
            .map_err(|error| files::file_error(&self.path, error))
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // Absent after `finish`.
        let _ = fs::remove_file(&self.tmp_path);
    }
}

pub(super) fn run(args: &SweepArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    // Before the head moves: no sweep for a file that cannot be written.
    let file = PartialFile::create(&args.out)?;
    let sweep = match client::request_sweep(&settings.api.socket)? {
        Some((info, ply)) => TakenSweep {
            ply,
            points: info.points,
            quality: info.sweep,
            fault: info.fault,
        },
        None => {
            let cancel = signals::cancel_on_signal()?;
            let sweep = take_sweep(&settings, &Clock::scaled(args.time_scale), &cancel)?;
            TakenSweep {
                ply: write_ply(&sweep.view.points),
                points: sweep.view.points.len(),
                fault: sweep.quality.fault(settings.sweep.max_missing_lines),
                quality: sweep.quality,
            }
        }
    };
    write_and_report(args, file, sweep)
}

/// Homes if needed, sweeps as configured, parks. Warnings of the devices go to standard error.
pub(super) fn take_sweep(
    settings: &Settings,
    clock: &Clock,
    cancel: &Cancel,
) -> Result<Sweep, Failure> {
    let request = SweepRequest::new(settings, None);
    let phases = [
        ("homing", clock.wall_time(HOMING)),
        ("sweeping", planned_sweep(&request, clock)),
    ];
    let phases = phases.map(|(name, planned)| (name.to_owned(), planned));
    let work = PlannedWork::start("sweep", phases.into());
    let (notes, received) = mpsc::channel();
    let mut station =
        Station::open(settings, clock.clone(), notes, cancel).map_err(Failure::failed)?;
    let raw = (|| {
        station.home_if_needed(cancel)?;
        work.next_phase();
        let raw = station.sweep(&request, cancel)?;
        park(&mut station);
        Ok(raw)
    })();
    drop((station, work));
    for note in received.try_iter().filter(|n| n.severity > Severity::Info) {
        eprintln!("patrold: {}: {}", note.device, note.text);
    }
    let raw = raw.map_err(|error: DeviceError| Failure::failed(error))?;
    assemble(&raw).map_err(Failure::failed)
}

/// A failure to park is a warning: the sweep is complete.
pub(super) fn park(station: &mut Station) {
    if let Err(error) = station.park() {
        eprintln!("patrold: head not parked: {error}");
    }
}

/// A sweep with a fault is written too, and is then a failure.
fn write_and_report(args: &SweepArgs, file: PartialFile, sweep: TakenSweep) -> CommandResult {
    let path = args.out.display();
    file.finish(&sweep.ply)?;
    let quality = &sweep.quality;
    if args.json {
        output::json(&json!({
            "out": args.out,
            "points": sweep.points,
            "quality": quality,
            "fault": sweep.fault,
        }))?;
    } else {
        output::line(format!(
            "{path}: {} points, {} of {} lines, {:.1} % of the beams without return",
            sweep.points,
            quality.lines_got,
            quality.lines_expected,
            100.0 * quality.no_return_share
        ))?;
    }
    match sweep.fault {
        None => Ok(DONE),
        Some(fault) => Err(Failure::Failed(fault)),
    }
}

#[cfg(test)]
mod tests {
    use super::PartialFile;
    use std::fs;

    #[test]
    fn an_output_file_appears_when_it_is_complete_and_a_bad_path_fails_at_once() {
        let dir = tempfile::tempdir().expect("temp dir");
        let out = dir.path().join("a.ply");
        let files = || fs::read_dir(dir.path()).expect("listed").count();
        drop(
            PartialFile::create(&out)
                .map_err(|e| e.to_string())
                .expect("created"),
        );
        assert_eq!(files(), 0);
        let file = PartialFile::create(&out)
            .map_err(|e| e.to_string())
            .expect("created");
        assert!(!out.exists());
        file.finish(b"ply")
            .map_err(|e| e.to_string())
            .expect("written");
        assert_eq!(
            (fs::read(&out).expect("there"), files()),
            (b"ply".to_vec(), 1)
        );
        // No link is followed.
        let victim = dir.path().join("victim");
        fs::write(&victim, b"kept").expect("written");
        std::os::unix::fs::symlink(&victim, dir.path().join("b.ply.tmp")).expect("a link");
        assert!(PartialFile::create(&dir.path().join("b.ply")).is_err());
        assert_eq!(fs::read(&victim).expect("there"), b"kept");
        assert!(PartialFile::create(dir.path()).is_err());
        assert!(PartialFile::create(&dir.path().join("no/a.ply")).is_err());
    }
}
