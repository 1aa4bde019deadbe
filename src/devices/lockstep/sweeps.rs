//! Whole sweeps of a room whose walls are known.

use super::bench::Bench;
use crate::config::SweepMode;
use patrold_engine::sweep::{Sweep, assemble};
use patrold_sim::emulator::EmulationOptions;
use patrold_sim::world::NoiseOptions;
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

struct Figures {
    median_mm: f64,
    p99_mm: f64,
    rms_mm: f64,
    seconds: f64,
    sweep: Sweep,
}

fn take(options: EmulationOptions, mode: SweepMode, pans: &[f64], reverse: bool) -> Figures {
    let mut bench = Bench::ready(options);
    let mut request = Bench::request(mode);
    request.pans_rad = pans.to_vec();
    if reverse {
        std::mem::swap(&mut request.tilt_from_rad, &mut request.tilt_to_rad);
    }
    let started = bench.now;
    let raw = bench.sweep(&request, |_, _, _| {}).expect("a sweep");
    let seconds = (bench.now - started).as_secs_f64();
    assert!(!bench.emulation.laser_on() && !bench.emulation.head_moving());
    let sweep = assemble(&raw).expect("assembles");
    assert_eq!(sweep.quality.fault(0.05), None, "{:?}", sweep.quality);
    let distances = wall_distances(&sweep);
    let at = |share: f64| 1e3 * distances[(share * (distances.len() - 1) as f64) as usize];
    let squares: f64 = distances.iter().map(|d| d * d).sum();
    let figures = Figures {
        median_mm: at(0.5),
        p99_mm: at(0.99),
        rms_mm: 1e3 * (squares / distances.len() as f64).sqrt(),
        seconds,
        sweep,
    };
    eprintln!(
        "{mode:?} {pans:?} reverse {reverse}: {} points, median {:.2} mm, p99 {:.2}, rms {:.2}, {:.1} s, {:?}",
        figures.sweep.view.points.len(),
        figures.median_mm,
        figures.p99_mm,
        figures.rms_mm,
        figures.seconds,
        figures.sweep.quality
    );
    figures
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
        let figures = take(ideal(), mode, &[0.0], reverse);
        // Ranges come in whole millimetres; a count of the head is 0.9 mrad, 1.8 mm at 2 m.
        assert!(figures.median_mm < 1.0, "{mode:?} {}", figures.median_mm);
        assert!(figures.p99_mm < 5.0, "{mode:?} {}", figures.p99_mm);
    }
}

#[test]
fn with_the_sensors_noise_the_residual_is_the_noise() {
    for mode in [SweepMode::Continuous, SweepMode::Step] {
        let figures = take(EmulationOptions::seeded(5), mode, &[0.0], false);
        // Sigma is 2.1 to 3.5 mm in this room; mixed pixels have no place to come from.
        assert!(figures.rms_mm < 5.0, "{mode:?} {}", figures.rms_mm);
        let quality = &figures.sweep.quality;
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
    let figures = take(ideal(), SweepMode::Continuous, &[-1.0, 1.0], false);
    assert!(figures.p99_mm < 5.0, "{}", figures.p99_mm);
    assert_eq!(figures.sweep.quality.lines_expected, 242);
}

#[test]
fn a_timer_about_to_wrap_and_a_scip_2_sensor_change_nothing() {
    let mut options = ideal();
    options.laser.profile = scip::twin::Profile::urg_04lx_ug01();
    let mut bench = Bench::ready(options.clone());
    // The timer is reset at connecting: let it come near the wrap from there.
    let wrap = Duration::from_millis(u64::from(scip::STAMP_MODULUS_MS));
    let connected = bench.now;
    bench.now = wrap - Duration::from_secs(30);
    assert!(bench.now > connected);
    bench.emulation.advance(bench.now);
    let raw = bench
        .sweep(&Bench::request(SweepMode::Continuous), |_, _, _| {})
        .expect("a sweep");
    let sweep = assemble(&raw).expect("assembles");
    let stamps: Vec<u64> = raw.legs[0].scans.iter().map(|s| s.stamp_ms).collect();
    assert!(stamps.windows(2).all(|w| w[1] > w[0]));
    assert_eq!(sweep.quality.fault(0.05), None, "{:?}", sweep.quality);
}

#[test]
fn the_same_seed_gives_the_same_sweep() {
    let once = || {
        let mut bench = Bench::ready(EmulationOptions::seeded(9));
        let mut request = Bench::request(SweepMode::Continuous);
        request.tilt_to_rad = request.tilt_from_rad + 0.3;
        bench.sweep(&request, |_, _, _| {}).expect("a sweep")
    };
    assert_eq!(once(), once());
}
