//! The life of references and alarms in the store, told as a guard and an engineer would see it.

use nalgebra::{Matrix3, Point3};
use patrold::alarm::State;
use patrold::geometry::View;
use patrold::mixture::{Gaussian, Mixture};
use patrold::novelty::{Kind, Novelty, Rim, Verdict};
use patrold::patrol::NoveltyRecord;
use patrold::store::{
    AlarmFilter, Level, NewReference, NewVisit, Recorded, Retention, Stamp, Store, StoreError,
    SweepRecord,
};
use std::path::Path;

const EVERYTHING: Retention = Retention {
    older_than: Some(jiff::Timestamp::MAX),
    most_bytes: Some(0),
};

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
            view: Some(&view),
            raw: Some(b"raw"),
            quality: "{}",
        },
        mixture: &mixture(),
        engine: r#"{"ground": "w2"}"#,
        seed: 7,
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
        rim: Rim::default(),
        mass: 0.01,
        contribution: 0.005,
        support: 400.0,
    };
    NoveltyRecord::new(&novelty, None)
}

fn visit(store: &mut Store, verdict: Verdict, things: &[NoveltyRecord], second: i64) -> Recorded {
    let reference = store.reference("hall").expect("reference");
    visit_of(store, reference.id, verdict, things, second)
}

fn visit_of(
    store: &mut Store,
    reference: i64,
    verdict: Verdict,
    things: &[NoveltyRecord],
    second: i64,
) -> Recorded {
    let view = view(1000.0 + second as f64);
    let visit = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference),
        sweep: Some(SweepRecord {
            view: Some(&view),
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
    let typo = AlarmFilter {
        waypoint: Some("hal".to_owned()),
        ..any()
    };
    let unknown = store.alarms(&typo).expect_err("never heard of");
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
    assert_eq!(back.view, Some(view(1010.0)));
    assert_eq!((back.verdict.as_str(), back.seed), ("changed", 7));
    assert_eq!((back.engine.as_str(), back.quality.as_str()), ("{}", "{}"));
    let reference = store
        .reference_by_id(back.reference_id.expect("compared"))
        .expect("its reference");
    assert_eq!(reference.view, view(0.0));
    assert_eq!(
        (reference.engine.as_str(), reference.seed),
        (r#"{"ground": "w2"}"#, 7)
    );
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

#[test]
fn raw_data_that_could_not_be_assembled_is_kept() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let reference = store.reference("hall").expect("reference").id;
    let broken = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference),
        sweep: Some(SweepRecord {
            view: None,
            raw: Some(b"odd scans"),
            quality: "null",
        }),
        verdict: Verdict::NotObserved,
        reason: "cannot be assembled",
        d_gmm: None,
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: &[],
        same_place_m: 0.5,
    };
    let id = store
        .record_visit(&broken, &stamp(10))
        .expect("recorded")
        .visit_id;
    let back = store.visit(id).expect("kept");
    assert_eq!(
        (back.view, back.raw.as_deref()),
        (None, Some(&b"odd scans"[..]))
    );

    let no_sweep = NewVisit {
        sweep: None,
        ..broken
    };
    let id = store
        .record_visit(&no_sweep, &stamp(20))
        .expect("recorded")
        .visit_id;
    let none = store.visit(id).expect_err("nothing to judge");
    assert!(none.to_string().contains("none was taken"), "{none}");

    let reference = NewReference {
        waypoint: "dock",
        sweep: SweepRecord {
            view: None,
            raw: None,
            quality: "null",
        },
        mixture: &mixture(),
        engine: "{}",
        seed: 7,
    };
    assert!(store.teach(&reference, &stamp(30)).is_err());
}

#[test]
fn a_thing_that_is_still_there_keeps_its_alarm_through_a_quiet_visit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    visit(&mut store, Verdict::Changed, &[thing(1.0)], 10);
    let still_there = visit(&mut store, Verdict::Quiet, &[thing(1.1)], 20);
    assert_eq!(still_there.cleared, [0i64; 0]);
    assert_eq!(visit(&mut store, Verdict::Quiet, &[], 30).cleared.len(), 1);
}

