//! A wall scanned by a simulated head and laser with separate clocks must come out flat.

use super::{assemble, assemble_with_mount};
use crate::geometry::{Mount, RollPitchYaw};
use crate::scan::ScanGeometry;
use crate::sweep::{
    HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, SweepError, TiltMotionError,
    TimeSample,
};
use nalgebra::{Point3, Vector3};
use std::f64::consts::FRAC_PI_2;

const STEP_RAD: f64 = 0.9 / 17.5 * std::f64::consts::PI / 180.0;
const WALL_X_M: f64 = 2.5;

fn mount() -> Mount {
    let level = RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: 0.0,
    };
    Mount::new(
        [0.0, -0.00955, 0.046774],
        [0.0, 0.0, 0.043713],
        [0.0, 0.0, 0.039116],
        [0.01, 0.0, 0.06],
        level,
    )
}

fn scan_geometry() -> ScanGeometry {
    ScanGeometry {
        steps_per_turn: 1024,
        front_step: 384,
        first_step: 44,
        cluster: 1,
        dmin_mm: 20,
        dmax_mm: 5600,
        period_s: 0.1,
    }
}

/// Host time of a sensor time: the rate is 0.13 % off, and the sensor was switched on at host second 7.
fn host_s(sensor_s: f64) -> f64 {
    7.0 + 0.99867 * sensor_s
}

/// Millimetres to the wall x = 2.5 m along beam `index` of a head at `tilt_rad`; 0 where it is missed.
fn wall_mm(index: usize, tilt_rad: f64) -> u32 {
    let pose = mount().base_from_laser(0.0, tilt_rad);
    let (sin, cos) = scan_geometry().azimuth_rad(index).sin_cos();
    let direction = pose.rotation * Vector3::new(cos, sin, 0.0);
    let from = pose * Point3::origin();
    let range_m = (WALL_X_M - from.x) / direction.x;
    if direction.x > 0.0 && range_m < 5.6 {
        (range_m * 1e3).round() as u32
    } else {
        0
    }
}

/// Tilt from -20 to +20 deg at `speed` counts a second from host second 100 on.
fn tilting(speed: f64) -> RawSweep {
    let from = -20f64.to_radians() / STEP_RAD;
    let count = |at_s: f64| (from + speed * (at_s - 100.0)).clamp(from, -from);
    let end_s = 100.0 - 2.0 * from / speed;
    let period_s = 0.09988;
    let scans = (0..)
        .map(|i| 93.3 + period_s * f64::from(i))
        .take_while(|sensor_s| host_s(*sensor_s) < end_s)
        .map(|sensor_s| StampedScan {
            stamp_ms: (sensor_s * 1e3).floor() as u64,
            arrived_s: host_s(sensor_s + 0.08),
            values: (0..682)
                .map(|index| {
                    let at_s = host_s(sensor_s + scan_geometry().turn_share(index) * period_s);
                    wall_mm(index, count(at_s) * STEP_RAD)
                })
                .collect(),
        })
        .collect();
    let polls = (0..)
        .map(|i| 99.5 + f64::from(i) / 60.0)
        .take_while(|at_s| *at_s < end_s + 0.5)
        .map(|at_s| PositionPoll {
            sent_s: at_s - 0.003,
            received_s: at_s + 0.003,
            tilt_steps: count(at_s).round() as i32,
        })
        .collect();
    let sample = |sensor_s: f64| TimeSample {
        sent_s: host_s(sensor_s) - 0.0005,
        received_s: host_s(sensor_s) + 0.0005,
        stamp_ms: (sensor_s * 1e3).round() as u64,
    };
    raw(PanSegment {
        pan_rad: 0.0,
        motion: HeadMotion::Tilting {
            speed_steps_s: speed,
        },
        scans,
        polls,
        time_samples: vec![sample(90.0), sample(110.0)],
    })
}

fn raw(segment: PanSegment) -> RawSweep {
    RawSweep {
        scan_geometry: scan_geometry(),
        mount: mount(),
        tilt_rad_per_step: STEP_RAD,
        tilt_zero_rad: 0.0,
        tilt_low_rad: -19f64.to_radians(),
        tilt_high_rad: 19f64.to_radians(),
        line_pitch_rad: 0.00871,
        time_offset_s: 0.0,
        tilt_backlash_rad: 0.0,
        pan_segments: vec![segment],
    }
}

