//! What is tried again: devices that are away, a sweep that does not fit.

use super::{error_note, ready, ready_note, visit, walk};
use crate::patrol::action::{Action, Weight};
use crate::patrol::event::Event;
use std::time::Duration;

#[test]
fn devices_that_are_not_there_are_looked_for_every_second_and_told_once() {
    let mut machine = ready();
    let absent = || Event::DevicesAbsent("laser away".to_owned());
    let lost = Event::DevicesLost("laser gone".to_owned());
    let at = |tenths: u64| Duration::from_millis(100 * tenths);
    assert_eq!(machine.handle(at(0), lost), [error_note("laser gone")]);
    assert_eq!(machine.handle(at(9), Event::Tick), []);
    assert_eq!(machine.handle(at(10), Event::Tick), [Action::OpenDevices]);
    assert_eq!(machine.handle(at(12), absent()), [error_note("laser away")]);
    for turn in 1..100 {
        let now = at(12 + 10 * turn);
        assert_eq!(machine.handle(now, Event::Tick), [Action::OpenDevices]);
        assert_eq!(machine.handle(now, absent()), []);
    }
    let ready = machine.handle(at(2000), Event::DevicesReady);
    assert_eq!(ready, [ready_note()]);
    let again = machine.handle(at(2001), Event::DevicesLost("laser away".to_owned()));
    assert_eq!(again, [error_note("laser away")]);
}

#[test]
fn a_sweep_that_does_not_fit_is_homed_and_taken_again() {
    let mut machine = ready();
    let text = "hall: bent; the head is homed and the place swept again".to_owned();
    walk(
        &mut machine,
        vec![
            (Event::Requested(visit(1)), vec![Action::Prepare(visit(1))]),
            (
                Event::Prepared(1, Ok(())),
                vec![Action::StartSweep(visit(1))],
            ),
            (Event::SweepDone(1), vec![Action::Judge(visit(1))]),
            (Event::Doubted(2, "bent".to_owned()), vec![]),
            (
                Event::Doubted(1, "bent".to_owned()),
                vec![
                    Action::Note(Weight::Warning, text),
                    Action::DistrustHead,
                    Action::StartSweep(visit(1)),
                ],
            ),
            (Event::SweepDone(1), vec![Action::Judge(visit(1))]),
            (Event::Judged(1, Ok(())), vec![Action::Record(visit(1))]),
        ],
    );
}
