//! Every way through the patrol, as tables: what happened, what is done about it.

use super::{FIRST_RETRY, MOST_WAITING, Machine};
use crate::patrol::action::{Action, Weight};
use crate::patrol::constants::LONGEST_RETRY;
use crate::patrol::event::{Change, Event, Refusal, Request, Task};
use std::time::Duration;

mod again;

fn request(id: u64, task: Task) -> Request {
    let waypoint = if task == Task::Sweep { "" } else { "hall" };
    Request {
        id,
        task,
        waypoint: waypoint.to_owned(),
    }
}

fn visit(id: u64) -> Request {
    request(id, Task::Visit)
}

fn failed(id: u64, reason: &str, lost: bool) -> Event {
    let reason = reason.to_owned();
    Event::SweepFailed { id, reason, lost }
}

fn ready_note() -> Action {
    Action::Note(Weight::Info, "devices ready".to_owned())
}

fn error_note(text: &str) -> Action {
    Action::Note(Weight::Error, text.to_owned())
}

fn ready() -> Machine {
    let (mut machine, first) = Machine::start();
    assert_eq!(first, [Action::OpenDevices]);
    assert_eq!(
        machine.handle(Duration::ZERO, Event::DevicesReady),
        [ready_note()]
    );
    machine
}

/// Walks a table at time zero.
fn walk(machine: &mut Machine, table: Vec<(Event, Vec<Action>)>) {
    for (row, (event, expected)) in table.into_iter().enumerate() {
        let told = format!("row {row}: {event:?}");
        assert_eq!(machine.handle(Duration::ZERO, event), expected, "{told}");
    }
}

#[test]
fn a_visit_goes_from_its_reference_to_its_reply() {
    let mut machine = ready();
    walk(
        &mut machine,
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (
                Event::Prepared(1, Ok(())),
                vec![Action::StartSweep(visit(1))],
            ),
            (Event::SweepDone(1), vec![Action::Judge(visit(1))]),
            (Event::Judged(1, Ok(())), vec![Action::Record(visit(1))]),
            (Event::Recorded(1, Ok(())), vec![Action::Reply(visit(1))]),
            (Event::Tick, vec![]),
        ],
    );
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn teaching_and_sweeping_need_no_reference() {
    let (teach, sweep) = (request(1, Task::Teach), request(2, Task::Sweep));
    walk(
        &mut ready(),
        vec![
            (
                Event::Requested(teach.clone()),
                vec![Action::StartSweep(teach.clone())],
            ),
            (Event::Requested(sweep.clone()), vec![]),
            (Event::SweepDone(1), vec![Action::Judge(teach.clone())]),
            (
                Event::Judged(1, Ok(())),
                vec![Action::Record(teach.clone())],
            ),
            (
                Event::Recorded(1, Ok(())),
                vec![Action::Reply(teach), Action::StartSweep(sweep.clone())],
            ),
            (Event::SweepDone(2), vec![Action::Judge(sweep.clone())]),
            (Event::Judged(2, Ok(())), vec![Action::Reply(sweep)]),
        ],
    );
}

#[test]
fn an_unknown_waypoint_is_told_before_any_sweep() {
    let refusal = Refusal::UnknownWaypoint("unknown waypoint".to_owned());
    walk(
        &mut ready(),
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (
                Event::Prepared(1, Err(refusal.clone())),
                vec![Action::Refuse(visit(1), refusal)],
            ),
        ],
    );
}

#[test]
fn a_failed_sweep_is_recorded_for_a_visit_and_refused_for_the_rest() {
    let teach = request(2, Task::Teach);
    let refusal = Refusal::NoSweep("teach refused: stalled".to_owned());
    walk(
        &mut ready(),
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (
                Event::Prepared(1, Ok(())),
                vec![Action::StartSweep(visit(1))],
            ),
            (
                failed(1, "stalled", false),
                vec![
                    error_note("sweep failed: stalled"),
                    Action::RecordNotObserved(visit(1), "stalled".to_owned()),
                ],
            ),
            (Event::Recorded(1, Ok(())), vec![Action::Reply(visit(1))]),
            (
                Event::Requested(teach.clone()),
                vec![Action::StartSweep(teach.clone())],
            ),
            (
                failed(2, "stalled", true),
                vec![
                    error_note("sweep failed: stalled"),
                    Action::OpenDevices,
                    Action::Refuse(teach, refusal),
                ],
            ),
        ],
    );
}

