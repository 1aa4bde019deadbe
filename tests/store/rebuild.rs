//! A lost database: nothing is deleted, visits say so, and the journal beside the evidence gives it back.

use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{EVERYTHING, changed_visit, first_raised, novelty_at, stamp, teach, visit};
use patrold::patrol::severity::Severity;
use patrold::store::{AlarmFilter, Ledger, Store, StoreError, VisitRecord};
use patrold_engine::novelty::Verdict;
use rusqlite::Connection;
use rusqlite::types::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) type Rows = BTreeMap<String, Vec<Vec<(String, Value)>>>;

/// All rows of all tables but the event log and what serves the journal.
pub(crate) fn rows(dir: &Path) -> Rows {
    let db = Connection::open(dir.join("patrold.db")).expect("opens");
    let texts = |sql: &str| -> Vec<String> {
        let mut query = db.prepare(sql).expect("a query");
        let rows = query.query_map([], |row| row.get(0)).expect("runs");
        rows.collect::<Result<_, _>>().expect("names")
    };
    let tables = texts(
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'
         AND name NOT IN ('event', 'unjournaled', 'journal_ahead')",
    );
    let table_rows = |table: &String| {
        let mut query = db
            .prepare(&format!("SELECT * FROM \"{table}\" ORDER BY id"))
            .expect("a query");
        let names: Vec<String> = query
            .column_names()
            .into_iter()
            .map(str::to_owned)
            .collect();
        let rows = query.query_map([], |row| {
            let value = |(at, name): (usize, &String)| Ok((name.clone(), row.get(at)?));
            names.iter().enumerate().map(value).collect()
        });
        rows.expect("runs").collect::<Result<_, _>>().expect("rows")
    };
    tables
        .iter()
        .map(|table| (table.clone(), table_rows(table)))
        .collect()
}

/// Two waypoints with two references each, visits of every verdict, alarms in every state, a forgotten waypoint.
fn full_store(dir: &Path) -> Store {
    let mut store = Store::open(dir).expect("store");
    for (name, second) in [("hall", 0), ("yard", 1), ("dock", 2), ("yard", 3)] {
        teach(&mut store, name, second);
    }
    visit(
        &mut store,
        Verdict::Changed,
        &[novelty_at(1.0), novelty_at(2.5)],
        10,
    );
    visit(&mut store, Verdict::Quiet, &[], 20);
    let open = first_raised(&visit(
        &mut store,
        Verdict::Changed,
        &[novelty_at(-3.0)],
        30,
    ));
    visit(&mut store, Verdict::NotObserved, &[], 40);
    store
        .acknowledge(
            open.expect("raised"),
            "guard",
            Some("a \"box\"\nof ours"),
            &stamp(50),
        )
        .expect("acknowledged");
    let yard = store.reference("yard").expect("taught").id;
    changed_visit("yard", yard, 0.1 + 0.2, |new| {
        store.record_visit(new, &stamp(60)).expect("recorded")
    });
    store
        .forget_waypoint("dock", &stamp(70))
        .expect("forgotten");
    teach(&mut store, "dock", 80);
    store
        .note_event(Severity::Info, "service", "a note", &stamp(90))
        .expect("noted");
    store
}

pub(crate) fn files(dir: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(dir.join("blobs")).expect("blobs");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    files
}

pub(crate) fn remove_database(dir: &Path) {
    for name in ["patrold.db", "patrold.db-wal", "patrold.db-shm"] {
        let _ = fs::remove_file(dir.join(name));
    }
}

#[test]
fn a_database_that_is_gone_is_rebuilt_row_by_row() {
    let dir = tempfile::tempdir().expect("temp dir");
    full_store(dir.path()).close();
    let (before, files_before) = (rows(dir.path()), files(dir.path()));
    assert!(
        before
            .values()
            .all(|rows| rows.len() >= 2 || rows.is_empty()),
        "two of everything"
    );
    remove_database(dir.path());
    let rebuilt = Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
    assert_eq!(rows(dir.path()), before);
    assert_eq!(files(dir.path()), files_before);
    let counts = [
        rebuilt.damaged_lines,
        rebuilt.incomplete_rows,
        rebuilt.evidence_missing,
        rebuilt.unnamed_files,
    ];
    assert_eq!((counts, rebuilt.old_database), ([0; 4], None));
    let mut store = Store::open(dir.path()).expect("opens");
    assert!(store.check(|_, _| ()).expect("checked").is_sound());
    assert!(!store.is_lost().expect("asked"));
    // Numbers go on where they were.
    let next = visit(&mut store, Verdict::Changed, &[novelty_at(9.0)], 110);
    let last = before["visit"].len() as i64;
    assert_eq!(next.visit_id, last + 1);
    // Rebuilding a sound database changes nothing, and keeps its events.
    store
        .note_event(Severity::Info, "service", "kept", &stamp(115))
        .expect("noted");
    store.close();
    let before = rows(dir.path());
    let again = Store::rebuild(dir.path(), &stamp(120)).expect("rebuilt");
    assert_eq!(rows(dir.path()), before);
    assert!(again.old_database.is_some_and(|path| path.is_file()));
    let events = Store::open(dir.path())
        .expect("opens")
        .events(9)
        .expect("events");
    assert_eq!(events[0].text, "kept");
}

