//! Complete sweeps of a room with known walls.

use super::rig::TestRig;
use crate::config::{Settings, SweepMode};
use patrold_engine::sweep::{Sweep, assemble};
use patrold_sim::emulator::EmulationOptions;
use patrold_sim::world::NoiseOptions;
use scip::emulator::LaserLink;
use std::f64::consts::PI;
use std::time::Duration;

/// Distances of the points from the nearest wall of the room, metres, sorted; base frame of the middle at 0.4 m.
fn wall_distances(sweep: &Sweep) -> Vec<f64> {
    let mut distances: Vec<f64> = sweep
        .view
        .points
        .iter()
        .map(|p| {
            let z = p.z + 0.4;
            let to = [p.x.abs() - 2.0, p.y.abs() - 1.5, (z - 1.2).abs() - 1.2];
            to.into_iter().map(f64::abs).fold(f64::INFINITY, f64::min)
        })
        .collect();
    distances.sort_by(f64::total_cmp);
    distances
}

struct SweepErrors {
    median_mm: f64,
    p99_mm: f64,
    rms_mm: f64,
    seconds: f64,
    sweep: Sweep,
}

fn take(options: EmulationOptions, mode: SweepMode, pans: &[f64], reverse: bool) -> SweepErrors {
    let mut rig = TestRig::ready(options);
    let mut request = TestRig::request(mode);
    request.pans_rad = pans.to_vec();
    if reverse {
        std::mem::swap(&mut request.tilt_from_rad, &mut request.tilt_to_rad);
    }
    let started = rig.now;
    let raw = rig.sweep(&request, |_, _, _| {}).expect("a sweep");
    let seconds = (rig.now - started).as_secs_f64();
    assert!(!rig.emulation.laser_on() && !rig.emulation.head_moving());
    let sweep = assemble(&raw).expect("assembles");
    assert_eq!(sweep.quality.fault(0.05), None, "{:?}", sweep.quality);
    let distances = wall_distances(&sweep);
    let at = |share: f64| 1e3 * distances[(share * (distances.len() - 1) as f64) as usize];
    let squares: f64 = distances.iter().map(|d| d * d).sum();
    let errors = SweepErrors {
        median_mm: at(0.5),
        p99_mm: at(0.99),
        rms_mm: 1e3 * (squares / distances.len() as f64).sqrt(),
        seconds,
        sweep,
    };
    eprintln!(
        "{mode:?} {pans:?} reverse {reverse}: {} points, median {:.2} mm, p99 {:.2}, rms {:.2}, {:.1} s, {:?}",
        errors.sweep.view.points.len(),
        errors.median_mm,
        errors.p99_mm,
        errors.rms_mm,
        errors.seconds,
        errors.sweep.quality
    );
    errors
}

fn ideal() -> EmulationOptions {
    EmulationOptions {
        noise: NoiseOptions::ideal(),
        ..EmulationOptions::seeded(3)
    }
}

#[test]
fn without_noise_the_points_lie_on_the_walls_in_both_modes_and_both_ways() {
    for (mode, reverse) in [
        (SweepMode::Continuous, false),
        (SweepMode::Continuous, true),
        (SweepMode::Step, false),
    ] {
        let errors = take(ideal(), mode, &[0.0], reverse);
        // Ranges come in whole millimetres; a count of the head is 0.9 mrad, 1.8 mm at 2 m.
        assert!(errors.median_mm < 1.0, "{mode:?} {}", errors.median_mm);
        assert!(errors.p99_mm < 5.0, "{mode:?} {}", errors.p99_mm);
    }
}

#[test]
fn with_sensor_noise_the_residual_is_the_noise() {
    for mode in [SweepMode::Continuous, SweepMode::Step] {
        let errors = take(EmulationOptions::seeded(5), mode, &[0.0], false);
        // Sigma is 2.1 to 3.5 mm in this room; it has no edges for mixed pixels.
        assert!(errors.rms_mm < 5.0, "{mode:?} {}", errors.rms_mm);
        let quality = &errors.sweep.quality;
        assert!(
            quality.lines_got + 1 >= quality.lines_expected,
            "{quality:?}"
        );
        assert_eq!(quality.gaps, 0);
        assert!(quality.clock_uncertainty_s < 0.002, "{quality:?}");
    }
}

#[test]
fn several_pans_give_one_cloud() {
    let errors = take(ideal(), SweepMode::Continuous, &[-1.0, 1.0], false);
    assert!(errors.p99_mm < 5.0, "{}", errors.p99_mm);
    assert_eq!(errors.sweep.quality.lines_expected, 242);
}

