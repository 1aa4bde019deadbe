//! `patrold backup DIR` and `patrold restore DIR`.

use super::failure::{CommandResult, DONE, FAILED, Failure};
use super::progress::Work;
use super::store::check_text;
use super::{client, config, output};
use crate::service::{StoreLock, record_time_now};
use crate::store::{BackupResult, Store};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct BackupArgs {
    /// Folder of the backup
    dir: PathBuf,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn back_up(args: &BackupArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let store = Store::open_for_reading(&settings.store.dir)?;
    let work = Work::start("copying");
    let result = store.back_up(&args.dir, |done, all| work.set_steps(done, all))?;
    drop(work);
    report(args, &result, "backed up to")
}

pub(super) fn restore(args: &BackupArgs) -> CommandResult {
    let settings = config::load_settings(args.config.as_deref())?;
    let dir = &settings.store.dir;
    // The service may have another working directory.
    let from = args.dir.canonicalize().unwrap_or_else(|_| args.dir.clone());
    if from.is_absolute()
        && let Some(result) = client::request_restore(&settings.api.socket, &from)?
    {
        return report(args, &result, "restored from");
    }
    let _lock = StoreLock::acquire(dir).map_err(Failure::failed)?;
    let work = Work::start("copying");
    let count = |done, all| work.set_steps(done, all);
    let result = Store::restore(dir, &args.dir, &record_time_now(), count)?;
    drop(work);
    report(args, &result, "restored from")
}

fn report(args: &BackupArgs, result: &BackupResult, what: &str) -> CommandResult {
    if args.json {
        output::json(result)?;
    } else {
        let mut lines = vec![format!(
            "{what} {}: {} evidence files copied ({} bytes), {} were there",
            args.dir.display(),
            result.copied_files,
            result.copied_bytes,
            result.present_files
        )];
        if result.damaged_files > 0 {
            let count = result.damaged_files;
            lines.push(format!(
                "  {count} evidence files are damaged and were not copied"
            ));
        }
        if let Some(path) = &result.old_database {
            lines.push(format!("  the old database is {}", path.display()));
        }
        lines.push(check_text(&result.check));
        output::line(lines.join("\n"))?;
    }
    Ok(if result.check.is_sound() {
        DONE
    } else {
        FAILED
    })
}
