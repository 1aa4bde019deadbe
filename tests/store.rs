//! The life of references and alarms in the store, told as a guard and an engineer would see it.

use nalgebra::{Matrix3, Point3};
use patrold::alarm::State;
use patrold::geometry::View;
use patrold::mixture::{Gaussian, Mixture};
use patrold::novelty::{Kind, Novelty, Verdict};
use patrold::patrol::NoveltyRecord;
use patrold::store::{
    AlarmFilter, Level, NewReference, NewVisit, Recorded, Retention, Stamp, Store, StoreError,
    SweepRecord,
};
use std::path::Path;

fn stamp(second: i64) -> Stamp {
    Stamp {
        at: jiff::Timestamp::from_second(1_800_000_000 + second).expect("a valid time"),
        boot_id: "boot".to_owned(),
    }
}

fn view(x: f64) -> View {
    View::bare(vec![Point3::new(x, 0.0, 0.0); 4], Point3::origin())
}

fn mixture() -> Mixture {
    Mixture {
        weights: vec![1.0],
        components: vec![gaussian(1.0)],
    }
}

fn gaussian(x: f64) -> Gaussian {
    Gaussian {
        mean: Point3::new(x, 0.0, 0.0),
        covariance: Matrix3::identity(),
    }
}

fn teach(store: &mut Store, name: &str, second: i64) -> i64 {
    let view = view(second as f64);
    let new = NewReference {
        waypoint: name,
        sweep: SweepRecord {
            view: &view,
            raw: Some(b"raw"),
            quality: "{}",
        },
        mixture: &mixture(),
    };
    store.teach(&new, &stamp(second)).expect("taught")
}

fn thing(x: f64) -> NoveltyRecord {
    let novelty = Novelty {
        kind: Kind::Appeared,
        moved_from: None,
        points: vec![0, 1],
        places: Vec::new(),
        moments: gaussian(x),
        mixture: mixture(),
        extent_m: [0.1, 0.1, 0.1],
        mass: 0.01,
        contribution: 0.005,
        support: 400.0,
    };
    NoveltyRecord::new(&novelty, None)
}

fn visit(store: &mut Store, verdict: Verdict, things: &[NoveltyRecord], second: i64) -> Recorded {
    let view = view(1000.0 + second as f64);
    let reference = store.reference("hall").expect("reference");
    let visit = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference.id),
        sweep: Some(SweepRecord {
            view: &view,
            raw: None,
            quality: "{}",
        }),
        verdict,
        reason: "test",
        d_gmm: Some(0.005),
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: things,
        same_place_m: 0.5,
    };
    store
        .record_visit(&visit, &stamp(second))
        .expect("recorded")
}

fn alarms(dir: &Path, filter: &AlarmFilter) -> Vec<(i64, String)> {
    let store = Store::open_for_reading(dir).expect("reader");
    let rows = store.alarms(filter).expect("query");
    rows.into_iter().map(|a| (a.id, a.state)).collect()
}

#[test]
fn an_alarm_is_raised_folded_acknowledged_and_cleared() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);

    let first = visit(&mut store, Verdict::Changed, &[thing(1.0)], 10);
    let id = first.raised.expect("raised");
    let again = visit(&mut store, Verdict::Changed, &[thing(1.1)], 20);
    assert_eq!((again.raised, again.folded), (None, Some(id)));

    let row = store
        .acknowledge(id, "ana", Some("known"), &stamp(25))
        .expect("acknowledged");
    assert_eq!(row.state, "acknowledged");
    assert_eq!(row.visits, 2);
    assert_eq!(row.novelties.len(), 1);
    assert_eq!(row.frame, "hall/1");

    let second = visit(&mut store, Verdict::Changed, &[thing(1.0), thing(5.0)], 30);
    let other = second.raised.expect("a second thing is a second alarm");
    visit(&mut store, Verdict::NotObserved, &[], 35);
    assert_eq!(
        alarms(dir.path(), &AlarmFilter::default()),
        [(other, "open".to_owned()), (id, "acknowledged".to_owned())]
    );
    let quiet = visit(&mut store, Verdict::Quiet, &[], 40);
    assert_eq!(quiet.cleared, [id, other]);
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
    let first = visit(&mut store, Verdict::Changed, &[thing(1.0)], 10)
        .raised
        .expect("raised");
    let second = visit(&mut store, Verdict::Changed, &[thing(5.0)], 20)
        .raised
        .expect("raised");
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
    assert_eq!(
        ids(AlarmFilter {
            waypoint: Some("dock".to_owned()),
            ..any()
        }),
        [0i64; 0]
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
            state: Some(State::Acknowledged),
            ..any()
        }),
        [first]
    );
    assert_eq!(
        ids(AlarmFilter {
            state: Some(State::Cleared),
            ..any()
        }),
        [0i64; 0]
    );
}

#[test]
fn teaching_again_makes_a_version_and_clears_what_spoke_of_the_old_one() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    assert_eq!(teach(&mut store, "hall", 0), 1);
    let id = visit(&mut store, Verdict::Changed, &[thing(1.0)], 10)
        .raised
        .expect("raised");
    assert_eq!(teach(&mut store, "hall", 20), 2);
    let alarm = store.alarm(id).expect("alarm");
    assert_eq!(
        alarm.cleared_because.as_deref(),
        Some("reference taught anew")
    );
    let reference = store.reference("hall").expect("newest");
    assert_eq!(reference.version, 2);
    assert_eq!(reference.view, view(20.0));
    assert_eq!(reference.mixture, mixture());
    let detail = store.waypoint("hall").expect("waypoint");
    assert_eq!(detail.references.len(), 2);

    store
        .forget_waypoint("hall", &stamp(30))
        .expect("forgotten");
    let unknown = store.reference("hall").expect_err("unknown now");
    assert!(
        unknown
            .to_string()
            .contains("unknown waypoint \"hall\"; known: none yet"),
        "{unknown}"
    );
    assert_eq!(store.alarms(&AlarmFilter::default()).expect("log").len(), 1);
}

#[test]
fn a_stored_visit_comes_back_as_it_was_judged() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let recorded = visit(&mut store, Verdict::Changed, &[thing(1.0)], 10);
    let back = store.visit(recorded.visit_id).expect("visit");
    assert_eq!(back.view, view(1010.0));
    assert_eq!((back.verdict.as_str(), back.seed), ("changed", 7));
    let reference = store
        .reference_by_id(back.reference_id)
        .expect("its reference");
    assert_eq!(reference.view, view(0.0));
    assert!(matches!(
        store.visit(999),
        Err(StoreError::UnknownVisit(999))
    ));
}

#[test]
fn retention_spares_evidence_and_references() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let quiet = visit(&mut store, Verdict::Quiet, &[], 10);
    let changed = visit(&mut store, Verdict::Changed, &[thing(1.0)], 20);
    let everything = Retention {
        older_than: Some(stamp(1000).at),
        most_bytes: Some(0),
    };
    let swept = store.retain(&everything).expect("retention");
    assert_eq!(swept.sweeps, 1);
    assert!(store.visit(quiet.visit_id).is_err());
    assert!(store.visit(changed.visit_id).is_ok());
    assert!(store.reference("hall").is_ok());
}

#[test]
fn events_are_kept_in_order() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    store
        .note_event(Level::Warning, "laser", "gone", &stamp(1))
        .expect("noted");
    store
        .note_event(Level::Info, "laser", "back", &stamp(2))
        .expect("noted");
    let events = store.events(10).expect("read");
    assert_eq!(events[0].text, "back");
    assert_eq!(events[1].level, "warning");
}
