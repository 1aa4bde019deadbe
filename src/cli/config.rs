//! `patrold config check|show`: all errors of the configuration; every value in force with its origin.

use super::failure::{CommandResult, DONE, Failure, USAGE};
use super::threshold_warning::never_alarming;
use super::{output, table};
use crate::config::{ConfigError, KEYS, LoadedConfig, Settings, load, load_leniently};
use crate::store::Store;
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
    let warnings = loaded.as_ref().map(warnings).unwrap_or_default();
    if args.json {
        let records: Vec<_> = errors.iter().map(error_json).collect();
        output::json(&json!({
            "valid": errors.is_empty(), "files": files, "mistakes": records, "warnings": warnings
        }))?;
        return Ok(if errors.is_empty() { DONE } else { USAGE });
    }
    loaded?;
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    output::line(format!("valid: {}", sources_text(&names)))?;
    for warning in &warnings {
        output::warning(warning);
    }
    Ok(DONE)
}

/// What is valid and can hardly be meant, a line each: values by themselves, and thresholds that no alarm of the log reaches.
fn warnings(loaded: &LoadedConfig) -> Vec<String> {
    let mut lines: Vec<String> = loaded.warnings().iter().map(ToString::to_string).collect();
    // Where there is no log yet, it has nothing to say.
    if let Ok(store) = Store::open_for_reading(&loaded.settings.store.dir) {
        match never_alarming(&loaded.settings, &store) {
            Ok(more) => lines.extend(more),
            Err(failure) => lines.push(format!("the log cannot be read: {failure}")),
        }
    }
    lines
}

/// Files of a configuration, for people.
pub(super) fn sources_text(names: &[String]) -> String {
    if names.is_empty() {
        "no file, defaults only".to_owned()
    } else {
        names.join(", ")
    }
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
            origin.to_string(),
        ]);
    }
    output::line(rows.to_string())?;
    Ok(DONE)
}

pub(super) fn settings_json(loaded: &LoadedConfig) -> Vec<serde_json::Value> {
    loaded
        .layers
        .values
        .iter()
        .map(|(key, (value, origin))| {
            json!({"key": key, "value": value.to_json(), "from": origin.to_string()})
        })
        .collect()
}

/// The configuration of a command that needs little of it, such as one that reads the log: mistakes stop nothing and are reported in
/// one line.
pub(super) fn load_leniently_for(what: &str, file: Option<&Path>) -> Result<Settings, Failure> {
    let (settings, mistakes) = load_leniently(file)?;
    if let Some(first) = mistakes.first() {
        output::warning(&format!(
            "{first}; {what} all the same ({} mistake(s), see patrold config check)",
            mistakes.len()
        ));
    }
    Ok(settings)
}

/// The configuration of a command that reads the log.
pub(super) fn load_for_reading(file: Option<&Path>) -> Result<Settings, Failure> {
    load_leniently_for("the log is read", file)
}

/// The configuration of another command.
pub(super) fn load_settings(file: Option<&Path>) -> Result<Settings, Failure> {
    Ok(load(file, &[])?.settings)
}
