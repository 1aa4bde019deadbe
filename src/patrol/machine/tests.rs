//! Paths through the patrol as tables of events and expected actions.

use super::{INITIAL_RETRY_PAUSE, MAX_QUEUED, PatrolMachine};
use crate::patrol::action::PatrolAction;
use crate::patrol::constants::MAX_RETRY_PAUSE;
use crate::patrol::event::{PatrolEvent, PatrolRequest, PatrolTask, RefusalReason};
use crate::patrol::severity::Severity;
use std::time::Duration;

mod cancelled;
mod departed_clients;
mod homing;
mod reload_and_shutdown;
mod retries;

fn request(id: u64, task: PatrolTask) -> PatrolRequest {
    let waypoint = match task {
        PatrolTask::Sweep => "",
        _ => "hall",
    };
    PatrolRequest {
        id,
        task,
        waypoint: waypoint.to_owned(),
    }
}

fn visit(id: u64) -> PatrolRequest {
    request(id, PatrolTask::Visit)
}

fn failed(id: u64, reason: &str, lost: bool) -> PatrolEvent {
    let reason = reason.to_owned();
    PatrolEvent::SweepFailed { id, reason, lost }
}

fn ready_note() -> PatrolAction {
    PatrolAction::LogEvent(Severity::Info, "devices ready".to_owned())
}

fn error_note(text: &str) -> PatrolAction {
    PatrolAction::LogEvent(Severity::Error, text.to_owned())
}

fn ready() -> PatrolMachine {
    let (mut machine, first) = PatrolMachine::start(0.05, 0.007);
    assert_eq!(first, [PatrolAction::OpenDevices]);
    assert_eq!(
        machine.handle(Duration::ZERO, PatrolEvent::DevicesReady),
        [ready_note()]
    );
    machine
}

/// Handles the events of a table at time zero.
fn run_table(machine: &mut PatrolMachine, table: Vec<(PatrolEvent, Vec<PatrolAction>)>) {
    for (row, (event, expected)) in table.into_iter().enumerate() {
        let context = format!("row {row}: {event:?}");
        assert_eq!(machine.handle(Duration::ZERO, event), expected, "{context}");
    }
}

#[test]
fn a_visit_goes_from_its_reference_to_its_reply() {
    let mut machine = ready();
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Requested(visit(1)),
                vec![PatrolAction::Prepare(visit(1))],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::StartSweep(visit(1))],
            ),
            (
                PatrolEvent::SweepDone(1),
                vec![PatrolAction::Judge(visit(1))],
            ),
            (
                PatrolEvent::Judged(1, Ok(())),
                vec![PatrolAction::Record(visit(1))],
            ),
            (
                PatrolEvent::Recorded(1, Ok(())),
                vec![PatrolAction::Reply(visit(1))],
            ),
            (PatrolEvent::Tick, vec![]),
        ],
    );
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_teach_is_prepared_and_a_sweep_needs_nothing() {
    let (teach, sweep) = (request(1, PatrolTask::Teach), request(2, PatrolTask::Sweep));
    run_table(
        &mut ready(),
        vec![
            (
                PatrolEvent::Requested(teach.clone()),
                vec![PatrolAction::Prepare(teach.clone())],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::StartSweep(teach.clone())],
            ),
            (PatrolEvent::Requested(sweep.clone()), vec![]),
            (
                PatrolEvent::SweepDone(1),
                vec![PatrolAction::Judge(teach.clone())],
            ),
            (
                PatrolEvent::Judged(1, Ok(())),
                vec![PatrolAction::Record(teach.clone())],
            ),
            (
                PatrolEvent::Recorded(1, Ok(())),
                vec![
                    PatrolAction::Reply(teach),
                    PatrolAction::StartSweep(sweep.clone()),
                ],
            ),
            (
                PatrolEvent::SweepDone(2),
                vec![PatrolAction::Judge(sweep.clone())],
            ),
            (
                PatrolEvent::Judged(2, Ok(())),
                vec![PatrolAction::Reply(sweep)],
            ),
        ],
    );
}

