//! Clients that disconnect.

use super::{failed, ready, request, run_table, visit};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolEvent, PatrolTask};
use std::time::Duration;

#[test]
fn requests_of_departed_clients_are_dropped_and_no_reference_is_taken() {
    let teach = |id| request(id, PatrolTask::Teach);
    let mut machine = ready();
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Requested(teach(1)),
                vec![PatrolAction::Prepare(teach(1))],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::StartSweep(teach(1))],
            ),
            (PatrolEvent::Requested(teach(2)), vec![]),
            (PatrolEvent::Requested(visit(3)), vec![]),
            (
                PatrolEvent::ClientGone(2),
                vec![PatrolAction::Abandon(teach(2))],
            ),
            (
                PatrolEvent::ClientGone(1),
                vec![PatrolAction::CancelDevices],
            ),
            (
                failed(1, "cancelled", false),
                vec![
                    PatrolAction::Abandon(teach(1)),
                    PatrolAction::Prepare(visit(3)),
                ],
            ),
            (
                PatrolEvent::ClientGone(3),
                vec![PatrolAction::Abandon(visit(3))],
            ),
            (PatrolEvent::Prepared(3, Ok(())), vec![]),
            (
                PatrolEvent::Requested(teach(4)),
                vec![PatrolAction::Prepare(teach(4))],
            ),
            (
                PatrolEvent::Prepared(4, Ok(())),
                vec![PatrolAction::StartSweep(teach(4))],
            ),
            (
                PatrolEvent::SweepDone(4),
                vec![PatrolAction::Judge(teach(4))],
            ),
            (
                PatrolEvent::ClientGone(4),
                vec![PatrolAction::Abandon(teach(4))],
            ),
            (PatrolEvent::Judged(4, Ok(())), vec![]),
            (
                PatrolEvent::Requested(teach(5)),
                vec![PatrolAction::Prepare(teach(5))],
            ),
            (
                PatrolEvent::Prepared(5, Ok(())),
                vec![PatrolAction::StartSweep(teach(5))],
            ),
            (
                PatrolEvent::ClientGone(5),
                vec![PatrolAction::CancelDevices],
            ),
            // The sweep was complete before the cancellation.
            (
                PatrolEvent::SweepDone(5),
                vec![PatrolAction::Abandon(teach(5))],
            ),
            (PatrolEvent::ClientGone(99), vec![]),
        ],
    );
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_started_visit_is_finished_without_its_client() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(1)));
    machine.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::ClientGone(1), vec![]),
            (
                PatrolEvent::SweepDone(1),
                vec![PatrolAction::Judge(visit(1))],
            ),
            (
                PatrolEvent::Judged(1, Ok(())),
                vec![PatrolAction::Record(visit(1))],
            ),
        ],
    );
}
