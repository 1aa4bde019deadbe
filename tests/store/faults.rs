//! Every step of the disk fails once, and from then on: no reported alarm is lost, and what is not stored is reported.

use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{changed_visit, first_raised, novelty_at, stamp, teach, visit};
use patrold::store::{Ledger, RecordTime, Store, StoreError, VisitOutcome, VisitRecord};
use patrold_engine::novelty::Verdict;
use std::path::Path;
use std::sync::Arc;

/// Makes a store with two waypoints and a standing alarm at the first; returns the alarm.
pub(crate) fn store_with_an_alarm(dir: &Path) -> i64 {
    let mut store = Store::open(dir).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    let raised = first_raised(&visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10));
    store.close();
    raised.expect("raised")
}

/// A ledger on a disk that works until a fault is injected.
pub(crate) fn ledger_of(dir: &Path) -> (Ledger, FaultyDisk) {
    let disk = FaultyDisk::default();
    let store = Store::open_on(dir, Arc::new(disk.clone())).expect("store");
    (Ledger::new(store), disk)
}

pub(crate) fn ledger_with_an_alarm(dir: &Path) -> (Ledger, FaultyDisk, i64) {
    let standing = store_with_an_alarm(dir);
    let (ledger, disk) = ledger_of(dir);
    (ledger, disk, standing)
}

/// In memory where the system has that: hundreds of stores are synced here, and what a sync does is not what is tested.
pub(crate) fn fast_dir() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").unwrap_or_else(|_| tempfile::tempdir().expect("temp dir"))
}

/// A copy of the store as a stop at this instant leaves it.
pub(crate) fn copy_store(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_store(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).expect("copied");
        }
    }
}

pub(crate) fn record(ledger: &mut Ledger, waypoint: &str, x: f64, at: &RecordTime) -> VisitRecord {
    let reference = ledger.store.reference(waypoint).expect("taught").id;
    record_of(ledger, waypoint, reference, x, at)
}

pub(crate) fn record_of(
    ledger: &mut Ledger,
    waypoint: &str,
    reference: i64,
    x: f64,
    at: &RecordTime,
) -> VisitRecord {
    let recorded = changed_visit(waypoint, reference, x, |new| ledger.record_visit(new, at));
    recorded.expect("stored or held")
}

fn half_written(dir: &Path) -> usize {
    let entries = std::fs::read_dir(dir.join("blobs")).expect("blobs");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    names
        .filter(|name| name.to_string_lossy().ends_with(".tmp"))
        .count()
}

/// The steps of a changed visit and of an acknowledgement, without a fault.
fn steps() -> Vec<String> {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, standing) = ledger_with_an_alarm(dir.path());
    let reference = ledger.store.reference("yard").expect("taught").id;
    disk.heal();
    record_of(&mut ledger, "yard", reference, 3.0, &stamp(20));
    let acknowledged = ledger
        .store
        .acknowledge(standing, "guard", None, &stamp(30));
    acknowledged.expect("acknowledged");
    disk.steps().done.clone()
}

#[test]
fn a_visit_and_an_acknowledgement_sync_all_that_they_write() {
    let file = [
        "open to create",
        "write",
        "sync",
        "rename",
        "open a folder",
        "sync of a folder",
    ];
    let transaction = ["Begin", "Commit"];
    let journal = ["Begin", "open to append", "write", "sync", "Commit"];
    let visit = [&transaction[..], &file, &file, &transaction, &journal].concat();
    assert_eq!(steps(), [&visit[..], &transaction, &journal].concat());
}

/// Words that only the error of this fault has.
pub(crate) fn advice_words(fault: Fault) -> &'static str {
    match fault {
        Fault::Full | Fault::ShortWrite => "the disk is full; make room",
        Fault::Quota => "quota of this user",
        Fault::Failing => "journalctl -k",
        Fault::TooManyOpen => "LimitNOFILE=",
        Fault::ReadOnly => "read-write",
        Fault::Busy => "another program is writing",
    }
}

/// What was reported of the visit at the yard and of the acknowledgement.
struct Reported {
    /// `None`: held.
    visit: Option<VisitOutcome>,
    acknowledged: bool,
    standing: i64,
}

/// Every step of one kind of fault, once and from then on.
fn check_all_steps(fault: Fault) {
    let steps = steps().len();
    let template = tempfile::tempdir().expect("temp dir");
    let standing = store_with_an_alarm(template.path());
    for lasting in [false, true] {
        for at in 0..steps {
            check_fault(template.path(), standing, fault, at, lasting);
        }
    }
}

