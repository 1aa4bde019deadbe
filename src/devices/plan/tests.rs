//! Angles and counts of a plan, and what it carries from the settings to the raw sweep.

use super::{HeadFacts, LaserFacts, SweepPlan, SweepRequest, TiltPlan};
use crate::config::{Settings, SweepMode};
use crate::devices::lockstep::rig::TestRig;
use patrold_sim::emulator::EmulationOptions;
use ptu::HeadIdentity;
use scip::LaserParameters;

fn plan(settings: &Settings, head: &HeadIdentity, pans_rad: &[f64]) -> SweepPlan {
    plan_on_line(settings, head, pans_rad, None)
}

fn plan_on_line(
    settings: &Settings,
    head: &HeadIdentity,
    pans_rad: &[f64],
    line_bytes_s: Option<u32>,
) -> SweepPlan {
    let mut request = SweepRequest::new(settings, None);
    request.pans_rad = pans_rad.to_vec();
    let head = HeadFacts {
        identity: head,
        settings: &settings.ptu,
        port: "ptu",
    };
    let laser = LaserFacts {
        parameters: LaserParameters::URG_04LX,
        line_bytes_s,
    };
    SweepPlan::new(&request, &head, laser).expect("within reach")
}

fn head() -> HeadIdentity {
    let rig = TestRig::ready(EmulationOptions::seeded(1));
    rig.identity.expect("connected")
}

#[test]
fn counts_have_the_sign_and_the_zero_of_their_axis() {
    let head = head();
    let (pan_step, tilt_step) = (head.pan.step.radians(), head.tilt.step.radians());
    for (pan_sign, tilt_sign) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        let mut settings = Settings::defaults();
        (settings.ptu.pan_sign, settings.ptu.tilt_sign) = (pan_sign, tilt_sign);
        (settings.ptu.pan_zero_rad, settings.ptu.tilt_zero_rad) = (0.2, -0.05);
        settings.sweep.mode = SweepMode::Step;
        (settings.sweep.tilt_from_rad, settings.sweep.tilt_to_rad) = (-0.25, 0.3);
        let plan = plan(&settings, &head, &[0.5, -0.4]);
        assert_eq!(plan.pans.len(), 2);
        for ((steps, rad), wanted_rad) in plan.pans.iter().zip([0.5, -0.4]) {
            // Count 0 is at the zero.
            let angle_rad = 0.2 + pan_sign * f64::from(*steps) * pan_step;
            assert!((rad - angle_rad).abs() < 1e-12, "{rad} {angle_rad}");
            assert!((rad - wanted_rad).abs() <= 0.51 * pan_step, "{rad}");
        }
        assert_eq!(plan.tilt_rad_per_step, tilt_sign * tilt_step);
        assert_eq!(plan.tilt_zero_rad, -0.05);
        let TiltPlan::Steps(lines) = &plan.tilt else {
            panic!("{:?}", plan.tilt)
        };
        let angle_rad =
            |line: Option<&i32>| -0.05 + tilt_sign * f64::from(*line.expect("a line")) * tilt_step;
        let (first, last) = (angle_rad(lines.first()), angle_rad(lines.last()));
        assert!((first + 0.25).abs() <= 0.51 * tilt_step, "{first}");
        assert!((0.3 - last).abs() < settings.sweep.step_rad, "{last}");
        assert!((plan.line_pitch_rad - settings.sweep.step_rad).abs() < 1e-12);
        for line in lines.windows(2) {
            let apart_rad = f64::from((line[1] - line[0]).abs()) * tilt_step;
            assert!((apart_rad - plan.line_pitch_rad).abs() <= tilt_step);
        }
    }
}

#[test]
fn what_a_calibration_found_is_carried_to_the_raw_sweep() {
    let mut settings = Settings::defaults();
    settings.sweep.time_offset_s = 0.0125;
    settings.ptu.tilt_backlash_rad = 0.003;
    settings.ptu.tilt_zero_rad = 0.02;
    let plan = plan(&settings, &head(), &[0.0]);
    let raw = plan.raw_sweep(Vec::new());
    assert_eq!(
        (raw.time_offset_s, raw.tilt_backlash_rad, raw.tilt_zero_rad),
        (0.0125, 0.003, 0.02)
    );
    assert_eq!(
        ((raw.tilt_low_rad, raw.tilt_high_rad), raw.line_pitch_rad),
        (plan.tilt_range_rad, plan.line_pitch_rad)
    );
    assert_eq!(raw.tilt_rad_per_step, plan.tilt_rad_per_step);
}

#[test]
fn a_slow_line_takes_the_periods_that_the_tilt_can_be_slower() {
    let head = head();
    let slowest_rad_s = f64::from(head.tilt.speed_min) * head.tilt.step.radians();
    for (mode, times_slowest, cluster_and_periods) in [
        // At 19,200 bit/s; the values are those of the tests of `stream`.
        (SweepMode::Continuous, 3.5, (4, 4)),
        (SweepMode::Continuous, 5.5, (3, 5)),
        (SweepMode::Continuous, 6.5, (2, 6)),
        (SweepMode::Step, 3.5, (2, 6)),
    ] {
        let mut settings = Settings::defaults();
        settings.sweep.mode = mode;
        settings.sweep.speed_rad_s = times_slowest * slowest_rad_s;
        let stream = plan_on_line(&settings, &head, &[0.0], Some(1920)).stream;
        let planned = (stream.cluster, stream.interval + 1);
        assert_eq!(planned, cluster_and_periods, "{mode:?} {times_slowest}");
    }
}
