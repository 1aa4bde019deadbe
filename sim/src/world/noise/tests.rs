//! The simulated errors against the recorded figures (scip2 sections 7 and 11).

use super::{NoiseOptions, TrueBeam};
use crate::world::constants::EDGE_JUMP_MM;
use std::time::Duration;

const SCANS: usize = 400;

fn beam(range_mm: f64) -> Option<TrueBeam> {
    Some(TrueBeam {
        range_m: range_mm / 1000.0,
        cos_incidence: 1.0,
        reflectance: 0.5,
    })
}

/// Scans at successive instants of one truth.
fn scans(options: &NoiseOptions, truth: &[Option<TrueBeam>], count: usize) -> Vec<Vec<u32>> {
    (0..count)
        .map(|k| options.measure(truth, Duration::from_millis(100 * k as u64)))
        .collect()
}

/// A room of 1.8 m x 1.4 m like the recorded one: ranges of 0.3-1.5 m, walls at every incidence.
fn small_room() -> Vec<Option<TrueBeam>> {
    (0..682)
        .map(|i| {
            let azimuth = (f64::from(i) - 340.0) * std::f64::consts::TAU / 1024.0;
            let (x, y) = (azimuth.cos(), azimuth.sin());
            let (to_x, to_y) = (
                if x > 0.0 { 1.2 } else { 0.6 } / x.abs().max(1e-9),
                if y > 0.0 { 0.9 } else { 0.5 } / y.abs().max(1e-9),
            );
            Some(TrueBeam {
                range_m: to_x.min(to_y),
                cos_incidence: if to_x < to_y { x.abs() } else { y.abs() },
                reflectance: 0.5,
            })
        })
        .collect()
}

/// Residuals of every scan about the mean of each beam; 0 for codes.
fn residuals(scans: &[Vec<u32>]) -> Vec<Vec<f64>> {
    let beams = scans[0].len();
    let means: Vec<f64> = (0..beams)
        .map(|b| {
            let valid: Vec<f64> = scans
                .iter()
                .map(|s| s[b])
                .filter(|v| *v >= 20)
                .map(f64::from)
                .collect();
            valid.iter().sum::<f64>() / valid.len() as f64
        })
        .collect();
    scans
        .iter()
        .map(|s| {
            s.iter()
                .zip(&means)
                .map(|(v, m)| if *v < 20 { 0.0 } else { f64::from(*v) - m })
                .collect()
        })
        .collect()
}

fn correlation(residuals: &[Vec<f64>], lag: usize) -> f64 {
    let (mut cross, mut own) = (0.0, 0.0);
    for scan in residuals {
        for (a, b) in scan.iter().zip(&scan[lag..]) {
            cross += a * b;
            own += (a * a + b * b) / 2.0;
        }
    }
    cross / own
}

fn equal_neighbours(scans: &[Vec<u32>]) -> f64 {
    let pairs = scans
        .iter()
        .flat_map(|s| s.windows(2))
        .filter(|w| w[0] >= 20 && w[1] >= 20);
    let (equal, all) = pairs.fold((0, 0), |(e, n), w| (e + usize::from(w[0] == w[1]), n + 1));
    equal as f64 / all as f64
}

fn median_std(scans: &[Vec<u32>]) -> f64 {
    let residuals = residuals(scans);
    let mut stds: Vec<f64> = (0..residuals[0].len())
        .map(|b| {
            (residuals.iter().map(|r| r[b] * r[b]).sum::<f64>() / residuals.len() as f64).sqrt()
        })
        .collect();
    stds.sort_by(f64::total_cmp);
    stds[stds.len() / 2]
}

#[test]
fn standard_deviations_are_those_of_their_bands() {
    // Middle of the band and the recorded median of that band, mm (recording L1).
    for (range_mm, recorded_mm) in [
        (200.0, 2.2),
        (500.0, 2.1),
        (850.0, 2.6),
        (1250.0, 2.9),
        (2500.0, 3.5),
    ] {
        let got = median_std(&scans(
            &NoiseOptions::seeded(1),
            &vec![beam(range_mm); 682],
            SCANS,
        ));
        assert!(
            (got / recorded_mm - 1.0).abs() < 0.1,
            "{range_mm} mm: {got}, recorded {recorded_mm}"
        );
    }
    for range_mm in [2700.0, 3500.0, 5000.0] {
        let got = median_std(&scans(
            &NoiseOptions::seeded(1),
            &vec![beam(range_mm); 682],
            SCANS,
        ));
        assert!((3.5..9.0).contains(&got), "{range_mm} mm: {got}");
    }
}

#[test]
fn neighbours_correlate_as_recorded() {
    let mut equal = Vec::new();
    let mut correlations = Vec::new();
    for truth in [vec![beam(700.0); 682], small_room()] {
        let scans = scans(&NoiseOptions::seeded(2), &truth, SCANS);
        equal.push(equal_neighbours(&scans));
        let residuals = residuals(&scans);
        correlations.push([1, 2, 3, 8].map(|lag| correlation(&residuals, lag)));
    }
    assert!(equal.iter().all(|e| (0.3..0.55).contains(e)), "{equal:?}");
    let mean = (equal[0] + equal[1]) / 2.0;
    assert!((mean - 0.42).abs() < 0.03, "{equal:?}");
    for (i, recorded) in [0.48, 0.28, 0.13, 0.0].into_iter().enumerate() {
        for c in &correlations {
            assert!((c[i] - recorded).abs() < 0.08, "{correlations:?}");
        }
    }
}