#[test]
fn a_timer_about_to_wrap_and_a_scip_2_sensor_change_nothing() {
    let mut options = ideal();
    options.laser.profile = scip::emulator::LaserProfile::urg_04lx_ug01();
    let mut rig = TestRig::ready(options.clone());
    // The timer is reset at connecting; advance it near the wrap.
    let wrap = Duration::from_millis(u64::from(scip::STAMP_MODULUS_MS));
    let connected = rig.now;
    rig.now = wrap - Duration::from_secs(30);
    assert!(rig.now > connected);
    rig.emulation.advance(rig.now);
    let raw = rig
        .sweep(&TestRig::request(SweepMode::Continuous), |_, _, _| {})
        .expect("a sweep");
    let sweep = assemble(&raw).expect("assembles");
    let stamps: Vec<u64> = raw.pan_segments[0]
        .scans
        .iter()
        .map(|s| s.stamp_ms)
        .collect();
    assert!(stamps.windows(2).all(|w| w[1] > w[0]));
    assert_eq!(sweep.quality.fault(0.05), None, "{:?}", sweep.quality);
}

#[test]
fn a_slow_line_gives_whole_sweeps_of_fewer_beams() {
    for (baud, cluster, lines) in [
        (115_200, 2, 120..=122),
        (57_600, 2, 120..=122),
        (19_200, 4, 90..=100),
    ] {
        let mut options = ideal();
        options.laser.link = LaserLink::Serial { baud };
        let errors = take(options, SweepMode::Continuous, &[0.0], false);
        let quality = &errors.sweep.quality;
        assert!(
            lines.contains(&quality.lines_expected),
            "{baud}: {quality:?}"
        );
        assert!(
            quality.lines_got + 1 >= quality.lines_expected,
            "{baud}: {quality:?}"
        );
        let beams = errors.sweep.view.points.len() / quality.lines_got;
        assert!(
            (600 / cluster..=682 / cluster).contains(&beams),
            "{baud}: {beams}"
        );
        // The nearest of some neighbours stands for them: on a slanting wall it is nearer.
        assert!(errors.median_mm < 25.0, "{baud}: {}", errors.median_mm);
    }
}

/// The room with a box 1 m to the left of the robot, on the floor.
const BOX_ON_THE_LEFT: &str = "[robot]\nheight_m = 0.4\n[[room]]\nname = \"room\"\ncentre = [0.0, 0.0, 1.2]\n\
    size = [4.0, 3.0, 2.4]\n[[box]]\nname = \"crate\"\ncentre = [0.6, 1.0, 0.3]\nsize = [0.4, 0.4, 0.6]\n";

#[test]
fn the_cloud_of_a_laser_mounted_upside_down_is_right_with_its_roll_and_mirrored_without() {
    let mut options = ideal();
    options.mount.laser_rpy.roll_rad = PI;
    let mut rig = TestRig::ready_in(options, BOX_ON_THE_LEFT);
    // Points of the crate in front of the walls: on the left, and at the same place on the right.
    let on_crate = |sweep: &Sweep| {
        let inside = |side: f64| {
            let points = sweep.view.points.iter();
            points
                .filter(|p| (p.x - 0.6).abs() < 0.25 && (side * p.y - 0.85).abs() < 0.1)
                .filter(|p| p.z > -0.3 && p.z < 0.25)
                .count()
        };
        (inside(1.0), inside(-1.0))
    };
    let mut sweep_with_roll = |roll_deg: f64| {
        let mut settings = Settings::defaults();
        settings.mount.laser_rpy_rad = [roll_deg.to_radians(), 0.0, 0.0];
        let mut request = TestRig::request(SweepMode::Continuous);
        request.mount = settings.mount.chain();
        let raw = rig.sweep(&request, |_, _, _| {}).expect("a sweep");
        assemble(&raw).expect("assembles")
    };
    let right = sweep_with_roll(180.0);
    let (left_points, right_points) = on_crate(&right);
    assert!(
        left_points > 200 && right_points == 0,
        "{left_points} {right_points}"
    );
    // Up is up: the floor is 0.4 m below the base, and nothing is lower.
    let lowest = right
        .view
        .points
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    assert!((lowest + 0.4).abs() < 0.02, "{lowest}");
    let (left_points, right_points) = on_crate(&sweep_with_roll(0.0));
    assert!(
        left_points == 0 && right_points > 200,
        "{left_points} {right_points}"
    );
}

#[test]
fn the_same_seed_gives_the_same_sweep() {
    let once = || {
        let mut rig = TestRig::ready(EmulationOptions::seeded(9));
        let mut request = TestRig::request(SweepMode::Continuous);
        request.tilt_to_rad = request.tilt_from_rad + 0.3;
        rig.sweep(&request, |_, _, _| {}).expect("a sweep")
    };
    assert_eq!(once(), once());
}
