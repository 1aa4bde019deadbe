//! The built program under clocks that jump, and stopped as by a suspend. `PATROLD_FAKETIME` names libfaketime's library, which
//! `.ci/run` fetches; without it the tests of the wall clock say that they did not run.

use super::process::{NotifySocket, configure, patrold, run_under_systemd, signal, terminate};
use super::{BEFORE, ScriptedScanner, TestService};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The library that shows programs another wall clock, and leaves the monotonic one alone.
fn faketime() -> Option<PathBuf> {
    let library = std::env::var_os("PATROLD_FAKETIME").map(PathBuf::from);
    if library.is_none() {
        eprintln!("skipped: PATROLD_FAKETIME is not set");
    }
    library
}

/// A service without devices, whose wall clock is what the file says.
struct Clocked {
    dir: PathBuf,
    clock: PathBuf,
    library: PathBuf,
    child: Child,
}

impl Clocked {
    /// In a folder with a taught waypoint.
    fn start(dir: &Path, library: &Path, at: &str, more: &str) -> Self {
        let clock = dir.join("clock");
        std::fs::write(&clock, at).expect("written");
        configure(dir, more);
        let notify = NotifySocket::listen(dir);
        let mut command = patrold(dir, &["run"]);
        let child = with_clock(&mut command, library, &clock)
            .env("NOTIFY_SOCKET", dir.join("notify"))
            .stderr(Stdio::null())
            .spawn()
            .expect("starts");
        notify.wait_for("READY=1");
        notify.wait_for("STATUS=devices lost");
        Self {
            dir: dir.to_owned(),
            clock,
            library: library.to_owned(),
            child,
        }
    }

    /// Sets the wall clock.
    fn set(&self, at: &str) {
        // In one step: a half-written time is none.
        let aside = self.clock.with_extension("new");
        std::fs::write(&aside, at).expect("written");
        std::fs::rename(&aside, &self.clock).expect("renamed");
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let mut command = patrold(&self.dir, arguments);
        let output = with_clock(&mut command, &self.library, &self.clock)
            .output()
            .expect("runs");
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
    }

    /// Visits the hall, which nobody can look at.
    fn visit(&self) {
        let visit = self.json(&["visit", "hall", "--json"]);
        assert_eq!(visit["verdict"], "not_observed", "{visit}");
    }

    /// Subjects of the health incidents that stand.
    fn health(&self) -> Vec<String> {
        let status = self.json(&["status", "--json"]);
        let health = status["health"].as_array().expect("a list");
        let subject = |h: &Value| h["subject"].as_str().expect("a text").to_owned();
        health.iter().map(subject).collect()
    }

    fn until(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            assert!(start.elapsed() < Duration::from_secs(60), "never: {what}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn stop(mut self) {
        signal(&self.child, "-TERM");
        assert_eq!(self.child.wait().expect("ends").code(), Some(0));
    }
}

fn with_clock<'a>(command: &'a mut Command, library: &Path, clock: &Path) -> &'a mut Command {
    command
        .env("LD_PRELOAD", library)
        .env("FAKETIME_TIMESTAMP_FILE", clock)
        .env("FAKETIME_NO_CACHE", "1")
        .env("FAKETIME_DONT_FAKE_MONOTONIC", "1")
        .env("TZ", "UTC")
}

fn taught(dir: &Path) {
    super::configure(dir, "");
    let service = TestService::start(dir, &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    service.stop();
}

/// Without a battery the clock begins in 1970; the network sets it minutes later, and once more, back by an hour.
#[test]
fn the_log_keeps_its_order_and_its_sweeps_whatever_the_clock_does() {
    let Some(library) = faketime() else { return };
    let dir = tempfile::tempdir().expect("temp dir");
    taught(dir.path());
    let more = "store.keep_days = 1\nstore.keep_gib = 0\n";
    let service = Clocked::start(dir.path(), &library, "@1970-01-01 00:00:10", more);
    service.visit();
    assert!(!service.health().contains(&"clock".to_owned()));
    service.set("@2040-06-01 12:00:00");
    service.until("the step is noted", |s| {
        s.health().contains(&"clock".to_owned())
    });
    service.visit();
    service.set("@2040-06-01 11:00:00");
    service.visit();

    let visits = service.json(&["visits", "--json"]);
    let visits = visits["visits"].as_array().expect("a list").clone();
    let ids: Vec<i64> = visits.iter().filter_map(|v| v["id"].as_i64()).collect();
    let newest_first: Vec<i64> = (1..=4).rev().collect();
    assert_eq!(
        ids, newest_first,
        "as they were made, not as the clock said"
    );
    let unset: Vec<bool> = visits
        .iter()
        .filter_map(|v| v["clock_unset"].as_bool())
        .collect();
    assert_eq!(unset, [false, false, true, false]);
    // A filter by time never drops what has no time.
    let since = service.json(&["visits", "--since", "2040-01-01", "--json"]);
    let since = since["visits"].as_array().expect("a list");
    let since: Vec<i64> = since.iter().filter_map(|v| v["id"].as_i64()).collect();
    assert_eq!(since, [4, 3, 2]);
    // The quiet visit is fourteen years old by this clock; nothing goes until the clock was right for an hour.
    let evidence = std::fs::read_dir(dir.path().join("store/blobs")).map(Iterator::count);
    assert!(evidence.is_ok_and(|files| files > 0));
    let kept = service.json(&["visits", "show", "1", "--json"]);
    assert_eq!(kept["verdict"], "quiet", "{kept}");
    service.stop();
}

/// The guards' clock changes by an hour: what is stored is UTC and says nothing of it.
#[test]
fn the_hour_that_comes_twice_has_an_order() {
    let Some(library) = faketime() else { return };
    let dir = tempfile::tempdir().expect("temp dir");
    taught(dir.path());
    let service = Clocked::start(dir.path(), &library, "@2040-10-28 00:30:00", "");
    service.visit();
    service.set("@2040-10-28 01:30:00");
    service.visit();
    let mut command = patrold(dir.path(), &["visits"]);
    let output = with_clock(&mut command, &library, &service.clock)
        .env("TZ", "CET-1CEST,M3.5.0,M10.5.0/3")
        .output()
        .expect("runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let [summer, winter] = ["02:30:", "02:30:"].map(|hour| text.matches(hour).count());
    assert_eq!((summer, winter), (2, 2), "{text}");
    for zone in ["CEST", "CET"] {
        let named = text.split_whitespace().any(|word| word == zone);
        assert!(named, "the zone tells the hours apart: {text}");
    }
    service.stop();
}

/// Stopped for longer than the watchdog waits, as a suspend does: it goes on where it was.
#[test]
fn a_service_that_was_stopped_goes_on() {
    let dir = tempfile::tempdir().expect("temp dir");
    let dir = dir.path();
    configure(dir, "");
    let (notify, child) = run_under_systemd(dir);
    notify.wait_for("READY=1");
    notify.wait_for("STATUS=devices lost");
    signal(&child, "-STOP");
    std::thread::sleep(Duration::from_secs(2));
    signal(&child, "-CONT");
    for _ in 0..20 {
        notify.wait_for("WATCHDOG=1");
    }
    let status = patrold(dir, &["status", "--json"]).output().expect("runs");
    let status: Value = serde_json::from_slice(&status.stdout).expect("a status");
    assert_eq!(
        status["service"]["status"]["phase"], "devices lost",
        "{status}"
    );
    let log = terminate(child);
    assert!(!log.contains("timed out"), "{log}");
}
