//! How noisy are ranges, told by neighbouring rays alone: before any surface is known, it says how wide one must look
//! to see one.

use super::directions::Directions;
use nalgebra::{Matrix3, Vector3};

/// Rays whose neighbours are asked; more change nothing.
const SAMPLES: usize = 1500;
/// Fewest neighbours that fix a plane and leave something to compare.
const FEWEST: usize = 8;
/// Most neighbours asked for one ray.
const MOST: usize = 40;
/// The share of sampled rays that are taken to have nothing but one plane around them, even in clutter, and what their
/// largest deviation is in standard deviations: a quarter of a normal distribution lies within 0.3186 of its middle.
const CALM: (f64, f64) = (0.25, 0.3186);

/// Standard deviation of ranges as a share of the range. On a plane the inverse range is linear in the direction: each
/// sampled ray is held against such a fit to its neighbours within `radius` (chord), and the calmest quarter of them
/// tells: corners and clutter deviate by their shape. 0 where no ray has neighbours.
pub fn relative(
    index: &Directions,
    directions: &[Vector3<f64>],
    ranges_m: &[f64],
    radius: f64,
) -> f64 {
    let step = (directions.len() / SAMPLES).max(1);
    let mut shares: Vec<f64> = (0..directions.len())
        .step_by(step)
        .filter(|i| ranges_m[*i].is_finite() && ranges_m[*i] > 1e-3)
        .filter_map(|i| deviation(index, directions, ranges_m, radius, i))
        .collect();
    if shares.is_empty() {
        return 0.0;
    }
    let at = (CALM.0 * shares.len() as f64) as usize;
    *shares.select_nth_unstable_by(at, f64::total_cmp).1 / CALM.1
}

/// Relative deviation of ray `i` from the plane through its neighbours, as if these had no noise of their own.
fn deviation(
    index: &Directions,
    directions: &[Vector3<f64>],
    ranges_m: &[f64],
    radius: f64,
    i: usize,
) -> Option<f64> {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let mut n = 0;
    index.for_each_within(&directions[i], radius, |j, _| {
        if j == i || n >= MOST || !ranges_m[j].is_finite() || ranges_m[j] < 1e-3 {
            return;
        }
        let d = directions[j];
        // Each equation told in shares of its own range.
        let r = ranges_m[j];
        matrix += d * d.transpose() * (r * r);
        right += d * r;
        n += 1;
    });
    if n < FEWEST {
        return None;
    }
    let inverse = matrix.try_inverse()?;
    let own = directions[i] * ranges_m[i];
    // The fit errs as well: by what the neighbours leave open in this direction.
    let leverage = own.dot(&(inverse * own)).max(0.0);
    Some((own.dot(&(inverse * right)) - 1.0).abs() / (1.0 + leverage).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{Directions, relative};
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn noise_on_slanted_walls_is_read_off() {
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
            let index = Directions::new(&directions, 0.009);
            let found = relative(&index, &directions, &ranges, 0.02);
            assert!((found / truth - 1.0).abs() < 0.15, "{found} of {truth}");
        }
    }

    #[test]
    fn lone_rays_say_nothing() {
        let index = Directions::new(&[Vector3::x(), Vector3::y()], 0.1);
        let found = relative(&index, &[Vector3::x(), Vector3::y()], &[1.0, 2.0], 0.1);
        assert_eq!(found, 0.0);
    }
}
