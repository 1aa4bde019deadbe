//! The watchdog, and the second sweep of a visit.

use super::{
    Instant, JUDGE_LIMIT, STORE_WRITE_LIMIT, ScannerEvent, ServiceMessage, Stepped, TIMEOUT, Value,
    empty_sweep, judgement,
};
use crate::patrol::event::SettingsChange;
use crate::patrol::turn_history::SeenTurn;
use crate::service::scanner_thread::max_sweep_duration;
use std::sync::mpsc;

/// Whether a tick at this instant feeds the watchdog, with nothing left to be written.
fn feeds_when_written(service: &mut Stepped, now: Instant) -> bool {
    service.settle();
    // The last job is done a moment before its thread says so.
    let hung = Instant::now() + 2 * STORE_WRITE_LIMIT;
    while service.controller.services.writer.is_overdue(hung) {
        std::thread::yield_now();
    }
    feeds(service, now)
}

fn feeds(service: &mut Stepped, now: Instant) -> bool {
    let before = service.controller.services.systemd.last_fed();
    service.controller.tick_at(now);
    let fed = service.controller.services.systemd.last_fed() != before;
    assert_eq!(fed, !service.controller.overdue);
    fed
}

#[test]
fn a_judgement_that_hangs_stops_the_watchdog() {
    let mut service = Stepped::new("");
    let began = service.controller.step_started;
    assert!(
        feeds_when_written(&mut service, began + 2 * JUDGE_LIMIT),
        "nothing is judged"
    );
    service.controller.judging = true;
    assert!(feeds_when_written(&mut service, began + JUDGE_LIMIT));
    assert!(!feeds_when_written(&mut service, began + 2 * JUDGE_LIMIT));
    service.controller.judging = false;
    assert!(feeds_when_written(&mut service, began + 2 * JUDGE_LIMIT));
}

#[test]
fn a_write_that_hangs_stops_the_watchdog() {
    let mut service = Stepped::new("");
    let (begin, begun) = mpsc::channel();
    let (release, released) = mpsc::channel::<()>();
    service.controller.services.writer.submit(
        move |_| {
            begin.send(()).expect("awaited");
            let _ = released.recv();
        },
        |()| (),
    );
    begun.recv_timeout(TIMEOUT).expect("begun");
    let late = Instant::now() + 2 * STORE_WRITE_LIMIT;
    assert!(feeds(&mut service, Instant::now()));
    assert!(!feeds(&mut service, late));
    drop(release);
    service.settle();
    // The upkeep that a tick submitted is done by now.
    service.controller.tick_at(Instant::now());
    service.settle();
    assert!(feeds(&mut service, Instant::now()));
}

#[test]
fn a_sweep_that_hangs_stops_the_watchdog() {
    let mut service = Stepped::new("");
    let limit = max_sweep_duration(&service.controller.settings, Some("hall"));
    service.sweeping();
    let late = Instant::now() + 2 * limit + TIMEOUT;
    // The command reaches the scanner's thread.
    while !service.controller.services.scanner.is_overdue(late) {
        std::thread::yield_now();
    }
    assert!(feeds_when_written(&mut service, Instant::now()));
    assert!(!feeds_when_written(&mut service, late));
    service.controller.services.scanner.cancel();
    while service.controller.services.scanner.is_overdue(late) {
        std::thread::yield_now();
    }
    assert!(feeds_when_written(&mut service, late));
}

#[test]
fn a_visit_is_swept_again_after_suspected_lost_steps_and_not_before() {
    let mut service = Stepped::new("");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime");
    let _context = runtime.enter();
    let repeated = |service: &Stepped| {
        let active = service.controller.active.as_ref().expect("served");
        active.repeated_sweep
    };
    let id = service.sweeping();
    assert!(!repeated(&service));
    service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
    assert!(!repeated(&service) && service.controller.judging);
    let mut suspected = judgement(None);
    suspected.suspected_lost_steps = Some("the view is rotated".to_owned());
    service
        .controller
        .handle_message(ServiceMessage::Judged(id, suspected));
    assert_eq!(service.controller.machine.phase(), "sweeping", "again");
    assert!(repeated(&service) && !service.controller.judging);
    // The next visit begins anew.
    service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
    service
        .controller
        .handle_message(ServiceMessage::Judged(id, judgement(None)));
    service.controller.handle_message(ServiceMessage::Recorded(
        id,
        Err(crate::patrol::event::RefusalReason::Failed(
            "the disk".to_owned(),
        )),
    ));
    service.scanner(ScannerEvent::Ready(Value::Null));
    service.sweeping();
    assert!(!repeated(&service));
}

