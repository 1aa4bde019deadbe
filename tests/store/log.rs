//! Lists of the log against the plain definition: every filter over random logs, pages, and the distances of the past.

use crate::kit::{novelty_at, stamp, teach};
use jiff::Timestamp;
use patrold::alarm::{AlarmAnswer, AlarmState, PastCase, PastDistance};
use patrold::patrol::severity::Severity;
use patrold::store::{
    AlarmFilter, EventFilter, NewVisit, RecordTime, Store, StoreError, TimeRange, VisitFilter,
};
use patrold_engine::novelty::Verdict;
use proptest::prelude::*;

const WAYPOINTS: [&str; 3] = ["hall", "dock", "attic"];
const VERDICTS: [Verdict; 3] = [Verdict::Quiet, Verdict::Changed, Verdict::NotObserved];

/// A visit of a random log: waypoint, verdict, and its second; `None`: the clock was not set.
type RandomVisit = (usize, usize, Option<i64>);

fn time_of(second: Option<i64>, row: usize) -> RecordTime {
    match second {
        Some(second) => stamp(second),
        None => RecordTime {
            at: Timestamp::from_second(row as i64).expect("a time"),
            boot_id: "early".to_owned(),
        },
    }
}

fn record(
    store: &mut Store,
    waypoint: &str,
    verdict: Verdict,
    d_gmm: Option<f64>,
    ground: &str,
    at: &RecordTime,
) -> i64 {
    // Each thing is at a place of its own.
    let x = at.at.as_second() as f64;
    let seen = if verdict == Verdict::Changed {
        vec![novelty_at(x)]
    } else {
        Vec::new()
    };
    let engine = format!("{{\"ground\": \"{ground}\"}}");
    let visit = NewVisit {
        waypoint,
        reference_id: Some(store.reference(waypoint).expect("reference").id),
        sweep: None,
        verdict,
        reason: "test",
        d_gmm,
        u_th: 0.001,
        seed: 7,
        engine: &engine,
        report: "{}",
        novelties: &seen,
        places: &[],
        same_place_m: 0.5,
    };
    store.record_visit(&visit, at).expect("recorded").visit_id
}

/// The log, and when `again` is reached the hall is forgotten and taught again.
fn random_log(dir: &std::path::Path, visits: &[RandomVisit], again: usize) -> Store {
    let mut store = Store::open(dir).expect("store");
    for name in WAYPOINTS {
        teach(&mut store, name, 0);
    }
    for (row, (waypoint, verdict, second)) in visits.iter().enumerate() {
        if row == again {
            store.forget_waypoint("hall", &stamp(0)).expect("forgotten");
            teach(&mut store, "hall", 0);
        }
        let at = time_of(*second, row);
        record(
            &mut store,
            WAYPOINTS[*waypoint],
            VERDICTS[*verdict],
            Some(0.002),
            "w2",
            &at,
        );
        let severity = [Severity::Info, Severity::Warning, Severity::Error][*verdict];
        store
            .note_event(severity, WAYPOINTS[*waypoint], "test", &at)
            .expect("noted");
    }
    store
}

