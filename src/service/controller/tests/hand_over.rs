//! What the loop hands on: from the sweep to the store, from the store to the client.

use super::health::teach;
use super::{
    Instant, PatrolTask, ScannerEvent, ServiceMessage, ServiceReply, Stepped, Store, TIMEOUT,
    TeachOptions, Value, empty_sweep, judgement,
};
use crate::patrol::event::RefusalReason;
use crate::service::captured_log::captured;
use crate::service::judgement::{AssembledSweep, SweepFinding, SweepJudgement};
use crate::service::message_id;
use crate::service::replies::{StatusReply, VisitReply};
use crate::store::{TimeRange, VisitFilter};
use nalgebra::Point3;
use patrold_engine::geometry::View;
use patrold_engine::mixture::Mixture;
use patrold_engine::novelty::ReferenceMixture;
use patrold_engine::sweep::SweepQuality;
use std::time::Duration;
use tokio::runtime::Runtime;

pub(super) fn runtime() -> Runtime {
    tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime")
}

pub(super) fn status(service: &Stepped) -> StatusReply {
    service.controller.services.status.borrow().clone()
}

fn is_prepared(message: &ServiceMessage) -> bool {
    matches!(message, ServiceMessage::Prepared(..))
}

fn not_observed(reply: ServiceReply) -> VisitReply {
    match reply {
        ServiceReply::Visit(visit) if visit.verdict == "not_observed" => *visit,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_visit_goes_from_its_sweep_to_the_store_and_to_its_client() {
    let mut service = Stepped::new("");
    let runtime = runtime();
    let _context = runtime.enter();
    service.controller.services.writer.submit(
        |ledger| {
            teach(&mut ledger.store, "yard");
            teach(&mut ledger.store, "hall");
        },
        |()| (),
    );
    service.scanner(ScannerEvent::Ready(Value::Null));
    assert_eq!(status(&service).phase, "idle");
    assert_eq!(status(&service).devices.state, "ready");
    let id = service.visit();
    let current = |service: &Stepped| status(service).current.expect("served").waypoint;
    assert_eq!(status(&service).phase, "preparing");
    let basis = service.next(is_prepared);
    let ServiceMessage::Prepared(of, Ok(Some(found))) = &basis else {
        panic!("{basis:?}");
    };
    assert_eq!((*of, found.reference.version), (id, 1));
    let reference = found.reference.id;
    service.controller.handle_message(basis);
    assert_eq!(status(&service).phase, "sweeping");
    assert_eq!(current(&service), "hall");
    service.visit();
    assert_eq!(status(&service).waiting, 1);
    service.clients.pop();

    let dialogue = b"of the devices".to_vec();
    service.scanner(ScannerEvent::Swept(
        id,
        empty_sweep().into(),
        Some(dialogue.clone()),
    ));
    service.controller.step_started = Instant::now() - TIMEOUT;
    let blind = ServiceMessage::Judged(id, judgement(Some("blind")));
    service.controller.handle_message(blind);
    assert_eq!(status(&service).phase, "recording");
    service.controller.step_started = Instant::now() - 2 * TIMEOUT;
    service.recorded();
    let reply = not_observed(service.reply());
    assert_eq!((reply.reason.as_str(), reply.stored), ("blind", true));
    assert_eq!((reply.visit_id, reply.reference_version), (Some(1), 1));
    let least_ms = TIMEOUT.as_secs_f64() * 1e3;
    assert!(reply.timing_ms.judge >= least_ms, "{:?}", reply.timing_ms);
    assert!(
        reply.timing_ms.record >= 2.0 * least_ms,
        "{:?}",
        reply.timing_ms
    );
    assert_eq!(status(&service).current, None);

    let store = Store::open_for_reading(&service.store_dir()).expect("readable");
    let stored = store.visit(1).expect("stored");
    assert_eq!(
        (stored.waypoint.as_str(), stored.verdict.as_str()),
        ("hall", "not_observed")
    );
    assert_eq!(stored.reference_id, Some(reference));
    assert_eq!(stored.dialogue, Ok(dialogue));
    assert_eq!(stored.seed, service.controller.settings.mixture.seed);
}

#[test]
fn each_sweep_of_a_visit_adds_its_time_and_each_judgement_too() {
    let mut service = Stepped::new("");
    let runtime = runtime();
    let _context = runtime.enter();
    let id = service.sweeping();
    let timing = |service: &Stepped| {
        let active = service.controller.active.as_ref().expect("served");
        active.timing
    };
    let clock = service.controller.services.scanner.clock().clone();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let mut swept_ms = [0.0, 0.0];
    for (sweep, suspected) in [(0.0, true), (1.0, false)] {
        service.controller.sweep_started = Duration::ZERO;
        let before = ms(clock.now());
        service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
        let after = ms(clock.now());
        swept_ms = [swept_ms[0] + before, swept_ms[1] + after];
        let sum = timing(&service).sweep;
        assert!(
            swept_ms[0] <= sum && sum <= swept_ms[1],
            "{sweep}: {sum} of {swept_ms:?}"
        );
        service.controller.step_started = Instant::now() - TIMEOUT;
        let mut judged = judgement(None);
        judged.suspected_lost_steps = suspected.then(|| "rotated".to_owned());
        service
            .controller
            .handle_message(ServiceMessage::Judged(id, judged));
        if suspected {
            let judge = timing(&service).judge;
            assert!(judge >= ms(TIMEOUT) && judge < 2.0 * ms(TIMEOUT), "{judge}");
        }
    }
    service.recorded();
    // Nobody taught the hall: the store refuses the visit, and the answer says why.
    let reply = not_observed(service.reply());
    assert!(!reply.stored, "{reply:?}");
    assert!(
        reply.timing_ms.judge >= 2.0 * ms(TIMEOUT),
        "{:?}",
        reply.timing_ms
    );
}

fn no_quality() -> SweepQuality {
    SweepQuality {
        lines_expected: 1,
        lines_got: 1,
        gaps: 0,
        widest_gap_lines: 0,
        widest_gap_rad: 0.0,
        line_pitch_rad: 0.01,
        pan_segments: Vec::new(),
        hit_share: 1.0,
        no_return_share: 0.0,
        position_residual_steps: 0.0,
        position_residual_rad: 0.0,
        clock_uncertainty_s: 0.0,
        clock_uncertainty_rad: 0.0,
        clock_rate: 1.0,
        frozen: false,
        blind_lines: 0,
    }
}

fn reference_of(view: &View) -> Box<SweepJudgement> {
    let gamma = ReferenceMixture {
        mixture: Mixture::default(),
        beams: Vec::new(),
    };
    Box::new(SweepJudgement {
        assembled: Some(AssembledSweep {
            view: view.clone(),
            raw: b"raw".to_vec(),
            quality: no_quality(),
        }),
        finding: Ok(SweepFinding::Reference(gamma)),
        ..*judgement(None)
    })
}

#[test]
fn a_reference_goes_from_its_sweep_to_the_store_and_to_its_client() {
    let mut service = Stepped::new("");
    let runtime = runtime();
    let _context = runtime.enter();
    service.scanner(ScannerEvent::Ready(Value::Null));
    let view = View::from_points(vec![Point3::new(1.0, 2.0, 0.0); 3], Point3::origin());
    for version in 1..=2 {
        let id = service.request(PatrolTask::Teach, TeachOptions::default());
        let basis = service.next(is_prepared);
        service.controller.handle_message(basis);
        service.scanner(ScannerEvent::Swept(id, empty_sweep().into(), None));
        let judged = ServiceMessage::Judged(id, reference_of(&view));
        service.controller.handle_message(judged);
        service.recorded();
        match service.reply() {
            ServiceReply::Teach(taught) => {
                assert_eq!((taught.version, taught.points), (version, 3));
            }
            other => panic!("{other:?}"),
        }
    }
    let store = Store::open_for_reading(&service.store_dir()).expect("readable");
    let stored = store.reference("hall").expect("taught");
    assert_eq!((stored.version, stored.view.points.len()), (2, 3));
}

#[test]
fn what_the_client_of_a_teach_decided_goes_with_its_request_alone() {
    let mut service = Stepped::new("");
    let options = |new_name| TeachOptions {
        accept: Vec::new(),
        new_name,
    };
    service
        .controller
        .services
        .writer
        .submit(|ledger| teach(&mut ledger.store, "hail"), |()| ());
    service.scanner(ScannerEvent::Ready(Value::Null));
    for (new_name, is_asked) in [(false, true), (true, false)] {
        let id = service.request(PatrolTask::Teach, options(new_name));
        let prepared = service.next(is_prepared);
        let ServiceMessage::Prepared(of, found) = &prepared else {
            panic!("{prepared:?}");
        };
        assert_eq!(*of, id);
        let refused =
            matches!(found, Err(RefusalReason::NearName { known, .. }) if known == "hail");
        assert_eq!(refused, is_asked, "{found:?}");
        service.controller.handle_message(prepared);
        assert!(service.controller.teach_options.is_empty());
    }
    // One teach is swept for; what waits behind it keeps its options until its turn.
    service.request(PatrolTask::Visit, options(true));
    assert!(
        service.controller.teach_options.is_empty(),
        "a visit has none"
    );
    let waiting = service.request(PatrolTask::Teach, options(true));
    assert_eq!(service.controller.teach_options.len(), 1);
    assert!(service.controller.teach_options.contains_key(&waiting));
    service.controller.stop();
    assert!(service.controller.teach_options.is_empty(), "refused");
}

#[test]
fn a_request_that_is_refused_is_answered_and_logged() {
    let mut service = Stepped::new("");
    service.scanner(ScannerEvent::Ready(Value::Null));
    let id = service.visit();
    let unknown = RefusalReason::UnknownWaypoint("unknown waypoint".to_owned());
    let log = captured(|| {
        let refused = ServiceMessage::Prepared(id, Err(unknown.clone()));
        service.controller.handle_message(refused);
    });
    assert!(log.contains(message_id::REQUEST_REFUSED), "{log}");
    assert_eq!(service.reply(), ServiceReply::Refused(unknown));
    let filter = VisitFilter {
        range: TimeRange::default(),
        waypoint: None,
        verdict: None,
        limit: 9,
    };
    service.settle();
    let store = Store::open_for_reading(&service.store_dir()).expect("readable");
    assert_eq!(store.visits(&filter).expect("visits"), []);
}
