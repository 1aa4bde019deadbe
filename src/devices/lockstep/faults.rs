//! Sweeps in which something goes wrong: never a silently wrong angle, never a laser left on.

use super::bench::Bench;
use crate::config::SweepMode;
use crate::devices::error::DeviceError;
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::EmulatedFault;
use patrold_sim::emulator::EmulationOptions;
use std::time::Duration;

/// A sweep with this fault set so many seconds after its beginning (some 3 s before the tilt begins).
fn with_fault(fault: &str, after_s: f64) -> (Bench, Result<RawSweep, DeviceError>) {
    let mut bench = Bench::ready(EmulationOptions::seeded(2));
    let fault: EmulatedFault = fault.parse().expect("a fault");
    let mut waiting = Some(fault);
    let request = Bench::request(SweepMode::Continuous);
    let outcome = bench.sweep(&request, |emulation, _, since| {
        if since.as_secs_f64() >= after_s
            && let Some(fault) = waiting.take()
        {
            emulation.inject(fault);
        }
    });
    (bench, outcome)
}

fn error_of(fault: &str) -> DeviceError {
    let (bench, outcome) = with_fault(fault, 7.0);
    let error = outcome.map(|_| ()).expect_err(fault);
    assert!(!bench.emulation.laser_on(), "laser on after {fault}");
    // Nobody can stop a head that hears nothing (its target is the end of the sweep) or calibrates at power-up.
    let deaf = fault.contains("deaf") || fault.contains("power-cycle");
    assert!(
        deaf || !bench.emulation.head_moving(),
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
            let mut bench = Bench::ready(EmulationOptions::seeded(1));
            let mut cancelled_at = None;
            let request = Bench::request(mode);
            let started = bench.now;
            let outcome = bench.sweep(&request, |_, run, since| {
                if since.as_secs_f64() >= after_s && cancelled_at.is_none() {
                    cancelled_at = Some(since);
                    run.cancel(started + since);
                }
            });
            assert_eq!(outcome, Err(DeviceError::Cancelled));
            assert!(!bench.emulation.laser_on() && !bench.emulation.head_moving());
            let took = (bench.now - started).saturating_sub(cancelled_at.expect("cancelled"));
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
fn a_blocked_or_silent_head_is_told() {
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
fn a_timer_that_jumps_or_starts_anew_voids_the_sweep() {
    for by in ["0.7", "0.1", "-0.1", "-0.2", "-3", "0.03"] {
        // From just after the exchange of time before the scans to the last scans.
        for after_s in [1.05, 3.0, 9.0, 13.0] {
            let fault = format!("laser.timer-jump:by={by}");
            let (bench, outcome) = with_fault(&fault, after_s);
            let error = outcome.map(|_| ()).expect_err(&fault);
            assert!(
                matches!(
                    error,
                    DeviceError::TimerLost { .. } | DeviceError::Fault { .. }
                ),
                "{fault} {after_s}: {error}"
            );
            assert!(!bench.emulation.laser_on());
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
fn broken_lasers_are_told() {
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
fn damage_that_can_be_repaired_costs_lines_only() {
    for fault in [
        "laser.bad-sum:count=2",
        "laser.dropped-byte",
        "laser.garbage",
        "ptu.lost-byte",
        "ptu.garbage-byte",
    ] {
        let (_, outcome) = with_fault(fault, 7.0);
        let raw = outcome.unwrap_or_else(|error| panic!("{fault}: {error}"));
        assert!(raw.legs[0].scans.len() >= 119, "{fault}");
    }
}

#[test]
fn ranges_out_of_reach_are_clipped_or_refused() {
    let bench = Bench::ready(EmulationOptions::seeded(1));
    let ptu = crate::config::Settings::defaults().ptu;
    let mut request = Bench::request(SweepMode::Continuous);
    request.tilt_from_rad = -1.2;
    let plan = bench.plan(&request, &ptu).expect("clipped");
    assert_eq!(plan.notes.len(), 1, "{:?}", plan.notes);
    let lowest = plan.tilt.start_steps().expect("a start");
    let limits = plan.tilt_axis.limits;
    assert!(limits.contains(lowest) && lowest < limits.min_steps + 20);
    (request.tilt_from_rad, request.tilt_to_rad) = (0.8, 1.2);
    let error = bench.plan(&request, &ptu).expect_err("out of reach");
    assert!(matches!(
        error,
        DeviceError::OutOfReach { axis: "tilt", .. }
    ));
    let mut request = Bench::request(SweepMode::Step);
    request.pans_rad = vec![3.1];
    let error = bench.plan(&request, &ptu).expect_err("out of reach");
    assert!(error.to_string().contains("sweep.pans_deg"), "{error}");
}

#[test]
fn faster_than_the_base_speed_the_ramps_lie_outside() {
    let mut options = EmulationOptions::seeded(4);
    options.head.base_speed = [57, 57];
    options.head.acceleration = [400, 400];
    let mut bench = Bench::ready(options);
    let request = Bench::request(SweepMode::Continuous);
    let raw = bench.sweep(&request, |_, _, _| {}).expect("a sweep");
    let sweep = patrold_engine::sweep::assemble(&raw).expect("no stall");
    assert!(
        sweep.quality.position_residual_steps < 2.0,
        "{:?}",
        sweep.quality
    );
    assert_eq!(sweep.quality.fault(0.05), None);
}
