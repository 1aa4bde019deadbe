//! What keeps the watch from seeing, as `patrold status` and the event log show it.

use super::faulty_disk::FaultyDisk;
use super::harness::{ScriptedScanner, ScriptedSweep, TestService, configure, parts};
use super::{BEFORE, events, process, schema};
use patrold::service::ServiceParts;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

fn start(dir: &Path, disk: &FaultyDisk) -> TestService {
    let scanner = ScriptedScanner::new(BEFORE);
    let parts = ServiceParts {
        disk: Arc::new(disk.clone()),
        ..parts(dir, &scanner)
    };
    TestService::start_with(dir, &scanner, parts)
}

/// Subjects and reasons of what stands, as `status` reports them.
fn health(dir: &Path) -> Vec<(String, String)> {
    let run = process::patrold(dir, &["status", "--json"])
        .output()
        .expect("runs");
    let status: Value = serde_json::from_slice(&run.stdout).expect("JSON");
    if status["service"]["running"] == false {
        // The scripted devices say less of themselves than real ones.
        schema::check("status-report", &status);
    }
    let text = |row: &Value, key: &str| row[key].as_str().expect("a text").to_owned();
    let rows = status["health"].as_array().expect("a list");
    rows.iter()
        .map(|row| (text(row, "subject"), text(row, "reason")))
        .collect()
}

/// Until exactly this stands.
fn until_stands(service: &TestService, expected: &[(&str, &str)]) {
    service.until(&format!("{expected:?}"), |service| {
        let now = health(&service.dir);
        let is = |(now, expected): (&(String, String), &(&str, &str))| {
            now.0 == expected.0 && now.1.contains(expected.1)
        };
        now.len() == expected.len() && now.iter().zip(expected).all(is)
    });
}

#[test]
fn what_the_scanner_reports_stands_until_it_is_over() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = start(dir.path(), &FaultyDisk::default());
    assert_eq!(service.post("/teach", "hall").status, 200);
    until_stands(&service, &[]);
    for (sweep, reason) in [
        (ScriptedSweep::Blind, "blind"),
        (ScriptedSweep::Frozen, "frozen"),
        (
            ScriptedSweep::Fail("laser: silent for 2 s; check its cable", false),
            "laser: silent",
        ),
    ] {
        let visit = service.visit(sweep);
        assert_eq!(visit["verdict"], "not_observed", "{visit}");
        until_stands(&service, &[("sweep", reason)]);
        assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
        until_stands(&service, &[]);
    }
    service.visit(ScriptedSweep::Fail("ptu: in slaved mode", true));
    until_stands(&service, &[]);
    service.scanner.script().sweep = BEFORE;
    service.scanner.script().absent = Some("ptu: in step mode; power it off and on");
    service.scanner.script().unplugged = Some("laser: has gone");
    until_stands(&service, &[("devices", "ptu: in step mode")]);
    service.scanner.script().absent = None;
    service.scanner.script().unplugged = None;
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    until_stands(&service, &[]);
    let logged = events(&service);
    for text in ["sweep: over", "devices: laser: has gone", "devices: over"] {
        assert!(
            logged.iter().any(|event| event == text),
            "{text}: {logged:?}"
        );
    }
    service.stop();
}

#[test]
fn a_store_without_space_stands_until_it_has_some() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let disk = FaultyDisk::default();
    // The reserve and a little more.
    disk.steps().free_bytes = Some(40 << 20);
    let service = start(dir.path(), &disk);
    until_stands(&service, &[("storage", "low space: 41 MB are free")]);
    service.stop();
    assert_eq!(
        health(dir.path()).len(),
        1,
        "also where the service is down"
    );
    disk.steps().free_bytes = None;
    let service = start(dir.path(), &disk);
    until_stands(&service, &[]);
    let logged = events(&service);
    assert!(
        logged.iter().any(|event| event == "storage: over"),
        "{logged:?}"
    );
    service.stop();
}
