//! Every fault of both devices, injected into whole visits: never an alarm or a false quiet, and a normal visit afterwards.

use super::fault_cases::{
    ALL, ExpectedOutcome, FaultCase, HEAD_BYTES, HEAD_MODES, HEAD_MOTION, HEAD_PORT, LASER_LINES,
    LASER_PORT, LASER_SCANS, LASER_STATES, LASER_TIMER, LASTING,
};
use super::virtual_patrol::{VirtualPatrol, VisitResult, taught_storeroom};
use ExpectedOutcome::{NotObserved, Tolerated};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq)]
enum FaultTime {
    /// While the devices are being opened.
    Connecting,
    /// Seven seconds after the request, while the head tilts.
    Sweeping,
}

/// A visit with the fault and one after it; an error text where either is wrong.
fn run_case(case: &FaultCase, when: FaultTime) -> Result<(), String> {
    let mut patrol = VirtualPatrol::with_reference(&taught_storeroom(), 7);
    let (device, rest) = case.fault.split_once('.').expect("device.kind");
    let (fault, expected) = match when {
        FaultTime::Connecting => (case.fault.to_owned(), case.connecting),
        FaultTime::Sweeping => {
            let (kind, keys) = rest.split_once(':').unwrap_or((rest, ""));
            (format!("{device}.{kind}:at=7,{keys}"), case.sweeping)
        }
    };
    if when == FaultTime::Connecting {
        // The fault is there when the device is plugged in again.
        patrol.inject(&format!("{device}.unplug:for=2"));
        patrol.until_ready(false).expect("noticed");
        patrol.until_plugged_in();
    }
    patrol.inject(&fault);
    let result = patrol.visit();
    let text = format!("{fault} {when:?}: {:?}: {}", result.verdict, result.reason);
    let as_expected = match expected {
        Tolerated => result.verdict == Verdict::Quiet,
        NotObserved(word) => result.verdict == Verdict::NotObserved && result.reason.contains(word),
    };
    if !as_expected || result.reason.contains('\n') {
        return Err(text);
    }
    patrol.idle(Duration::from_secs(60));
    if LASTING.contains(&case.fault) {
        patrol.inject(&format!("{device}.unplug:for=1"));
        patrol.idle(Duration::from_secs(2));
    }
    if patrol.until_ready(true).is_none() {
        return Err(format!("{text}; not ready again: {:?}", patrol.event_log));
    }
    // Nobody helps.
    let mut after = Vec::new();
    while after.len() < 2
        && after
            .last()
            .is_none_or(|v: &VisitResult| v.verdict != Verdict::Quiet)
    {
        after.push(patrol.visit());
    }
    if after.last().is_none_or(|v| v.verdict != Verdict::Quiet) {
        return Err(format!("{text}; after it: {after:?}"));
    }
    Ok(())
}

fn run_all(cases: &[FaultCase]) {
    let runs = cases.iter().flat_map(|case| {
        [FaultTime::Connecting, FaultTime::Sweeping].map(|when| run_case(case, when).err())
    });
    let wrong: Vec<String> = runs.flatten().collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn no_fault_of_the_lasers_port_gives_an_alarm_or_a_false_quiet() {
    run_all(&LASER_PORT);
}

#[test]
fn no_damaged_line_of_the_laser_gives_an_alarm_or_a_false_quiet() {
    run_all(&LASER_LINES);
}

#[test]
fn no_wrong_scan_gives_an_alarm_or_a_false_quiet() {
    run_all(&LASER_SCANS);
}

#[test]
fn no_state_of_the_laser_gives_an_alarm_or_a_false_quiet() {
    run_all(&LASER_STATES);
}

#[test]
fn no_jump_of_the_lasers_timer_gives_an_alarm_or_a_false_quiet() {
    run_all(&LASER_TIMER);
}

#[test]
fn no_fault_of_the_heads_port_gives_an_alarm_or_a_false_quiet() {
    run_all(&HEAD_PORT);
}

#[test]
fn no_wrong_motion_of_the_head_gives_an_alarm_or_a_false_quiet() {
    run_all(&HEAD_MOTION);
}

#[test]
fn no_damaged_reply_of_the_head_gives_an_alarm_or_a_false_quiet() {
    run_all(&HEAD_BYTES);
}

#[test]
fn no_mode_of_the_head_gives_an_alarm_or_a_false_quiet() {
    run_all(&HEAD_MODES);
}

#[test]
fn every_kind_of_fault_is_tested() {
    let laser = scip::emulator::LaserFault::kinds().map(|kind| format!("laser.{kind}"));
    let head = ptu::emulator::HeadFaultKind::kinds().map(|kind| format!("ptu.{kind}"));
    for kind in laser.chain(head) {
        let tested = |case: &FaultCase| case.fault.split(':').next() == Some(&kind);
        assert!(ALL.into_iter().flatten().any(tested), "{kind}");
    }
}
