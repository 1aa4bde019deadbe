//! How residuals scatter: more or less than the sensor's law, alike among neighbours, apart between travels up and down.

use super::beams::CalibrationBeam;
use super::constants::{LAGS, ROBUST_SIGMAS};
use super::solve::{OnPlane, Scatter};

/// Share of a normal distribution's standard deviation that the median of absolute values is.
const MEDIAN_OF_SIGMA: f64 = 0.6745;

/// The scatter that `residuals_m` show, on each of `planes` surfaces and among neighbours.
pub fn scatter(
    beams: &[CalibrationBeam],
    met: &[OnPlane],
    residuals_m: &[f64],
    planes: usize,
) -> Scatter {
    let mut of_plane = vec![Vec::new(); planes];
    for (on, residual) in met.iter().zip(residuals_m) {
        of_plane[on.plane].push((residual / on.sigma_m).abs());
    }
    let scales: Vec<f64> = of_plane
        .into_iter()
        .map(|mut z| {
            z.sort_by(f64::total_cmp);
            let median = z.get(z.len() / 2).copied().unwrap_or(MEDIAN_OF_SIGMA);
            (median / MEDIAN_OF_SIGMA).max(1e-3)
        })
        .collect();
    let z: Vec<f64> = met
        .iter()
        .zip(residuals_m)
        .map(|(on, r)| {
            let most = 1.5 * ROBUST_SIGMAS;
            (r / (on.sigma_m * scales[on.plane])).clamp(-most, most)
        })
        .collect();
    let variance = z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64;
    let mut sharing = 1.0;
    for lag in 1..=LAGS {
        let (mut sum, mut pairs) = (0.0, 0_usize);
        for i in 0..met.len().saturating_sub(lag) {
            let (a, b) = (&beams[met[i].beam], &beams[met[i + lag].beam]);
            let neighbours = met[i].plane == met[i + lag].plane
                && (a.leg, a.scan, a.index + lag) == (b.leg, b.scan, b.index);
            if neighbours {
                sum += z[i] * z[i + lag];
                pairs += 1;
            }
        }
        let shared = sum / (pairs.max(1) as f64 * variance.max(1e-12));
        if shared <= 0.0 {
            break;
        }
        sharing += 2.0 * shared;
    }
    Scatter { scales, sharing }
}

/// How far surfaces seen on travels up lie from the same seen on travels down, metres: root mean square over the surfaces
/// that both saw; `None` without any.
pub fn up_against_down_m(
    beams: &[CalibrationBeam],
    met: &[OnPlane],
    residuals_m: &[f64],
    planes: usize,
) -> Option<f64> {
    // Sum and number on travels up, then on travels down.
    let mut sums = vec![[(0.0, 0_usize); 2]; planes];
    for (on, residual) in met.iter().zip(residuals_m) {
        let way = beams[on.beam].way;
        if way != 0.0 {
            let (sum, n) = &mut sums[on.plane][usize::from(way < 0.0)];
            *sum += residual;
            *n += 1;
        }
    }
    let apart: Vec<f64> = sums
        .into_iter()
        .filter(|[up, down]| up.1 > 0 && down.1 > 0)
        .map(|[up, down]| up.0 / up.1 as f64 - down.0 / down.1 as f64)
        .collect();
    let squares: f64 = apart.iter().map(|d| d * d).sum();
    (!apart.is_empty()).then(|| (squares / apart.len() as f64).sqrt())
}
