//! Another program holds the lock of the database: what is not stored is reported so, and stored when it lets go.

use super::faults::{ledger_of, store_with_an_alarm};
use super::kit::{accept, changed_visit, first_raised, stamp};
use patrold::store::{Store, StoreError, VisitRecord};
use rusqlite::Connection;
use std::path::Path;

/// Takes the write lock, as a program does that writes and is stopped in the middle.
fn hold_lock(dir: &Path) -> Connection {
    let other = Connection::open(dir.join("patrold.db")).expect("opens");
    other.execute_batch("BEGIN IMMEDIATE").expect("locked");
    other
}

fn is_busy(error: &StoreError) -> bool {
    error.to_string().contains("another program is writing")
}

#[test]
fn a_visit_is_held_until_the_lock_is_free() {
    let dir = tempfile::tempdir().expect("temp dir");
    store_with_an_alarm(dir.path());
    let (mut ledger, _) = ledger_of(dir.path());
    let reference = ledger.store.reference("yard").expect("taught").id;
    let other = hold_lock(dir.path());
    let recorded = changed_visit("yard", reference, 3.0, |new| {
        ledger
            .record_visit(new, &stamp(20))
            .expect("stored or held")
    });
    let VisitRecord::Held(why) = recorded else {
        panic!("{recorded:?}");
    };
    assert!(is_busy(&why), "{why}");
    assert_eq!(
        Store::open_for_reading(dir.path())
            .expect("reads")
            .alarm(1)
            .expect("kept")
            .state,
        "open"
    );
    drop(other);
    let stored = ledger.retry().stored;
    let raised = first_raised(&stored[0].2).expect("raised");
    let alarm = ledger.store.alarm(raised).expect("stored");
    assert_eq!(
        (alarm.waypoint.as_str(), alarm.novelties[0].centre[0]),
        ("yard", 3.0)
    );
}

#[test]
fn an_acknowledgement_and_an_accept_are_refused_while_the_lock_is_held() {
    let dir = tempfile::tempdir().expect("temp dir");
    store_with_an_alarm(dir.path());
    let mut store = Store::open(dir.path()).expect("opens");
    let other = hold_lock(dir.path());
    let refused = store
        .acknowledge(1, "guard", None, &stamp(30))
        .expect_err("busy");
    assert!(is_busy(&refused), "{refused}");
    let refused = accept(&mut store, 1, 40).expect_err("busy");
    assert!(is_busy(&refused), "{refused}");
    drop(other);
    assert_eq!(store.alarm(1).expect("kept").state, "open");
    store
        .acknowledge(1, "guard", None, &stamp(50))
        .expect("acknowledged");
    assert_eq!(accept(&mut store, 1, 60).expect("accepted"), 2);
}
