//! Askers that go away.

use super::{failed, ready, request, visit, walk};
use crate::patrol::action::Action;
use crate::patrol::event::{Event, Task};
use std::time::Duration;

#[test]
fn what_nobody_waits_for_is_not_begun_and_no_reference_is_taken_for_it() {
    let teach = |id| request(id, Task::Teach);
    let mut machine = ready();
    walk(
        &mut machine,
        vec![
            (
                Event::Requested(teach(1)),
                vec![Action::StartSweep(teach(1))],
            ),
            (Event::Requested(teach(2)), vec![]),
            (Event::Requested(visit(3)), vec![]),
            (Event::AskerGone(2), vec![Action::Drop(teach(2))]),
            (Event::AskerGone(1), vec![Action::CancelDevices]),
            (
                failed(1, "cancelled", false),
                vec![Action::Drop(teach(1)), Action::Prepare(visit(3))],
            ),
            (Event::AskerGone(3), vec![Action::Drop(visit(3))]),
            (Event::Prepared(3, Ok(())), vec![]),
            (
                Event::Requested(teach(4)),
                vec![Action::StartSweep(teach(4))],
            ),
            (Event::SweepDone(4), vec![Action::Judge(teach(4))]),
            (Event::AskerGone(4), vec![Action::Drop(teach(4))]),
            (Event::Judged(4, Ok(())), vec![]),
            (
                Event::Requested(teach(5)),
                vec![Action::StartSweep(teach(5))],
            ),
            (Event::AskerGone(5), vec![Action::CancelDevices]),
            // The sweep was done before it heard.
            (Event::SweepDone(5), vec![Action::Drop(teach(5))]),
            (Event::AskerGone(99), vec![]),
        ],
    );
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_visit_that_has_begun_is_finished_whoever_asked() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, Event::Requested(visit(1)));
    machine.handle(Duration::ZERO, Event::Prepared(1, Ok(())));
    walk(
        &mut machine,
        vec![
            (Event::AskerGone(1), vec![]),
            (Event::SweepDone(1), vec![Action::Judge(visit(1))]),
            (Event::Judged(1, Ok(())), vec![Action::Record(visit(1))]),
        ],
    );
}
