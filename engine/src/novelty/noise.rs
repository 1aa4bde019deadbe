//! How noisy is a view? Read off its flat places where the sensor does not say.

use crate::geometry::{NoiseLaw, Registration, Surfaces};
use nalgebra::Point3;

/// Points per bin of range; fewer make one bin.
const PER_BIN: usize = 200;
/// Most bins of range.
const BINS: usize = 10;
/// Cosine of incidence below which heights say little about ranges.
const STEEP: f64 = 0.5;
/// Places that the agreement of two views is read from; more change nothing.
const MOST_SAMPLES: usize = 20_000;
/// Turns a median absolute deviation into a standard deviation of a normal distribution.
const MAD_TO_SIGMA: f64 = 1.4826;

/// The noise law of ranges, from heights of `points` over the flat places they lie on. `None` where
/// nothing flat is seen.
pub fn estimate(
    points: &[Point3<f64>],
    origin: &Point3<f64>,
    surfaces: &Surfaces,
) -> Option<NoiseLaw> {
    let mut samples: Vec<(f64, f64)> = points
        .iter()
        .zip(&surfaces.patch_of_point)
        .filter_map(|(p, patch)| {
            let patch = surfaces.patches.get(*patch as usize)?;
            let view = p - origin;
            let range_m = view.norm();
            let steep = patch.normal.dot(&view).abs() / range_m.max(1e-9);
            let n = patch.neighbours as f64;
            // The plane was fitted to the same points: three of them went into it.
            (patch.flat && steep > STEEP).then(|| {
                (
                    range_m,
                    patch.height_m(p).abs() / steep * (n / (n - 3.0)).sqrt(),
                )
            })
        })
        .collect();
    law(&mut samples)
}

/// How well two views agree where they look at the same surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// Ranges, from surfaces met steeply.
    pub ranges: NoiseLaw,
    /// Standard deviation of heights over surfaces met at a shallow angle, metres: range noise has
    /// little part in it, bent scans have.
    pub height_m: f64,
}

/// The noise of the difference between two views, from heights of current places over the
/// reference's flat places after registration. Places further off than `gate_m` changed.
pub fn between(
    reference: &Surfaces,
    reference_origin: &Point3<f64>,
    current_points: &[Point3<f64>],
    registration: &Registration,
    gate_m: f64,
) -> Option<Between> {
    let back = registration.reference_from_current();
    let step = current_points.len().div_ceil(MOST_SAMPLES).max(1);
    let mut steep = Vec::new();
    let mut shallow = Vec::new();
    for p in current_points.iter().step_by(step) {
        let p = back.carry(p);
        let Some(patch) = reference
            .grid
            .nearest(&p, 1.5 * reference.cell_m)
            .and_then(|(i, _)| reference.patches.get(i))
        else {
            continue;
        };
        let view = p - reference_origin;
        let range_m = view.norm().max(1e-9);
        let incidence = patch.normal.dot(&view).abs() / range_m;
        let height = patch.height_m(&p).abs();
        if !patch.flat || height >= gate_m {
            continue;
        }
        if incidence > STEEP {
            steep.push((range_m, height / incidence));
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
    law(&mut steep).map(|ranges| Between { ranges, height_m })
}

/// Fits `a + b r`, neither negative, to robust deviations in bins of equal population.
fn law(samples: &mut [(f64, f64)]) -> Option<NoiseLaw> {
    if samples.len() < 20 {
        return None;
    }
    samples.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let bins = (samples.len() / PER_BIN).clamp(1, BINS);
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
    fn the_law_behind_two_noisy_walls_is_read_off() {
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
        let surfaces = Surfaces::of(&points, &Point3::origin(), 0.01, 0.0, 0.06);
        let law = estimate(&points, &Point3::origin(), &surfaces).expect("walls are flat");
        assert!((law.sigma_m(1.6) - 0.0082).abs() < 0.0016, "{law:?}");
        assert!((law.sigma_m(6.5) - 0.018).abs() < 0.003, "{law:?}");
    }
}