#[test]
fn a_lost_database_deletes_nothing_and_says_what_to_do() {
    for empty in [false, true] {
        let dir = tempfile::tempdir().expect("temp dir");
        full_store(dir.path()).close();
        let before = (rows(dir.path()), files(dir.path()));
        remove_database(dir.path());
        if empty {
            fs::write(dir.path().join("patrold.db"), b"").expect("emptied");
        }
        let mut ledger = Ledger::new(Store::open(dir.path()).expect("opens"));
        let start = ledger.start();
        let evidence = before
            .1
            .iter()
            .filter(|file| !file.ends_with("journal.txt"))
            .count();
        assert_eq!(start.lost_files, Some(evidence));
        ledger.store.apply_retention(&EVERYTHING).expect("applied");
        ledger.maintain();
        let refused = ledger
            .store
            .reference("hall")
            .expect_err("unknown")
            .to_string();
        let expected =
            format!("no reference, {evidence} evidence files; run patrold store rebuild");
        assert_eq!(refused, expected);
        ledger.close();
        let kept: Vec<PathBuf> = files(dir.path());
        assert_eq!(kept, before.1, "emptied: {empty}");
        Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
        assert_eq!(rows(dir.path()), before.0);
    }
}

#[test]
fn a_database_that_was_set_back_is_joined_with_what_followed() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    store.close();
    let early = fs::read(dir.path().join("patrold.db")).expect("a database");
    let mut store = Store::open(dir.path()).expect("store");
    let lost = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    store.close();
    remove_database(dir.path());
    fs::write(dir.path().join("patrold.db"), early).expect("set back");

    let mut store = Store::open(dir.path()).expect("opens");
    assert!(store.changes_lost().expect("asked") > 0);
    assert!(store.is_lost().expect("asked"));
    let after = visit(&mut store, Verdict::Changed, &[novelty_at(5.0)], 20);
    assert!(
        after.visit_id > lost.visit_id && first_raised(&after) > first_raised(&lost),
        "numbers are not used twice"
    );
    // Nothing new is taught: its name may be in the journal.
    drop(store);
    let store = Store::open(dir.path()).expect("opens again");
    assert!(
        store.changes_lost().expect("asked") > 0,
        "until it is rebuilt"
    );
    assert_eq!(
        store.check(|_, _| ()).expect("checked").unnamed.len(),
        1,
        "the sweep of the lost visit"
    );
    store.close();
    Store::rebuild(dir.path(), &stamp(30)).expect("rebuilt");
    let store = Store::open(dir.path()).expect("opens");
    assert_eq!(store.changes_lost().expect("asked"), 0);
    let alarms = store.alarms(&AlarmFilter::default()).expect("alarms");
    let ids: Vec<Option<i64>> = alarms.iter().map(|alarm| Some(alarm.id)).collect();
    assert_eq!(ids, [first_raised(&after), first_raised(&lost)]);
    assert!(store.visit(lost.visit_id).is_ok() && store.visit(after.visit_id).is_ok());
}

#[test]
fn what_the_journal_could_not_take_follows_later() {
    let dir = tempfile::tempdir().expect("temp dir");
    full_store(dir.path()).close();
    let disk = FaultyDisk::default();
    let store = Store::open_on(dir.path(), Arc::new(disk.clone())).expect("store");
    let mut ledger = Ledger::new(store);
    let yard = ledger.store.reference("yard").expect("taught").id;
    for (fault, step) in [
        (Fault::Full, "open to append"),
        (Fault::ShortWrite, "write"),
        (Fault::Failing, "sync"),
    ] {
        disk.fail(fault, 0, true);
        disk.steps().only = Some(step.to_owned());
        let recorded = changed_visit("yard", yard, 8.0, |new| {
            ledger.record_visit(new, &stamp(100))
        });
        assert!(
            matches!(recorded, Ok(VisitRecord::Stored(_))),
            "{step}: {recorded:?}"
        );
        assert!(ledger.store.journal_error().is_some(), "{step}");
        disk.heal();
        let report = ledger.maintain();
        assert_eq!(
            (report.journal_error, report.retry.waiting),
            (None, 0),
            "{step}"
        );
    }
    let check = ledger.store.check(|_, _| ()).expect("checked");
    assert_eq!(check.journal.waiting_rows, 0);
    ledger.close();
    let before = rows(dir.path());
    remove_database(dir.path());
    let rebuilt = Store::rebuild(dir.path(), &stamp(200)).expect("rebuilt");
    assert_eq!(rows(dir.path()), before);
    // The half lines that the full disk left.
    assert_eq!(rebuilt.damaged_lines, check.journal.damaged_lines);
}

