//! Changed settings and the end of the service, in every stage of a visit.

use super::{failed, ready, request, run_table, visit};
use crate::patrol::action::PatrolAction;
use crate::patrol::constants::MAX_RETRY_PAUSE;
use crate::patrol::event::{PatrolEvent, PatrolTask, RefusalReason, SettingsChange};
use crate::patrol::machine::PatrolMachine;
use std::time::Duration;

#[test]
fn settings_change_between_sweeps_only() {
    let teach = request(1, PatrolTask::Teach);
    run_table(
        &mut ready(),
        vec![
            (
                PatrolEvent::Reload(Ok(SettingsChange::KeepDevices)),
                vec![PatrolAction::ApplySettings],
            ),
            (
                PatrolEvent::Requested(teach.clone()),
                vec![PatrolAction::Prepare(teach.clone())],
            ),
            (
                PatrolEvent::Prepared(1, Ok(())),
                vec![PatrolAction::StartSweep(teach.clone())],
            ),
            (
                PatrolEvent::Reload(Ok(SettingsChange::ReopenDevices)),
                vec![],
            ),
            (PatrolEvent::Reload(Ok(SettingsChange::KeepDevices)), vec![]),
            (
                PatrolEvent::SweepDone(1),
                vec![
                    PatrolAction::Judge(teach),
                    PatrolAction::ApplySettings,
                    PatrolAction::OpenDevices,
                ],
            ),
            (
                PatrolEvent::Reload(Err(vec!["t.toml:1: wrong".to_owned()])),
                vec![PatrolAction::KeepSettings(vec![
                    "t.toml:1: wrong".to_owned(),
                ])],
            ),
        ],
    );
}

#[test]
fn a_shutdown_in_a_sweep_stops_the_head_and_is_recorded() {
    let mut machine = ready();
    machine.handle(Duration::ZERO, PatrolEvent::Requested(visit(1)));
    machine.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    let reason = "the service was stopped during the sweep".to_owned();
    run_table(
        &mut machine,
        vec![
            (PatrolEvent::Requested(visit(2)), vec![]),
            (
                PatrolEvent::Shutdown,
                vec![
                    PatrolAction::CancelDevices,
                    PatrolAction::CloseDevices,
                    PatrolAction::Refuse(visit(2), RefusalReason::Stopping),
                ],
            ),
            (PatrolEvent::Shutdown, vec![]),
            (
                PatrolEvent::Requested(visit(3)),
                vec![PatrolAction::Refuse(visit(3), RefusalReason::Stopping)],
            ),
            (
                failed(1, "cancelled", false),
                vec![PatrolAction::RecordNotObserved(visit(1), reason)],
            ),
            (PatrolEvent::DevicesClosed, vec![]),
            (
                PatrolEvent::Recorded(1, Ok(())),
                vec![PatrolAction::Reply(visit(1)), PatrolAction::Exit],
            ),
            (PatrolEvent::Tick, vec![]),
        ],
    );
}

#[test]
fn a_shutdown_while_idle_judging_or_lost_ends() {
    let mut idle = ready();
    let closing = [PatrolAction::CancelDevices, PatrolAction::CloseDevices];
    assert_eq!(idle.handle(Duration::ZERO, PatrolEvent::Shutdown), closing);
    assert_eq!(
        idle.handle(Duration::ZERO, PatrolEvent::DevicesClosed),
        [PatrolAction::Exit]
    );

    let mut judging = ready();
    let teach = request(1, PatrolTask::Teach);
    judging.handle(Duration::ZERO, PatrolEvent::Requested(teach.clone()));
    judging.handle(Duration::ZERO, PatrolEvent::Prepared(1, Ok(())));
    judging.handle(Duration::ZERO, PatrolEvent::SweepDone(1));
    let out = judging.handle(Duration::ZERO, PatrolEvent::Shutdown);
    assert!(
        matches!(out.last(), Some(PatrolAction::Refuse(r, RefusalReason::NoSweep(_))) if *r == teach)
    );
    assert_eq!(
        judging.handle(Duration::ZERO, PatrolEvent::Judged(1, Ok(()))),
        [],
        "its verdict comes too late"
    );
    assert_eq!(
        judging.handle(Duration::ZERO, PatrolEvent::DevicesClosed),
        [PatrolAction::Exit]
    );

    let (mut lost, _) = PatrolMachine::start(0.05, 0.007);
    lost.handle(
        Duration::ZERO,
        PatrolEvent::DevicesFailed("gone".to_owned()),
    );
    lost.handle(Duration::ZERO, PatrolEvent::Shutdown);
    assert_eq!(lost.handle(MAX_RETRY_PAUSE, PatrolEvent::Tick), []);
    assert_eq!(
        lost.handle(MAX_RETRY_PAUSE, PatrolEvent::DevicesClosed),
        [PatrolAction::Exit]
    );
}