/// A robot of which nothing is known: three views half a degree of tilt off.
#[test]
fn the_turns_of_judged_views_reach_the_patrol() {
    let mut service = Stepped::new("");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime");
    let _context = runtime.enter();
    let mut phases = Vec::new();
    for _ in 0..3 {
        let id = service.sweeping();
        service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
        let mut seen = judgement(None);
        seen.turn = Some(SeenTurn {
            waypoint: "hall".to_owned(),
            frame_version: 1,
            pan_rad: 0.0,
            tilt_rad: Some(0.009),
        });
        service
            .controller
            .handle_message(ServiceMessage::Judged(id, seen));
        let failed = crate::patrol::event::RefusalReason::Failed("the disk".to_owned());
        service
            .controller
            .handle_message(ServiceMessage::Recorded(id, Err(failed)));
        phases.push(service.controller.machine.phase());
        if phases.ends_with(&["homing"]) {
            break;
        }
    }
    assert_eq!(phases, ["idle", "homing"]);
    service.scanner(ScannerEvent::Homed);
    service.scanner(ScannerEvent::HomingDone);
    assert_eq!(service.controller.machine.phase(), "idle");
}

#[test]
fn the_basis_goes_to_the_visit_that_asked_for_it() {
    let mut service = Stepped::new("");
    service.scanner(ScannerEvent::Ready(Value::Null));
    let id = service.visit();
    let basis = || {
        let settings = crate::config::Settings::defaults();
        let view = patrold_engine::geometry::View::from_points(
            vec![nalgebra::Point3::new(1.0, 0.0, 0.0); 4],
            nalgebra::Point3::origin(),
        );
        let gamma = patrold_engine::novelty::ReferenceMixture {
            mixture: patrold_engine::mixture::Mixture::default(),
            beams: Vec::new(),
        };
        Box::new(crate::service::judgement::VisitBasis {
            reference: crate::service::visit_tests::stored_reference::stored_reference(
                &settings, view, gamma, "a",
            ),
            incidents: Vec::new(),
        })
    };
    let has_basis = |service: &Stepped| {
        let active = service.controller.active.as_ref().expect("served");
        active.basis.is_some()
    };
    service
        .controller
        .handle_message(ServiceMessage::Prepared(id + 1, Ok(Some(basis()))));
    assert!(!has_basis(&service), "of another request");
    service
        .controller
        .handle_message(ServiceMessage::Prepared(id, Ok(Some(basis()))));
    assert!(has_basis(&service));
}

/// Upkeeps of the store that were done since the last call.
fn upkeeps(service: &mut Stepped) -> usize {
    service.settle();
    let mut count = 0;
    while let Ok(message) = service.messages.try_recv() {
        count += usize::from(matches!(message, ServiceMessage::Storage(_)));
    }
    count
}

#[test]
fn the_upkeep_is_done_when_it_is_due_and_once_at_a_time() {
    let mut service = Stepped::new("");
    upkeeps(&mut service);
    let now = Instant::now();
    for (maintaining, due, expected) in [
        (false, true, 1),
        (false, false, 0),
        (true, true, 0),
        (true, false, 0),
    ] {
        service.controller.maintaining = maintaining;
        service.controller.maintenance_due = if due { now } else { now + TIMEOUT };
        service.controller.tick_at(now);
        assert_eq!(upkeeps(&mut service), expected, "{maintaining} {due}");
    }
}

#[test]
fn each_request_has_a_number_of_its_own_and_its_time() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime");
    let mut service = Stepped::new("");
    let _context = runtime.enter();
    let id = service.sweeping();
    assert_eq!(service.visit(), id + 1);
    let sweep_ms = |service: &Stepped| {
        let active = service.controller.active.as_ref().expect("served");
        active.timing.sweep
    };
    let before = sweep_ms(&service);
    service.scanner(ScannerEvent::Swept(id + 1, empty_sweep().into(), None));
    assert_eq!(sweep_ms(&service), before, "of another request");
    service.controller.sweep_started = std::time::Duration::ZERO;
    service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
    assert!(sweep_ms(&service) > before);
    let began = Instant::now() - TIMEOUT;
    service.controller.step_started = began;
    assert!(service.controller.step_ms() >= TIMEOUT.as_secs_f64() * 1e3);
}

#[test]
fn devices_are_opened_again_where_their_settings_changed() {
    let service = Stepped::new("");
    let old = (*service.controller.settings).clone();
    assert_eq!(
        service.controller.settings_change(&old),
        SettingsChange::KeepDevices
    );
    let (mut laser, mut head) = (old.clone(), old.clone());
    laser.laser.port = "/dev/another".to_owned();
    head.ptu.port = "/dev/another".to_owned();
    for new in [laser, head] {
        let change = service.controller.settings_change(&new);
        assert_eq!(change, SettingsChange::ReopenDevices);
    }
}
