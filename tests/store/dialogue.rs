//! The bytes of the devices beside a sweep: an evidence file that costs no alarm where it cannot be written.

use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{changed_visit, first_raised, stamp, teach};
use patrold::store::{
    Ledger, NewVisit, Retention, Store, StoreError, SweepRecord, VisitOutcome, VisitRecord,
};
use std::path::Path;
use std::sync::Arc;

/// Dialogues of two sweeps that differ.
const HALL: &[u8] = b"what the devices said at the hall";
const YARD: &[u8] = b"what they said at the yard, and more of it";

fn record(
    ledger: &mut Ledger,
    waypoint: &str,
    x: f64,
    dialogue: &[u8],
    second: i64,
) -> VisitRecord {
    let reference = ledger.store.reference(waypoint).expect("taught").id;
    let recorded = changed_visit(waypoint, reference, x, |new| {
        let sweep = new.sweep.clone().map(|sweep| SweepRecord {
            dialogue: Some(dialogue),
            ..sweep
        });
        let new = NewVisit {
            sweep,
            ..new.clone()
        };
        ledger.record_visit(&new, &stamp(second))
    });
    recorded.expect("stored or held")
}

fn stored(record: VisitRecord) -> VisitOutcome {
    match record {
        VisitRecord::Stored(outcome) => outcome,
        other => panic!("{other:?}"),
    }
}

fn ledger(dir: &Path) -> (Ledger, FaultyDisk) {
    let disk = FaultyDisk::default();
    let mut store = Store::open_on(dir, Arc::new(disk.clone())).expect("store");
    for (name, second) in [("hall", 10), ("yard", 11)] {
        teach(&mut store, name, second);
    }
    (Ledger::new(store), disk)
}

fn file_of(dir: &Path, content: &[u8]) -> Option<std::path::PathBuf> {
    let entries = std::fs::read_dir(dir.join("blobs")).expect("blobs");
    let mut paths = entries.map(|entry| entry.expect("an entry").path());
    paths.find(|path| std::fs::read(path).is_ok_and(|bytes| bytes == content))
}

#[test]
fn it_is_kept_with_its_visit_checked_backed_up_counted_and_deleted_with_its_sweep() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, _) = ledger(dir.path());
    let measured = ledger.store.disk_space().expect("space").visit_bytes;
    let hall = stored(record(&mut ledger, "hall", 3.0, HALL, 20));
    let yard = stored(record(&mut ledger, "yard", 4.0, &[YARD; 9999].concat(), 21));
    assert_eq!(
        (&hall.evidence_missing, &yard.evidence_missing),
        (&None, &None)
    );
    let space = ledger.store.disk_space().expect("space").visit_bytes;
    assert!(
        space > measured + 50_000,
        "{space} bytes a visit, {measured} before"
    );
    let store = &ledger.store;
    assert_eq!(
        store
            .visit(hall.visit_id)
            .expect("visit")
            .dialogue
            .as_deref(),
        Ok(HALL)
    );
    assert!(store.unnamed_files().expect("files").is_empty());
    let check = store.check(|_, _| ()).expect("checked");
    // Two references and two visits with view and raw data (the references share theirs), two dialogues.
    assert!(check.is_sound() && check.evidence_files == 10, "{check:?}");
    let to = tempfile::tempdir().expect("temp dir");
    let copied = store.back_up(to.path(), |_, _| ()).expect("backed up");
    assert!(copied.check.is_sound() && file_of(to.path(), HALL).is_some());

    std::fs::write(file_of(dir.path(), HALL).expect("its file"), b"changed").expect("damaged");
    let check = ledger.store.check(|_, _| ()).expect("checked");
    let missing: Vec<_> = check
        .missing
        .iter()
        .map(|m| (m.visit_id, m.waypoint.as_str()))
        .collect();
    assert_eq!(missing, [(Some(hall.visit_id), "hall")]);
    let visit = ledger
        .store
        .visit(hall.visit_id)
        .expect("the rest is whole");
    assert!(visit.dialogue.is_err() && visit.view.is_some());

    // What belongs to an alarm stays, whatever its age.
    let all = Retention {
        older_than: Some(stamp(1000).at),
        max_bytes: Some(0),
        unnamed_older_than: None,
    };
    ledger.store.apply_retention(&all).expect("applied");
    assert!(
        ledger
            .store
            .visit(yard.visit_id)
            .expect("visit")
            .dialogue
            .is_ok()
    );
}