#[test]
fn a_reference_replaced_during_the_comparison_leaves_the_alarms_alone() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let old = store.reference("hall").expect("reference").id;
    teach(&mut store, "hall", 10);
    let late = visit_of(&mut store, old, Verdict::Changed, &[thing(1.0)], 20);
    assert_eq!(
        (late.raised, late.folded, late.outdated),
        (None, None, true)
    );

    let raised = visit(&mut store, Verdict::Changed, &[thing(1.0)], 30);
    let late = visit_of(&mut store, old, Verdict::Quiet, &[], 40);
    assert_eq!(
        (late.cleared.len(), late.outdated, raised.outdated),
        (0, true, false)
    );

    let newest = store.reference("hall").expect("reference").id;
    store
        .forget_waypoint("hall", &stamp(50))
        .expect("forgotten");
    let late = visit_of(&mut store, newest, Verdict::Changed, &[thing(7.0)], 60);
    assert_eq!((late.raised, late.outdated), (None, true));
    assert!(store.visit(late.visit_id).is_ok(), "on record all the same");
}

#[test]
fn two_writers_wait_for_each_other() {
    let dir = tempfile::tempdir().expect("temp dir");
    drop(Store::open(dir.path()).expect("store"));
    let writer = |name: &'static str| {
        let dir = dir.path().to_owned();
        std::thread::spawn(move || {
            let mut store = Store::open_existing(&dir).expect("store");
            for second in 0..20 {
                teach(&mut store, name, second);
            }
        })
    };
    let both = [writer("hall"), writer("hall")];
    for one in both {
        one.join().expect("no write was refused");
    }
    let store = Store::open_for_reading(dir.path()).expect("reader");
    assert_eq!(store.reference("hall").expect("newest").version, 40);
}

#[test]
fn versions_go_on_after_a_waypoint_was_forgotten() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    assert_eq!(teach(&mut store, "hall", 0), 1);
    store
        .forget_waypoint("hall", &stamp(10))
        .expect("forgotten");
    assert_eq!(teach(&mut store, "hall", 20), 2);
    assert_eq!(teach(&mut store, "dock", 30), 1);
}

#[test]
fn figures_that_are_not_finite_lose_neither_visit_nor_log() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let mut odd = thing(1.0);
    odd.centre[2] = f64::NAN;
    odd.mass = f64::NAN;
    odd.covariance[0][0] = f64::INFINITY;
    let reference = store.reference("hall").expect("reference").id;
    let visit_with = |store: &mut Store, d_gmm, u_th, second| {
        let view = view(second as f64);
        let visit = NewVisit {
            waypoint: "hall",
            reference_id: Some(reference),
            sweep: Some(SweepRecord {
                view: Some(&view),
                raw: None,
                quality: "{}",
            }),
            verdict: Verdict::Changed,
            reason: "test",
            d_gmm,
            u_th,
            seed: 7,
            engine: "{}",
            report: "{}",
            novelties: std::slice::from_ref(&odd),
            same_place_m: 0.5,
        };
        store
            .record_visit(&visit, &stamp(second))
            .expect("recorded")
    };
    visit_with(&mut store, Some(f64::NAN), 0.001, 10);
    visit_with(&mut store, None, f64::NAN, 20);
    visit(&mut store, Verdict::Changed, &[thing(5.0)], 30);
    let log = store
        .alarms(&AlarmFilter::default())
        .expect("the whole log");
    assert_eq!(log.len(), 3);
    assert_eq!((log[2].d_gmm, log[1].u_th), (None, None));
    assert!(log[2].novelties[0].centre[2].is_nan());
    assert_eq!(log[0].d_gmm, Some(0.005));
}

#[test]
fn the_first_to_acknowledge_stays_and_notes_add_up() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let id = visit(&mut store, Verdict::Changed, &[thing(1.0)], 10)
        .raised
        .expect("raised");
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

