//! Each write changes the rows it is about and no other: a store with two of everything, and all rows before and after.

use super::kit::{by_relation, changed_visit, novelty_at, stamp, teach, visit_of};
use super::rebuild::rows;
use patrold::alarm::Relation;
use patrold::store::{Retention, Store, VisitOutcome};
use patrold_engine::novelty::Verdict;
use std::collections::BTreeSet;
use std::path::Path;

/// Tables with ids: hall has sweeps 1, 3, 5, references 1, 3; yard 2, 4, 6 and 2, 4. Alarms 1 (hall, cleared), 2 (yard,
/// cleared), 3 (hall, open), 4 (yard, acknowledged), 5 (hall, open), 6 (yard, open).
fn two_of_everything(dir: &Path) -> Store {
    let mut store = Store::open(dir).expect("store");
    for (name, second) in [("hall", 0), ("yard", 1)] {
        teach(&mut store, name, second);
    }
    raise(&mut store, "hall", 1.0, 10);
    raise(&mut store, "yard", 1.0, 11);
    for (name, second) in [("hall", 20), ("yard", 21)] {
        teach(&mut store, name, second);
    }
    for (name, x, second) in [
        ("hall", 1.0, 30),
        ("yard", 1.0, 31),
        ("hall", 9.0, 40),
        ("yard", 9.0, 41),
    ] {
        raise(&mut store, name, x, second);
    }
    store
        .acknowledge(4, "guard", None, &stamp(50))
        .expect("acknowledged");
    store
}

fn raise(store: &mut Store, waypoint: &str, x: f64, second: i64) -> VisitOutcome {
    let reference = store.reference(waypoint).expect("taught").id;
    changed_visit(waypoint, reference, x, |new| {
        store.record_visit(new, &stamp(second)).expect("recorded")
    })
}

/// Rows that are new or differ, as `table id`.
fn changes(dir: &Path, store: &mut Store, write: impl FnOnce(&mut Store)) -> BTreeSet<String> {
    let before = rows(dir);
    write(store);
    let after = rows(dir);
    let mut changed = BTreeSet::new();
    for (table, rows) in after {
        for row in rows {
            if !before[&table].contains(&row) {
                let id = &row.iter().find(|(name, _)| name == "id").expect("an id").1;
                changed.insert(format!("{table} {}", as_number(id)));
            }
        }
    }
    changed
}

fn as_number(value: &rusqlite::types::Value) -> i64 {
    match value {
        rusqlite::types::Value::Integer(number) => *number,
        other => panic!("an id: {other:?}"),
    }
}

fn set(rows: &[&str]) -> BTreeSet<String> {
    rows.iter().map(|row| (*row).to_owned()).collect()
}

#[test]
fn each_write_changes_its_own_rows() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (path, mut store) = (dir.path(), two_of_everything(dir.path()));
    let states: Vec<String> = (1..=6)
        .map(|id| store.alarm(id).expect("raised").state)
        .collect();
    assert_eq!(
        states,
        ["cleared", "cleared", "open", "acknowledged", "open", "open"]
    );

    let acknowledged = changes(path, &mut store, |store| {
        store
            .acknowledge(5, "guard", Some("a box"), &stamp(60))
            .map(drop)
            .expect("acknowledged")
    });
    assert_eq!(acknowledged, set(&["alarm 5"]));
    let extended = changes(path, &mut store, |store| {
        assert_eq!(
            by_relation(&raise(store, "yard", 9.0, 70), Relation::Seen),
            [6]
        );
    });
    assert_eq!(
        extended,
        set(&["alarm 6", "visit 7", "sweep 11", "novelty 7", "sighting 7"])
    );
    let quiet = changes(path, &mut store, |store| {
        let reference = store.reference("hall").expect("taught").id;
        // The thing of alarm 3 is still there.
        visit_of(store, reference, Verdict::Quiet, &[novelty_at(1.0)], 80);
    });
    assert_eq!(
        quiet,
        set(&[
            "alarm 3",
            "alarm 5",
            "visit 8",
            "sweep 12",
            "novelty 8",
            "sighting 8",
            "sighting 9"
        ])
    );
    let taught = changes(path, &mut store, |store| {
        teach(store, "hall", 90);
    });
    assert_eq!(taught, set(&["alarm 3", "reference 5", "sweep 13"]));
    let forgotten = changes(path, &mut store, |store| {
        store
            .forget_waypoint("yard", &stamp(100))
            .expect("forgotten");
    });
    assert_eq!(forgotten, set(&["alarm 4", "alarm 6", "waypoint 2"]));
    let old = Retention {
        older_than: Some(stamp(85).at),
        max_bytes: None,
        unnamed_older_than: None,
    };
    let swept = changes(path, &mut store, |store| {
        store.apply_retention(&old).map(drop).expect("applied")
    });
    assert_eq!(
        swept,
        set(&[]),
        "a visit that still sees the thing is evidence"
    );
    let check = store.check(|_, _| ()).expect("checked");
    assert!(
        check.missing.is_empty() && check.unnamed.is_empty(),
        "{check:?}"
    );
}
