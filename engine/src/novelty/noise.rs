//! Estimates range noise: of one view, and of the difference between two.

use crate::geometry::{NoiseLaw, Registration, Surfaces};
use nalgebra::Point3;

/// Samples per bin of range, at least; fewer make one bin.
const SAMPLES_PER_BIN: usize = 200;
const MAX_BINS: usize = 10;
/// Cosine of incidence above which the height over a plane measures the range.
pub(super) const STEEP_COS: f64 = 0.5;
/// Samples of the difference between two views; more make no difference.
const MAX_SAMPLES: usize = 20_000;
/// Standard deviation over median absolute deviation of a normal distribution.
const MAD_TO_SIGMA: f64 = 1.4826;

/// The noise law of ranges, from heights of `points` over their flat cells. `None` if there are too few.
pub(super) fn estimate(
    points: &[Point3<f64>],
    origin: &Point3<f64>,
    surfaces: &Surfaces,
) -> Option<NoiseLaw> {
    let mut samples: Vec<(f64, f64)> = points
        .iter()
        .zip(&surfaces.patch_of_point)
        .filter_map(|(p, patch)| {
            let patch = surfaces.patches.get(*patch as usize)?;
            let ray = p - origin;
            let range_m = ray.norm();
            let incidence_cos = patch.normal.dot(&ray).abs() / range_m.max(1e-9);
            let n = patch.neighbours as f64;
            // The plane was fitted to the same points, which costs three degrees of freedom.
            (patch.flat && incidence_cos > STEEP_COS).then(|| {
                (
                    range_m,
                    patch.height_m(p).abs() / incidence_cos * (n / (n - 3.0)).sqrt(),
                )
            })
        })
        .collect();
    fit_law(&mut samples)
}

/// Noise of the difference between two registered views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CrossViewNoise {
    /// Of ranges, from surfaces met steeply.
    pub ranges: NoiseLaw,
    /// Standard deviation of heights over surfaces met at a shallow angle, metres. Range noise contributes little to it,
    /// bent scans do.
    pub height_m: f64,
}

/// The noise between two views, from heights of current points over the reference's flat cells after registration. Points
/// more than `gate_m` away have changed. `None` if too few are left.
pub(super) fn cross_view_noise(
    reference: &Surfaces,
    reference_origin: &Point3<f64>,
    current_points: &[Point3<f64>],
    registration: &Registration,
    gate_m: f64,
) -> Option<CrossViewNoise> {
    let reference_from_current = registration.reference_from_current();
    let step = current_points.len().div_ceil(MAX_SAMPLES).max(1);
    let mut steep = Vec::new();
    let mut shallow = Vec::new();
    for p in current_points.iter().step_by(step) {
        let p = reference_from_current.apply(p);
        let Some(patch) = reference
            .grid
            .nearest(&p, 1.5 * reference.cell_m)
            .and_then(|(i, _)| reference.patches.get(i))
        else {
            continue;
        };
        let ray = p - reference_origin;
        let range_m = ray.norm().max(1e-9);
        let incidence_cos = patch.normal.dot(&ray).abs() / range_m;
        let height = patch.height_m(&p).abs();
        if !patch.flat || height >= gate_m {
            continue;
        }
        if incidence_cos > STEEP_COS {
            steep.push((range_m, height / incidence_cos));
        } else {
            shallow.push(height);
        }
    }
    let middle = shallow.len() / 2;
    let height_m = if shallow.len() < 20 {
        0.0
    } else {
        MAD_TO_SIGMA * *shallow.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    fit_law(&mut steep).map(|ranges| CrossViewNoise { ranges, height_m })
}

/// Fits `a + b r`, neither negative, to robust deviations in bins of equal size.
fn fit_law(samples: &mut [(f64, f64)]) -> Option<NoiseLaw> {
    if samples.len() < 20 {
        return None;
    }
    samples.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let bins = (samples.len() / SAMPLES_PER_BIN).clamp(1, MAX_BINS);
    let size = samples.len().div_ceil(bins);
    let medians: Vec<(f64, f64)> = samples
        .chunks(size)
        .map(|bin| {
            let mut heights: Vec<f64> = bin.iter().map(|s| s.1).collect();
            heights.sort_unstable_by(f64::total_cmp);
            (
                bin[bin.len() / 2].0,
                MAD_TO_SIGMA * heights[heights.len() / 2],
            )
        })
        .collect();
    let n = medians.len() as f64;
    let (mr, ms) = medians
        .iter()
        .fold((0.0, 0.0), |(r, s), m| (r + m.0 / n, s + m.1 / n));
    let (rr, rs) = medians.iter().fold((0.0, 0.0), |(rr, rs), m| {
        let r = m.0 - mr;
        (rr + r * r, rs + r * (m.1 - ms))
    });
    let mut per_m = if rr > 1e-9 { (rs / rr).max(0.0) } else { 0.0 };
    let mut at_zero_m = ms - per_m * mr;
    if at_zero_m < 0.0 {
        at_zero_m = 0.0;
        per_m = medians.iter().map(|m| m.0 * m.1).sum::<f64>()
            / medians.iter().map(|m| m.0 * m.0).sum::<f64>();
    }
    Some(NoiseLaw { at_zero_m, per_m })
}

#[cfg(test)]
mod tests {
    use super::estimate;
    use crate::geometry::Surfaces;
    use nalgebra::{Point3, Vector3};
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn the_noise_law_of_two_noisy_walls_is_estimated() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let unit = Normal::new(0.0, 1.0).expect("a normal distribution");
        let mut points = Vec::new();
        for wall in [1.5, 6.0] {
            for i in 0..14_400 {
                let (az, el) = (
                    (f64::from(i % 120) * 0.5 - 30.0).to_radians(),
                    (f64::from(i / 120) * 0.5 - 30.0).to_radians(),
                );
                let d = Vector3::new(1.0, az.tan(), el.tan()).normalize();
                let d = if wall > 2.0 { -d } else { d };
                let r = wall / d.x.abs();
                let r = r + unit.sample(&mut rng) * (0.005 + 0.002 * r);
                points.push(Point3::from(d * r));
            }
        }
        let surfaces = Surfaces::fit(&points, &Point3::origin(), 0.01, 0.0, 0.06);
        let law = estimate(&points, &Point3::origin(), &surfaces).expect("walls are flat");
        assert!((law.sigma_m(1.6) - 0.0082).abs() < 0.0016, "{law:?}");
        assert!((law.sigma_m(6.5) - 0.018).abs() < 0.003, "{law:?}");
    }
}