fn check_fault(template: &Path, standing: i64, fault: Fault, at: usize, lasting: bool) {
    let what = format!("{fault:?} at step {at}, lasting {lasting}");
    let dir = fast_dir();
    let (running, killed) = (dir.path().join("running"), dir.path().join("killed"));
    copy_store(template, &running);
    let (mut ledger, disk) = ledger_of(&running);
    let reference = ledger.store.reference("yard").expect("taught").id;
    disk.fail(fault, at, lasting);
    let recorded = record_of(&mut ledger, "yard", reference, 3.0, &stamp(20));
    let acknowledged = ledger
        .store
        .acknowledge(standing, "guard", Some("seen"), &stamp(30));
    let advice = |text: &str| {
        assert!(text.contains(advice_words(fault)), "{what}: {text}");
    };
    let mut reported = Reported {
        visit: None,
        acknowledged: acknowledged.is_ok(),
        standing,
    };
    match recorded {
        VisitRecord::Stored(outcome) => {
            outcome.evidence_missing.iter().for_each(|why| advice(why));
            reported.visit = Some(outcome);
        }
        VisitRecord::Held(why) => advice(&why.to_string()),
        VisitRecord::Dropped(why) => panic!("{what}: one visit can be held: {why}"),
    }
    if let Err(why) = &acknowledged {
        advice(&why.to_string());
    }
    copy_store(&running, &killed);
    check_stored(&killed, &reported, &format!("{what}, killed"));

    disk.heal();
    let retry = ledger.retry();
    assert!(
        retry.why.is_none() && !ledger.is_behind(),
        "{what}: {retry:?}"
    );
    assert_eq!(retry.stored.is_empty(), reported.visit.is_some(), "{what}");
    for (waypoint, time, outcome) in retry.stored {
        assert_eq!((waypoint.as_str(), time), ("yard", stamp(20)), "{what}");
        reported.visit = Some(outcome);
    }
    if let Some(visit) = &mut reported.visit {
        visit.evidence_missing = None;
    }
    drop(ledger);
    check_stored(&running, &reported, &what);
}

/// The store has what was reported, after a start.
fn check_stored(dir: &Path, reported: &Reported, what: &str) {
    let mut ledger = Ledger::new(Store::open(dir).expect("opens"));
    let start = ledger.start();
    assert!(start.failures.is_empty(), "{what}: {start:?}");
    assert_eq!(half_written(dir), 0, "{what}");
    let store = &ledger.store;
    let state = store.alarm(reported.standing).expect("kept").state;
    let expected = if reported.acknowledged {
        "acknowledged"
    } else {
        "open"
    };
    assert_eq!(state, expected, "{what}");
    let Some(outcome) = &reported.visit else {
        let unreported = store.alarm(reported.standing + 1);
        assert!(unreported.is_err(), "{what}: {unreported:?}");
        return;
    };
    let alarm = store
        .alarm(first_raised(outcome).expect("raised"))
        .expect("kept");
    let seen = (alarm.waypoint.as_str(), alarm.novelties[0].centre[0]);
    assert_eq!(seen, ("yard", 3.0), "{what}");
    match (store.visit(outcome.visit_id), &outcome.evidence_missing) {
        (Ok(visit), None) => assert!(visit.view.is_some() && visit.raw.is_some(), "{what}"),
        // Also where it was written, and only the mark that it is there was not.
        (Ok(_) | Err(StoreError::EvidenceMissing { .. }), Some(_)) => {}
        (other, missing) => panic!("{what}: {other:?}, reported {missing:?}"),
    }
}

#[test]
fn a_full_disk_loses_no_reported_alarm() {
    check_all_steps(Fault::Full);
}

#[test]
fn a_used_up_quota_loses_no_reported_alarm() {
    check_all_steps(Fault::Quota);
}

#[test]
fn a_failing_disk_loses_no_reported_alarm() {
    check_all_steps(Fault::Failing);
}

#[test]
fn too_many_open_files_lose_no_reported_alarm() {
    check_all_steps(Fault::TooManyOpen);
}

#[test]
fn a_read_only_disk_loses_no_reported_alarm() {
    check_all_steps(Fault::ReadOnly);
}

#[test]
fn a_short_write_loses_no_reported_alarm() {
    check_all_steps(Fault::ShortWrite);
}

#[test]
fn a_busy_database_loses_no_reported_alarm() {
    check_all_steps(Fault::Busy);
}

#[test]
fn a_sweep_that_was_being_written_at_the_stop_is_settled_at_the_start() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir.path());
    let mut ids = Vec::new();
    // The last step marks the row: with all files written, with none, and with the view alone.
    for (x, at) in [(3.0, 14), (5.0, 2), (7.0, 8)] {
        let yard = ledger.store.reference("yard").expect("taught").id;
        disk.fail(Fault::Failing, at, true);
        let recorded = record_of(&mut ledger, "yard", yard, x, &stamp(20));
        disk.heal();
        let VisitRecord::Stored(outcome) = recorded else {
            panic!("{recorded:?}");
        };
        ids.push(outcome.visit_id);
    }
    drop(ledger);
    let mut ledger = Ledger::new(Store::open(dir.path()).expect("opens"));
    assert_eq!(ledger.start().evidence_missing, 2);
    assert!(ledger.store.visit(ids[0]).is_ok());
    for id in [ids[1], ids[2]] {
        let gone = ledger.store.visit(id).expect_err("no files").to_string();
        assert!(gone.contains("stopped before it was written"), "{gone}");
    }
    assert_eq!(ledger.start().evidence_missing, 0);
    let VisitRecord::Stored(next) = record(&mut ledger, "hall", 9.0, &stamp(60)) else {
        panic!("the disk works");
    };
    assert!(next.evidence_missing.is_none());
}
