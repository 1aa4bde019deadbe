//! Statistics of residuals: their scale on each plane, their correlation between neighbours, and the mismatch between travels
//! up and down.

use super::beams::CalibrationBeam;
use super::constants::{HUBER_SIGMAS, MAX_LAG, MEDIAN_OF_SIGMA};
use super::solve::{PlaneHit, ResidualScatter};

/// The scatter of `residuals_m` on each of `planes` planes and between neighbours.
pub(super) fn residual_scatter(
    beams: &[CalibrationBeam],
    hits: &[PlaneHit],
    residuals_m: &[f64],
    planes: usize,
) -> ResidualScatter {
    let mut deviations_of_plane = vec![Vec::new(); planes];
    for (hit, residual) in hits.iter().zip(residuals_m) {
        deviations_of_plane[hit.plane].push((residual / hit.sigma_m).abs());
    }
    let scales: Vec<f64> = deviations_of_plane
        .into_iter()
        .map(|mut z| {
            z.sort_by(f64::total_cmp);
            let median = z.get(z.len() / 2).copied().unwrap_or(MEDIAN_OF_SIGMA);
            (median / MEDIAN_OF_SIGMA).max(1e-3)
        })
        .collect();
    let z: Vec<f64> = hits
        .iter()
        .zip(residuals_m)
        .map(|(hit, r)| {
            let max = 1.5 * HUBER_SIGMAS;
            (r / (hit.sigma_m * scales[hit.plane])).clamp(-max, max)
        })
        .collect();
    let variance = z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64;
    let mut correlated_beams = 1.0;
    for lag in 1..=MAX_LAG {
        let (mut sum, mut pairs) = (0.0, 0_usize);
        for i in 0..hits.len().saturating_sub(lag) {
            let (a, b) = (&beams[hits[i].beam], &beams[hits[i + lag].beam]);
            let neighbours = hits[i].plane == hits[i + lag].plane
                && (a.pan_segment, a.scan, a.index + lag) == (b.pan_segment, b.scan, b.index);
            if neighbours {
                sum += z[i] * z[i + lag];
                pairs += 1;
            }
        }
        let correlation = sum / (pairs.max(1) as f64 * variance.max(1e-12));
        if correlation <= 0.0 {
            break;
        }
        correlated_beams += 2.0 * correlation;
    }
    ResidualScatter {
        scales,
        correlated_beams,
    }
}

/// Distance between planes seen on travels up and the same planes seen on travels down, metres: root mean square over the
/// planes seen both ways; `None` without any.
pub(super) fn up_down_mismatch_m(
    beams: &[CalibrationBeam],
    hits: &[PlaneHit],
    residuals_m: &[f64],
    planes: usize,
) -> Option<f64> {
    // Sum and number on travels up, then on travels down.
    let mut sums = vec![[(0.0, 0_usize); 2]; planes];
    for (hit, residual) in hits.iter().zip(residuals_m) {
        let travel = beams[hit.beam].travel_direction;
        if travel != 0.0 {
            let (sum, n) = &mut sums[hit.plane][usize::from(travel < 0.0)];
            *sum += residual;
            *n += 1;
        }
    }
    let mismatches_m: Vec<f64> = sums
        .into_iter()
        .filter(|[up, down]| up.1 > 0 && down.1 > 0)
        .map(|[up, down]| up.0 / up.1 as f64 - down.0 / down.1 as f64)
        .collect();
    let squares: f64 = mismatches_m.iter().map(|d| d * d).sum();
    (!mismatches_m.is_empty()).then(|| (squares / mismatches_m.len() as f64).sqrt())
}