#[test]
fn a_sweep_that_cannot_be_judged_is_never_quiet() {
    let teach = request(2, Task::Teach);
    let refusal = Refusal::BadSweep("teach refused: frozen".to_owned());
    let mut machine = ready();
    machine.handle(Duration::ZERO, Event::Requested(visit(1)));
    machine.handle(Duration::ZERO, Event::Prepared(1, Ok(())));
    machine.handle(Duration::ZERO, Event::SweepDone(1));
    walk(
        &mut machine,
        vec![
            (
                Event::Judged(1, Err("frozen".to_owned())),
                vec![Action::RecordNotObserved(visit(1), "frozen".to_owned())],
            ),
            (
                Event::Recorded(1, Err("disk full".to_owned())),
                vec![Action::Refuse(
                    visit(1),
                    Refusal::Failed("disk full".to_owned()),
                )],
            ),
            (
                Event::Requested(teach.clone()),
                vec![Action::StartSweep(teach.clone())],
            ),
            (Event::SweepDone(2), vec![Action::Judge(teach.clone())]),
            (
                Event::Judged(2, Err("frozen".to_owned())),
                vec![Action::Refuse(teach, refusal)],
            ),
        ],
    );
}

#[test]
fn a_visit_waits_for_devices_that_are_being_opened() {
    let (mut machine, _) = Machine::start();
    walk(
        &mut machine,
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (Event::Prepared(1, Ok(())), vec![]),
            (
                Event::DevicesReady,
                vec![ready_note(), Action::StartSweep(visit(1))],
            ),
        ],
    );
}

#[test]
fn without_devices_a_visit_is_not_observed_and_the_devices_are_tried_again_ever_more_slowly() {
    let (mut machine, _) = Machine::start();
    let mut now = Duration::ZERO;
    let mut pause = FIRST_RETRY;
    for attempt in 0..8 {
        let out = machine.handle(now, Event::DevicesFailed("no laser".to_owned()));
        assert_eq!(out.len(), usize::from(attempt == 0), "said once");
        assert_eq!(machine.phase(), "devices lost");
        let early = now + pause - Duration::from_millis(1);
        assert_eq!(machine.handle(early, Event::Tick), []);
        now += pause;
        if attempt < 7 {
            assert_eq!(machine.handle(now, Event::Tick), [Action::OpenDevices]);
        }
        pause = (2 * pause).min(LONGEST_RETRY);
    }
}

#[test]
fn a_request_to_lost_devices_has_one_attempt_of_its_own() {
    let (mut machine, _) = Machine::start();
    let gone = || Event::DevicesFailed("no laser".to_owned());
    machine.handle(Duration::ZERO, gone());
    let sweep = request(2, Task::Sweep);
    let reason = "no devices: no laser".to_owned();
    let refusal = Refusal::NoSweep(format!("sweep refused: {reason}"));
    walk(
        &mut machine,
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (Event::Prepared(1, Ok(())), vec![Action::OpenDevices]),
            (gone(), vec![Action::RecordNotObserved(visit(1), reason)]),
            (Event::Recorded(1, Ok(())), vec![Action::Reply(visit(1))]),
            (Event::Requested(sweep.clone()), vec![Action::OpenDevices]),
            (gone(), vec![Action::Refuse(sweep.clone(), refusal)]),
            (Event::Requested(visit(3)), vec![Action::Prepare(visit(3))]),
            (Event::Prepared(3, Ok(())), vec![Action::OpenDevices]),
            (
                Event::DevicesReady,
                vec![ready_note(), Action::StartSweep(visit(3))],
            ),
        ],
    );
}

#[test]
fn devices_that_go_away_while_idle_are_lost_and_tried_again() {
    let mut machine = ready();
    let lost = || Event::DevicesLost("laser unplugged".to_owned());
    walk(
        &mut machine,
        vec![
            (lost(), vec![error_note("laser unplugged")]),
            (lost(), vec![]),
        ],
    );
    assert_eq!(machine.phase(), "devices lost");
    assert_eq!(
        machine.handle(FIRST_RETRY, Event::Tick),
        [Action::OpenDevices]
    );
    machine.handle(FIRST_RETRY, Event::DevicesReady);
    let sweep = request(1, Task::Sweep);
    machine.handle(FIRST_RETRY, Event::Requested(sweep));
    assert_eq!(machine.handle(FIRST_RETRY, lost()), [], "the sweep tells");
    assert_eq!(machine.phase(), "sweeping");
}

