//! Calibration finds the hidden mount, time offset and backlash of emulated robots from sweeps of the shipped scenes.

use super::rig::TestRig;
use crate::config::{Settings, SweepMode};
use crate::devices::calibration_plan::calibration_requests;
use patrold_engine::geometry::RollPitchYaw;
use patrold_engine::sweep::{
    Calibration, CalibrationParameter, ParameterEstimate, RawSweep, calibrate, calibration_beams,
};
use patrold_sim::emulator::{Emulation, EmulationOptions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Half a step of a D46-17, radians.
const HALF_STEP_RAD: f64 = 185.1428 / 3600.0 * std::f64::consts::PI / 180.0;

/// True parameters of an emulated robot, to be found.
#[derive(Debug, Clone, Copy)]
struct Hidden {
    rpy_deg: [f64; 3],
    stamp_offset_ms: f64,
    backlash_half_steps: f64,
    bias_mm: f64,
}

fn options(seed: u64, hidden: Hidden) -> EmulationOptions {
    let mut options = EmulationOptions::seeded(seed);
    let [roll_rad, pitch_rad, yaw_rad] = hidden.rpy_deg.map(f64::to_radians);
    options.mount.laser_rpy = RollPitchYaw {
        roll_rad,
        pitch_rad,
        yaw_rad,
    };
    options.laser.stamp_offset_ms = hidden.stamp_offset_ms;
    options.head.backlash_half_steps = [0.0, hidden.backlash_half_steps];
    options.noise.bias_mm = hidden.bias_mm;
    options
}

fn sweeps(rig: &mut TestRig, pans: bool) -> Vec<RawSweep> {
    let request = TestRig::request(SweepMode::Continuous);
    calibration_requests(&request, pans)
        .iter()
        .map(|request| rig.sweep(request, |_, _, _| {}).expect("a sweep"))
        .collect()
}

/// Only the segments at the middle pan.
fn at_middle_pan(sweep: &RawSweep) -> RawSweep {
    let mut sweep = sweep.clone();
    sweep
        .pan_segments
        .retain(|segment| segment.pan_rad.abs() < 0.1);
    sweep
}

/// The true time offset, seconds: difference of the tilt of a beam by clock and polls and the true tilt when the mirror
/// passed, divided by the tilt speed.
fn true_time_offset_s(emulation: &Emulation, sweeps: &[RawSweep], hidden: Hidden) -> f64 {
    let beams = calibration_beams(sweeps).expect("beams");
    let segments: Vec<_> = sweeps
        .iter()
        .flat_map(|s| s.pan_segments.iter().map(move |segment| (s, segment)))
        .collect();
    let backlash_rad = hidden.backlash_half_steps * HALF_STEP_RAD;
    let mut offsets = Vec::new();
    for scan in beams.chunk_by(|a, b| (a.pan_segment, a.scan) == (b.pan_segment, b.scan)) {
        let beam = &scan[0];
        let (sweep, segment) = segments[beam.pan_segment];
        let geometry = &sweep.scan_geometry;
        // Data follow step 768 of the turn.
        let begun_by_s = segment.scans[beam.scan].arrived_s - 0.074;
        let turns = emulation.revolutions();
        let at = turns.partition_point(|(start, _)| start.as_secs_f64() <= begun_by_s);
        let (_, ahead_rad) = turns[at - 1];
        let shares = geometry.turn_share(340) - geometry.turn_share(beam.index);
        let measured_rad = beam.tilt_rad + beam.speed_rad_s * shares * 0.0998;
        let true_rad = ahead_rad + beam.travel_direction * backlash_rad / 2.0;
        if beam.speed_rad_s.abs() > 0.2 {
            offsets.push((true_rad - measured_rad) / beam.speed_rad_s);
        }
    }
    offsets.iter().sum::<f64>() / offsets.len() as f64
}

fn estimate(calibration: &Calibration, parameter: CalibrationParameter) -> ParameterEstimate {
    let found = calibration
        .estimates
        .iter()
        .find(|e| e.parameter == parameter);
    *found.expect("all are there")
}

/// Errors of angles in degrees, of the time offset in ms, of the backlash in degrees, each with its standard deviation.
fn errors(calibration: &Calibration, hidden: Hidden, time_s: f64) -> [(f64, f64); 5] {
    let of = |parameter, truth: f64, factor: f64| {
        let e = estimate(calibration, parameter);
        (factor * (e.value - truth), factor * e.sigma)
    };
    let deg = 1f64.to_degrees();
    let [roll, pitch, yaw] = hidden.rpy_deg.map(f64::to_radians);
    [
        of(CalibrationParameter::Roll, roll, deg),
        of(CalibrationParameter::Pitch, pitch, deg),
        of(CalibrationParameter::Yaw, yaw, deg),
        of(CalibrationParameter::TimeOffset, time_s, 1e3),
        of(
            CalibrationParameter::Backlash,
            hidden.backlash_half_steps * HALF_STEP_RAD,
            deg,
        ),
    ]
}

/// The shipped scenes, each with a differently misaligned robot.
const MISALIGNED: [(&str, Hidden); 3] = [
    (
        "storeroom.toml",
        Hidden {
            rpy_deg: [-1.6, 0.8, -0.5],
            stamp_offset_ms: -9.0,
            backlash_half_steps: 0.0,
            bias_mm: 8.0,
        },
    ),
    (
        "office.toml",
        Hidden {
            rpy_deg: [0.7, -1.1, 0.9],
            stamp_offset_ms: 6.0,
            backlash_half_steps: 2.0,
            bias_mm: 0.0,
        },
    ),
    (
        "corridor.toml",
        Hidden {
            rpy_deg: [0.1, 0.3, -1.9],
            stamp_offset_ms: 0.0,
            backlash_half_steps: 5.0,
            bias_mm: -6.0,
        },
    ),
];

const NAMES: [&str; 5] = ["roll", "pitch", "yaw", "tau ms", "backlash"];

/// Errors and standard deviations of a calibration with three pans; `check_one_pan` gets the calibration with one pan.
fn found_in(
    scene: &str,
    seed: u64,
    hidden: Hidden,
    check_one_pan: impl FnOnce(&Calibration),
) -> [(f64, f64); 5] {
    let mut rig = TestRig::ready_in_scene(options(seed, hidden), scene);
    rig.emulation.record_revolutions();
    let sweeps = sweeps(&mut rig, true);
    let time_s = true_time_offset_s(&rig.emulation, &sweeps, hidden);
    let found =
        calibrate(&sweeps, None).unwrap_or_else(|e| panic!("{scene} {seed} {hidden:?}: {e}"));
    let middle: Vec<RawSweep> = sweeps.iter().map(at_middle_pan).collect();
    check_one_pan(&calibrate(&middle, None).expect("calibrates"));
    errors(&found, hidden, time_s)
}

/// Angles within 0.05 deg and the time offset within 0.3 ms: less than the noise of a sweep.
fn assert_found(which: usize) {
    let (scene, hidden) = MISALIGNED[which];
    let errors = found_in(scene, 1 + which as u64, hidden, |one_pan| {
        let pitch = estimate(one_pan, CalibrationParameter::Pitch);
        assert!(!pitch.observable, "{pitch:?}");
    });
    for ((name, (error, sigma)), max) in NAMES.iter().zip(errors).zip([0.05, 0.05, 0.05, 0.3, 0.05])
    {
        eprintln!("{scene} {name}: error {error:+.4}, sigma {sigma:.4}");
        assert!(error.abs() < max, "{scene} {name}: {error}");
    }
}

#[test]
fn mount_time_and_backlash_hidden_in_the_storeroom_are_found() {
    assert_found(0);
}

#[test]
fn mount_time_and_backlash_hidden_in_the_office_are_found() {
    assert_found(1);
}

/// A robot of the storeroom whose laser has this roll, configured with another.
fn roll_found(true_deg: f64, configured_deg: f64, several_pans: bool) -> ParameterEstimate {
    let (scene, mut hidden) = MISALIGNED[0];
    hidden.rpy_deg[0] = true_deg;
    let mut rig = TestRig::ready_in_scene(options(7, hidden), scene);
    let mut settings = Settings::defaults();
    settings.mount.laser_rpy_rad[0] = configured_deg.to_radians();
    let mut request = TestRig::request(SweepMode::Continuous);
    request.mount = settings.mount.chain();
    let taken: Vec<RawSweep> = calibration_requests(&request, several_pans)
        .iter()
        .map(|request| rig.sweep(request, |_, _, _| {}).expect("a sweep"))
        .collect();
    let found = calibrate(&taken, None).expect("calibrates");
    estimate(&found, CalibrationParameter::Roll)
}

#[test]
fn a_laser_that_is_mounted_the_other_way_up_than_configured_is_found_by_several_pans() {
    for (true_deg, configured_deg) in [(178.6, 0.0), (-1.3, 180.0)] {
        let roll = roll_found(true_deg, configured_deg, true);
        let found_deg = roll.value.to_degrees();
        assert!(roll.observable, "{roll:?}");
        assert!((found_deg - true_deg).abs() < 0.05, "{found_deg}");
        assert!((roll.present.to_degrees() - configured_deg).abs() < 1e-9);
    }
}

#[test]
fn one_pan_cannot_show_which_way_up_a_laser_is_mounted() {
    let roll = roll_found(178.6, 0.0, false);
    assert!(
        roll.value.abs() < 0.1,
        "stays with what is configured: {roll:?}"
    );
}

#[test]
#[ignore = "half a minute; a third scene, as the two above"]
fn mount_time_and_backlash_hidden_in_the_corridor_are_found() {
    assert_found(2);
}

/// Randomly misaligned robots in all scenes: all within the same bounds, and the 95 % intervals contain the truth.
#[test]
#[ignore = "ten minutes"]
fn stated_uncertainties_hold_the_truth_of_many_robots() {
    let robots = 8;
    let mut contained = [0; 5];
    let mut worst = [0.0_f64; 5];
    for (scene, _) in MISALIGNED {
        for seed in 100..100 + robots {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut between = |max: f64| rng.random_range(-max..=max);
            let hidden = Hidden {
                rpy_deg: [between(2.0), between(2.0), between(2.0)],
                stamp_offset_ms: between(10.0),
                backlash_half_steps: between(3.0) + 3.0,
                bias_mm: between(10.0),
            };
            let errors = found_in(scene, seed, hidden, |_| ());
            eprintln!("{scene} {seed}: {errors:.4?}");
            for (i, (error, sigma)) in errors.into_iter().enumerate() {
                contained[i] += usize::from(error.abs() <= 1.96 * sigma);
                worst[i] = worst[i].max(error.abs());
            }
        }
    }
    let all = MISALIGNED.len() * robots as usize;
    eprintln!("contained of {all}: {NAMES:?} {contained:?}; worst errors {worst:.4?}");
    for (name, (worst, max)) in NAMES
        .iter()
        .zip(worst.into_iter().zip([0.05, 0.05, 0.05, 0.3, 0.05]))
    {
        assert!(worst < max, "{name}: {worst}");
    }
    for (name, contained) in NAMES.iter().zip(contained) {
        assert!(
            contained as f64 >= 0.85 * all as f64,
            "{name}: {contained} of {all}"
        );
    }
}