#[test]
fn the_visits_in_the_middle_of_an_alarm_are_evidence() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let ids: Vec<i64> = [10, 20, 30]
        .into_iter()
        .map(|second| visit(&mut store, Verdict::Changed, &[thing(1.0)], second).visit_id)
        .collect();
    store.retain(&EVERYTHING).expect("retention");
    assert!(ids.iter().all(|id| store.visit(*id).is_ok()));
}

/// Size of the largest file there is: all views of these tests have as many points.
fn bytes_of_a_sweep(dir: &Path) -> u64 {
    let entries = std::fs::read_dir(dir.join("blobs")).expect("blobs");
    let sizes = entries.map(|entry| entry.and_then(|e| e.metadata()).expect("a file").len());
    sizes.max().expect("a sweep")
}

#[test]
fn evidence_does_not_push_out_the_rest() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    for second in 10..20 {
        visit(&mut store, Verdict::Changed, &[thing(1.0)], second);
    }
    let quiet = [
        visit(&mut store, Verdict::Quiet, &[], 30).visit_id,
        visit(&mut store, Verdict::Quiet, &[], 40).visit_id,
        visit(&mut store, Verdict::Quiet, &[], 50).visit_id,
    ];
    let one_sweep = bytes_of_a_sweep(dir.path());
    let limit = |most| Retention {
        older_than: None,
        most_bytes: Some(most),
    };
    assert_eq!(
        store.retain(&limit(3 * one_sweep)).expect("all fit").sweeps,
        0
    );
    assert_eq!(
        store
            .retain(&limit(2 * one_sweep))
            .expect("one goes")
            .sweeps,
        1
    );
    let kept: Vec<bool> = quiet.iter().map(|id| store.visit(*id).is_ok()).collect();
    assert_eq!(kept, [false, true, true], "the oldest");
}

#[test]
fn shared_files_count_once() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    // The same second, the same points, the same file.
    visit(&mut store, Verdict::Quiet, &[], 10);
    visit(&mut store, Verdict::Quiet, &[], 10);
    let one_sweep = bytes_of_a_sweep(dir.path());
    let limit = Retention {
        older_than: None,
        most_bytes: Some(one_sweep),
    };
    assert_eq!(store.retain(&limit).expect("fits").sweeps, 0);
}

#[test]
fn references_of_a_forgotten_waypoint_go_by_age_unless_they_are_evidence() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let spare = store.reference("hall").expect("reference").id;
    teach(&mut store, "hall", 10);
    let evidence = store.reference("hall").expect("reference").id;
    visit(&mut store, Verdict::Changed, &[thing(1.0)], 20);
    assert_eq!(store.retain(&EVERYTHING).expect("known").sweeps, 0);
    store
        .forget_waypoint("hall", &stamp(30))
        .expect("forgotten");
    let by_size = Retention {
        older_than: None,
        ..EVERYTHING
    };
    assert_eq!(store.retain(&by_size).expect("by age alone").sweeps, 0);
    assert_eq!(store.retain(&EVERYTHING).expect("old").sweeps, 1);
    let gone = store.reference_by_id(spare).expect_err("gone");
    assert!(gone.to_string().contains("retention"), "{gone}");
    assert!(store.reference_by_id(evidence).is_ok());
}

#[test]
fn what_a_stop_left_behind_is_swept_and_nothing_else() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let blobs = dir.path().join("blobs");
    let hash = "a".repeat(64);
    for name in [hash.clone(), format!("{hash}.tmp"), "notes.txt".to_owned()] {
        std::fs::write(blobs.join(name), b"left").expect("written");
    }
    let swept = store.sweep_orphans().expect("swept");
    assert_eq!((swept.sweeps, swept.bytes), (2, 8));
    assert!(blobs.join("notes.txt").is_file(), "not ours");
    assert!(store.reference("hall").is_ok());
    assert_eq!(store.sweep_orphans().expect("again").sweeps, 0);
}
