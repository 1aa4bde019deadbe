//! Each step of a restore fails once, and from then on, without a service and under a running ledger: the store is as before or
//! the backup, nothing that was reported is missing, and it can be done again.

use super::faults::{advice_words, copy_store, fast_dir, ledger_of, store_with_an_alarm};
use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{novelty_at, stamp, teach, visit};
use super::rebuild::{Rows, files, rows};
use patrold::store::{Ledger, PreparedRestore, Store, StoreError};
use patrold_engine::novelty::Verdict;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A store, its backup of some time ago, and what both have.
struct Template {
    dir: tempfile::TempDir,
    backed_up: Rows,
    later: Rows,
    evidence: usize,
}

fn template() -> Template {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    store_with_an_alarm(&live);
    let reader = Store::open_for_reading(&live).expect("opens");
    reader.back_up(&copy, |_, _| ()).expect("backed up");
    drop(reader);
    let backed_up = rows(&copy);
    let mut store = Store::open(&live).expect("opens");
    visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 50);
    teach(&mut store, "dock", 60);
    // A file that the backup has and the store has not any more.
    store.close();
    let lost = files(&copy).swap_remove(0);
    std::fs::remove_file(live.join("blobs").join(lost.file_name().expect("a name"))).expect("lost");
    Template {
        backed_up,
        later: rows(&live),
        evidence: files(&live).len(),
        dir,
    }
}

impl Template {
    fn copy(&self) -> (tempfile::TempDir, PathBuf, PathBuf) {
        let dir = fast_dir();
        copy_store(self.dir.path(), dir.path());
        let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
        (dir, live, copy)
    }
}

fn check_advice(fault: Fault, error: &StoreError, what: &str) {
    let text = error.to_string();
    assert!(text.contains(advice_words(fault)), "{what}: {text}");
}

/// Calls `check` for every fault at each of `steps` steps, once and lasting.
fn each_fault(steps: usize, faults: &[Fault], check: impl Fn(Fault, usize, bool, &str)) {
    for fault in faults {
        for (at, lasting) in (0..steps).flat_map(|at| [(at, false), (at, true)]) {
            let what = format!("{fault:?} at step {at}, lasting {lasting}");
            check(*fault, at, lasting, &what);
        }
    }
}

fn restore(live: &Path, copy: &Path, disk: &FaultyDisk) -> Result<(), StoreError> {
    let disk = Arc::new(disk.clone());
    Store::restore_on(live, copy, disk, &stamp(100), |_, _| ()).map(drop)
}

fn check_stopped_service(faults: &[Fault]) {
    let template = template();
    let steps = {
        let (_dir, live, copy) = template.copy();
        let disk = FaultyDisk::default();
        restore(&live, &copy, &disk).expect("restored");
        let steps = disk.steps().done.clone();
        for name in [
            "open to read",
            "open to create",
            "write",
            "sync",
            "link",
            "rename",
        ] {
            assert!(steps.iter().any(|step| step == name), "{name}: {steps:?}");
        }
        steps.len()
    };
    each_fault(steps, faults, |fault, at, lasting, what| {
        let (_dir, live, copy) = template.copy();
        let disk = FaultyDisk::default();
        disk.fail(fault, at, lasting);
        let done = restore(&live, &copy, &disk);
        disk.heal();
        assert!(
            files(&live).len() >= template.evidence,
            "{what}: nothing is deleted"
        );
        let store = Store::open(&live).unwrap_or_else(|error| panic!("{what}: {error}"));
        let lost = store.changes_lost().expect("asked");
        store.close();
        let now = rows(&live);
        match done {
            Ok(()) => assert!(now == template.backed_up && lost == 0, "{what}"),
            Err(error) => {
                check_advice(fault, &error, what);
                // Where the disk does not let it be undone either, the start notices.
                let is_as_before = now == template.later && lost == 0;
                let is_noticed =
                    now == template.backed_up && (lost > 0 || lasting || at + 12 > steps);
                assert!(is_as_before || is_noticed, "{what}: {lost} lost");
                restore(&live, &copy, &disk).unwrap_or_else(|error| panic!("{what}: {error}"));
            }
        }
        assert_eq!(rows(&live), template.backed_up, "{what}");
        let store = Store::open(&live).expect("opens");
        assert_eq!(store.changes_lost().expect("asked"), 0, "{what}");
        assert!(
            store.check(|_, _| ()).expect("checked").is_sound(),
            "{what}"
        );
    });
}

/// Restores under a ledger; whether the backup is in place.
fn restore_running(
    ledger: &mut Ledger,
    live: &Path,
    copy: &Path,
    disk: &FaultyDisk,
) -> Result<(), StoreError> {
    let prepared = PreparedRestore::new(live, copy, Arc::new(disk.clone()), |_, _| ())?;
    let (prepared, _) = ledger.restore(prepared, &stamp(100))?;
    // What it finds is reported; the backup is in place whatever it is.
    let _ = prepared.finish();
    Ok(())
}

fn check_running_service(faults: &[Fault]) {
    let template = template();
    let steps = {
        let (_dir, live, copy) = template.copy();
        let (mut ledger, disk) = ledger_of(&live);
        disk.heal();
        restore_running(&mut ledger, &live, &copy, &disk).expect("restored");
        disk.steps().done.len()
    };
    each_fault(steps, faults, |fault, at, lasting, what| {
        let (dir, live, copy) = template.copy();
        let (mut ledger, disk) = ledger_of(&live);
        disk.fail(fault, at, lasting);
        let done = restore_running(&mut ledger, &live, &copy, &disk);
        disk.heal();
        ledger.maintain();
        let before = match &done {
            Ok(()) => &template.backed_up,
            Err(error) => {
                check_advice(fault, error, what);
                &template.later
            }
        };
        assert_eq!(rows(&live), *before, "{what}");
        // The ledger goes on, and what it reports as stored outlives it.
        let stored = visit(&mut ledger.store, Verdict::Changed, &[novelty_at(9.0)], 110);
        let killed = dir.path().join("killed");
        copy_store(&live, &killed);
        let store = Store::open(&killed).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(store.changes_lost().expect("asked"), 0, "{what}");
        store
            .visit(stored.visit_id)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        drop(store);
        let again = restore_running(&mut ledger, &live, &copy, &disk);
        again.unwrap_or_else(|error| panic!("{what}: {error}"));
        ledger.close();
        assert_eq!(rows(&live), template.backed_up, "{what}");
    });
}

const OF_SPACE: [Fault; 3] = [Fault::Full, Fault::Quota, Fault::ShortWrite];
const OF_DISK: [Fault; 4] = [
    Fault::Failing,
    Fault::TooManyOpen,
    Fault::ReadOnly,
    Fault::Busy,
];

#[test]
fn each_step_of_a_restore_finds_no_room() {
    check_stopped_service(&OF_SPACE);
}

#[test]
fn each_step_of_a_restore_fails() {
    check_stopped_service(&OF_DISK);
}

#[test]
fn each_step_of_a_restore_under_a_ledger_finds_no_room() {
    check_running_service(&OF_SPACE);
}

#[test]
fn each_step_of_a_restore_under_a_ledger_fails() {
    check_running_service(&OF_DISK);
}
