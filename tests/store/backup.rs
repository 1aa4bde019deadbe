//! Backup and restore: whole, continued when run again, and nothing is deleted.

use super::kit::{novelty_at, stamp, teach, visit};
use super::rebuild::rows;
use patrold::store::{Ledger, Store, StoreError};
use patrold_engine::novelty::Verdict;
use std::fs;
use std::path::Path;

fn filled(dir: &Path) -> Store {
    let mut store = Store::open(dir).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    store
}

#[test]
fn a_backup_while_the_service_runs_is_whole_and_continues() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    let mut store = filled(&live);
    let reader = Store::open_for_reading(&live).expect("reader");
    let first = reader.back_up(&copy, |_, _| ()).expect("backed up");
    assert!(first.check.is_sound(), "{first:?}");
    assert_eq!(
        (first.copied_files, first.present_files),
        (4, 0),
        "two views, a raw, a visit"
    );
    assert_eq!(rows(&copy), rows(&live));

    visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 20);
    fs::remove_file(copy.join("blobs").join(first_file(&copy))).expect("interrupted");
    let again = reader.back_up(&copy, |_, _| ()).expect("backed up");
    assert_eq!((again.copied_files, again.present_files), (2, 3));
    assert!(again.check.is_sound());
    assert_eq!(rows(&copy), rows(&live));
    // A backup is a store: also its journal gives its database back.
    let before = rows(&copy);
    fs::remove_file(copy.join("patrold.db")).expect("lost");
    Store::rebuild(&copy, &stamp(100)).expect("rebuilt");
    assert_eq!(rows(&copy), before);
}

fn first_file(dir: &Path) -> String {
    let entries = fs::read_dir(dir.join("blobs")).expect("blobs");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<String> = names
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    names.sort();
    names.swap_remove(0)
}

#[test]
fn a_restored_store_is_the_backup_and_what_it_replaced_is_kept() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    let mut store = filled(&live);
    store.back_up(&copy, |_, _| ()).expect("backed up");
    let backed_up = rows(&copy);
    let later = visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 20);
    let lost = first_file(&live);
    store.close();
    fs::remove_file(live.join("blobs").join(&lost)).expect("lost");

    let restored = Store::restore(&live, &copy, &stamp(100), |_, _| ()).expect("restored");
    assert!(restored.check.is_sound(), "{restored:?}");
    assert_eq!((restored.copied_files, restored.present_files), (1, 3));
    assert_eq!(rows(&live), backed_up);
    let old = restored.old_database.expect("kept");
    assert_eq!(
        restored.check.unnamed.len(),
        1,
        "the sweep of the later visit"
    );
    let mut store = Store::open(&live).expect("opens");
    assert_eq!(
        store.changes_lost().expect("asked"),
        0,
        "database and journal are of one time"
    );
    assert!(store.visit(later.visit_id).is_err());
    let next = visit(&mut store, Verdict::Quiet, &[], 110);
    assert_eq!(next.visit_id, later.visit_id);
    assert!(old.is_file());
}

#[test]
fn a_backup_that_is_none_or_damaged_changes_nothing() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    let store = filled(&live);
    store.back_up(&copy, |_, _| ()).expect("backed up");
    store.close();
    let before = rows(&live);
    let none = Store::restore(&live, &dir.path().join("none"), &stamp(100), |_, _| ());
    assert!(
        matches!(none, Err(StoreError::NoDatabase { .. })),
        "{none:?}"
    );
    let database = copy.join("patrold.db");
    let mut bytes = fs::read(&database).expect("read");
    // All but the first page, which has the tables' names.
    bytes[4096..].fill(0xff);
    fs::write(&database, bytes).expect("damaged");
    let damaged = Store::restore(&live, &copy, &stamp(100), |_, _| ());
    assert!(damaged.is_err(), "{damaged:?}");
    assert_eq!(rows(&live), before);
}

#[test]
fn a_store_is_no_backup_of_itself() {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    let other_name = dir.path().join("link");
    std::os::unix::fs::symlink(&live, &other_name).expect("linked");
    let store = filled(&live);
    let before = rows(&live);
    for to in [&live, &other_name] {
        let refused = store.back_up(to, |_, _| ());
        assert!(
            matches!(refused, Err(StoreError::OwnBackup { .. })),
            "{refused:?}"
        );
    }
    store.close();
    for from in [&live, &other_name] {
        let refused = Store::restore(&live, from, &stamp(100), |_, _| ());
        assert!(
            matches!(refused, Err(StoreError::OwnBackup { .. })),
            "{refused:?}"
        );
    }
    assert_eq!(rows(&live), before);
    let names = fs::read_dir(&live).expect("a folder");
    let left = names.filter(|entry| {
        let name = entry.as_ref().expect("an entry").file_name();
        name.to_string_lossy().contains(".new") || name.to_string_lossy().contains("restore")
    });
    assert_eq!(left.count(), 0, "nothing was begun");
}

/// What a shell copies after a clean stop is whole, also where somebody reads.
#[test]
fn a_ledger_that_is_closed_beside_a_reader_leaves_nothing_in_the_log() {
    let dir = tempfile::tempdir().expect("temp dir");
    let store = filled(dir.path());
    let reader = Store::open_for_reading(dir.path()).expect("reader");
    assert_eq!(reader.waypoints().expect("read").len(), 2);
    let log = || fs::metadata(dir.path().join("patrold.db-wal")).map_or(0, |file| file.len());
    assert!(log() > 0);
    Ledger::new(store).close();
    assert_eq!(log(), 0);
    let copy = tempfile::tempdir().expect("temp dir");
    let database = dir.path().join("patrold.db");
    fs::copy(database, copy.path().join("patrold.db")).expect("copied");
    assert_eq!(rows(copy.path()), rows(dir.path()));
}