fn is_in(second: Option<i64>, since: Option<i64>, until: Option<i64>) -> bool {
    second.is_none_or(|s| {
        since.is_none_or(|since| s >= since) && until.is_none_or(|until| s <= until)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_filter_lists_exactly_what_it_says(
        mut visits in prop::collection::vec((0usize..3, 0usize..3, prop::option::weighted(0.8, 0i64..40)), 1..25),
        again in 0usize..25, ordered in any::<bool>(),
        since in prop::option::of(0i64..40), until in prop::option::of(0i64..40),
        waypoint in prop::option::of(0usize..3), verdict in prop::option::of(0usize..3),
        limit in 0u32..8,
    ) {
        if ordered {
            visits.sort_by_key(|visit| visit.2.unwrap_or(0));
        }
        let dir = tempfile::tempdir().expect("temp dir");
        let store = random_log(dir.path(), &visits, again);
        let second = |s: Option<i64>| s.map(|s| stamp(s).at);
        let range = TimeRange { since: second(since), until: second(until) };
        let mut expected: Vec<i64> = visits.iter().zip(1i64..)
            .filter(|((at, of, s), _)| waypoint.is_none_or(|w| w == *at)
                && verdict.is_none_or(|v| v == *of) && is_in(*s, since, until))
            .map(|(_, id)| id).collect();
        expected.reverse();
        let filter = |limit| VisitFilter {
            range,
            waypoint: waypoint.map(|w| WAYPOINTS[w].to_owned()),
            verdict: verdict.map(|v| VERDICTS[v]),
            limit,
        };
        let ids = |limit| -> Vec<i64> {
            store.visits(&filter(limit)).expect("listed").iter().map(|v| v.id).collect()
        };
        prop_assert_eq!(&ids(1000), &expected);
        let some = ids(limit);
        prop_assert_eq!(some.len(), expected.len().min(limit as usize));
        // Where the clock only went forward, the newest by time are the newest by number.
        if ordered && visits.iter().all(|v| v.2.is_some()) || range.is_all() {
            prop_assert_eq!(&some[..], &expected[..some.len()]);
        }

        let events = store.events(EventFilter {
            range,
            severity: verdict.map(|v| [Severity::Info, Severity::Warning, Severity::Error][v]),
            device: waypoint.map(|w| WAYPOINTS[w].to_owned()),
            limit: 1000,
        }).expect("listed");
        let events: Vec<i64> = events.iter().map(|event| event.id).collect();
        prop_assert_eq!(&events, &expected);

        // The pages of a walk are all that match but the verdict, once, in order.
        let name = waypoint.map(|w| WAYPOINTS[w]);
        let (mut walked, mut after) = (Vec::new(), 0);
        loop {
            let page = store.visit_ids_after(after, &range, name, 3).expect("a page");
            let Some(last) = page.last() else { break };
            after = *last;
            walked.extend(page);
        }
        let all: Vec<i64> = visits.iter().zip(1i64..)
            .filter(|((at, _, s), _)| waypoint.is_none_or(|w| w == *at) && is_in(*s, since, until))
            .map(|(_, id)| id).collect();
        prop_assert_eq!(store.count_visits(&range, name).expect("counted"), all.len() as u64);
        prop_assert_eq!(walked, all);
    }
}

#[test]
fn alarms_are_read_in_pages_without_a_gap() {
    let dir = tempfile::tempdir().expect("temp dir");
    let visits: Vec<RandomVisit> = (0..12).map(|i| (i % 2, 1, Some(i as i64 * 100))).collect();
    let mut store = random_log(dir.path(), &visits, 99);
    store
        .acknowledge(5, "ana", None, &stamp(9000))
        .expect("acknowledged");
    let page = |before, state| -> Vec<i64> {
        let filter = AlarmFilter {
            before,
            state,
            limit: Some(5),
            ..AlarmFilter::default()
        };
        store
            .alarms(&filter)
            .expect("a page")
            .iter()
            .map(|a| a.id)
            .collect()
    };
    assert_eq!(page(None, None), [12, 11, 10, 9, 8]);
    assert_eq!(page(Some(8), None), [7, 6, 5, 4, 3]);
    assert_eq!(page(Some(3), None), [2, 1]);
    assert_eq!(page(Some(8), Some(AlarmState::Open)), [7, 6, 4, 3, 2]);
    assert_eq!(page(Some(1), None), [0i64; 0]);
}

fn past(store: &Store, waypoint: &str, range: &TimeRange) -> Vec<PastDistance> {
    let mut all = Vec::new();
    let each = &mut |one: &PastDistance| all.push(*one);
    store
        .each_past_distance(waypoint, range, "w2", each)
        .expect("read");
    all
}

#[test]
fn the_past_of_a_waypoint_is_its_own_in_its_unit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 0);
    record(
        &mut store,
        "dock",
        Verdict::Changed,
        Some(0.9),
        "w2",
        &stamp(100),
    );
    let quiet = record(
        &mut store,
        "hall",
        Verdict::Quiet,
        Some(1e-4),
        "w2",
        &stamp(200),
    );
    record(
        &mut store,
        "hall",
        Verdict::Quiet,
        Some(5.0),
        "fm",
        &stamp(300),
    );
    record(
        &mut store,
        "hall",
        Verdict::NotObserved,
        Some(0.5),
        "w2",
        &stamp(400),
    );
    record(&mut store, "hall", Verdict::Quiet, None, "w2", &stamp(500));
    let changed = record(
        &mut store,
        "hall",
        Verdict::Changed,
        Some(0.004),
        "w2",
        &stamp(600),
    );
    let visit = |id, d_gmm, case| PastDistance { id, d_gmm, case };
    let expected = [
        visit(quiet, 1e-4, PastCase::Quiet { listed: false }),
        visit(changed, 0.004, PastCase::Changed),
        visit(2, 0.004, PastCase::Alarm(None)),
    ];
    assert_eq!(past(&store, "hall", &TimeRange::default()), expected);

    store
        .acknowledge_and_answer(2, "ana", None, Some(AlarmAnswer::FalseAlarm), &stamp(700))
        .expect("answered");
    store
        .acknowledge_and_answer(2, "bo", None, Some(AlarmAnswer::Confirmed), &stamp(800))
        .expect("answered");
    store
        .acknowledge_and_answer(1, "bo", None, Some(AlarmAnswer::FalseAlarm), &stamp(900))
        .expect("answered");
    let hall = past(&store, "hall", &TimeRange::default());
    assert_eq!(hall[2].case, PastCase::Alarm(Some(AlarmAnswer::Confirmed)));
    let late = TimeRange {
        since: Some(stamp(600).at),
        until: None,
    };
    assert_eq!(past(&store, "hall", &late).len(), 2);
    let early = TimeRange {
        since: None,
        until: Some(stamp(599).at),
    };
    assert_eq!(past(&store, "hall", &early), expected[..1]);
    let unknown =
        store.acknowledge_and_answer(99, "ana", None, Some(AlarmAnswer::Confirmed), &stamp(900));
    assert!(matches!(unknown, Err(StoreError::UnknownAlarm(99))));
    let nobody = store.each_past_distance("attic", &late, "w2", &mut |_| ());
    assert!(matches!(nobody, Err(StoreError::NotInLog { .. })));
}
