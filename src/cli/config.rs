//! `patrold config check|show`: all errors of the configuration; every value in force with its origin.

use super::failure::{CommandResult, DONE, Failure, USAGE};
use super::{output, table};
use crate::config::{ConfigError, KEYS, LoadedConfig, Settings, ValueOrigin, load};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct ConfigArgs {
    #[command(subcommand)]
    action: ConfigAction,
}

#[derive(Debug, Subcommand)]
enum ConfigAction {
    /// List all errors, with file, line and nearest valid key
    Check(ConfigFileArgs),
    /// Show all values in force and where each comes from
    Show(ConfigFileArgs),
}

#[derive(Debug, Args)]
struct ConfigFileArgs {
    /// Configuration file [default: /etc/patrold/patrold.toml, if there is one]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Report as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &ConfigArgs) -> CommandResult {
    match &args.action {
        ConfigAction::Check(file) => check(file),
        ConfigAction::Show(file) => show(file),
    }
}

fn check(args: &ConfigFileArgs) -> CommandResult {
    let loaded = load(args.config.as_deref(), &[]);
    let (files, errors) = match &loaded {
        Ok(loaded) => (loaded.files.clone(), Vec::new()),
        Err(errors) => (Vec::new(), errors.clone()),
    };
    if args.json {
        let records: Vec<_> = errors.iter().map(error_json).collect();
        output::json(&json!({"valid": errors.is_empty(), "files": files, "mistakes": records}))?;
        return Ok(if errors.is_empty() { DONE } else { USAGE });
    }
    loaded?;
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    let sources = if names.is_empty() {
        "no file, defaults only".to_owned()
    } else {
        names.join(", ")
    };
    output::line(format!("valid: {sources}"))?;
    Ok(DONE)
}

fn error_json(error: &ConfigError) -> serde_json::Value {
    json!({"file": error.file, "line": error.line, "problem": error.problem.to_string()})
}

fn show(args: &ConfigFileArgs) -> CommandResult {
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

fn settings_json(loaded: &LoadedConfig) -> Vec<serde_json::Value> {
    loaded
        .layers
        .values
        .iter()
        .map(|(key, (value, origin))| {
            json!({"key": key, "value": value.to_json(), "from": origin_text(origin)})
        })
        .collect()
}

fn origin_text(origin: &ValueOrigin) -> String {
    match origin {
        ValueOrigin::Default => "default".to_owned(),
        ValueOrigin::File(path, line) => format!("{}:{line}", path.display()),
        ValueOrigin::Flag => "command line".to_owned(),
    }
}

/// The configuration of another command.
pub(super) fn load_settings(file: Option<&Path>) -> Result<Settings, Failure> {
    Ok(load(file, &[])?.settings)
}
