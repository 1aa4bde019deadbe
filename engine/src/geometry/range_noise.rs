//! Relative noise of ranges, estimated from neighbouring rays alone. It is needed before any surface is known: it decides
//! how wide a neighbourhood must be to show one.

use super::constants::{
    CALM_QUANTILE_SIGMAS, CALM_SHARE, MAX_NOISE_NEIGHBOURS, MIN_NOISE_NEIGHBOURS, MIN_RANGE_M,
    NOISE_SAMPLES,
};
use super::direction_index::DirectionIndex;
use nalgebra::{Matrix3, Vector3};

/// Standard deviation of ranges as a share of the range. On a plane the inverse range is linear in the direction: each
/// sampled ray is compared with such a fit to its neighbours within `radius` (chord). The quarter with the smallest
/// deviations counts, since corners and clutter deviate by their shape. 0 where no ray has neighbours.
pub(super) fn relative_noise(
    index: &DirectionIndex,
    directions: &[Vector3<f64>],
    ranges_m: &[f64],
    radius: f64,
) -> f64 {
    let step = (directions.len() / NOISE_SAMPLES).max(1);
    let mut deviations: Vec<f64> = (0..directions.len())
        .step_by(step)
        .filter(|i| ranges_m[*i].is_finite() && ranges_m[*i] > MIN_RANGE_M)
        .filter_map(|i| deviation(index, directions, ranges_m, radius, i))
        .collect();
    if deviations.is_empty() {
        return 0.0;
    }
    let at = (CALM_SHARE * deviations.len() as f64) as usize;
    *deviations.select_nth_unstable_by(at, f64::total_cmp).1 / CALM_QUANTILE_SIGMAS
}

/// Relative deviation of ray `i` from the plane through its neighbours, as if these had no noise of their own.
fn deviation(
    index: &DirectionIndex,
    directions: &[Vector3<f64>],
    ranges_m: &[f64],
    radius: f64,
    i: usize,
) -> Option<f64> {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let mut n = 0;
    index.for_each_within(&directions[i], radius, |j, _| {
        if j == i
            || n >= MAX_NOISE_NEIGHBOURS
            || !ranges_m[j].is_finite()
            || ranges_m[j] < MIN_RANGE_M
        {
            return;
        }
        let d = directions[j];
        // Each equation is divided by its own inverse range: residuals are shares of the range.
        let r = ranges_m[j];
        matrix += d * d.transpose() * (r * r);
        right += d * r;
        n += 1;
    });
    if n < MIN_NOISE_NEIGHBOURS {
        return None;
    }
    let inverse = matrix.try_inverse()?;
    let own = directions[i] * ranges_m[i];
    // The fit itself errs by the leverage of this direction.
    let leverage = own.dot(&(inverse * own)).max(0.0);
    Some((own.dot(&(inverse * right)) - 1.0).abs() / (1.0 + leverage).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{DirectionIndex, relative_noise};
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn noise_on_slanted_walls_is_estimated() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        for truth in [0.002, 0.01, 0.03] {
            let (mut directions, mut ranges) = (Vec::new(), Vec::new());
            for i in 0..14_400 {
                let (az, el) = (
                    (f64::from(i % 120) * 0.5 - 30.0).to_radians(),
                    (f64::from(i / 120) * 0.5 - 50.0).to_radians(),
                );
                let d = Vector3::new(el.cos() * az.cos(), el.cos() * az.sin(), el.sin());
                let floor = if d.z < 0.0 { 1.2 / -d.z } else { f64::INFINITY };
                let gauss: f64 = StandardNormal.sample(&mut rng);
                ranges.push((4.0 / d.x).min(floor) * (1.0 + truth * gauss));
                directions.push(d);
            }
            let index = DirectionIndex::new(&directions, 0.009);
            let found = relative_noise(&index, &directions, &ranges, 0.02);
            assert!((found / truth - 1.0).abs() < 0.15, "{found} of {truth}");
        }
    }

    #[test]
    fn rays_without_neighbours_give_zero() {
        let index = DirectionIndex::new(&[Vector3::x(), Vector3::y()], 0.1);
        let found = relative_noise(&index, &[Vector3::x(), Vector3::y()], &[1.0, 2.0], 0.1);
        assert_eq!(found, 0.0);
    }
}