#[test]
fn an_unknown_waypoint_is_refused_before_any_sweep() {
    let refusal = RefusalReason::UnknownWaypoint("unknown waypoint".to_owned());
    run_table(
        &mut ready(),
        vec![
            (
                PatrolEvent::Requested(visit(1)),
                vec![PatrolAction::Prepare(visit(1))],
            ),
            (
                PatrolEvent::Prepared(1, Err(refusal.clone())),
                vec![PatrolAction::Refuse(visit(1), refusal)],
            ),
        ],
    );
}

#[test]
fn a_failed_sweep_is_recorded_for_a_visit_and_refused_for_the_rest() {
    let teach = request(2, PatrolTask::Teach);
    let refusal = RefusalReason::NoSweep("teach refused: stalled".to_owned());
    run_table(
        &mut ready(),
        vec![
            (
                PatrolEvent::Requested(visit(1)),
                vec![PatrolAction::Prepare(visit(1))],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::StartSweep(visit(1))],
            ),
            (
                failed(1, "stalled", false),
                vec![
                    error_note("sweep failed: stalled"),
                    PatrolAction::RecordNotObserved(visit(1), "stalled".to_owned()),
                ],
            ),
            (
                PatrolEvent::Recorded(1, Ok(())),
                vec![PatrolAction::Reply(visit(1))],
            ),
            (
                PatrolEvent::Requested(teach.clone()),
                vec![PatrolAction::Prepare(teach.clone())],
            ),
            (
                PatrolEvent::Prepared(2, Ok(())),
                vec![PatrolAction::StartSweep(teach.clone())],
            ),
            (
                failed(2, "stalled", true),
                vec![
                    error_note("sweep failed: stalled"),
                    PatrolAction::OpenDevices,
                    PatrolAction::Refuse(teach, refusal),
                ],
            ),
        ],
    );
}

#[test]
fn a_sweep_that_cannot_be_judged_is_not_observed() {
    let teach = request(2, PatrolTask::Teach);
    let refusal = RefusalReason::BadSweep("teach refused: frozen".to_owned());
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(1)));
    machine.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    machine.handle(Duration::ZERO, PatrolEvent::SweepDone(1));
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Judged(1, Err("frozen".to_owned())),
                vec![PatrolAction::RecordNotObserved(
                    visit(1),
                    "frozen".to_owned(),
                )],
            ),
            (
                PatrolEvent::Recorded(1, Err("disk full".to_owned())),
                vec![PatrolAction::Refuse(
                    visit(1),
                    RefusalReason::Failed("disk full".to_owned()),
                )],
            ),
            (
                PatrolEvent::Requested(teach.clone()),
                vec![PatrolAction::Prepare(teach.clone())],
            ),
            (
                PatrolEvent::Prepared(2, Ok(())),
                vec![PatrolAction::StartSweep(teach.clone())],
            ),
            (
                PatrolEvent::SweepDone(2),
                vec![PatrolAction::Judge(teach.clone())],
            ),
            (
                PatrolEvent::Judged(2, Err("frozen".to_owned())),
                vec![PatrolAction::Refuse(teach, refusal)],
            ),
        ],
    );
}

#[test]
fn a_visit_waits_for_devices_that_are_being_opened() {
    let (mut machine, _) = PatrolMachine::start(0.05, 0.007);
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Requested(visit(1)),
                vec![PatrolAction::Prepare(visit(1))],
            ),
            (PatrolEvent::Prepared(1, Ok(())), vec![]),
            (
                PatrolEvent::DevicesReady,
                vec![ready_note(), PatrolAction::StartSweep(visit(1))],
            ),
        ],
    );
}

#[test]
fn retries_of_failed_devices_back_off_and_are_logged_once() {
    let (mut machine, _) = PatrolMachine::start(0.05, 0.007);
    let mut now = Duration::ZERO;
    let mut pause = INITIAL_RETRY_PAUSE;
    for attempt in 0..8 {
        let out = machine.handle(now, PatrolEvent::DevicesFailed("no laser".to_owned()));
        assert_eq!(out.len(), usize::from(attempt == 0), "logged once");
        assert_eq!(machine.phase(), "devices lost");
        let early = now + pause - Duration::from_millis(1);
        assert_eq!(machine.handle(early, PatrolEvent::Tick), []);
        now += pause;
        if attempt < 7 {
            assert_eq!(
                machine.handle(now, PatrolEvent::Tick),
                [PatrolAction::OpenDevices]
            );
        }
        pause = (2 * pause).min(MAX_RETRY_PAUSE);
    }
}

