//! One alarm per thing, as rows: two of everything, so that a wrong link shows.

use super::kit::{novelty_at, raised, stamp, teach, visit};
use patrold::alarm::Relation;
use patrold::store::{
    AlarmFilter, AlarmRow, FloorPlace, NearFilter, NewVisit, Store, ThingFilter, VisitOutcome,
};
use patrold_engine::novelty::{PlaceView, Verdict};
use patrold_engine::report::{NoveltyRecord, ShapeRecord};

/// A box of this width, in metres; its height is 1 m.
pub(crate) fn thing(x: f64, width: f64) -> NoveltyRecord {
    let variances = [width * width / 12.0, 0.02, 1.0 / 12.0];
    NoveltyRecord {
        covariance: [0, 1, 2]
            .map(|row| [0, 1, 2].map(|c| if row == c { variances[row] } else { 0.0 })),
        contribution: 0.001 * x,
        shape: Some(ShapeRecord {
            class: "box".to_owned(),
            method: "covariance".to_owned(),
            probability: 1.0,
            alternatives: Vec::new(),
            centre: [x, 0.0, 0.0],
            centre_sd: [0.01; 3],
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            size: [1.0, width, 0.5],
            size_sd: [0.01; 3],
            exponents: None,
            residual_m: 0.004,
            inliers: 2,
        }),
        ..novelty_at(x)
    }
}

struct Visit<'a> {
    waypoint: &'a str,
    seen: &'a [NoveltyRecord],
    places: &'a [(i64, PlaceView)],
    second: i64,
}

fn record(store: &mut Store, verdict: Verdict, of: &Visit<'_>) -> VisitOutcome {
    let visit = NewVisit {
        waypoint: of.waypoint,
        reference_id: Some(store.reference(of.waypoint).expect("reference").id),
        sweep: None,
        verdict,
        reason: "test",
        d_gmm: Some(0.1 * of.second as f64),
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: of.seen,
        places: of.places,
        same_place_m: 0.5,
    };
    store
        .record_visit(&visit, &stamp(of.second))
        .expect("recorded")
}

pub(crate) fn changed(
    store: &mut Store,
    waypoint: &str,
    seen: &[NoveltyRecord],
    second: i64,
) -> VisitOutcome {
    let places: Vec<(i64, PlaceView)> = store
        .incidents(waypoint)
        .expect("incidents")
        .iter()
        .map(|incident| (incident.id, PlaceView::AsTaught))
        .collect();
    let of = Visit {
        waypoint,
        seen,
        places: &places,
        second,
    };
    record(store, Verdict::Changed, &of)
}

pub(crate) fn relations(outcome: &VisitOutcome) -> Vec<(i64, Relation, usize)> {
    let alarms = outcome.effects.alarms.iter();
    alarms.map(|a| (a.id, a.relation, a.position)).collect()
}

pub(crate) fn states(store: &Store) -> Vec<(i64, String)> {
    let rows = store.alarms(&AlarmFilter::default()).expect("alarms");
    rows.into_iter().rev().map(|a| (a.id, a.state)).collect()
}

pub(crate) fn unchanged(store: &Store, id: i64, before: &AlarmRow) {
    assert_eq!(&store.alarm(id).expect("alarm"), before);
}

/// The hall with alarms 1 (0.4 m wide, at 1 m) and 2 (0.9 m, at 4 m), the dock with 3 (0.4 m, at 1 m).
pub(crate) fn two_waypoints() -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 1);
    let first = changed(&mut store, "hall", &[thing(1.0, 0.4), thing(4.0, 0.9)], 10);
    assert_eq!(raised(&first), [1, 2], "two new things are two alarms");
    let other = changed(&mut store, "dock", &[thing(1.0, 0.4)], 20);
    assert_eq!(raised(&other), [3]);
    (dir, store)
}

