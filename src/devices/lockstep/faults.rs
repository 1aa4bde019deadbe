//! Sweeps with faults: no undetected wrong angle, no laser left on.

use super::rig::TestRig;
use crate::config::SweepMode;
use crate::devices::error::DeviceError;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::EmulatedFault;
use patrold_sim::emulator::EmulationOptions;
use std::time::Duration;

/// A sweep with `fault` injected `after_s` seconds after its start; the tilt starts after some 3 s.
fn with_fault(fault: &str, after_s: f64) -> (TestRig, Result<RawSweep, DeviceError>) {
    let mut rig = TestRig::ready(EmulationOptions::seeded(2));
    let fault: EmulatedFault = fault.parse().expect("a fault");
    let mut pending = Some(fault);
    let request = TestRig::request(SweepMode::Continuous);
    let outcome = rig.sweep(&request, |emulation, _, since| {
        if since.as_secs_f64() >= after_s
            && let Some(fault) = pending.take()
        {
            emulation.inject(fault);
        }
    });
    (rig, outcome)
}

fn error_of(fault: &str) -> DeviceError {
    let (rig, outcome) = with_fault(fault, 7.0);
    let error = outcome.map(|_| ()).expect_err(fault);
    assert!(!rig.emulation.laser_on(), "laser on after {fault}");
    // A deaf head moves on to the end of the sweep; a head calibrates at power-up.
    let deaf = fault.contains("deaf") || fault.contains("power-cycle");
    assert!(
        deaf || !rig.emulation.head_moving(),
        "head moves after {fault}"
    );
    let text = error.to_string();
    eprintln!("{fault}: {text}");
    assert!(!text.contains('\n'));
    error
}

#[test]
fn cancelling_turns_the_laser_off_and_stops_the_head_within_a_second() {
    for mode in [SweepMode::Continuous, SweepMode::Step] {
        for after_s in [0.1, 1.0, 2.0, 2.6, 3.3, 6.0] {
            let mut rig = TestRig::ready(EmulationOptions::seeded(1));
            let mut cancelled_at = None;
            let request = TestRig::request(mode);
            let started = rig.now;
            let outcome = rig.sweep(&request, |_, run, since| {
                if since.as_secs_f64() >= after_s && cancelled_at.is_none() {
                    cancelled_at = Some(since);
                    run.cancel(started + since);
                }
            });
            assert_eq!(outcome, Err(DeviceError::Cancelled));
            assert!(!rig.emulation.laser_on() && !rig.emulation.head_moving());
            let took = (rig.now - started).saturating_sub(cancelled_at.expect("cancelled"));
            assert!(took < Duration::from_secs(1), "{mode:?} {after_s} {took:?}");
        }
    }
}

#[test]
fn a_limit_hit_a_lost_cable_and_a_restart_void_the_position() {
    for fault in [
        "ptu.event:which=T",
        "ptu.event:which=P",
        "ptu.event:which=D",
        "ptu.echo",
        "ptu.verbose",
        "ptu.power-cycle:for=1",
    ] {
        let error = error_of(fault);
        assert!(
            matches!(
                error,
                DeviceError::PositionLost { .. } | DeviceError::Fault { .. }
            ),
            "{fault}: {error}"
        );
    }
}

#[test]
fn a_blocked_or_silent_head_is_reported() {
    assert!(matches!(
        error_of("ptu.stuck:axis=tilt"),
        DeviceError::Stalled { axis: "tilt", .. }
    ));
    assert!(matches!(
        error_of("ptu.silence:deaf=true,for=20"),
        DeviceError::Fault { .. } | DeviceError::Overdue { .. }
    ));
}

#[test]
fn a_timer_that_jumps_or_restarts_voids_the_sweep() {
    for by in ["0.7", "0.1", "-0.1", "-0.2", "-3", "0.03"] {
        // From just after the time exchange before the scans to the last scans.
        for after_s in [1.05, 3.0, 9.0, 13.0] {
            let fault = format!("laser.timer-jump:by={by}");
            let (rig, outcome) = with_fault(&fault, after_s);
            let error = outcome.map(|_| ()).expect_err(&fault);
            assert!(
                matches!(
                    error,
                    DeviceError::TimerLost { .. } | DeviceError::Fault { .. }
                ),
                "{fault} {after_s}: {error}"
            );
            assert!(!rig.emulation.laser_on());
        }
    }
    let error = error_of("laser.brown-out");
    assert!(
        matches!(
            error,
            DeviceError::Fault { .. } | DeviceError::TimerLost { .. }
        ),
        "{error}"
    );
}

#[test]
fn laser_faults_are_reported() {
    for fault in [
        "laser.hardware",
        "laser.silence:for=60",
        "laser.repeated-stamp",
    ] {
        let error = error_of(fault);
        assert!(
            matches!(
                error,
                DeviceError::Fault { .. } | DeviceError::TimerLost { .. }
            ),
            "{fault}: {error}"
        );
    }
}

#[test]
fn repairable_damage_costs_lines_only() {
    for fault in [
        "laser.bad-sum:count=2",
        "laser.dropped-byte",
        "laser.garbage",
        "ptu.lost-byte",
        "ptu.garbage-byte",
    ] {
        let (_, outcome) = with_fault(fault, 7.0);
        let raw = outcome.unwrap_or_else(|error| panic!("{fault}: {error}"));
        assert!(raw.pan_segments[0].scans.len() >= 119, "{fault}");
    }
}

#[test]
fn ranges_out_of_reach_are_clipped_or_refused() {
    let rig = TestRig::ready(EmulationOptions::seeded(1));
    let ptu = crate::config::Settings::defaults().ptu;
    let mut request = TestRig::request(SweepMode::Continuous);
    request.tilt_from_rad = -1.2;
    let plan = rig.plan(&request, &ptu).expect("clipped");
    assert_eq!(plan.notes.len(), 1, "{:?}", plan.notes);
    let lowest = plan.tilt.start_steps().expect("a start");
    let limits = plan.tilt_axis.limits;
    assert!(limits.contains(lowest) && lowest < limits.min_steps + 20);
    (request.tilt_from_rad, request.tilt_to_rad) = (0.8, 1.2);
    let error = rig.plan(&request, &ptu).expect_err("out of reach");
    assert!(matches!(
        error,
        DeviceError::OutOfReach { axis: "tilt", .. }
    ));
    let mut request = TestRig::request(SweepMode::Step);
    request.pans_rad = vec![3.1];
    let error = rig.plan(&request, &ptu).expect_err("out of reach");
    assert!(
        error.to_string().contains("sweep.pans_deg, its default"),
        "{error}"
    );
}

#[test]
fn faster_than_the_base_speed_the_ramps_lie_outside() {
    let mut options = EmulationOptions::seeded(4);
    options.head.base_speed = [57, 57];
    options.head.acceleration = [400, 400];
    let mut rig = TestRig::ready(options);
    let request = TestRig::request(SweepMode::Continuous);
    let raw = rig.sweep(&request, |_, _, _| {}).expect("a sweep");
    let sweep = patrold_engine::sweep::assemble(&raw).expect("no stall");
    assert!(
        sweep.quality.position_residual_steps < 2.0,
        "{:?}",
        sweep.quality
    );
    assert_eq!(sweep.quality.fault(0.05), None);
}