#[test]
fn a_request_to_lost_devices_has_one_attempt_of_its_own() {
    let (mut machine, _) = PatrolMachine::start(0.05, 0.007);
    let failure = || PatrolEvent::DevicesFailed("no laser".to_owned());
    machine.handle(Duration::ZERO, failure());
    let sweep = request(2, PatrolTask::Sweep);
    let reason = "no devices: no laser".to_owned();
    let refusal = RefusalReason::NoSweep(format!("sweep refused: {reason}"));
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Requested(visit(1)),
                vec![PatrolAction::Prepare(visit(1))],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::OpenDevices],
            ),
            (
                failure(),
                vec![PatrolAction::RecordNotObserved(visit(1), reason)],
            ),
            (
                PatrolEvent::Recorded(1, Ok(())),
                vec![PatrolAction::Reply(visit(1))],
            ),
            (
                PatrolEvent::Requested(sweep.clone()),
                vec![PatrolAction::OpenDevices],
            ),
            (
                failure(),
                vec![PatrolAction::Refuse(sweep.clone(), refusal)],
            ),
            (
                PatrolEvent::Requested(visit(3)),
                vec![PatrolAction::Prepare(visit(3))],
            ),
            (
                PatrolEvent::Prepared(3, Ok(())),
                vec![PatrolAction::OpenDevices],
            ),
            (
                PatrolEvent::DevicesReady,
                vec![ready_note(), PatrolAction::StartSweep(visit(3))],
            ),
        ],
    );
}

#[test]
fn devices_that_go_away_while_idle_are_lost_and_tried_again() {
    let mut machine = ready();
    let lost = || PatrolEvent::DevicesLost("laser unplugged".to_owned());
    run_table(
        &mut machine,
        vec![
            (lost(), vec![error_note("laser unplugged")]),
            (lost(), vec![]),
        ],
    );
    assert_eq!(machine.phase(), "devices lost");
    assert_eq!(
        machine.handle(INITIAL_RETRY_PAUSE, PatrolEvent::Tick),
        [PatrolAction::OpenDevices]
    );
    machine.handle(INITIAL_RETRY_PAUSE, PatrolEvent::DevicesReady);
    let sweep = request(1, PatrolTask::Sweep);
    machine.handle(INITIAL_RETRY_PAUSE, PatrolEvent::Requested(sweep));
    assert_eq!(
        machine.handle(INITIAL_RETRY_PAUSE, lost()),
        [],
        "reported by the sweep"
    );
    assert_eq!(machine.phase(), "sweeping");
}

#[test]
fn a_full_queue_refuses() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(0)));
    for id in 1..=MAX_QUEUED as u64 {
        assert_eq!(
            machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(id))),
            []
        );
    }
    assert_eq!(
        machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(99))),
        [PatrolAction::Refuse(visit(99), RefusalReason::Busy)]
    );
}

#[test]
fn those_that_wait_are_served_in_their_order() {
    let mut machine = ready();
    for (id, task) in [
        (1, PatrolTask::Visit),
        (2, PatrolTask::Teach),
        (3, PatrolTask::Visit),
        (4, PatrolTask::Visit),
    ] {
        machine.handle(Duration::ZERO, PatrolEvent::Requested(request(id, task)));
    }
    assert_eq!(machine.queued(), 3);
    let current = |machine: &PatrolMachine| machine.current().map(|(request, _)| request.id);
    for id in [1, 2, 3, 4] {
        assert_eq!(current(&machine), Some(id));
        let unknown = RefusalReason::UnknownWaypoint("unknown".to_owned());
        machine.handle(Duration::ZERO, PatrolEvent::Prepared(id, Err(unknown)));
    }
    assert_eq!((current(&machine), machine.queued()), (None, 0));
}
