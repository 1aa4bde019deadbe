//! What `evaluate` and `reproduce` share: the clock, choices by name, the output folder, tables and the report.

use super::failure::Failure;
use super::{files, output, table};
use comfy_table::{Table, presets};
use serde::Serialize;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Time since the start of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunClock(Instant);

impl RunClock {
    /// Starts now.
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    pub(super) fn millis(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }

    /// Seconds since the start.
    pub(super) fn seconds(&self) -> f64 {
        self.millis() / 1e3
    }
}

/// The one of `all` that is called `text`; else an error that lists the names.
pub(super) fn by_name<T: Copy>(
    all: &[T],
    name: impl Fn(T) -> &'static str,
    text: &str,
) -> Result<T, String> {
    let names = || all.iter().map(|t| name(*t)).collect::<Vec<_>>().join(", ");
    let found = all.iter().copied().find(|t| name(*t) == text);
    found.ok_or_else(|| format!("expected one of: {}", names()))
}

/// Creates `folder` and those above it.
pub(super) fn create_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| files::file_error(folder, error))
}

/// A table in Markdown.
pub(super) fn markdown_table(headings: &[&str]) -> Table {
    let mut table = table::table(headings);
    table.load_style(presets::ASCII_MARKDOWN);
    table
}

/// A number with so many decimals; `-` where there is none.
pub(super) fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".to_owned(), |v| format!("{v:.decimals$}"))
}

/// Writes the report as JSON, or its tables.
pub(super) fn write_report(
    report: &impl Serialize,
    tables: impl FnOnce() -> String,
    json: bool,
) -> Result<(), Failure> {
    if json {
        output::json(report)
    } else {
        output::line(tables())
    }
}
