//! What the twins hide is found: mount, time offset and backlash from sweeps of the shipped rooms.

use super::bench::Bench;
use crate::config::SweepMode;
use crate::devices::calibration_plan::calibration_requests;
use crate::devices::emulation::{Emulation, EmulationOptions};
use crate::geometry::RollPitchYaw;
use crate::sweep::{Calibration, Estimate, Parameter, RawSweep, bare_beams, calibrate};

/// Half a step of a D46-17, radians.
const HALF_STEP_RAD: f64 = 185.1428 / 3600.0 * std::f64::consts::PI / 180.0;

/// What a robot hides.
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

fn sweeps(bench: &mut Bench, pans: bool) -> Vec<RawSweep> {
    let request = Bench::request(SweepMode::Continuous);
    calibration_requests(&request, pans)
        .iter()
        .map(|request| bench.sweep(request, |_, _, _| {}).expect("a sweep"))
        .collect()
}

/// The leg at the middle pan alone.
fn at_middle_pan(sweep: &RawSweep) -> RawSweep {
    let mut sweep = sweep.clone();
    sweep.legs.retain(|leg| leg.pan_rad.abs() < 0.1);
    sweep
}

/// The time offset in truth, seconds: what separates the tilt that clock and polls tell for a beam from the tilt that the
/// head had when the mirror truly passed, over the tilt's speed.
fn true_time_offset_s(emulation: &Emulation, sweeps: &[RawSweep], hidden: Hidden) -> f64 {
    let beams = bare_beams(sweeps).expect("beams");
    let legs: Vec<_> = sweeps
        .iter()
        .flat_map(|s| s.legs.iter().map(move |leg| (s, leg)))
        .collect();
    let backlash_rad = hidden.backlash_half_steps * HALF_STEP_RAD;
    let mut offsets = Vec::new();
    for scan in beams.chunk_by(|a, b| (a.leg, a.scan) == (b.leg, b.scan)) {
        let beam = &scan[0];
        let (sweep, leg) = legs[beam.leg];
        let optics = &sweep.optics;
        // Data follow step 768 of the turn.
        let begun_by_s = leg.scans[beam.scan].arrived_s - 0.074;
        let turns = &emulation.turns;
        let at = turns.partition_point(|(start, _)| start.as_secs_f64() <= begun_by_s);
        let (_, ahead_rad) = turns[at - 1];
        let shares = optics.turn_share(340) - optics.turn_share(beam.index);
        let told_rad = beam.tilt_rad + beam.speed_rad_s * shares * 0.0998;
        let true_rad = ahead_rad + beam.way * backlash_rad / 2.0;
        if beam.speed_rad_s.abs() > 0.2 {
            offsets.push((true_rad - told_rad) / beam.speed_rad_s);
        }
    }
    offsets.iter().sum::<f64>() / offsets.len() as f64
}

fn estimate(calibration: &Calibration, parameter: Parameter) -> Estimate {
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
        of(Parameter::Roll, roll, deg),
        of(Parameter::Pitch, pitch, deg),
        of(Parameter::Yaw, yaw, deg),
        of(Parameter::TimeOffset, time_s, 1e3),
        of(
            Parameter::Backlash,
            hidden.backlash_half_steps * HALF_STEP_RAD,
            deg,
        ),
    ]
}

const AWRY: [Hidden; 3] = [
    Hidden {
        rpy_deg: [0.7, -1.1, 0.9],
        stamp_offset_ms: 6.0,
        backlash_half_steps: 2.0,
        bias_mm: 0.0,
    },
    Hidden {
        rpy_deg: [-1.6, 0.8, -0.5],
        stamp_offset_ms: -9.0,
        backlash_half_steps: 0.0,
        bias_mm: 8.0,
    },
    Hidden {
        rpy_deg: [0.1, 0.3, -1.9],
        stamp_offset_ms: 0.0,
        backlash_half_steps: 5.0,
        bias_mm: -6.0,
    },
];

#[test]
fn hidden_mount_time_and_backlash_are_found_in_the_shipped_rooms() {
    let (mut within, mut all) = (0, 0);
    let mut missed = Vec::new();
    for (seed, scene) in (1..).zip(["office.toml", "storeroom.toml", "corridor.toml"]) {
        let hidden = AWRY[(seed as usize - 1) % AWRY.len()];
        let mut bench = Bench::ready_in(options(seed, hidden), scene);
        let sweeps = sweeps(&mut bench, true);
        let time_s = true_time_offset_s(&bench.emulation, &sweeps, hidden);
        let found = match calibrate(&sweeps, None) {
            Ok(found) => found,
            Err(error) => {
                eprintln!("{scene}: {error}");
                missed.push((scene, [(f64::NAN, f64::NAN); 5]));
                continue;
            }
        };
        let middle: Vec<RawSweep> = sweeps.iter().map(at_middle_pan).collect();
        let poor = calibrate(&middle, None).expect("calibrates");
        let pitch = estimate(&poor, Parameter::Pitch);
        eprintln!(
            "{scene}, one pan: pitch +- {:.3} deg, roll +- {:.3}, yaw +- {:.3}",
            pitch.sigma.to_degrees(),
            estimate(&poor, Parameter::Roll).sigma.to_degrees(),
            estimate(&poor, Parameter::Yaw).sigma.to_degrees()
        );
        assert!(!pitch.observable, "{pitch:?}");
        let errors = errors(&found, hidden, time_s);
        eprintln!(
            "{scene} {hidden:?}: true tau {:.3} ms, {} planes, {} beams, residual {:.2} mm, up/down {:?}",
            1e3 * time_s,
            found.planes,
            found.beams,
            1e3 * found.residual_m,
            found.up_against_down_m
        );
        for (name, (error, sigma)) in ["roll", "pitch", "yaw", "tau ms", "backlash"]
            .iter()
            .zip(errors)
        {
            eprintln!("  {name}: error {error:+.4}, sigma {sigma:.4}");
            all += 1;
            within += usize::from(error.abs() <= 2.0 * sigma);
        }
        let most = [0.05, 0.05, 0.05, 0.3, 0.05];
        let off = errors
            .iter()
            .zip(most)
            .any(|((error, _), most)| error.abs() >= most);
        if off {
            missed.push((scene, errors));
        }
    }
    eprintln!("{within} of {all} within two standard deviations");
    // Roll, pitch, yaw in degrees, milliseconds, degrees of backlash: what a sweep needs to be better than its noise.
    assert!(missed.is_empty(), "{missed:?}");
}
