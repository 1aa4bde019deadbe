//! The journal is compacted: it loses no row, whatever fails, is written meanwhile or copies it.

use super::faults::{copy_store, fast_dir, ledger_of};
use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{changed_visit, novelty_at, stamp, teach, visit};
use super::rebuild::{Rows, remove_database, rows};
use patrold::store::{CompactedJournal, CompactionLimits, Ledger, Store};
use patrold_engine::novelty::Verdict;
use std::fs;
use std::path::Path;

/// Notes on the alarm, each of which changes its row.
const NOTES: i64 = 60;

/// A store whose journal has most rows once and two alarms very often.
fn template() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    let yard = store.reference("yard").expect("taught").id;
    changed_visit("yard", yard, 3.0, |new| {
        store.record_visit(new, &stamp(11)).expect("recorded")
    });
    for second in 0..NOTES {
        let alarm = 1 + second % 2;
        store
            .acknowledge(alarm, "guard", Some("again"), &stamp(100 + second))
            .expect("acknowledged");
    }
    store.close();
    dir
}

fn journal(dir: &Path) -> Vec<u8> {
    fs::read(dir.join("blobs/journal.txt")).expect("a journal")
}

const LIMITS: CompactionLimits = CompactionLimits {
    min_bytes: 1000,
    slice_bytes: 15_000,
};

/// With room for the journal and none for the reserve, whose writes would be most of the steps.
fn compacting(dir: &Path) -> (Ledger, FaultyDisk) {
    let (ledger, disk) = ledger_of(dir);
    let mut ledger = ledger.with_compaction(LIMITS);
    disk.steps().free_bytes = Some(20 << 20);
    ledger.start();
    (ledger, disk)
}

/// Upkeeps until it is done; what was done, and in how many steps.
fn compact(ledger: &mut Ledger) -> (CompactedJournal, usize) {
    for steps in 1..1000 {
        if let Some(done) = ledger.maintain().compacted.expect("no fault") {
            return (done, steps);
        }
    }
    panic!("never compacted");
}

/// The rows that the journal alone gives.
fn rebuilt(dir: &Path) -> Rows {
    let copy = fast_dir();
    copy_store(dir, copy.path());
    remove_database(copy.path());
    Store::rebuild(copy.path(), &stamp(900)).expect("rebuilt");
    rows(copy.path())
}

#[test]
fn each_row_keeps_its_newest_line_in_order_and_damage_stays_seen() {
    let dir = template();
    let path = dir.path().join("blobs/journal.txt");
    let mut text = fs::read_to_string(&path).expect("a journal");
    text.insert_str(0, "no line of ours\n");
    fs::write(&path, &text).expect("written");
    let (mut ledger, _) = compacting(dir.path());
    let before = rows(dir.path());
    let (done, steps) = compact(&mut ledger);
    assert_eq!(
        (done.before, done.after),
        (text.len() as u64, journal(dir.path()).len() as u64)
    );
    assert!(
        done.after * 2 <= done.before && steps > 5,
        "{done:?} in {steps}"
    );
    // The lines that are left are some of those before, each row has one.
    let after = fs::read_to_string(&path).expect("a journal");
    let mut old = text.lines();
    assert!(
        after
            .lines()
            .all(|line| old.any(|of_before| of_before == line)),
        "in order"
    );
    let count: usize = before.values().map(Vec::len).sum();
    assert_eq!(after.lines().count(), count + 1);
    let check = ledger.store.check(|_, _| ()).expect("checked");
    assert_eq!(
        (check.journal.lines, check.journal.damaged_lines),
        (count, 1)
    );
    assert_eq!(rebuilt(dir.path()), before);
    assert!(!dir.path().join("journal.compact").exists());
    // It is not done again before it is worth it.
    for _ in 0..20 {
        assert_eq!(ledger.maintain().compacted.expect("no fault"), None);
    }
    assert_eq!(fs::read_to_string(&path).expect("a journal"), after);
    for second in 0..NOTES {
        ledger
            .store
            .acknowledge(1, "guard", Some("more"), &stamp(300 + second))
            .expect("acknowledged");
    }
    compact(&mut ledger);
    assert_eq!(rebuilt(dir.path()), rows(dir.path()));
}

#[test]
fn a_journal_that_is_short_or_has_little_to_lose_is_left_as_it_is() {
    let dir = template();
    let length = journal(dir.path()).len() as u64;
    for (min_bytes, expected) in [(length, true), (length + 1, false)] {
        let copy = fast_dir();
        copy_store(dir.path(), copy.path());
        let (ledger, _) = ledger_of(copy.path());
        let mut ledger = ledger.with_compaction(CompactionLimits {
            min_bytes,
            slice_bytes: 1 << 20,
        });
        let done = (0..9).filter_map(|_| ledger.maintain().compacted.expect("no fault"));
        assert_eq!(done.count() == 1, expected, "{min_bytes}");
    }
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk) = compacting(dir.path());
    for (name, second) in [("hall", 0), ("yard", 1), ("dock", 2)] {
        teach(&mut ledger.store, name, second);
    }
    let before = journal(dir.path());
    assert!(before.len() as u64 > LIMITS.min_bytes);
    for _ in 0..20 {
        assert_eq!(ledger.maintain().compacted.expect("no fault"), None);
    }
    assert_eq!(
        journal(dir.path()),
        before,
        "each line is the newest of its row"
    );
    let read = disk
        .steps()
        .done
        .iter()
        .filter(|step| *step == "open to read")
        .count();
    assert!(read <= 4, "and is not read again: {read}");
}