#[test]
fn damaged_lines_cost_their_rows_alone_and_lost_files_are_marked() {
    let dir = tempfile::tempdir().expect("temp dir");
    full_store(dir.path()).close();
    let before = rows(dir.path());
    let journal = dir.path().join("blobs/journal.txt");
    let text = fs::read_to_string(&journal).expect("the journal");
    // The only line of the first shape or novelty; what belongs to it goes too.
    let damaged: String = text
        .lines()
        .map(|line| {
            let hit = line.contains("\"table\":\"waypoint\"") && line.contains("\"id\":2,");
            let line = if hit {
                line.replacen("yard", "yars", 1)
            } else {
                line.to_owned()
            };
            line + "\n"
        })
        .collect();
    assert_ne!(damaged, text);
    fs::write(&journal, damaged).expect("damaged");
    let named = before["sweep"]
        .iter()
        .flatten()
        .find_map(|(name, value)| match value {
            Value::Text(file) if name == "view_file" => Some(file.clone()),
            _ => None,
        });
    fs::remove_file(dir.path().join("blobs").join(named.expect("a view"))).expect("removed");
    remove_database(dir.path());
    let rebuilt = Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
    assert!(
        rebuilt.damaged_lines > 0 && rebuilt.incomplete_rows > 0,
        "{rebuilt:?}"
    );
    assert_eq!(rebuilt.evidence_missing, 1);
    let after = rows(dir.path());
    let of_hall = |rows: &Rows| -> usize {
        let is_of = |row: &&Vec<(String, Value)>| {
            row.contains(&("waypoint_id".to_owned(), Value::Integer(1)))
        };
        rows["visit"].iter().filter(is_of).count()
    };
    assert_eq!(of_hall(&after), of_hall(&before));
    assert_eq!(after["waypoint"].len(), before["waypoint"].len() - 1);
}

#[test]
fn a_line_after_one_that_was_cut_off_begins_anew() {
    let dir = tempfile::tempdir().expect("temp dir");
    full_store(dir.path()).close();
    let path = dir.path().join("blobs/journal.txt");
    let mut text = fs::read_to_string(&path).expect("the journal");
    text.truncate(text.len() - 20);
    let lines = text.lines().count();
    fs::write(&path, text).expect("cut off");
    let mut store = Store::open(dir.path()).expect("opens");
    store
        .acknowledge(1, "guard", None, &stamp(200))
        .expect("acknowledged");
    let journal = store.check(|_, _| ()).expect("checked").journal;
    assert_eq!(
        (journal.lines, journal.damaged_lines),
        (lines, 1),
        "{journal:?}"
    );
    let text = fs::read_to_string(&path).expect("the journal");
    assert!(
        text.ends_with("}\n") && !text.contains("\n\n"),
        "no line is empty"
    );
}

#[test]
fn a_rebuild_writes_no_row_down_again_and_a_check_counts_each_line() {
    let dir = tempfile::tempdir().expect("temp dir");
    full_store(dir.path()).close();
    let path = dir.path().join("blobs/journal.txt");
    let text = fs::read_to_string(&path).expect("the journal");
    remove_database(dir.path());
    Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
    assert_eq!(fs::read_to_string(&path).expect("the journal"), text);
    let journal = || {
        let store = Store::open_for_reading(dir.path()).expect("opens");
        store.check(|_, _| ()).map(|check| check.journal)
    };
    let lines = text.lines().count();
    let whole = journal().expect("checked");
    assert_eq!(
        (
            whole.lines,
            whole.damaged_lines,
            whole.waiting_rows,
            whole.ahead
        ),
        (lines, 0, 0, 0)
    );
    fs::write(&path, text.replacen('7', "8", 1)).expect("damaged");
    let damaged = journal().expect("checked");
    assert_eq!((damaged.lines, damaged.damaged_lines), (lines - 1, 1));
    fs::remove_file(&path).expect("removed");
    assert_eq!(journal().expect("checked").lines, 0, "none yet");
    fs::create_dir(&path).expect("a folder");
    let error = journal().expect_err("no file").to_string();
    assert!(error.contains("journal.txt"), "{error}");
}

#[test]
fn without_a_journal_there_is_nothing_to_rebuild_from() {
    let dir = tempfile::tempdir().expect("temp dir");
    fs::create_dir(dir.path().join("blobs")).expect("folder");
    let error = Store::rebuild(dir.path(), &stamp(0)).expect_err("no journal");
    assert!(matches!(error, StoreError::NoJournal { .. }), "{error}");
    assert!(error.to_string().contains("patrold restore"), "{error}");
}