#[test]
fn each_thing_has_its_own_visits_score_and_place() {
    let (_dir, mut store) = two_waypoints();
    let dock = store.alarm(3).expect("alarm");
    // The list of the second visit is in another order.
    let again = changed(
        &mut store,
        "hall",
        &[thing(4.02, 0.9), thing(1.01, 0.4)],
        30,
    );
    assert_eq!(
        relations(&again),
        [(2, Relation::Seen, 0), (1, Relation::Seen, 1)]
    );
    let small = store.alarm(1).expect("alarm");
    assert_eq!((small.visits, small.novelties.len()), (2, 1));
    assert_eq!(small.novelties[0].centre[0], 1.0);
    let last = small.last_sighting.expect("seen");
    assert_eq!((last.visit_id, last.novelties[0].centre[0]), (3, 1.01));
    assert_eq!((small.d_gmm, last.d_gmm), (Some(1.0), Some(3.0)));
    assert!((small.score.expect("a score") - 0.00101).abs() < 1e-12);
    let large = store.alarm(2).expect("alarm");
    assert_eq!(large.novelties[0].centre[0], 4.0);
    assert!((large.score.expect("a score") - 0.00402).abs() < 1e-12);
    unchanged(&store, 3, &dock);
}

#[test]
fn one_goes_and_the_others_stay() {
    let (_dir, mut store) = two_waypoints();
    let dock = store.alarm(3).expect("alarm");
    let gone = changed(&mut store, "hall", &[thing(4.0, 0.9)], 30);
    assert_eq!(gone.effects.cleared, [1]);
    let expected = [(1, "cleared"), (2, "open"), (3, "open")];
    assert_eq!(states(&store), expected.map(|(id, s)| (id, s.to_owned())));
    let cleared = store.alarm(1).expect("alarm");
    let parts: Vec<_> = cleared
        .sightings
        .expect("details")
        .into_iter()
        .map(|s| (s.visit_id, s.relation))
        .collect();
    assert_eq!(parts, [(1, "raised".to_owned()), (3, "gone".to_owned())]);
    assert_eq!(cleared.last_sighting.expect("seen").visit_id, 1);
    let back = changed(&mut store, "hall", &[thing(4.0, 0.9), thing(1.02, 0.4)], 40);
    assert_eq!(
        relations(&back),
        [(2, Relation::Seen, 0), (1, Relation::Back, 1)]
    );
    let row = store.alarm(1).expect("alarm");
    assert_eq!((row.state.as_str(), row.cleared_at), ("open", None));
    unchanged(&store, 3, &dock);
}

/// Alarms of the hall whose thing is at this place, as it was last seen.
fn ids_near(store: &Store, x_m: f64) -> Vec<i64> {
    let place = FloorPlace {
        waypoint: "hall".to_owned(),
        x_m,
        y_m: 0.0,
    };
    let near = NearFilter {
        places: vec![place],
        within_m: 0.3,
    };
    let filter = AlarmFilter {
        thing: ThingFilter {
            near: Some(near),
            ..ThingFilter::default()
        },
        ..AlarmFilter::default()
    };
    let rows = store.alarms(&filter).expect("alarms");
    rows.into_iter().map(|row| row.id).collect()
}

#[test]
fn an_acknowledged_thing_hides_no_other_and_is_open_again_when_it_moves() {
    let (_dir, mut store) = two_waypoints();
    store
        .acknowledge(1, "ana", Some("a box"), &stamp(25))
        .expect("acknowledged");
    store
        .acknowledge(2, "bo", None, &stamp(26))
        .expect("acknowledged");
    // Another thing in the first one's place; the second moved by 2 m.
    let visit = changed(&mut store, "hall", &[thing(1.0, 0.7), thing(6.0, 0.9)], 30);
    assert_eq!(
        relations(&visit),
        [(4, Relation::Raised, 0), (2, Relation::Moved, 1)]
    );
    let moved = store.alarm(2).expect("alarm");
    assert_eq!(moved.state, "open");
    let last = moved.last_sighting.as_ref().expect("seen");
    assert_eq!(
        (last.relation.as_str(), last.distance_m),
        ("moved", Some(2.0))
    );
    for (x_m, expected) in [(6.0, vec![2]), (4.0, vec![])] {
        assert_eq!(
            ids_near(&store, x_m),
            expected,
            "where it was last seen, {x_m}"
        );
    }
    assert_eq!(
        (moved.novelties[0].centre[0], last.novelties[0].centre[0]),
        (4.0, 6.0)
    );
    // From there it is compared with its new place.
    let again = changed(&mut store, "hall", &[thing(1.0, 0.7), thing(6.0, 0.9)], 40);
    assert_eq!(
        relations(&again),
        [(4, Relation::Seen, 0), (2, Relation::Seen, 1)]
    );
    let row = store
        .acknowledge(2, "cy", Some("the cart"), &stamp(50))
        .expect("again");
    assert_eq!(row.acknowledged_by.as_deref(), Some("cy"));
    let note = row.note.expect("a note");
    assert!(
        note.contains(" by bo, open again later\nthe cart"),
        "{note}"
    );
}

