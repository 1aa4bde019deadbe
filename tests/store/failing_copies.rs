//! Every call of the system fails under a rebuild, a backup and a restore: they can be run again, and nothing is lost.

use super::call_faults::{
    CallFault, FAILING, FULL, QUOTA, READ_ONLY, SHORT, TOO_MANY_OPEN, fail_each_call,
};
use super::faults::store_with_an_alarm;
use super::kit::{novelty_at, stamp, teach, visit};
use super::rebuild::{files, remove_database, rows};
use patrold::store::Store;
use patrold_engine::novelty::Verdict;

/// Faults of each kind, in groups, so that all cores share them.
const OF_SPACE: [(CallFault, bool); 3] = [(FULL, false), (SHORT, false), (QUOTA, false)];
const OF_SPACE_THAT_STAYS: [(CallFault, bool); 1] = [(FULL, true)];
const OF_DISK: [(CallFault, bool); 1] = [(FAILING, false)];
const OF_OPENING: [(CallFault, bool); 2] = [(TOO_MANY_OPEN, false), (READ_ONLY, false)];

fn check_rebuild(faults: &[(CallFault, bool)]) {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    store_with_an_alarm(&live);
    let (before, evidence) = (rows(&live), files(&live).len());
    remove_database(&live);
    fail_each_call("rebuild", dir.path(), faults, |root, report, what| {
        let live = root.join("live");
        if report.trim_end() != "done" {
            assert_eq!(files(&live).len(), evidence, "{what}");
            Store::rebuild(&live, &stamp(200)).unwrap_or_else(|error| panic!("{what}: {error}"));
        }
        assert_eq!(rows(&live), before, "{what}");
        assert_eq!(files(&live).len(), evidence, "{what}");
    });
}

fn check_backup(faults: &[(CallFault, bool)]) {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    store_with_an_alarm(&live);
    let before = rows(&live);
    fail_each_call("backup", dir.path(), faults, |root, report, what| {
        let (live, copy) = (root.join("live"), root.join("copy"));
        if report.trim_end() != "done" {
            let store = Store::open_for_reading(&live).expect("opens");
            let again = store.back_up(&copy, |_, _| ());
            let again = again.unwrap_or_else(|error| panic!("{what}: {error}"));
            assert!(again.check.is_sound(), "{what}: {again:?}");
        }
        assert_eq!(
            (rows(&copy), rows(&live)),
            (before.clone(), before.clone()),
            "{what}"
        );
    });
}

fn check_restore(faults: &[(CallFault, bool)]) {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    store_with_an_alarm(&live);
    let backed_up = rows(&live);
    let reader = Store::open_for_reading(&live).expect("opens");
    reader.back_up(&copy, |_, _| ()).expect("backed up");
    drop(reader);
    let mut store = Store::open(&live).expect("opens");
    visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 50);
    teach(&mut store, "dock", 60);
    store.close();
    let (later, evidence) = (rows(&live), files(&live).len());
    fail_each_call("restore", dir.path(), faults, |root, report, what| {
        let (live, copy) = (root.join("live"), root.join("copy"));
        assert!(files(&live).len() >= evidence, "{what}: nothing is deleted");
        if report.trim_end() != "done" {
            let store = Store::open(&live).unwrap_or_else(|error| panic!("{what}: {error}"));
            store.close();
            let now = rows(&live);
            assert!(now == later || now == backed_up, "{what}");
            Store::restore(&live, &copy, &stamp(200), |_, _| ())
                .unwrap_or_else(|error| panic!("{what}: {error}"));
        }
        assert_eq!(rows(&live), backed_up, "{what}");
        let store = Store::open(&live).expect("opens");
        assert_eq!(store.changes_lost().expect("asked"), 0, "{what}");
    });
}

#[test]
fn a_rebuild_out_of_space_can_be_run_again() {
    check_rebuild(&OF_SPACE);
}

#[test]
fn a_rebuild_on_a_disk_that_stays_full_can_be_run_again() {
    check_rebuild(&OF_SPACE_THAT_STAYS);
}

#[test]
fn a_rebuild_on_a_failing_disk_can_be_run_again() {
    check_rebuild(&OF_DISK);
}

#[test]
fn a_rebuild_that_opens_no_file_can_be_run_again() {
    check_rebuild(&OF_OPENING);
}

#[test]
fn a_backup_out_of_space_can_be_run_again() {
    check_backup(&OF_SPACE);
}

#[test]
fn a_backup_on_a_disk_that_stays_full_can_be_run_again() {
    check_backup(&OF_SPACE_THAT_STAYS);
}

#[test]
fn a_backup_on_a_failing_disk_can_be_run_again() {
    check_backup(&OF_DISK);
}

#[test]
fn a_backup_that_opens_no_file_can_be_run_again() {
    check_backup(&OF_OPENING);
}

#[test]
fn a_restore_out_of_space_can_be_run_again() {
    check_restore(&OF_SPACE);
}

#[test]
fn a_restore_on_a_disk_that_stays_full_can_be_run_again() {
    check_restore(&OF_SPACE_THAT_STAYS);
}

#[test]
fn a_restore_on_a_failing_disk_can_be_run_again() {
    check_restore(&OF_DISK);
}

#[test]
fn a_restore_that_opens_no_file_can_be_run_again() {
    check_restore(&OF_OPENING);
}
