//! The head is homed while nobody waits: once a round, and where past views say that steps may be lost.

use super::{ready, ready_note, request, run_table, visit};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolEvent, PatrolTask};
use crate::patrol::machine::{DeviceAvailability, PatrolMachine};
use crate::patrol::severity::Severity;
use crate::patrol::turn_history::SeenTurn;
use std::time::Duration;

fn turned(waypoint: &str, tilt_rad: f64) -> PatrolEvent {
    PatrolEvent::ViewTurned(SeenTurn {
        waypoint: waypoint.to_owned(),
        frame_version: 1,
        pan_rad: 0.0,
        tilt_rad: Some(tilt_rad),
    })
}

/// A whole visit at `now`; the actions at its end.
fn visited(
    machine: &mut PatrolMachine,
    now: Duration,
    id: u64,
    waypoint: &str,
    tilt_rad: f64,
) -> Vec<PatrolAction> {
    let visit = PatrolEvent::Requested(visit(id));
    for event in [
        visit,
        PatrolEvent::Prepared(id, Ok(())),
        PatrolEvent::SweepDone(id),
        turned(waypoint, tilt_rad),
        PatrolEvent::Judged(id, Ok(())),
    ] {
        machine.handle(now, event);
    }
    machine.handle(now, PatrolEvent::Recorded(id, Ok(())))
}

fn is_homing(machine: &PatrolMachine) -> bool {
    *machine.devices() == DeviceAvailability::Homing
}

const LATER: Duration = Duration::from_secs(600);

/// Homed at time zero; a round of one waypoint is over.
fn homing() -> PatrolMachine {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::HeadHomed);
    visited(&mut machine, LATER, 1, "hall", 0.0);
    assert!(!is_homing(&machine));
    let end = visited(&mut machine, LATER, 2, "hall", 0.0);
    let note = "a round is over; homing the head".to_owned();
    assert_eq!(
        end,
        [
            PatrolAction::Reply(visit(2)),
            PatrolAction::LogEvent(Severity::Info, note),
            PatrolAction::HomeHead,
        ]
    );
    assert!(is_homing(&machine) && machine.phase() == "homing");
    machine
}

#[test]
fn after_a_round_the_head_is_homed_once_the_client_has_its_answer() {
    let mut machine = homing();
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::Tick, vec![]),
            (PatrolEvent::HeadHomed, vec![]),
            (PatrolEvent::HomingDone, vec![]),
            (PatrolEvent::Tick, vec![]),
        ],
    );
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_head_whose_homings_are_not_counted_is_homed_once() {
    let mut machine = homing();
    assert_eq!(machine.handle(LATER, PatrolEvent::HomingDone), []);
    assert_eq!(machine.handle(LATER, PatrolEvent::Tick), []);
    assert_eq!(machine.phase(), "idle");
}

#[test]
fn a_request_waits_for_the_end_of_the_homing() {
    let mut machine = homing();
    let sweep = request(3, PatrolTask::Sweep);
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::Requested(sweep.clone()), vec![]),
            (PatrolEvent::HeadHomed, vec![]),
            (
                PatrolEvent::HomingDone,
                vec![PatrolAction::StartSweep(sweep)],
            ),
            // A second event of the same homing changes nothing.
            (PatrolEvent::HomingDone, vec![]),
        ],
    );
    assert_eq!(machine.phase(), "sweeping");
}

#[test]
fn a_queued_request_goes_before_the_homing() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::HeadHomed);
    visited(&mut machine, LATER, 1, "hall", 0.0);
    for event in [
        PatrolEvent::Requested(visit(2)),
        PatrolEvent::Requested(visit(3)),
        PatrolEvent::Prepared(2, Ok(())),
        PatrolEvent::SweepDone(2),
        turned("hall", 0.0),
        PatrolEvent::Judged(2, Ok(())),
    ] {
        machine.handle(LATER, event);
    }
    assert_eq!(
        machine.handle(LATER, PatrolEvent::Recorded(2, Ok(()))),
        [
            PatrolAction::Reply(visit(2)),
            PatrolAction::Prepare(visit(3))
        ]
    );
    assert!(!is_homing(&machine));
}

#[test]
fn views_that_stand_out_are_a_warning_and_homed_at_once() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::HeadHomed);
    let now = Duration::from_secs(1);
    let mut ends = ["hall", "store", "office"].into_iter().zip(1..);
    let end = ends.find_map(|(waypoint, id)| {
        let end = visited(&mut machine, now, id, waypoint, 0.009);
        is_homing(&machine).then_some(end)
    });
    let end = end.expect("homed");
    let [
        PatrolAction::Reply(_),
        PatrolAction::LogEvent(Severity::Warning, text),
        PatrolAction::HomeHead,
    ] = &end[..]
    else {
        panic!("{end:?}");
    };
    assert!(text.contains("tilt") && text.contains("may have lost steps"));
}

#[test]
fn a_homing_that_fails_opens_the_devices_anew() {
    let mut machine = homing();
    let failed = PatrolEvent::DevicesFailed("stuck".to_owned());
    machine.handle(LATER, PatrolEvent::Requested(request(3, PatrolTask::Sweep)));
    let actions = machine.handle(LATER, failed);
    assert!(
        matches!(&actions[..], [PatrolAction::LogEvent(..), PatrolAction::Refuse(r, _)] if r.id == 3),
        "{actions:?}"
    );
    let later = LATER + Duration::from_secs(60);
    assert_eq!(
        machine.handle(later, PatrolEvent::Tick),
        [PatrolAction::OpenDevices]
    );
    // A late event of the failed homing changes nothing.
    assert_eq!(machine.handle(later, PatrolEvent::HomingDone), []);
    assert_eq!(
        machine.handle(later, PatrolEvent::DevicesReady)[0],
        ready_note()
    );
}

#[test]
fn a_head_that_goes_while_it_is_homed_is_absent() {
    let mut machine = homing();
    machine.handle(LATER, PatrolEvent::DevicesLost("gone".to_owned()));
    assert!(matches!(machine.devices(), DeviceAvailability::Lost { .. }));
}
