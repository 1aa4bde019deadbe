use super::{NoiseOptions, TrueBeam};
use crate::world::constants::{EDGE_JUMP_MM, SIGMA_MM};
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

/// A room of 1.8 m x 1.4 m as the recorded one: ranges of 0.3-1.5 m, walls at every incidence.
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

/// Residuals of every scan about every beam's own mean; codes stand as 0.
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
fn tell() {
    let room = small_room();
    for (name, truth) in [("flat", vec![beam(700.0); 682]), ("room", room)] {
        let s = scans(&NoiseOptions::seeded(1), &truth, SCANS);
        let r = residuals(&s);
        eprintln!(
            "{name} std {} equal {} corr {:?}",
            median_std(&s),
            equal_neighbours(&s),
            [1, 2, 3, 5].map(|l| correlation(&r, l))
        );
    }
    for (r, s) in SIGMA_MM {
        eprintln!(
            "{r} {s} {}",
            median_std(&scans(
                &NoiseOptions::seeded(1),
                &vec![beam(r - 50.0); 682],
                SCANS
            ))
        );
    }
    let _ = EDGE_JUMP_MM;
}
