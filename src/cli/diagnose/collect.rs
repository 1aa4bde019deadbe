//! What goes into the bundle. Each part stands alone: one that cannot be had is named with the reason, and the others are there.

use crate::cli::alarm_report::alarm_json;
use crate::cli::client::{NoStatus, request_status};
use crate::cli::config::settings_json;
use crate::cli::devices::device_json;
use crate::cli::failure::Failure;
use crate::cli::{signals, status};
use crate::config::{Settings, load, load_leniently};
use crate::devices::{Station, inventory};
use crate::store::{AlarmFilter, EventFilter, Store, TimeRange, VisitFilter};
use link::Clock;
use serde::Serialize;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc;

/// Newest events, visits and alarms.
const MAX_EVENTS: u32 = 2000;
const MAX_VISITS: u32 = 500;
const MAX_ALARMS: u32 = 500;
/// Newest lines of the system's journal.
const MAX_JOURNAL_LINES: &str = "5000";
/// A key of the configuration with one of these in its name has a value that is nobody else's business.
const SECRETS: [&str; 4] = ["password", "secret", "token", "credential"];

/// A file of the bundle, or why there is none.
pub(super) struct BundlePart {
    pub(super) name: &'static str,
    pub(super) content: Result<Vec<u8>, String>,
}

/// All parts, in the order of the bundle.
///
/// # Errors
/// A configuration file that cannot be read at all: nobody knows where the store is.
pub(super) fn collect(config: Option<&Path>) -> Result<Vec<BundlePart>, Failure> {
    let (settings, mistakes) = load_leniently(config)?;
    let mistakes: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
    let part = |name, content: Result<Vec<u8>, Failure>| BundlePart {
        name,
        content: content.map_err(|failure| failure.to_string()),
    };
    Ok(vec![
        part("about.txt", Ok(about().into_bytes())),
        part("configuration.json", configuration(config, &mistakes)),
        part(
            "status.json",
            status::report(config).and_then(|report| one(&report)),
        ),
        part("devices.json", devices(&settings)),
        part("events.jsonl", events(&settings)),
        part("visits.jsonl", visits(&settings)),
        part("alarms.jsonl", alarms(&settings)),
        part("store.txt", store_files(&settings.store.dir)),
        part("unit.txt", unit()),
        part("journal.txt", journal()),
    ])
}

fn one(value: &impl Serialize) -> Result<Vec<u8>, Failure> {
    let mut text = serde_json::to_vec_pretty(value).map_err(Failure::failed)?;
    text.push(b'\n');
    Ok(text)
}

fn lines<T: Serialize>(values: impl IntoIterator<Item = T>) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    for value in values {
        serde_json::to_writer(&mut text, &value).map_err(Failure::failed)?;
        text.push(b'\n');
    }
    Ok(text)
}

fn about() -> String {
    let file = |path: &str| fs::read_to_string(path).unwrap_or_default();
    format!(
        "patrold {}\nat {}\nuser id {}\nuptime {}{}\n{}",
        env!("CARGO_PKG_VERSION"),
        jiff::Timestamp::now(),
        rustix::process::getuid().as_raw(),
        file("/proc/uptime"),
        file("/proc/version"),
        file("/etc/os-release"),
    )
}

/// Values, not files: comments of a file may hold anything.
fn configuration(config: Option<&Path>, mistakes: &[String]) -> Result<Vec<u8>, Failure> {
    let loaded = load(config, &[]).ok();
    let settings: Vec<Value> = loaded
        .iter()
        .flat_map(settings_json)
        .map(without_secret)
        .collect();
    let files = loaded.map(|loaded| loaded.files);
    one(&json!({"files": files, "mistakes": mistakes, "settings": settings}))
}

fn without_secret(mut setting: Value) -> Value {
    let key = setting["key"].as_str().unwrap_or_default().to_lowercase();
    if SECRETS.iter().any(|secret| key.contains(secret)) {
        setting["value"] = "(not shown)".into();
    }
    setting
}

/// All ports; and the devices themselves where no service has them: the status has what it knows of them.
fn devices(settings: &Settings) -> Result<Vec<u8>, Failure> {
    let ports = inventory(settings).map_err(Failure::failed)?;
    let status = request_status(&settings.api.socket)?;
    let is_down = matches!(status, Err(NoStatus { is_down: true, .. }));
    let mut found = json!({"ports": ports, "service_has_them": !is_down});
    if is_down {
        let (notes, _) = mpsc::channel();
        let cancel = signals::cancel_on_signal()?;
        let survey =
            Station::survey(settings, Clock::real(), notes, &cancel).map_err(Failure::failed)?;
        found["laser"] = device_json(&survey.laser, &settings.laser.port);
        found["ptu"] = device_json(&survey.ptu, &settings.ptu.port);
        found["sweep_notes"] = json!(survey.sweep_notes);
    }
    one(&found)
}

