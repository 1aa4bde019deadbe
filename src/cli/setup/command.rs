//! The command: arguments, the drop-in, the sweep and its pictures, the calibration.

use super::picture::{Side, picture};
use super::search::{FoundDevices, find};
use crate::cli::calibrate::take_sweeps;
use crate::cli::calibration_report::{has_proposals, report_json, report_lines};
use crate::cli::client::NoStatus;
use crate::cli::failure::{CommandResult, DONE, FAILED, Failure};
use crate::cli::sweep::take_sweep;
use crate::cli::{client, drop_in, files, output, signals, value_parsers};
use crate::config::{LoadedConfig, Settings, ValueOrigin, devices_drop_in, drop_in_folder, load};
use clap::Args;
use link::Clock;
use patrold_engine::sweep::{Calibration, Sweep, assemble, calibrate};
use rustix::fs::Access;
use rustix::io::Errno;
use serde_json::{Value, json};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file that names the devices; those of the site come later and win.
const DROP_IN: &str = "10-devices.toml";

/// Where a person puts what is right of the proposals: this command does not write it.
const MOUNT_FILE: &str = "20-mount.toml";

#[derive(Debug, Args)]
pub(crate) struct SetupArgs {
    /// Folder of the pictures, patrold-above.svg and patrold-side.svg
    #[arg(long, value_name = "DIR", default_value = ".")]
    pictures: PathBuf,
    /// Take one sweep only, and propose nothing about the mount
    #[arg(long)]
    no_calibration: bool,
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

pub(crate) fn run(args: &SetupArgs) -> CommandResult {
    check_rights(args.config.as_deref())?;
    let settings = settings_without_earlier_laser(args.config.as_deref())?;
    match client::request_status(&settings.api.socket)? {
        Err(NoStatus { is_down: true, .. }) => {}
        Err(NoStatus { why, .. }) => return Err(Failure::Failed(why)),
        Ok(_) => {
            let text =
                "the service runs and has the devices; stop it first: systemctl stop patrold";
            return Err(Failure::Failed(text.to_owned()));
        }
    }
    fs::create_dir_all(&args.pictures).map_err(|error| files::file_error(&args.pictures, error))?;
    let clock = Clock::scaled(args.time_scale);
    let cancel = signals::cancel_on_signal()?;
    let found = find(&settings, &clock, &cancel)?;
    say(args, &devices_text(&found))?;
    let before = read_before(args.config.as_deref())?;
    let (drop_in, settings) = name_devices(args.config.as_deref(), &found)?;
    let replaced = keep_replaced(&drop_in, before)?;
    let kept = replaced.iter().map(|old| {
        let old = old.display();
        format!("; what was there is kept as {old}, which nothing reads")
    });
    let written = format!("written: {}{}", drop_in.display(), kept.collect::<String>());
    say(args, &written)?;

    let (sweep, calibration) = if args.no_calibration {
        (take_sweep(&settings, &clock, &cancel)?, None)
    } else {
        let sweeps = take_sweeps(&settings, true, None, clock, &cancel)?;
        let first = sweeps.first().map(assemble);
        let first = first.ok_or_else(|| Failure::Failed("no sweep was taken".to_owned()))?;
        (
            first.map_err(Failure::failed)?,
            Some(calibrate(&sweeps, None)),
        )
    };
    let pictures = write_pictures(&args.pictures, &sweep)?;
    let fault = sweep.quality.fault(settings.sweep.max_missing_lines);
    let calibration = calibration.map(|result| result.map_err(|error| error.to_string()));
    let failed = matches!(calibration, Some(Err(_))) || fault.is_some();
    if args.json {
        let (found_mount, why_not) = match &calibration {
            Some(Ok(calibration)) => (report_json(calibration, 0), None),
            Some(Err(why)) => (Value::Null, Some(why)),
            None => (Value::Null, None),
        };
        output::json(&json!({
            "laser": found.laser,
            "ptu": found.head,
            "drop_in": drop_in,
            "replaced": replaced,
            "points": sweep.view.points.len(),
            "quality": sweep.quality,
            "fault": fault,
            "pictures": pictures,
            "config": found_mount["config"],
            "no_calibration_because": why_not,
        }))?;
    } else {
        let lines = result_lines(&pictures, fault.as_deref(), calibration.as_ref(), &drop_in);
        output::line(lines.join("\n"))?;
    }
    Ok(if failed { FAILED } else { DONE })
}

/// The folder of the drop-in is written to, or the nearest above it that is there, and the service is asked: who may do the one
/// may do the other.
fn check_rights(config: Option<&Path>) -> Result<(), Failure> {
    let folder = std::path::absolute(drop_in_folder(config)).map_err(Failure::failed)?;
    let existing = folder.ancestors().find(|folder| folder.exists());
    let access = Access::WRITE_OK | Access::EXEC_OK;
    match existing.map(|existing| rustix::fs::access(existing, access)) {
        Some(Err(Errno::ACCESS)) => Err(Failure::Failed(format!(
            "setup writes to {}, which this user may not: run it as root",
            folder.display()
        ))),
        _ => Ok(()),
    }
}

/// A laser that an earlier setup named may be another one now; one that a person named may not.
fn settings_without_earlier_laser(config: Option<&Path>) -> Result<Settings, Failure> {
    let LoadedConfig {
        mut settings,
        layers,
        ..
    } = load(config, &[])?;
    let own = drop_in_folder(config).join(DROP_IN);
    if let Some((_, ValueOrigin::File(path, _))) = layers.values.get("laser.serial")
        && *path == own
    {
        settings.laser.serial = Settings::defaults().laser.serial;
    }
    Ok(settings)
}

/// What the drop-in has before; empty where there is none.
fn read_before(config: Option<&Path>) -> Result<Vec<u8>, Failure> {
    let path = drop_in_folder(config).join(DROP_IN);
    match fs::read(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        read => read.map_err(|error| files::file_error(&path, error)),
    }
}

/// Keeps what was in the drop-in `before` beside it, if it has something else now.
fn keep_replaced(drop_in: &Path, before: Vec<u8>) -> Result<Option<PathBuf>, Failure> {
    let now = fs::read(drop_in).map_err(|error| files::file_error(drop_in, error))?;
    if before.is_empty() || before == now {
        return Ok(None);
    }
    let old = drop_in.with_extension("toml.old");
    files::write(&old, &before)?;
    Ok(Some(old))
}

fn say(args: &SetupArgs, text: &str) -> Result<(), Failure> {
    if args.json {
        Ok(())
    } else {
        output::line(text)
    }
}

fn devices_text(found: &FoundDevices) -> String {
    format!(
        "laser: {}, serial {}, on {}\npan-tilt: {}, on {}",
        found.laser.product,
        found.laser.serial,
        found.settings.laser.port,
        found.head.firmware,
        found.settings.ptu.port
    )
}

/// Writes which devices these are, and reads the configuration with it.
fn name_devices(
    config: Option<&Path>,
    found: &FoundDevices,
) -> Result<(PathBuf, Settings), Failure> {
    let text = devices_drop_in(&found.settings, &found.laser.serial);
    drop_in::put(config, DROP_IN, &text, || {
        let settings = load(config, &[])?.settings;
        let (wanted, got) = (&found.settings, &settings);
        if (&wanted.laser.port, &wanted.ptu.port) == (&got.laser.port, &got.ptu.port) {
            return Ok(settings);
        }
        let differs = [
            ("laser.port", wanted.laser.port != got.laser.port),
            ("ptu.port", wanted.ptu.port != got.ptu.port),
        ];
        let differs = differs.into_iter().filter(|(_, differs)| *differs);
        let settings: Vec<String> = differs.map(|(key, _)| got.origins.quote(key)).collect();
        Err(Failure::Usage(format!(
            "a file of the configuration that comes after {DROP_IN} names other ports ({}, {}): {}; take them out there",
            got.laser.port,
            got.ptu.port,
            settings.join(", and ")
        )))
    })
}

fn write_pictures(folder: &Path, sweep: &Sweep) -> Result<[PathBuf; 2], Failure> {
    let pictures = [
        (folder.join("patrold-above.svg"), Side::Above),
        (folder.join("patrold-side.svg"), Side::Right),
    ];
    for (path, side) in &pictures {
        files::write(path, picture(&sweep.view, *side).as_bytes())?;
    }
    Ok(pictures.map(|(path, _)| path))
}

fn result_lines(
    pictures: &[PathBuf; 2],
    fault: Option<&str>,
    calibration: Option<&Result<Calibration, String>>,
    drop_in: &Path,
) -> Vec<String> {
    let [above, side] = pictures.each_ref().map(|path| path.display());
    let mut lines = vec![format!(
        "look at {above} and {side}: they say what must be seen"
    )];
    if let Some(fault) = fault {
        lines.push(format!("the sweep is not good enough for a visit: {fault}"));
    }
    match calibration {
        None => {}
        Some(Ok(calibration)) => lines.extend(report_lines(calibration)),
        Some(Err(why)) => lines.push(format!(
            "no calibration: {why}; measure mount.xyz_m by hand, or take another place"
        )),
    }
    let start = "start the service, then patrold teach NAME";
    lines.push(match calibration {
        Some(Ok(calibration)) if has_proposals(calibration) => format!(
            "next: write the lines that are right to {}, {start}",
            drop_in.with_file_name(MOUNT_FILE).display()
        ),
        _ => format!("next: {start}"),
    });
    lines
}