#[test]
fn retention_deletes_it_with_its_sweep_and_says_so() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, _) = ledger(dir.path());
    let quiet = |ledger: &mut Ledger, dialogue, view: bool, second| {
        let reference = ledger.store.reference("hall").expect("taught").id;
        let recorded = changed_visit("hall", reference, second as f64, |new| {
            let sweep = new.sweep.clone().map(|sweep| SweepRecord {
                dialogue: Some(dialogue),
                view: sweep.view.filter(|_| view),
                raw: sweep.raw.filter(|_| view),
                ..sweep
            });
            let new = NewVisit {
                sweep,
                verdict: patrold_engine::novelty::Verdict::NotObserved,
                novelties: &[],
                ..new.clone()
            };
            ledger.record_visit(&new, &stamp(second))
        });
        stored(recorded.expect("stored")).visit_id
    };
    // Of the first nothing but the bytes came; the second shares them with the third.
    let first = quiet(&mut ledger, HALL, false, 20);
    let second = quiet(&mut ledger, YARD, true, 30);
    let third = quiet(&mut ledger, YARD, true, 40);
    assert_eq!(
        ledger
            .store
            .visit(first)
            .expect("visit")
            .dialogue
            .as_deref(),
        Ok(HALL)
    );
    let older = |second| Retention {
        older_than: Some(stamp(second).at),
        max_bytes: None,
        unnamed_older_than: None,
    };
    let deleted = ledger.store.apply_retention(&older(35)).expect("applied");
    assert_eq!(deleted.sweeps, 2);
    assert!(file_of(dir.path(), HALL).is_none() && file_of(dir.path(), YARD).is_some());
    for visit in [first, second] {
        let gone = ledger.store.visit(visit).expect_err("deleted");
        assert!(matches!(gone, StoreError::NotKept { .. }), "{gone}");
    }
    assert_eq!(
        ledger
            .store
            .visit(third)
            .expect("visit")
            .dialogue
            .as_deref(),
        Ok(YARD)
    );
    ledger.store.apply_retention(&older(45)).expect("applied");
    assert!(file_of(dir.path(), YARD).is_none());
}

#[test]
fn where_it_cannot_be_written_the_alarm_and_the_view_are_there_and_it_follows() {
    // Of a visit: view, raw data, dialogue; each is opened, written, synced, renamed.
    for step in ["open to create", "write", "sync", "rename"] {
        let dir = tempfile::tempdir().expect("temp dir");
        let (mut ledger, disk) = ledger(dir.path());
        disk.heal();
        record(&mut ledger, "yard", 3.0, YARD, 20);
        let done = disk.steps().done.clone();
        let of_kind = done.iter().enumerate().filter(|(_, name)| *name == step);
        let third = of_kind.map(|(at, _)| at).nth(2).expect("the dialogue");
        disk.fail(Fault::Failing, third, false);
        let outcome = stored(record(&mut ledger, "hall", 4.0, HALL, 21));
        assert!(first_raised(&outcome).is_some(), "{step}");
        let why = outcome.evidence_missing.expect("reported");
        assert!(why.contains("journalctl -k"), "{step}: {why}");
        let visit = ledger
            .store
            .visit(outcome.visit_id)
            .expect("view and raw data");
        assert!(visit.view.is_some() && visit.raw.is_some(), "{step}");
        assert_eq!(visit.dialogue, Err(why), "{step}");
        assert!(ledger.is_behind());
        disk.heal();
        assert_eq!(ledger.retry().evidence, 1, "{step}");
        let visit = ledger.store.visit(outcome.visit_id).expect("visit");
        assert_eq!(visit.dialogue.as_deref(), Ok(HALL), "{step}");
        let other = ledger.store.visit(1).expect("visit");
        assert_eq!(other.dialogue.as_deref(), Ok(YARD), "{step}");
    }
}

#[test]
fn a_stop_before_it_is_written_is_settled_at_the_next_start_and_a_rebuild_finds_it_missing() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, _) = ledger(dir.path());
    let outcome = stored(record(&mut ledger, "hall", 3.0, HALL, 20));
    let kept = stored(record(&mut ledger, "yard", 3.0, YARD, 21));
    ledger.close();
    std::fs::remove_file(file_of(dir.path(), HALL).expect("its file")).expect("removed");
    let db = rusqlite::Connection::open(dir.path().join("patrold.db")).expect("database");
    db.execute(
        "UPDATE sweep SET evidence = 'pending' WHERE dialogue_file IS NOT NULL",
        [],
    )
    .expect("as a stop leaves it");
    drop(db);
    let mut store = Store::open(dir.path()).expect("store");
    assert_eq!(store.settle_evidence().expect("settled"), 1);
    let why_of = |store: &Store| {
        let visit = store.visit(outcome.visit_id).expect("view and raw data");
        assert!(visit.view.is_some());
        visit.dialogue.expect_err("not there")
    };
    assert!(why_of(&store).contains("stopped before it was written"));
    assert_eq!(
        store
            .visit(kept.visit_id)
            .expect("visit")
            .dialogue
            .as_deref(),
        Ok(YARD)
    );
    store.close();
    let rebuilt = Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
    assert_eq!(rebuilt.evidence_missing, 1);
    let store = Store::open_for_reading(dir.path()).expect("reader");
    assert!(why_of(&store).contains("stopped before it was written"));
    assert_eq!(
        store
            .visit(kept.visit_id)
            .expect("visit")
            .dialogue
            .as_deref(),
        Ok(YARD)
    );
}