fn events(settings: &Settings) -> Result<Vec<u8>, Failure> {
    let store = Store::open_for_reading(&settings.store.dir)?;
    lines(store.events(EventFilter::from(MAX_EVENTS))?)
}

fn visits(settings: &Settings) -> Result<Vec<u8>, Failure> {
    let store = Store::open_for_reading(&settings.store.dir)?;
    lines(store.visits(&VisitFilter {
        range: TimeRange::default(),
        waypoint: None,
        verdict: None,
        limit: MAX_VISITS,
    })?)
}

fn alarms(settings: &Settings) -> Result<Vec<u8>, Failure> {
    let store = Store::open_for_reading(&settings.store.dir)?;
    let filter = AlarmFilter {
        limit: Some(MAX_ALARMS),
        ..AlarmFilter::default()
    };
    let alarms = store.alarms(&filter)?;
    lines(alarms.iter().map(|alarm| alarm_json(alarm, settings)))
}

/// Names, sizes, owners and modes; of the evidence how much there is.
fn store_files(dir: &Path) -> Result<Vec<u8>, Failure> {
    let entries = |dir: &Path| {
        let failed = |error| Failure::Failed(format!("{}: {error}", dir.display()));
        let read = fs::read_dir(dir).map_err(failed)?;
        let mut all: Vec<_> = read.flatten().collect();
        all.sort_by_key(fs::DirEntry::file_name);
        Ok::<_, Failure>(all)
    };
    let mut text = format!("{}\n", dir.display());
    for entry in entries(dir)? {
        let Ok(file) = entry.metadata() else { continue };
        text.push_str(&format!(
            "{:o} {}:{} {:>12} {} {}\n",
            file.mode(),
            file.uid(),
            file.gid(),
            file.len(),
            file.mtime(),
            entry.file_name().to_string_lossy()
        ));
    }
    let blobs = entries(&dir.join("blobs")).unwrap_or_default();
    let bytes: u64 = blobs
        .iter()
        .filter_map(|e| e.metadata().ok())
        .map(|m| m.len())
        .sum();
    text.push_str(&format!("blobs: {} files, {bytes} bytes\n", blobs.len()));
    Ok(text.into_bytes())
}

fn unit() -> Result<Vec<u8>, Failure> {
    let mut text = output_of("systemctl", &["cat", "patrold.service"])?;
    text.extend(output_of("systemctl", &["show", "patrold.service"])?);
    Ok(without_environment(&text).into_bytes())
}

/// The environment of a service may have what is secret.
fn without_environment(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    let shown = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("Environment"));
    shown.map(|line| format!("{line}\n")).collect()
}

fn journal() -> Result<Vec<u8>, Failure> {
    let arguments = [
        "-u",
        "patrold",
        "-n",
        MAX_JOURNAL_LINES,
        "-o",
        "short-iso",
        "--no-pager",
    ];
    let text = output_of("journalctl", &arguments)?;
    if is_empty_journal(&text) {
        let why = "no entry of patrold that this user may read; run this as root, or as a member of systemd-journal or adm";
        return Err(Failure::Failed(why.to_owned()));
    }
    Ok(text)
}

/// journalctl exits with 0 also where this user may read none of the entries.
fn is_empty_journal(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text);
    let mut entries = text.lines().filter(|line| !line.starts_with("-- "));
    entries.next().is_none()
}

fn output_of(program: &str, arguments: &[&str]) -> Result<Vec<u8>, Failure> {
    let failed = |why: &dyn std::fmt::Display| Failure::Failed(format!("{program}: {why}"));
    let ran = Command::new(program)
        .args(arguments)
        .output()
        .map_err(|e| failed(&e))?;
    if ran.status.success() {
        return Ok(ran.stdout);
    }
    let why = String::from_utf8_lossy(&ran.stderr);
    Err(failed(&why.trim().replace('\n', "; ")))
}

#[cfg(test)]
mod tests {
    use super::{is_empty_journal, without_environment, without_secret};
    use serde_json::json;

    #[test]
    fn a_journal_without_entries_is_missing() {
        assert!(is_empty_journal(b"-- No entries --\n") && is_empty_journal(b""));
        let one =
            b"-- Boot 0123 --\n2026-11-30T13:22:50+0000 robot patrold[138]: service: started\n";
        assert!(!is_empty_journal(one));
    }

    #[test]
    fn what_is_secret_is_not_shown() {
        let shown =
            without_secret(json!({"key": "serve.mqtt_Password", "value": "hunter2", "from": "x"}));
        assert_eq!(shown["value"], "(not shown)");
        let shown = without_secret(json!({"key": "laser.port", "value": "/dev/x", "from": "x"}));
        assert_eq!(shown["value"], "/dev/x");
        let unit = b"[Service]\nUser=patrold\n  Environment=A=b\nEnvironmentFile=/x\nUMask=0007\n";
        assert_eq!(
            without_environment(unit),
            "[Service]\nUser=patrold\nUMask=0007\n"
        );
    }
}
