//! What keeps the watch from seeing stands as a health incident until it is over.

use super::{
    DiskSpace, Duration, RetryResult, ScannerError, ScannerEvent, ServiceMessage, Stepped,
    StorageReport, Store, Value, WALL_CLOCK_STABLE_FOR, judgement,
};
use crate::store::{NewReference, RecordTime, ReferenceFrame, SweepRecord};
use jiff::Timestamp;
use nalgebra::Point3;
use patrold_engine::geometry::View;
use patrold_engine::mixture::Mixture;
use patrold_engine::novelty::ReferenceMixture;

fn stands(subject: &str, reason: &str) -> Vec<(String, String)> {
    vec![(subject.to_owned(), reason.to_owned())]
}

fn swept_badly(id: u64, reason: &str, lost: bool) -> ScannerEvent {
    let reason = reason.to_owned();
    ScannerEvent::SweepFailed(id, ScannerError { reason, lost }, None)
}

#[test]
fn devices_that_are_absent_fail_or_get_lost_are_noted_until_they_are_ready() {
    type Event = fn(String) -> ScannerEvent;
    let events: [(Event, &str); 3] = [
        (ScannerEvent::Absent, "laser: not plugged in"),
        (
            ScannerEvent::Failed,
            "ptu: in step mode; power it off and on",
        ),
        (ScannerEvent::Lost, "ptu: silent"),
    ];
    let mut service = Stepped::new("");
    for (event, reason) in events {
        service.scanner(event(reason.to_owned()));
        assert_eq!(service.health(), stands("devices", reason));
        service.scanner(ScannerEvent::Ready(Value::Null));
        assert_eq!(service.health(), [], "{reason}");
        let logged = service.events();
        for text in [format!("devices: {reason}"), "devices: over".to_owned()] {
            assert!(logged.contains(&text), "{text}: {logged:?}");
        }
    }
    let id = service.sweeping();
    service.scanner(swept_badly(id, "laser: has gone", true));
    assert_eq!(service.health(), stands("devices", "laser: has gone"));
}

#[test]
fn a_sweep_that_fails_or_cannot_be_judged_is_noted_until_one_can() {
    let mut service = Stepped::new("");
    let id = service.sweeping();
    service.scanner(swept_badly(id, "laser: silent during the sweep", false));
    assert_eq!(
        service.health(),
        stands("sweep", "laser: silent during the sweep")
    );
    for (fault, expected) in [
        (None, vec![]),
        (
            Some("blind: the laser is covered"),
            stands("sweep", "blind: the laser is covered"),
        ),
        (Some("frozen"), stands("sweep", "frozen")),
    ] {
        let mut service = Stepped::new("");
        let id = service.sweeping();
        let judged = |id| ServiceMessage::Judged(id, judgement(fault));
        service.controller.handle_message(judged(id + 1));
        assert_eq!(service.health(), [], "not the one that is being served");
        service.controller.handle_message(judged(id));
        assert_eq!(service.health(), expected);
        // The next sweep is well.
        service
            .controller
            .handle_message(ServiceMessage::Judged(id, judgement(None)));
        assert_eq!(service.health(), []);
    }
}

#[test]
fn a_sweep_that_was_cancelled_is_no_fault() {
    let mut service = Stepped::new("");
    let id = service.sweeping();
    service.controller.stop();
    service.scanner(swept_badly(id, "cancelled", false));
    assert_eq!(service.health(), []);
}

#[test]
fn a_clock_that_was_set_is_noted_until_it_is_stable() {
    let mut service = Stepped::new("");
    let at = |second| Timestamp::from_second(second).expect("a time");
    let minutes = |n: u64| Duration::from_secs(60 * n);
    service.controller.note_clock(minutes(1), at(0));
    service.controller.note_clock(minutes(2), at(60));
    assert_eq!(service.health(), [], "never set");
    let years_later = 1_800_000_000;
    service.controller.note_clock(minutes(3), at(years_later));
    let expected = stands(
        "clock",
        "the wall clock was set: earlier times may be wrong",
    );
    assert_eq!(service.health(), expected);
    let hour = WALL_CLOCK_STABLE_FOR.as_secs() as i64;
    let later = minutes(3) + WALL_CLOCK_STABLE_FOR;
    let second = Duration::from_secs(1);
    service
        .controller
        .note_clock(later - second, at(years_later + hour - 1));
    assert_eq!(service.health(), expected);
    service.controller.note_clock(later, at(years_later + hour));
    assert_eq!(service.health(), []);
}

#[test]
fn each_tick_looks_at_the_clock() {
    let mut service = Stepped::new("");
    service.controller.tick();
    assert_eq!(service.health(), []);
    let day = jiff::SignedDuration::from_hours(24);
    let elapsed = service.controller.started.elapsed();
    service
        .controller
        .note_clock(elapsed, Timestamp::now() + day);
    assert_eq!(service.health().len(), 1, "it was set since");
}

