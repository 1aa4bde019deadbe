//! What a tick does when it is due, and what a start reports.

use super::health::{stamp, teach};
use super::{Instant, Stepped, Store, TIMEOUT, WALL_CLOCK_STABLE_FOR};
use crate::service::captured_log::captured;
use crate::store::{NewVisit, StoreStart, SweepRecord};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

#[test]
fn a_call_that_hangs_is_logged_once_until_it_returns() {
    let mut service = Stepped::new("");
    let began = service.controller.step_started;
    let late = began + Duration::from_secs(1000);
    let count = |service: &mut Stepped, now| {
        let log = captured(|| service.controller.tick_at(now));
        log.matches("watchdog notifications stopped").count()
    };
    for _ in 0..2 {
        service.controller.judging = true;
        assert_eq!(count(&mut service, late), 1);
        assert_eq!(count(&mut service, late), 0);
        service.controller.judging = false;
        assert_eq!(count(&mut service, began), 0);
    }
}

#[test]
fn retention_waits_until_it_is_due_and_nobody_is_served() {
    for (due, served, expected) in [
        (true, false, true),
        (false, false, false),
        (true, true, false),
    ] {
        let mut service = Stepped::new("");
        if served {
            service.sweeping();
        }
        let now = Instant::now();
        let at = if due { now } else { now + TIMEOUT };
        service.controller.retention_due = at;
        service.controller.tick_at(now);
        let is_done = service.controller.retention_due > at;
        assert_eq!(is_done, expected, "{due} {served}");
    }
}

#[test]
fn retention_deletes_by_size_where_that_is_asked_for() {
    for (gib, is_kept) in [("0", true), ("1e-9", false), ("1.0", true)] {
        let mut service = Stepped::new(&format!("store.keep_days = 0\nstore.keep_gib = {gib}"));
        service.controller.services.writer.submit(
            |ledger| {
                teach(&mut ledger.store, "hall");
                not_observed(&mut ledger.store);
            },
            |()| (),
        );
        service.controller.apply_retention();
        service.settle();
        let store = Store::open_for_reading(&service.store_dir()).expect("readable");
        let detail = store.visit_detail(1).expect("its row stays");
        assert_eq!(detail.sweep_kept, is_kept, "{gib}");
        assert!(store.reference("hall").is_ok(), "never a reference in use");
    }
}

/// A visit whose sweep could not be assembled.
fn not_observed(store: &mut Store) {
    let visit = NewVisit {
        waypoint: "hall",
        reference_id: None,
        sweep: Some(SweepRecord {
            view: None,
            raw: Some(b"raw data"),
            dialogue: None,
            quality: "null",
        }),
        verdict: Verdict::NotObserved,
        reason: "gaps",
        d_gmm: None,
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: &[],
        places: &[],
        same_place_m: 0.5,
    };
    store.record_visit(&visit, &stamp(5)).expect("recorded");
}

#[test]
fn retention_deletes_by_age_where_that_is_asked_for_and_the_clock_can_be_trusted() {
    let kept = |more: &str, is_stable: bool| {
        let mut service = Stepped::new(more);
        service.controller.services.writer.submit(
            |ledger| {
                teach(&mut ledger.store, "hall");
                teach(&mut ledger.store, "yard");
                ledger
                    .store
                    .forget_waypoint("yard", &stamp(1))
                    .expect("forgotten");
            },
            |()| (),
        );
        if is_stable {
            let first = jiff::Timestamp::from_second(0).expect("a time");
            service.controller.note_clock(Duration::ZERO, first);
            service.controller.started -= WALL_CLOCK_STABLE_FOR;
        }
        service.controller.apply_retention();
        service.settle();
        let store = Store::open_for_reading(&service.store_dir()).expect("readable");
        ["hall", "yard"].map(|name| store.reference_version(name, 1).is_ok())
    };
    assert_eq!(
        kept("store.keep_days = 0\nstore.keep_gib = 0", true),
        [true, true]
    );
    // Of 2020, and its waypoint is forgotten.
    assert_eq!(
        kept("store.keep_days = 1\nstore.keep_gib = 0", true),
        [true, false]
    );
    assert_eq!(
        kept("store.keep_days = 1\nstore.keep_gib = 0", false),
        [true, true]
    );
}

#[test]
fn what_the_start_found_in_the_store_is_in_the_log() {
    let mut service = Stepped::new("");
    let start = StoreStart {
        evidence_missing: 2,
        lost_files: Some(7),
        ..StoreStart::default()
    };
    service.controller.report_store_start(&start);
    let logged = service.events();
    for part in ["2 sweeps have no files", "in 7 evidence files"] {
        assert!(logged.iter().any(|text| text.contains(part)), "{logged:?}");
    }
}
