//! Retries: absent devices, and a sweep that does not fit.

use super::{error_note, ready, ready_note, run_table, visit};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::PatrolEvent;
use crate::patrol::severity::Severity;
use std::time::Duration;

#[test]
fn absent_devices_are_tried_every_second_and_logged_once() {
    let mut machine = ready();
    let absent = || PatrolEvent::DevicesAbsent("laser away".to_owned());
    let lost = PatrolEvent::DevicesLost("laser gone".to_owned());
    let at = |tenths: u64| Duration::from_millis(100 * tenths);
    assert_eq!(machine.handle(at(0), lost), [error_note("laser gone")]);
    assert_eq!(machine.handle(at(9), PatrolEvent::Tick), []);
    assert_eq!(
        machine.handle(at(10), PatrolEvent::Tick),
        [PatrolAction::OpenDevices]
    );
    assert_eq!(machine.handle(at(12), absent()), [error_note("laser away")]);
    for retry in 1..100 {
        let now = at(12 + 10 * retry);
        assert_eq!(
            machine.handle(now, PatrolEvent::Tick),
            [PatrolAction::OpenDevices]
        );
        assert_eq!(machine.handle(now, absent()), []);
    }
    let ready = machine.handle(at(2000), PatrolEvent::DevicesReady);
    assert_eq!(ready, [ready_note()]);
    let again = machine.handle(at(2001), PatrolEvent::DevicesLost("laser away".to_owned()));
    assert_eq!(again, [error_note("laser away")]);
}

#[test]
fn a_sweep_that_does_not_fit_is_homed_and_taken_again() {
    let mut machine = ready();
    let text = "hall: bent; homing the head, then the place is swept again".to_owned();
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
                PatrolEvent::LostStepsSuspected(2, "bent".to_owned()),
                vec![],
            ),
            (
                PatrolEvent::LostStepsSuspected(1, "bent".to_owned()),
                vec![
                    PatrolAction::LogEvent(Severity::Warning, text),
                    PatrolAction::DistrustHead,
                    PatrolAction::StartSweep(visit(1)),
                ],
            ),
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
