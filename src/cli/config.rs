//! `patrold config check|show`: every mistake at once; what is in force and where it came from.

use super::failure::{DONE, Failure, Outcome};
use super::{output, table};
use crate::config::{KEYS, Loaded, Mistake, Origin, load};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `config`.
#[derive(Debug, Args)]
pub struct ConfigArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Tell every mistake at once, with line and nearest valid key
    Check(FileArgs),
    /// Show what is in force and where it came from
    Show(FileArgs),
}

#[derive(Debug, Args)]
struct FileArgs {
    /// Configuration file [default: /etc/patrold/patrold.toml, if there is one]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `config`.
pub fn run(args: &ConfigArgs) -> Outcome {
    match &args.action {
        Action::Check(file) => check(file),
        Action::Show(file) => show(file),
    }
}

fn check(args: &FileArgs) -> Outcome {
    let loaded = load(args.config.as_deref(), &[]);
    let (files, mistakes) = match &loaded {
        Ok(loaded) => (loaded.files.clone(), Vec::new()),
        Err(mistakes) => (Vec::new(), mistakes.clone()),
    };
    if args.json {
        let told: Vec<_> = mistakes.iter().map(mistake_json).collect();
        output::json(&json!({"valid": mistakes.is_empty(), "files": files, "mistakes": told}))?;
        return Ok(if mistakes.is_empty() {
            DONE
        } else {
            super::failure::USAGE
        });
    }
    loaded?;
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    let read = if names.is_empty() {
        "no file, defaults only".to_owned()
    } else {
        names.join(", ")
    };
    output::line(format!("valid: {read}"))?;
    Ok(DONE)
}

fn mistake_json(mistake: &Mistake) -> serde_json::Value {
    json!({"file": mistake.file, "line": mistake.line, "problem": mistake.problem.to_string()})
}

fn show(args: &FileArgs) -> Outcome {
    let loaded = load(args.config.as_deref(), &[])?;
    if args.json {
        output::json(&json!({"files": loaded.files, "settings": settings_json(&loaded)}))?;
        return Ok(DONE);
    }
    let mut rows = table::table(&["key", "value", "unit", "from"]);
    for (name, (value, origin)) in &loaded.layers.values {
        let unit = KEYS.iter().find(|k| k.name == name).map_or("", |k| k.unit);
        rows.add_row([
            name.clone(),
            value.to_string(),
            unit.to_owned(),
            origin_text(origin),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}

fn settings_json(loaded: &Loaded) -> Vec<serde_json::Value> {
    loaded
        .layers
        .values
        .iter()
        .map(|(key, (value, origin))| {
            json!({"key": key, "value": value.to_json(), "from": origin_text(origin)})
        })
        .collect()
}

fn origin_text(origin: &Origin) -> String {
    match origin {
        Origin::Default => "default".to_owned(),
        Origin::File(path, line) => format!("{}:{line}", path.display()),
        Origin::Flag => "command line".to_owned(),
    }
}

/// Reads the configuration for another command.
///
/// # Errors
/// Every mistake in it.
pub fn settings(file: Option<&std::path::Path>) -> Result<crate::config::Settings, Failure> {
    Ok(load(file, &[])?.settings)
}