#[test]
fn the_queue_has_an_end() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, Event::Requested(visit(0)));
    for id in 1..=MOST_WAITING as u64 {
        assert_eq!(
            machine.handle(Duration::ZERO, Event::Requested(visit(id))),
            []
        );
    }
    assert_eq!(
        machine.handle(Duration::ZERO, Event::Requested(visit(99))),
        [Action::Refuse(visit(99), Refusal::Busy)]
    );
}

#[test]
fn settings_change_between_sweeps_only() {
    let teach = request(1, Task::Teach);
    walk(
        &mut ready(),
        vec![
            (
                Event::Reload(Ok(Change::Plain)),
                vec![Action::ApplySettings],
            ),
            (
                Event::Requested(teach.clone()),
                vec![Action::StartSweep(teach.clone())],
            ),
            (Event::Reload(Ok(Change::Devices)), vec![]),
            (Event::Reload(Ok(Change::Plain)), vec![]),
            (
                Event::SweepDone(1),
                vec![
                    Action::Judge(teach),
                    Action::ApplySettings,
                    Action::OpenDevices,
                ],
            ),
            (
                Event::Reload(Err(vec!["t.toml:1: wrong".to_owned()])),
                vec![Action::KeepSettings(vec!["t.toml:1: wrong".to_owned()])],
            ),
        ],
    );
}

#[test]
fn a_shutdown_in_a_sweep_stops_the_head_and_leaves_a_trace() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, Event::Requested(visit(1)));
    machine.handle(Duration::ZERO, Event::Prepared(1, Ok(())));
    let reason = "the service was stopped during the sweep".to_owned();
    walk(
        &mut machine,
        vec![
            (Event::Requested(visit(2)), vec![]),
            (
                Event::Shutdown,
                vec![
                    Action::CancelDevices,
                    Action::CloseDevices,
                    Action::Refuse(visit(2), Refusal::Stopping),
                ],
            ),
            (Event::Shutdown, vec![]),
            (
                Event::Requested(visit(3)),
                vec![Action::Refuse(visit(3), Refusal::Stopping)],
            ),
            (
                failed(1, "cancelled", false),
                vec![Action::RecordNotObserved(visit(1), reason)],
            ),
            (Event::DevicesClosed, vec![]),
            (
                Event::Recorded(1, Ok(())),
                vec![Action::Reply(visit(1)), Action::Exit],
            ),
            (Event::Tick, vec![]),
        ],
    );
}

#[test]
fn a_shutdown_while_idle_judging_or_lost_ends() {
    let mut idle = ready();
    let closing = [Action::CancelDevices, Action::CloseDevices];
    assert_eq!(idle.handle(Duration::ZERO, Event::Shutdown), closing);
    assert_eq!(
        idle.handle(Duration::ZERO, Event::DevicesClosed),
        [Action::Exit]
    );

    let mut judging = ready();
    let teach = request(1, Task::Teach);
    judging.handle(Duration::ZERO, Event::Requested(teach.clone()));
    judging.handle(Duration::ZERO, Event::SweepDone(1));
    let out = judging.handle(Duration::ZERO, Event::Shutdown);
    assert!(matches!(out.last(), Some(Action::Refuse(r, Refusal::NoSweep(_))) if *r == teach));
    assert_eq!(
        judging.handle(Duration::ZERO, Event::Judged(1, Ok(()))),
        [],
        "its verdict comes too late"
    );
    assert_eq!(
        judging.handle(Duration::ZERO, Event::DevicesClosed),
        [Action::Exit]
    );

    let (mut lost, _) = Machine::start();
    lost.handle(Duration::ZERO, Event::DevicesFailed("gone".to_owned()));
    lost.handle(Duration::ZERO, Event::Shutdown);
    assert_eq!(lost.handle(LONGEST_RETRY, Event::Tick), []);
    assert_eq!(
        lost.handle(LONGEST_RETRY, Event::DevicesClosed),
        [Action::Exit]
    );
}

mod askers;
