//! A restore under a running ledger: what fails is undone, and what is held belongs to the old store.

use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{changed_visit, novelty_at, stamp, teach, visit};
use super::rebuild::rows;
use patrold::store::{Ledger, PreparedRestore, Store, SystemDisk, VisitRecord};
use patrold_engine::novelty::Verdict;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A ledger whose store has a visit more than its backup.
fn ledger(dir: &Path) -> (Ledger, FaultyDisk, PathBuf, PathBuf) {
    let (live, copy) = (dir.join("live"), dir.join("copy"));
    let disk = FaultyDisk::default();
    let mut store = Store::open_on(&live, Arc::new(disk.clone())).expect("store");
    teach(&mut store, "hall", 10);
    teach(&mut store, "yard", 11);
    visit(&mut store, Verdict::Changed, &[novelty_at(3.0)], 20);
    store.back_up(&copy, |_, _| ()).expect("backed up");
    visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 30);
    (Ledger::new(store), disk, live, copy)
}

fn prepare(live: &Path, copy: &Path) -> PreparedRestore {
    let disk = Arc::new(SystemDisk);
    PreparedRestore::new(live, copy, disk, |_, _| ()).expect("prepared")
}

#[test]
fn the_ledger_goes_on_with_the_restored_store() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, _, live, copy) = ledger(dir.path());
    let backed_up = rows(&copy);
    let before = rows(&live);
    let reader = Store::open_for_reading(&live).expect("a reader that stays");
    let restored = ledger.restore(prepare(&live, &copy), &stamp(100));
    let (prepared, start) = restored.expect("restored");
    assert!(
        start.failures.is_empty() && start.lost_files.is_none(),
        "{start:?}"
    );
    let result = prepared.finish().expect("checked");
    assert!(result.check.is_sound(), "{result:?}");
    assert_eq!(rows(&live), backed_up);
    assert_eq!(ledger.store.changes_lost().expect("asked"), 0);
    let outcome = visit(&mut ledger.store, Verdict::Changed, &[novelty_at(9.0)], 110);
    assert_eq!(
        outcome.visit_id, 2,
        "the number of the visit that the backup has not"
    );
    drop(reader);
    ledger.close();
    assert_eq!(rows(&live)["visit"].len(), backed_up["visit"].len() + 1);
    // The old one is whole under its other name.
    let old = result.old_database.expect("kept");
    let other = dir.path().join("old");
    fs::create_dir(&other).expect("folder");
    fs::rename(&old, other.join("patrold.db")).expect("moved");
    let mut log = old.into_os_string();
    log.push("-wal");
    if Path::new(&log).exists() {
        fs::rename(&log, other.join("patrold.db-wal")).expect("moved");
    }
    assert_eq!(rows(&other), before);
}

#[test]
fn a_restore_that_fails_at_any_of_its_steps_is_undone() {
    for spoilt in ["no database", "no journal", "another database"] {
        let dir = tempfile::tempdir().expect("temp dir");
        let (mut ledger, _, live, copy) = ledger(dir.path());
        let before = rows(&live);
        let journal = fs::read(live.join("blobs/journal.txt")).expect("a journal");
        let prepared = prepare(&live, &copy);
        let database = live.join("patrold.db.restore");
        match spoilt {
            "no database" => fs::remove_file(database).expect("removed"),
            "no journal" => fs::remove_file(live.join("journal.restore")).expect("removed"),
            _ => fs::write(
                database,
                b"this is no database, and it is long enough to see",
            )
            .expect("written"),
        }
        let failed = ledger.restore(prepared, &stamp(100));
        failed.map(|_| ()).expect_err(spoilt);
        assert_eq!(rows(&live), before, "{spoilt}");
        let now = fs::read(live.join("blobs/journal.txt")).expect("a journal");
        assert!(now == journal, "{spoilt}");
        // The ledger goes on with the old one, and nothing of what follows is lost either.
        visit(&mut ledger.store, Verdict::Changed, &[novelty_at(9.0)], 110);
        ledger.close();
        let after = rows(&live);
        assert_eq!(after["visit"].len(), before["visit"].len() + 1, "{spoilt}");
        let store = Store::open(&live).expect("opens");
        assert_eq!(store.changes_lost().expect("asked"), 0, "{spoilt}");
        assert!(
            store.check(|_, _| ()).expect("checked").is_sound(),
            "{spoilt}"
        );
    }
}

#[test]
fn nothing_is_restored_while_a_visit_is_held_that_the_old_store_has_not() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, live, copy) = ledger(dir.path());
    let before = rows(&live);
    let reference = ledger.store.reference("yard").expect("taught").id;
    disk.fail(Fault::Failing, 0, true);
    let held = changed_visit("yard", reference, 5.0, |new| {
        ledger.record_visit(new, &stamp(40))
    });
    assert!(matches!(held.expect("held"), VisitRecord::Held(_)));
    let prepared = prepare(&live, &copy);
    let refused = ledger.restore(prepared, &stamp(100)).map(|_| ());
    assert!(refused.is_err() && rows(&live) == before);
    disk.heal();
    let restored = ledger.restore(prepare(&live, &copy), &stamp(101));
    let result = restored.expect("restored").0.finish().expect("checked");
    let old = rusqlite::Connection::open(result.old_database.expect("kept")).expect("opens");
    let held: i64 = old
        .query_row("SELECT count(*) FROM visit v JOIN waypoint w ON w.id = v.waypoint_id WHERE w.name = 'yard'", [], |row| row.get(0))
        .expect("a count");
    assert_eq!(held, 1, "it is in the store that it belongs to");
}