#[test]
fn noise_is_white_in_time() {
    let residuals = residuals(&scans(
        &NoiseOptions::seeded(3),
        &vec![beam(700.0); 682],
        SCANS,
    ));
    let (mut cross, mut own) = (0.0, 0.0);
    for (a, b) in residuals.iter().zip(&residuals[1..]) {
        cross += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        own += a.iter().map(|a| a * a).sum::<f64>();
    }
    assert!((cross / own).abs() < 0.02, "{}", cross / own);
}

#[test]
fn two_beams_in_a_hundred_flicker_within_sixteen_scans() {
    let (mut flickering, mut beams) = (0, 0);
    for seed in 0..30 {
        let scans = scans(&NoiseOptions::seeded(seed), &vec![beam(700.0); 682], 16);
        flickering += (0..682)
            .filter(|b| scans.iter().any(|s| s[*b] < 20))
            .count();
        beams += 682;
    }
    let share = f64::from(flickering as u32) / f64::from(beams);
    assert!((share - 0.02).abs() < 0.003, "{share}");
}

#[test]
fn edges_have_mixed_pixels_as_often_as_recorded() {
    // Steps of 1 m every 20 beams.
    let truth: Vec<_> = (0..680)
        .map(|i| beam(if (i / 20) % 2 == 0 { 1000.0 } else { 2000.0 }))
        .collect();
    let options = NoiseOptions {
        code_scale: 0.0,
        ..NoiseOptions::seeded(4)
    };
    let (mut between, mut edges) = (0, 0);
    for scan in scans(&options, &truth, 100) {
        for at in (20..680).step_by(20) {
            edges += 1;
            between += usize::from(scan[at - 1..=at].iter().any(|v| (1050..1950).contains(v)));
        }
    }
    let share = f64::from(between as u32) / f64::from(edges);
    assert!((share - 0.27).abs() < 0.02, "{share}");
    // A slope without jumps above the limit has none: values stay near the truth.
    let slope: Vec<_> = (0..10)
        .map(|i| beam(1000.0 + (EDGE_JUMP_MM - 1.0) * f64::from(i)))
        .collect();
    for scan in scans(&options, &slope, 50) {
        for (v, t) in scan.iter().zip(&slope) {
            assert!((f64::from(*v) - t.expect("a beam").range_m * 1000.0).abs() < 60.0);
        }
    }
}

#[test]
fn empty_beams_give_the_recorded_codes() {
    let all: Vec<u32> = scans(&NoiseOptions::seeded(5), &[None; 682], 200).concat();
    for (code, recorded) in [(0, 0.95), (7, 0.026), (6, 0.012), (1, 0.004)] {
        let share = all.iter().filter(|v| **v == code).count() as f64 / all.len() as f64;
        assert!((share - recorded).abs() < 0.003, "code {code}: {share}");
    }
    assert!(all.iter().all(|v| *v < 20));
}

#[test]
fn targets_are_lost_when_dark_grazing_or_far() {
    let lost = |truth: TrueBeam| {
        let all = scans(&NoiseOptions::seeded(6), &vec![Some(truth); 682], 20).concat();
        all.iter().filter(|v| **v < 20).count() as f64 / all.len() as f64
    };
    let good = TrueBeam {
        range_m: 1.0,
        cos_incidence: 1.0,
        reflectance: 0.5,
    };
    assert!(lost(good) < 0.003);
    assert_eq!(
        lost(TrueBeam {
            reflectance: 0.0,
            ..good
        }),
        1.0
    );
    assert_eq!(
        lost(TrueBeam {
            cos_incidence: 0.0,
            ..good
        }),
        1.0
    );
    assert!(
        (lost(TrueBeam {
            cos_incidence: 0.04,
            ..good
        }) - 0.5)
            .abs()
            < 0.05
    );
    assert!(
        (lost(TrueBeam {
            range_m: 5.3,
            ..good
        }) - 0.074)
            .abs()
            < 0.02
    );
}

#[test]
fn ranges_outside_the_sensor_are_codes() {
    let values = NoiseOptions::ideal().measure(
        &[
            beam(5600.0),
            beam(5601.0),
            beam(20.0),
            beam(19.0),
            None,
            beam(1234.4),
        ],
        Duration::ZERO,
    );
    assert_eq!(values, [5600, 0, 20, 1, 0, 1234]);
}

#[test]
fn bias_applies_at_once_and_drift_grows() {
    let options = NoiseOptions {
        bias_mm: 10.0,
        drift_mm: 20.0,
        drift_time_s: 100.0,
        ..NoiseOptions::ideal()
    };
    let at = |s| options.measure(&[beam(1000.0)], Duration::from_secs(s))[0];
    assert_eq!((at(0), at(100), at(10_000)), (1010, 1023, 1030));
}

#[test]
fn a_changed_object_leaves_the_noise_of_the_others() {
    let mut truth = vec![beam(1000.0); 100];
    let options = NoiseOptions {
        seed: 7,
        mixed_scale: 0.0,
        ..NoiseOptions::default()
    };
    let before = options.measure(&truth, Duration::from_millis(100));
    truth[50] = None;
    let after = options.measure(&truth, Duration::from_millis(100));
    assert_eq!(before[..50], after[..50]);
    // Behind it a plateau may begin anew.
    assert_eq!(before[70..], after[70..]);
}
