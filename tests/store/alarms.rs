//! Alarms: raised, extended, acknowledged, cleared, filtered.

use super::kit::{alarms, by_relation, novelty_at, raised, stamp, teach, visit, visit_of};
use patrold::alarm::{AlarmState, Relation};
use patrold::store::{AlarmEffects, AlarmFilter, Store, StoreError};
use patrold_engine::novelty::Verdict;

#[test]
fn an_alarm_is_raised_extended_acknowledged_and_cleared() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);

    let first = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    let id = raised(&first)[0];
    let again = visit(&mut store, Verdict::Changed, &[novelty_at(1.1)], 20);
    assert_eq!(by_relation(&again, Relation::Seen), [id]);
    assert_eq!(raised(&again), [0i64; 0]);

    let row = store
        .acknowledge(id, "ana", Some("known"), &stamp(25))
        .expect("acknowledged");
    assert_eq!(row.state, "acknowledged");
    assert_eq!(row.visits, 2);
    assert_eq!(row.novelties.len(), 1);
    assert_eq!(row.frame, "hall/1");

    let second = visit(
        &mut store,
        Verdict::Changed,
        &[novelty_at(1.0), novelty_at(5.0)],
        30,
    );
    let other = raised(&second)[0];
    assert_eq!(by_relation(&second, Relation::Seen), [id]);
    visit(&mut store, Verdict::NotObserved, &[], 35);
    assert_eq!(
        alarms(dir.path(), &AlarmFilter::default()),
        [(other, "open".to_owned()), (id, "acknowledged".to_owned())]
    );
    let quiet = visit(&mut store, Verdict::Quiet, &[], 40);
    assert_eq!(quiet.effects.cleared, [id, other]);
    let late = store
        .acknowledge(other, "ana", None, &stamp(45))
        .expect("late");
    assert_eq!(
        (late.state.as_str(), late.acknowledged_by.as_deref()),
        ("cleared", Some("ana"))
    );
    assert!(matches!(
        store.acknowledge(99, "ana", None, &stamp(46)),
        Err(StoreError::UnknownAlarm(99))
    ));
}

#[test]
fn each_filter_narrows_the_log() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let first = raised(&visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10))[0];
    let second = raised(&visit(&mut store, Verdict::Changed, &[novelty_at(5.0)], 20))[0];
    let ids = |filter: AlarmFilter| -> Vec<i64> {
        alarms(dir.path(), &filter)
            .into_iter()
            .map(|(id, _)| id)
            .collect()
    };
    let any = AlarmFilter::default;
    assert_eq!(
        ids(AlarmFilter {
            since: Some(stamp(15).at),
            ..any()
        }),
        [second]
    );
    assert_eq!(
        ids(AlarmFilter {
            until: Some(stamp(15).at),
            ..any()
        }),
        [first]
    );
    assert_eq!(
        ids(AlarmFilter {
            limit: Some(1),
            ..any()
        }),
        [second]
    );
    let misspelt = AlarmFilter {
        waypoint: Some("hal".to_owned()),
        ..any()
    };
    let unknown = store.alarms(&misspelt).expect_err("not in the log");
    assert!(
        unknown
            .to_string()
            .contains("unknown waypoint \"hal\"; the log knows: hall"),
        "{unknown}"
    );
    assert_eq!(
        ids(AlarmFilter {
            waypoint: Some("hall".to_owned()),
            ..any()
        }),
        [second, first]
    );
    store
        .acknowledge(first, "ana", None, &stamp(30))
        .expect("acknowledged");
    assert_eq!(
        ids(AlarmFilter {
            state: Some(AlarmState::Acknowledged),
            ..any()
        }),
        [first]
    );
    assert_eq!(
        ids(AlarmFilter {
            state: Some(AlarmState::Cleared),
            ..any()
        }),
        [0i64; 0]
    );
}

#[test]
fn a_change_that_is_still_there_keeps_its_alarm_through_a_quiet_visit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    let still_there = visit(&mut store, Verdict::Quiet, &[novelty_at(1.1)], 20);
    assert_eq!(still_there.effects.cleared, [0i64; 0]);
    assert_eq!(
        visit(&mut store, Verdict::Quiet, &[], 30)
            .effects
            .cleared
            .len(),
        1
    );
}

#[test]
fn a_reference_replaced_during_the_comparison_leaves_the_alarms_alone() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let old = store.reference("hall").expect("reference").id;
    teach(&mut store, "hall", 10);
    let late = visit_of(&mut store, old, Verdict::Changed, &[novelty_at(1.0)], 20);
    assert_eq!(
        (&late.effects, late.outdated),
        (&AlarmEffects::default(), true)
    );

    let new = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 30);
    let late = visit_of(&mut store, old, Verdict::Quiet, &[], 40);
    assert_eq!(
        (late.effects.cleared.len(), late.outdated, new.outdated),
        (0, true, false)
    );

    let newest = store.reference("hall").expect("reference").id;
    store
        .forget_waypoint("hall", &stamp(50))
        .expect("forgotten");
    let late = visit_of(&mut store, newest, Verdict::Changed, &[novelty_at(7.0)], 60);
    assert_eq!(
        (&late.effects, late.outdated),
        (&AlarmEffects::default(), true)
    );
    assert!(store.visit(late.visit_id).is_ok(), "stored all the same");
}

#[test]
fn the_first_name_stays_and_notes_are_appended() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let id = raised(&visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10))[0];
    let first = store
        .acknowledge(id, "ana", Some("a bin"), &stamp(20))
        .expect("first");
    store
        .acknowledge(id, "cy", None, &stamp(25))
        .expect("silent");
    let second = store
        .acknowledge(id, "bo", Some("gone by noon"), &stamp(30))
        .expect("second");
    assert_eq!(second.acknowledged_by.as_deref(), Some("ana"));
    assert_eq!(second.acknowledged_at, first.acknowledged_at);
    assert_eq!(second.note.as_deref(), Some("a bin\nbo: gone by noon"));
}