#[test]
fn what_is_written_while_it_goes_on_is_there_afterwards() {
    let dir = template();
    let (mut ledger, _) = compacting(dir.path());
    let mut second = 400;
    let done = loop {
        second += 1;
        ledger
            .store
            .acknowledge(2, "guard", Some("meanwhile"), &stamp(second))
            .expect("acknowledged");
        if second == 404 {
            teach(&mut ledger.store, "dock", second);
        }
        if let Some(done) = ledger.maintain().compacted.expect("no fault") {
            break done;
        }
        assert!(second < 600, "it catches up");
    };
    assert!(
        second > 405 && done.after < done.before,
        "{second} {done:?}"
    );
    assert_eq!(rebuilt(dir.path()), rows(dir.path()));
    ledger
        .store
        .acknowledge(1, "guard", Some("after"), &stamp(700))
        .expect("acknowledged");
    assert_eq!(rebuilt(dir.path()), rows(dir.path()));
    assert_eq!(ledger.store.changes_lost().expect("asked"), 0);
}

#[test]
fn each_step_of_it_fails_and_the_journal_has_every_row() {
    let dir = template();
    let steps = {
        let copy = fast_dir();
        copy_store(dir.path(), copy.path());
        let (mut ledger, disk) = compacting(copy.path());
        disk.heal();
        compact(&mut ledger);
        disk.steps().done.len()
    };
    let expected = rows(dir.path());
    for fault in [
        Fault::Full,
        Fault::Quota,
        Fault::Failing,
        Fault::TooManyOpen,
        Fault::ReadOnly,
        Fault::ShortWrite,
        Fault::Busy,
    ] {
        for (at, lasting) in (0..steps).flat_map(|at| [(at, false), (at, true)]) {
            let what = format!("{fault:?} at step {at}, lasting {lasting}");
            let place = fast_dir();
            let (running, killed) = (place.path().join("running"), place.path().join("killed"));
            copy_store(dir.path(), &running);
            let (mut ledger, disk) = compacting(&running);
            disk.fail(fault, at, lasting);
            let mut failed = 0;
            for _ in 0..25 {
                failed += usize::from(ledger.maintain().compacted.is_err());
            }
            assert!(failed <= if lasting { 25 } else { 1 }, "{what}: {failed}");
            copy_store(&running, &killed);
            remove_database(&killed);
            Store::rebuild(&killed, &stamp(900)).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(rows(&killed), expected, "{what}");
            disk.heal();
            ledger
                .store
                .acknowledge(1, "guard", Some("healed"), &stamp(800))
                .expect("acknowledged");
            ledger.maintain();
            drop(ledger);
            assert_eq!(rebuilt(&running), rows(&running), "{what}");
        }
    }
}

#[test]
fn a_stop_at_each_step_leaves_a_journal_and_no_half_file() {
    let dir = template();
    let expected = rows(dir.path());
    let (mut ledger, _) = compacting(dir.path());
    for step in 0..1000 {
        let done = ledger.maintain().compacted.expect("no fault");
        let killed = fast_dir();
        copy_store(dir.path(), killed.path());
        assert_eq!(rebuilt(killed.path()), expected, "step {step}");
        let mut again = Ledger::new(Store::open(killed.path()).expect("opens"));
        again.start();
        assert!(
            !killed.path().join("journal.compact").exists(),
            "step {step}"
        );
        assert_eq!(again.store.changes_lost().expect("asked"), 0, "step {step}");
        if done.is_some() {
            return;
        }
    }
    panic!("never compacted");
}

#[test]
fn a_backup_during_which_it_is_done_has_every_row_of_its_database() {
    let dir = template();
    let (live, copy) = (dir.path().to_owned(), dir.path().join("copy"));
    let (mut ledger, _) = compacting(&live);
    let backed_up = rows(&live);
    let reader = Store::open_for_reading(&live).expect("opens");
    let mut is_done = false;
    // Files are copied after the database and before the journal.
    reader
        .back_up(&copy, |_, _| {
            if !is_done {
                ledger
                    .store
                    .acknowledge(1, "guard", Some("later"), &stamp(700))
                    .expect("acknowledged");
                compact(&mut ledger);
                is_done = true;
            }
        })
        .expect("backed up");
    assert!(is_done);
    assert_eq!(rows(&copy), backed_up);
    assert_eq!(rebuilt(&copy), backed_up);
}
