//! `patrold sweep --out FILE.ply`: one sweep, through the running service, else straight from the devices.

use super::failure::{DONE, Failure, Outcome};
use super::{client, config, files, output, signals};
use crate::config::Settings;
use crate::devices::{Cancel, NoteLevel, Station, SweepRequest};
use clap::Args;
use link::Clock;
use patrold_engine::formats::write_ply;
use patrold_engine::sweep::{Quality, Sweep, assemble};
use serde_json::json;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
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
    /// Seconds of the devices per second of the wall, for emulated devices that run at X times the wall's pace
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = super::emulate::scale)]
    time_scale: f64,
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

/// The file of a cloud that is still to come: `FILE.tmp` beside it, renamed when it is whole, else removed.
struct Unfinished {
    wanted: PathBuf,
    path: PathBuf,
    file: fs::File,
}

impl Unfinished {
    fn create(wanted: &Path) -> Result<Self, Failure> {
        let Some(name) = wanted.file_name().filter(|_| !wanted.is_dir()) else {
            return Err(files::named(wanted, "is a folder; name a file"));
        };
        let mut name = name.to_owned();
        name.push(".tmp");
        let path = wanted.with_file_name(name);
        let file = fs::File::create(&path).map_err(|error| {
            let text =
                format!("cannot be written there: {error}; check its folder, or name another");
            files::named(wanted, text)
        })?;
        Ok(Self {
            wanted: wanted.to_owned(),
            path,
            file,
        })
    }

    fn finish(mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file
            .write_all(bytes)
            .and_then(|()| fs::rename(&self.path, &self.wanted))
            .map_err(|error| files::named(&self.wanted, error))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // After the renaming there is none.
        let _ = fs::remove_file(&self.path);
    }
}

/// Runs `sweep`.
pub fn run(args: &SweepArgs) -> Outcome {
    let settings = config::settings(args.config.as_deref())?;
    // Before anything moves: a cloud that cannot be kept is not worth a sweep.
    let file = Unfinished::create(&args.out)?;
    let taken = match client::sweep(&settings.api.socket)? {
        Some((about, ply)) => Taken {
            ply,
            points: about.points,
            quality: about.sweep,
            fault: about.fault,
        },
        None => {
            let cancel = signals::cancel_on_signal()?;
            let sweep = sweep_direct(&settings, &Clock::scaled(args.time_scale), &cancel)?;
            Taken {
                ply: write_ply(&sweep.view.points),
                points: sweep.view.points.len(),
                fault: sweep.quality.fault(settings.sweep.max_missing_lines),
                quality: sweep.quality,
            }
        }
    };
    report(args, file, taken)
}

/// Homes if the head needs it, sweeps as configured, parks. Notes of the devices go to standard error.
///
/// # Errors
/// A device that does not do its part; a sweep that cannot be assembled.
pub fn sweep_direct(settings: &Settings, clock: &Clock, cancel: &Cancel) -> Result<Sweep, Failure> {
    let (notes, heard) = mpsc::channel();
    let mut station =
        Station::open(settings, clock.clone(), notes, cancel).map_err(Failure::failed)?;
    let taken = (|| {
        if !station.position_trusted() {
            station.home(cancel)?;
        }
        let request = SweepRequest::new(&settings.sweep, &settings.mount, &settings.sweep.pans_rad);
        let raw = station.sweep(&request, cancel)?;
        park(&mut station);
        Ok(raw)
    })();
    drop(station);
    for note in heard.try_iter().filter(|n| n.level > NoteLevel::Info) {
        eprintln!("patrold: {}: {}", note.device, note.text);
    }
    let raw = taken.map_err(|error: crate::devices::DeviceError| Failure::failed(error))?;
    assemble(&raw).map_err(Failure::failed)
}

/// Parks. What was measured stands, whatever becomes of the head after it; it is told on standard error.
pub(super) fn park(station: &mut Station) {
    if let Err(error) = station.park() {
        eprintln!("patrold: not parked: {error}");
    }
}

/// Writes the cloud and says what it is worth. A sweep that must not be judged is written all the same, and a failure.
fn report(args: &SweepArgs, file: Unfinished, taken: Taken) -> Outcome {
    let path = args.out.display();
    file.finish(&taken.ply)?;
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

#[cfg(test)]
mod tests {
    use super::Unfinished;
    use std::fs;

    #[test]
    fn a_cloud_appears_whole_or_not_at_all_and_its_place_is_tried_first() {
        let dir = tempfile::tempdir().expect("temp dir");
        let out = dir.path().join("a.ply");
        let left = || fs::read_dir(dir.path()).expect("listed").count();
        drop(
            Unfinished::create(&out)
                .map_err(|e| e.to_string())
                .expect("made"),
        );
        assert_eq!(left(), 0);
        let file = Unfinished::create(&out)
            .map_err(|e| e.to_string())
            .expect("made");
        assert!(!out.exists());
        file.finish(b"ply")
            .map_err(|e| e.to_string())
            .expect("written");
        assert_eq!(
            (fs::read(&out).expect("there"), left()),
            (b"ply".to_vec(), 1)
        );
        assert!(Unfinished::create(dir.path()).is_err());
        assert!(Unfinished::create(&dir.path().join("no/a.ply")).is_err());
    }
}
