//! Requests that their clients end.

use super::{failed, ready, request, run_table, visit};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolEvent, PatrolTask};
use std::time::Duration;

const REASON: &str = "cancelled by its client during the sweep";

fn sweeping() -> crate::patrol::machine::PatrolMachine {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(1)));
    machine.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(2)));
    machine
}

fn not_observed() -> PatrolAction {
    PatrolAction::RecordNotObserved(visit(1), REASON.to_owned())
}

#[test]
fn one_that_waits_or_prepares_is_dropped() {
    let mut machine = sweeping();
    assert!(machine.may_cancel(2) && machine.may_cancel(1) && !machine.may_cancel(3));
    run_table(
        &mut machine,
        vec![
            (
                PatrolEvent::Cancelled(2),
                vec![PatrolAction::Abandon(visit(2))],
            ),
            (PatrolEvent::Cancelled(2), vec![]),
            (PatrolEvent::Cancelled(9), vec![]),
        ],
    );
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(1)));
    assert!(machine.may_cancel(1));
    let dropped = vec![PatrolAction::Abandon(visit(1))];
    run_table(&mut machine, vec![(PatrolEvent::Cancelled(1), dropped)]);
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_visit_in_its_sweep_is_not_observed_however_the_sweep_ends() {
    for (ends, lost) in [
        (PatrolEvent::SweepDone(1), false),
        (failed(1, "cancelled", false), false),
        (failed(1, "unplugged", true), true),
    ] {
        let mut machine = sweeping();
        let mut then = vec![not_observed()];
        if lost {
            then.insert(0, PatrolAction::OpenDevices);
        }
        run_table(
            &mut machine,
            vec![
                (PatrolEvent::Cancelled(1), vec![PatrolAction::CancelDevices]),
                (ends, then),
            ],
        );
        assert!(!machine.may_cancel(1), "it is being recorded");
        // The next one is not touched by it.
        let then = vec![
            PatrolAction::Reply(visit(1)),
            PatrolAction::Prepare(visit(2)),
        ];
        run_table(&mut machine, vec![(PatrolEvent::Recorded(1, Ok(())), then)]);
    }
}

#[test]
fn what_is_swept_is_judged_and_a_reference_is_not_taken() {
    let mut machine = sweeping();
    machine.handle(Duration::ZERO, PatrolEvent::SweepDone(1));
    assert!(!machine.may_cancel(1));
    let recorded = vec![PatrolAction::Record(visit(1))];
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::Cancelled(1), vec![]),
            (PatrolEvent::Judged(1, Ok(())), recorded),
        ],
    );
    let teach = request(1, PatrolTask::Teach);
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(teach.clone()));
    machine.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::Cancelled(1), vec![PatrolAction::CancelDevices]),
            (
                PatrolEvent::SweepDone(1),
                vec![PatrolAction::Abandon(teach)],
            ),
        ],
    );
}