fn worst_off_wall_m(raw: &RawSweep) -> f64 {
    let sweep = assemble(raw).expect("assembles");
    assert!(sweep.view.points.len() > 5_000);
    assert!(!sweep.view.no_return.is_empty());
    sweep
        .view
        .points
        .iter()
        .map(|p| (p.x - WALL_X_M).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_wall_swept_while_tilting_is_flat() {
    // 0.5 mm of rounding and the 1 ms of the stamps (0.005 deg at 5 deg/s), at grazing incidence near +-60 deg.
    let worst = worst_off_wall_m(&tilting(97.0));
    assert!(worst < 0.002, "{worst}");
}

#[test]
fn the_wall_stays_flat_at_four_times_the_speed() {
    // One tilt per scan would bend it by 1.3 deg, 50 mm at the edge.
    let worst = worst_off_wall_m(&tilting(388.0));
    assert!(worst < 0.004, "{worst}");
}

#[test]
fn step_and_stare_sees_the_same_wall() {
    let counts: Vec<i32> = (-369..=369).step_by(20).collect();
    let scans = counts
        .iter()
        .enumerate()
        .map(|(i, count)| StampedScan {
            stamp_ms: 100_000 + 300 * i as u64,
            arrived_s: host_s(100.08 + 0.3 * i as f64),
            values: (0..682)
                .map(|index| wall_mm(index, f64::from(*count) * STEP_RAD))
                .collect(),
        })
        .collect();
    let moving = tilting(97.0);
    let stare = raw(PanSegment {
        motion: HeadMotion::StepAndStare { tilt_steps: counts },
        scans,
        polls: Vec::new(),
        ..moving.pan_segments[0].clone()
    });
    let worst = worst_off_wall_m(&stare);
    assert!(worst < 0.001, "{worst}");
}

#[test]
fn quality_counts_lines_and_gaps() {
    let mut raw = tilting(97.0);
    let whole = assemble(&raw).expect("assembles").quality;
    assert!(
        whole.lines_got.abs_diff(whole.lines_expected) <= 1,
        "{whole:?}"
    );
    assert_eq!(whole.gaps, 0);
    assert!((whole.clock_rate - 0.99867).abs() < 2e-4);
    assert_eq!(whole.fault(0.05), None);
    raw.pan_segments[0].scans.drain(20..40);
    let incomplete = assemble(&raw).expect("assembles").quality;
    assert_eq!(
        (incomplete.gaps, incomplete.lines_got),
        (1, whole.lines_got - 20)
    );
    assert!(incomplete.fault(0.05).is_some());
}

#[test]
fn a_head_that_stops_on_its_way_gives_no_view() {
    let not_covered = |raw: &RawSweep| {
        let error = assemble(raw).expect_err("half a sweep");
        let of_head = matches!(
            error,
            SweepError::Motion {
                source: TiltMotionError::NotCovered { .. },
                ..
            }
        );
        assert!(of_head, "{error}");
    };
    // At 4 s of 8 it stops; from then on all polls have the same count.
    let mut stopped = tilting(97.0);
    for poll in &mut stopped.pan_segments[0].polls {
        poll.tilt_steps = poll.tilt_steps.min(0);
    }
    not_covered(&stopped);
    let mut ends_early = tilting(97.0);
    ends_early.pan_segments[0]
        .polls
        .retain(|poll| poll.received_s < 104.0);
    not_covered(&ends_early);
    let mut begins_late = tilting(97.0);
    begins_late.pan_segments[0]
        .polls
        .retain(|poll| poll.received_s > 104.0);
    not_covered(&begins_late);
}

#[test]
fn no_line_is_projected_where_no_poll_covers_the_motion() {
    // The polls of the first two seconds of motion are lost, not those of the stationary head before.
    let mut raw = tilting(97.0);
    let whole = assemble(&raw).expect("assembles").quality;
    raw.pan_segments[0]
        .polls
        .retain(|poll| !(100.0..102.0).contains(&poll.received_s));
    let incomplete = assemble(&raw).expect("assembles").quality;
    assert!(
        (15..=20).contains(&(whole.lines_got - incomplete.lines_got)),
        "{incomplete:?}"
    );
    assert!(incomplete.widest_gap_lines >= 15);
    assert!(incomplete.fault(1.0).is_some());
}

#[test]
fn six_lines_missing_in_a_row_are_a_fault() {
    let mut raw = tilting(97.0);
    // 76 lines; 6 of them are 8 %, and a tolerance of 10 % does not excuse a hole of 3.5 deg.
    raw.pan_segments[0].scans.drain(30..36);
    let quality = assemble(&raw).expect("assembles").quality;
    assert_eq!(quality.widest_gap_lines, 6, "{quality:?}");
    assert!((quality.widest_gap_rad.to_degrees() - 3.5).abs() < 0.1);
    let fault = quality.fault(0.1).unwrap_or_default();
    assert!(fault.contains("6 lines missing in a row"), "{fault}");
}

#[test]
fn extra_lines_of_one_pan_do_not_replace_those_of_another() {
    let mut raw = tilting(97.0);
    let mut other = raw.pan_segments[0].clone();
    // Every eighth line of one pan is missing, and the other has each of its lines twice.
    let mut at = 0;
    other.scans.retain(|_| {
        at += 1;
        at % 8 != 0
    });
    other.pan_rad = 0.5;
    raw.pan_segments[0].scans = raw.pan_segments[0]
        .scans
        .iter()
        .flat_map(|scan| [scan.clone(), scan.clone()])
        .collect();
    raw.pan_segments.push(other);
    let quality = assemble(&raw).expect("assembles").quality;
    let [first, second] = quality.pan_segments[..] else {
        panic!("{quality:?}");
    };
    assert_eq!(first.expected, second.expected);
    assert!(first.got <= first.expected && second.got + 8 < second.expected);
    assert_eq!(quality.lines_got, first.got + second.got);
    assert!(quality.fault(0.08).is_some(), "{quality:?}");
}

#[test]
fn an_uncertain_clock_is_a_fault() {
    let mut raw = tilting(97.0);
    for sample in &mut raw.pan_segments[0].time_samples {
        sample.sent_s -= 0.11;
        sample.received_s += 0.11;
    }
    // 110 ms at 5 deg/s displace beams by more than a line.
    let quality = assemble(&raw).expect("assembles").quality;
    let fault = quality.fault(0.05).unwrap_or_default();
    assert!(fault.contains("uncertain clock"), "{fault}");
}

#[test]
fn invalid_values_are_errors() {
    let spoil: [fn(&mut RawSweep); 9] = [
        |raw| raw.line_pitch_rad = 0.0,
        |raw| raw.line_pitch_rad = f64::NAN,
        |raw| raw.line_pitch_rad = f64::INFINITY,
        |raw| raw.line_pitch_rad = 1e-300,
        |raw| raw.tilt_high_rad = f64::INFINITY,
        |raw| raw.tilt_rad_per_step = 0.0,
        |raw| raw.scan_geometry.period_s = 0.0,
        |raw| raw.scan_geometry.steps_per_turn = 0,
        |raw| raw.pan_segments[0].pan_rad = f64::NAN,
    ];
    for (i, spoil) in spoil.into_iter().enumerate() {
        let mut raw = tilting(97.0);
        spoil(&mut raw);
        let error = assemble(&raw).expect_err("no such sweep");
        assert!(
            matches!(error, SweepError::InvalidValue { .. }),
            "{i}: {error}"
        );
    }
}

/// A laser this far ahead of the pan axis.
fn mount_ahead(by_m: f64) -> Mount {
    let mut parameters = mount().parameters();
    parameters[9] = by_m;
    Mount::from_parameters(parameters)
}

#[test]
fn the_origin_is_the_mean_of_the_lasers_positions_or_refused() {
    let mut raw = tilting(97.0);
    for pan_deg in [-120.0_f64, 120.0] {
        let other = PanSegment {
            pan_rad: pan_deg.to_radians(),
            ..raw.pan_segments[0].clone()
        };
        raw.pan_segments.push(other);
    }
    let sweep = assemble_with_mount(&raw, &mount_ahead(0.1)).expect("near enough");
    // The three positions lie around the pan axis.
    let off = sweep.view.origin - Point3::new(0.0, -0.00955, sweep.view.origin.z);
    assert!(off.norm() < 1e-3, "{off}");
    assert_eq!(sweep.view.tilt_axis, None);
    let error = assemble_with_mount(&raw, &mount_ahead(0.2)).expect_err("too far apart");
    assert!(matches!(error, SweepError::OriginSpread { distance_m } if distance_m > 0.19));
    assert!(error.to_string().contains("fewer pans"), "{error}");
    raw.pan_segments.truncate(1);
    assert!(
        assemble_with_mount(&raw, &mount_ahead(0.2)).is_ok(),
        "one pan is one position"
    );
}

#[test]
fn the_view_uses_the_mount_of_the_sweep_and_has_its_tilt_axis() {
    let mut raw = tilting(97.0);
    raw.pan_segments[0].pan_rad = FRAC_PI_2;
    let own = assemble(&raw).expect("assembles");
    assert_eq!(Ok(&own), assemble_with_mount(&raw, &mount()).as_ref());
    let axis = own.view.tilt_axis.expect("one pan").into_inner();
    assert!((axis + Vector3::x()).norm() < 1e-12);
    let remounted = assemble_with_mount(&raw, &mount_ahead(0.03)).expect("assembles");
    assert!((remounted.view.points[0] - own.view.points[0]).norm() > 0.01);
}

#[test]
fn frozen_scans_are_detected() {
    let mut raw = tilting(97.0);
    let stale = raw.pan_segments[0].scans[30].values.clone();
    for scan in &mut raw.pan_segments[0].scans[31..36] {
        scan.values.clone_from(&stale);
    }
    assert!(assemble(&raw).expect("assembles").quality.frozen);
}

#[test]
fn an_empty_sweep_is_an_error() {
    let mut raw = tilting(97.0);
    raw.pan_segments.clear();
    assert_eq!(assemble(&raw), Err(SweepError::Empty));
}
