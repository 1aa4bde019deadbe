//! The command: arguments, the archive, what it reports.

use super::collect::{BundlePart, collect};
use super::tar_file;
use crate::cli::failure::{CommandResult, DONE, Failure};
use crate::cli::{files, output};
use clap::Args;
use serde_json::json;
use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

/// The folder in the archive.
const FOLDER: &str = "patrold-diagnose";

#[derive(Debug, Args)]
pub(crate) struct DiagnoseArgs {
    /// The bundle, a tar file; must not exist yet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &DiagnoseArgs) -> CommandResult {
    // Before anything is asked: an existing file, or a link, is never written over.
    let created = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(&args.out);
    let file = created.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => {
            files::file_error(&args.out, "exists already; choose another file")
        }
        _ => files::file_error(&args.out, error),
    })?;
    let written = collect(args.config.as_deref()).and_then(|parts| {
        write_bundle(BufWriter::new(file), &parts)
            .map_err(|error| files::file_error(&args.out, error))?;
        Ok(parts)
    });
    let parts = written.inspect_err(|_| {
        // Half a bundle is none.
        let _ = fs::remove_file(&args.out);
    })?;
    report(args, &parts)?;
    Ok(DONE)
}

fn write_bundle(mut out: impl Write, parts: &[BundlePart]) -> io::Result<()> {
    let now_s = u64::try_from(jiff::Timestamp::now().as_second()).unwrap_or_default();
    let contents = serde_json::to_vec_pretty(&contents(parts))?;
    tar_file::append(
        &mut out,
        &format!("{FOLDER}/contents.json"),
        &contents,
        now_s,
    )?;
    for part in parts {
        if let Ok(bytes) = &part.content {
            tar_file::append(&mut out, &format!("{FOLDER}/{}", part.name), bytes, now_s)?;
        }
    }
    tar_file::finish(&mut out)?;
    out.flush()
}

/// What is in it, and what is not and why.
fn contents(parts: &[BundlePart]) -> serde_json::Value {
    let entry = |part: &BundlePart| match &part.content {
        Ok(bytes) => json!({"name": part.name, "bytes": bytes.len(), "missing_because": null}),
        Err(why) => json!({"name": part.name, "bytes": null, "missing_because": why}),
    };
    parts.iter().map(entry).collect()
}

fn report(args: &DiagnoseArgs, parts: &[BundlePart]) -> Result<(), Failure> {
    if args.json {
        return output::json(&json!({"out": args.out, "parts": contents(parts)}));
    }
    output::line(text(&args.out, parts))
}

fn text(out: &Path, parts: &[BundlePart]) -> String {
    let mut lines = vec![format!(
        "{}: look through it before you send it (tar tf lists it)",
        out.display()
    )];
    for part in parts {
        lines.push(match &part.content {
            Ok(bytes) => format!("  {:<20} {} bytes", part.name, bytes.len()),
            Err(why) => format!("  {:<20} missing: {}", part.name, why.replace('\n', "; ")),
        });
    }
    lines.join("\n")
}