#[test]
fn an_unseen_place_is_said_and_forgotten_when_it_is_seen() {
    let (_dir, mut store) = two_waypoints();
    let hidden = |seen, second| Visit {
        waypoint: "hall",
        seen,
        places: &[(2, PlaceView::Otherwise)],
        second,
    };
    let still = [thing(4.0, 0.9)];
    let visit = record(&mut store, Verdict::Changed, &hidden(&still, 30));
    assert_eq!(
        (visit.effects.unobserved, visit.effects.cleared),
        (vec![1], vec![])
    );
    record(&mut store, Verdict::NotObserved, &hidden(&[], 40));
    let since = |store: &Store, id| store.alarm(id).expect("alarm").unobserved_since;
    assert_eq!(since(&store, 1), Some(stamp(30).to_rfc3339()), "the first");
    assert_eq!(since(&store, 2), Some(stamp(40).to_rfc3339()));
    assert_eq!(since(&store, 3), None, "of another waypoint");
    changed(&mut store, "hall", &[thing(1.0, 0.4)], 50);
    assert_eq!((since(&store, 1), since(&store, 2)), (None, None));
}

#[test]
fn a_new_reference_clears_its_own_waypoint_and_rewrites_no_cleared_alarm() {
    let (_dir, mut store) = two_waypoints();
    changed(&mut store, "hall", &[thing(4.0, 0.9)], 30);
    let (cleared, dock) = (store.alarm(1).expect("1"), store.alarm(3).expect("3"));
    teach(&mut store, "hall", 60);
    let because = store.alarm(2).expect("2").cleared_because;
    assert_eq!(because.as_deref(), Some("accepted with reference hall/2"));
    unchanged(&store, 1, &cleared);
    unchanged(&store, 3, &dock);
    // What was gone before is in another frame.
    let visit = changed(&mut store, "hall", &[thing(1.0, 0.4)], 70);
    assert_eq!(raised(&visit), [4]);
    store
        .forget_waypoint("hall", &stamp(80))
        .expect("forgotten");
    assert_eq!(store.alarm(4).expect("4").state, "cleared");
    unchanged(&store, 1, &cleared);
    unchanged(&store, 3, &dock);
}

#[test]
fn visits_of_things_are_evidence_and_others_are_not() {
    let (_dir, mut store) = two_waypoints();
    let quiet = visit(&mut store, Verdict::Quiet, &[], 90);
    let seen = visit(&mut store, Verdict::Changed, &[thing(1.0, 0.4)], 100);
    store
        .apply_retention(&super::kit::EVERYTHING)
        .expect("retention");
    assert!(store.visit(quiet.visit_id).is_err());
    assert!(store.visit(seen.visit_id).is_ok());
}

/// As many things that are gone as are compared with what a visit sees (`src/store/alarms/incidents.rs`).
const MAX_GONE: i64 = 32;

#[test]
fn of_things_that_are_gone_the_latest_may_come_back_and_all_that_stand_are_known() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    for n in 0..MAX_GONE + 3 {
        let x = 10.0 * n as f64;
        assert_eq!(
            raised(&changed(&mut store, "hall", &[thing(x, 0.4)], 10 * n)),
            [n + 1]
        );
        let gone = Visit {
            waypoint: "hall",
            seen: &[],
            places: &[(n + 1, PlaceView::AsTaught)],
            second: 10 * n + 5,
        };
        record(&mut store, Verdict::Quiet, &gone);
    }
    let standing: Vec<_> = (1..=40).map(|n| thing(-10.0 * f64::from(n), 0.4)).collect();
    let stand = raised(&changed(&mut store, "hall", &standing, 9000));
    assert_eq!(stand.len(), standing.len());
    let known = store.incidents("hall").expect("incidents");
    let ids: Vec<i64> = known.iter().map(|incident| incident.id).collect();
    let expected: Vec<i64> = (4..=MAX_GONE + 3).chain(stand).collect();
    assert_eq!(ids, expected);
}
