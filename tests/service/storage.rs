//! A disk that fails under a running service: verdicts are answered, held and stored later.

use super::faulty_disk::{Fault, FaultyDisk};
use super::harness::{ScriptedScanner, TestService, configure, parts};
use super::{AFTER, BEFORE, events};
use patrold::service::ServiceParts;
use patrold::store::{AlarmFilter, Store};
use std::path::Path;
use std::sync::Arc;

fn start(dir: &Path) -> (TestService, FaultyDisk) {
    configure(dir, "");
    let (scanner, disk) = (ScriptedScanner::new(BEFORE), FaultyDisk::default());
    let parts = ServiceParts {
        disk: Arc::new(disk.clone()),
        ..parts(dir, &scanner)
    };
    let service = TestService::start_with(dir, &scanner, parts);
    let taught = service.post("/teach", "hall");
    assert_eq!(taught.status, 200, "{}", taught.json());
    (service, disk)
}

#[test]
fn a_change_on_a_full_disk_is_answered_held_and_stored_later() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, disk) = start(dir.path());
    disk.fail(Fault::Full, 0, true);
    let changed = service.visit(AFTER);
    assert_eq!(changed["verdict"], "changed");
    assert_eq!(changed["stored"], false);
    assert!(changed["visit_id"].is_null() && changed["alarm"].is_null());
    let why = changed["not_stored_because"].as_str().expect("why");
    assert!(why.contains("the disk is full; make room"), "{why}");
    assert!(changed["novelties"][0]["kind"] == "appeared");
    disk.heal();
    let quiet = service.visit(BEFORE);
    assert_eq!(quiet["stored"], true);
    assert_eq!(quiet["cleared"].as_array().map(Vec::len), Some(1));
    let store = Store::open_for_reading(&service.dir.join("store")).expect("reader");
    let alarms = store.alarms(&AlarmFilter::default()).expect("alarms");
    assert_eq!(
        alarms.len(),
        1,
        "stored before the quiet visit, which cleared it"
    );
    assert_eq!(alarms[0].state, "cleared");
    assert!(store.visit(alarms[0].visit_id).is_ok(), "with its evidence");
    drop(store);
    service.stop();
    let store_dir = dir.path().join("store");
    let log = std::fs::metadata(store_dir.join("patrold.db-wal")).map_or(0, |file| file.len());
    assert_eq!(log, 0, "the database is whole by itself");
}

#[test]
fn whatever_the_disk_fails_with_a_change_is_answered_and_stored_later() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, disk) = start(dir.path());
    let faults = [
        Fault::Quota,
        Fault::Failing,
        Fault::ReadOnly,
        Fault::ShortWrite,
        Fault::Busy,
    ];
    for fault in faults {
        disk.fail(fault, 0, true);
        disk.steps().only = Some("Begin".to_owned());
        let changed = service.visit(AFTER);
        let answer = (&changed["verdict"], &changed["stored"]);
        assert_eq!(answer, (&"changed".into(), &false.into()), "{fault:?}");
        disk.heal();
        let cleared = service.visit(BEFORE)["cleared"].clone();
        assert_eq!(cleared.as_array().map(Vec::len), Some(1), "{fault:?}");
    }
    service.stop();
}

#[test]
fn a_change_while_another_program_holds_the_lock_is_answered_held_and_stored_later() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, _) = start(dir.path());
    let other = rusqlite::Connection::open(dir.path().join("store/patrold.db")).expect("opens");
    other.execute_batch("BEGIN IMMEDIATE").expect("locked");
    let changed = service.visit(AFTER);
    let answer = (&changed["verdict"], &changed["stored"]);
    assert_eq!(answer, (&"changed".into(), &false.into()));
    let why = changed["not_stored_because"].as_str().expect("why");
    assert!(why.contains("another program is writing"), "{why}");
    drop(other);
    let quiet = service.visit(BEFORE);
    assert_eq!(
        (&quiet["verdict"], &quiet["stored"]),
        (&"quiet".into(), &true.into())
    );
    assert_eq!(
        quiet["cleared"].as_array().map(Vec::len),
        Some(1),
        "stored before it"
    );
    service.stop();
}

#[test]
fn an_alarm_is_stored_where_its_evidence_is_not() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, disk) = start(dir.path());
    disk.fail(Fault::TooManyOpen, 1, true);
    // The reference is read first, and the rows of a visit take no file of their own.
    disk.steps().only = Some("open to create".to_owned());
    let changed = service.visit(AFTER);
    assert_eq!(
        (&changed["verdict"], &changed["stored"]),
        (&"changed".into(), &true.into())
    );
    assert_eq!(changed["alarm"]["raised"], true);
    let why = changed["evidence_missing_because"].as_str().expect("why");
    assert!(why.contains("LimitNOFILE="), "{why}");
    disk.heal();
    service.stop();
    let store = Store::open_for_reading(&dir.path().join("store")).expect("reader");
    let visit = changed["visit_id"].as_i64().expect("stored");
    assert!(store.visit(visit).is_ok(), "written at the last chance");
}

#[test]
fn a_reference_that_cannot_be_read_is_not_observed_and_no_error() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, disk) = start(dir.path());
    disk.fail(Fault::Failing, 0, true);
    disk.steps().only = Some("open to read".to_owned());
    let visit = service.visit(AFTER);
    assert_eq!(visit["verdict"], "not_observed");
    let reason = visit["reason"].as_str().expect("why");
    assert!(reason.contains("journalctl -k"), "{reason}");
    assert_eq!(visit["stored"], true);
    disk.heal();
    assert_eq!(service.visit(AFTER)["verdict"], "changed");
    assert!(!events(&service).is_empty());
    service.stop();
}

#[test]
fn a_service_on_a_lost_database_says_so_and_deletes_nothing() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, _) = start(dir.path());
    service.visit(AFTER);
    service.stop();
    let store = dir.path().join("store");
    for name in ["patrold.db", "patrold.db-wal", "patrold.db-shm"] {
        let _ = std::fs::remove_file(store.join(name));
    }
    let names = || {
        let entries = std::fs::read_dir(store.join("blobs")).expect("blobs");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    };
    let before = names();
    let scanner = ScriptedScanner::new(AFTER);
    let service = TestService::start(dir.path(), &scanner);
    let visit = service.visit(AFTER);
    assert_eq!(
        (&visit["verdict"], &visit["stored"]),
        (&"not_observed".into(), &false.into())
    );
    let reason = "no reference, 4 evidence files; run patrold store rebuild";
    assert_eq!(visit["reason"], reason);
    assert_eq!(
        scanner.script().sweeps,
        0,
        "there is nothing to compare with"
    );
    let taught = service.post("/teach", "hall");
    assert!(taught.error().contains("run patrold store rebuild"));
    let told = |text: &String| text.contains("the database was lost or set back");
    assert!(events(&service).iter().any(told));
    service.stop();
    assert_eq!(names(), before);
}