fn space(visits: u64) -> ServiceMessage {
    ServiceMessage::Storage(Box::new(StorageReport {
        retry: RetryResult::default(),
        journal_error: None,
        compacted: Ok(None),
        space: Ok(DiskSpace {
            free_bytes: (16 << 20) + visits * 1_000_000,
            visit_bytes: 1_000_000,
        }),
    }))
}

#[test]
fn a_store_without_space_is_noted_until_it_has_some() {
    let mut service = Stepped::new("");
    service.controller.handle_message(space(1000));
    assert_eq!(service.health(), []);
    service.controller.handle_message(space(119));
    let reason =
        "low space: 135 MB are free, room for 119 visits; make room or lower store.keep_gib";
    assert_eq!(service.health(), stands("storage", reason));
    for visits in [10, 149] {
        service.controller.handle_message(space(visits));
        assert_eq!(service.health(), stands("storage", reason), "as it began");
    }
    service.controller.handle_message(space(150));
    assert_eq!(service.health(), []);
    let logged = service.events();
    assert!(logged.contains(&format!("storage: {reason}")), "{logged:?}");
    assert!(logged.contains(&"storage: over".to_owned()), "{logged:?}");
}

/// What an earlier run left standing is over when this one finds it well.
#[test]
fn what_stood_at_the_stop_is_cleared_when_it_is_over() {
    let mut service = Stepped::new("");
    let note = |ledger: &mut crate::store::Ledger| {
        let stamp = stamp(0);
        for subject in ["storage", "devices"] {
            ledger
                .store
                .note_health(subject, Some("of the last run"), &stamp)
                .expect("noted");
        }
    };
    service.controller.services.writer.submit(note, |()| ());
    assert_eq!(service.health().len(), 2);
    service.controller.handle_message(space(1000));
    assert_eq!(service.health(), stands("devices", "of the last run"));
    service.scanner(ScannerEvent::Ready(Value::Null));
    assert_eq!(service.health(), []);
}

#[test]
fn what_could_not_be_written_is_noted_at_the_next_occasion() {
    let mut service = Stepped::new("");
    let absent = || ScannerEvent::Absent("laser: not plugged in".to_owned());
    service.scanner(absent());
    assert_eq!(service.health().len(), 1);
    let forget = |ledger: &mut crate::store::Ledger| {
        ledger
            .store
            .note_health("devices", None, &stamp(0))
            .expect("cleared");
    };
    service.controller.services.writer.submit(forget, |()| ());
    service.scanner(absent());
    assert_eq!(service.health(), [], "once is enough where it was written");
    service
        .controller
        .handle_message(ServiceMessage::HealthUnwritten("devices"));
    service.scanner(absent());
    assert_eq!(service.health(), stands("devices", "laser: not plugged in"));
}

pub(super) fn stamp(second: i64) -> RecordTime {
    RecordTime {
        at: Timestamp::from_second(1_600_000_000 + second).expect("a time"),
        boot_id: "boot".to_owned(),
    }
}

pub(super) fn teach(store: &mut Store, waypoint: &str) {
    teach_at(store, waypoint, &stamp(0));
}

fn teach_at(store: &mut Store, waypoint: &str, at: &RecordTime) {
    let view = View::from_points(vec![Point3::new(1.0, 0.0, 0.0); 4], Point3::origin());
    let mixture = ReferenceMixture {
        mixture: Mixture::default(),
        beams: Vec::new(),
    };
    let new = NewReference {
        waypoint,
        sweep: SweepRecord {
            view: Some(&view),
            raw: None,
            dialogue: None,
            quality: "null",
        },
        mixture: &mixture,
        model: "{}",
        engine: "{}",
        seed: 7,
        accepted: &[],
        frame: ReferenceFrame::Own,
    };
    store.teach(&new, at).expect("taught");
}

#[test]
fn a_waypoint_is_unseen_after_its_hours_and_not_before() {
    for (hours, is_noted) in [(1.0, true), (2.0, false)] {
        let mut service = Stepped::new(&format!("alarms.unseen_after = {hours:?}"));
        let taught = RecordTime {
            at: Timestamp::now() - jiff::SignedDuration::from_mins(90),
            boot_id: "boot".to_owned(),
        };
        let job = move |ledger: &mut crate::store::Ledger| {
            teach_at(&mut ledger.store, "hall", &taught);
        };
        service.controller.services.writer.submit(job, |()| ());
        service.controller.note_unseen();
        assert_eq!(service.health().len(), usize::from(is_noted), "{hours}");
    }
}

#[test]
fn a_waypoint_that_nobody_visits_is_noted_where_that_is_asked_for() {
    for (more, expected) in [
        ("", vec![]),
        (
            "alarms.unseen_after = 1.0",
            stands(
                "waypoint hall",
                &format!("not visited since {}", stamp(0).to_rfc3339()),
            ),
        ),
    ] {
        let mut service = Stepped::new(more);
        service
            .controller
            .services
            .writer
            .submit(|ledger| teach(&mut ledger.store, "hall"), |()| ());
        service.settle();
        service.controller.tick();
        assert_eq!(service.health(), expected, "{more}");
    }
}
