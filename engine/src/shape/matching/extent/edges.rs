//! Maximum likelihood of edges: points spread evenly between two edges and blurred by noise have the density
//! (Phi((u - low) / s) - Phi((u - high) / s)) / (high - low) along an axis (docs/shapes.md section 7).

use crate::shape::constants::{EDGE_CUTOFF_SIGMAS, LIKELIHOOD_TOLERANCE, MAX_LIKELIHOOD_STEPS};
use nalgebra::{SMatrix, SVector, Vector3};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Probability that a point is between two blurred edges, and its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlurredInterval {
    /// Phi((u - low) / s) - Phi((u - high) / s).
    pub probability: f64,
    /// Derivative with respect to the lower edge, per metre.
    pub by_low: f64,
    /// Derivative with respect to the upper edge, per metre.
    pub by_high: f64,
}

impl BlurredInterval {
    /// For a point at `u`, edges at `low` < `high` and a blur of `sigma` (metres).
    pub(super) fn new(u: f64, low: f64, high: f64, sigma: f64) -> Self {
        let (from_low, low_density) = normal_cdf_and_density((u - low) / sigma);
        let (from_high, high_density) = normal_cdf_and_density((u - high) / sigma);
        Self {
            probability: from_low - from_high,
            by_low: -low_density / sigma,
            by_high: high_density / sigma,
        }
    }

    /// Derivative with respect to the point's position, per metre.
    pub(super) fn by_position(&self) -> f64 {
        -(self.by_low + self.by_high)
    }
}

/// The normal distribution function at `z`, and its density.
fn normal_cdf_and_density(z: f64) -> (f64, f64) {
    if z > EDGE_CUTOFF_SIGMAS {
        (1.0, 0.0)
    } else if z < -EDGE_CUTOFF_SIGMAS {
        (0.0, 0.0)
    } else {
        let density = (-0.5 * z * z).exp() / (2.0 * PI).sqrt();
        (0.5 * libm::erfc(-z * FRAC_1_SQRT_2), density)
    }
}

/// Typical gap between neighbours along an axis, metres: half of the covered length is in gaps no larger. Rows of a scan
/// give their spacing, however many points a row has; points at random give about 1.7 times their mean spacing. Sorts
/// `positions`.
pub(super) fn point_spacing_m(positions: &mut [f64]) -> f64 {
    positions.sort_by(f64::total_cmp);
    let mut gaps: Vec<f64> = positions.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let half = gaps.iter().sum::<f64>() / 2.0;
    let mut covered = 0.0;
    gaps.into_iter()
        .find(|gap| {
            covered += gap;
            covered >= half
        })
        .unwrap_or(0.0)
}

/// Gap between the rows at the upper end of the first axis, metres: from the outermost points, the median of the steps
/// inwards to the next point that is more along the axis than across it. Neighbours in a row that runs across do not
/// count, nor do rows elsewhere, whose positions mix in [`point_spacing_m`].
pub(super) fn gap_at_end_m(positions: &[Vector3<f64>], outermost: usize) -> f64 {
    let mut order: Vec<&Vector3<f64>> = positions.iter().collect();
    order.sort_by(|a, b| b.x.total_cmp(&a.x));
    let step_inwards = |from: &&Vector3<f64>| {
        let steps = positions.iter().map(|to| *from - to);
        let inwards = steps.filter(|d| d.x > 0.0 && d.x > d.yz().norm());
        inwards.map(|d| d.x).min_by(f64::total_cmp)
    };
    let mut gaps: Vec<f64> = order
        .iter()
        .take(outermost)
        .filter_map(step_inwards)
        .collect();
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
}

/// Log-likelihood of all points, its gradient, and its information: the sum of the outer products of the points' gradients.
#[derive(Debug, Clone)]
pub(super) struct Likelihood<const N: usize> {
    pub log: f64,
    pub gradient: SVector<f64, N>,
    pub information: SMatrix<f64, N, N>,
}

impl<const N: usize> Likelihood<N> {
    pub(super) fn zero() -> Self {
        Self {
            log: 0.0,
            gradient: SVector::zeros(),
            information: SMatrix::zeros(),
        }
    }

    /// Adds one point.
    pub(super) fn add(&mut self, log: f64, gradient: &SVector<f64, N>) {
        self.log += log;
        self.gradient += gradient;
        self.information.ger(1.0, gradient, gradient, 1.0);
    }
}

/// The nearest maximum of a likelihood from `start`, by damped scoring. `None` where it is not defined at `start`.
pub(super) fn maximize<const N: usize>(
    start: SVector<f64, N>,
    likelihood: impl Fn(&SVector<f64, N>) -> Option<Likelihood<N>>,
) -> Option<(SVector<f64, N>, Likelihood<N>)> {
    let mut current = start;
    let mut at_current = likelihood(&current).filter(|l| l.log.is_finite())?;
    let mut damping = 1e-3;
    for _ in 0..MAX_LIKELIHOOD_STEPS {
        let mut normal = at_current.information;
        for k in 0..N {
            normal[(k, k)] += damping * normal[(k, k)] + f64::MIN_POSITIVE;
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&at_current.gradient)) else {
            damping = (damping * 10.0).max(1e-6);
            continue;
        };
        let next = current + step;
        match likelihood(&next).filter(|l| l.log > at_current.log) {
            Some(better) => {
                let gained = better.log - at_current.log;
                (current, at_current) = (next, better);
                damping /= 10.0;
                if gained < LIKELIHOOD_TOLERANCE {
                    break;
                }
            }
            None if step.dot(&at_current.gradient) < LIKELIHOOD_TOLERANCE => break,
            None => damping = (damping * 10.0).max(1e-6),
        }
    }
    Some((current, at_current))
}

#[cfg(test)]
mod tests {
    use super::{BlurredInterval, Likelihood, gap_at_end_m, maximize, point_spacing_m};
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn a_blurred_interval_has_its_known_values_and_slopes() {
        let b = BlurredInterval::new(0.5, 0.0, 1.0, 0.5);
        // scipy.stats.norm.cdf(1) - cdf(-1)
        assert!((b.probability - 0.682_689_492_137_086).abs() < 1e-12);
        let h = 1e-6;
        for (u, low, high) in [(0.1, 0.0, 1.0), (1.3, 0.2, 1.0), (-0.4, 0.0, 0.7)] {
            let b = BlurredInterval::new(u, low, high, 0.3);
            let by_low =
                (BlurredInterval::new(u, low + h, high, 0.3).probability - b.probability) / h;
            let by_high =
                (BlurredInterval::new(u, low, high + h, 0.3).probability - b.probability) / h;
            let by_position =
                (BlurredInterval::new(u + h, low, high, 0.3).probability - b.probability) / h;
            assert!((b.by_low - by_low).abs() < 1e-5);
            assert!((b.by_high - by_high).abs() < 1e-5);
            assert!((b.by_position() - by_position).abs() < 1e-5);
        }
    }

    #[test]
    fn rows_give_their_spacing_despite_an_outlier() {
        let mut rows: Vec<f64> = (0..100).map(|i| f64::from(i / 10) * 0.2).collect();
        rows.push(2.5);
        assert!((point_spacing_m(&mut rows) - 0.2).abs() < 1e-12);
        assert!(point_spacing_m(&mut []).abs() < 1e-12);
    }

    #[test]
    fn slanted_rows_show_their_spacing_at_the_end_though_their_positions_mix() {
        // Rows 0.1 m apart that rise by a row's spacing over the width; further down they are closer.
        let rows = [1.0, 0.9, 0.8, 0.7, 0.68, 0.66, 0.64];
        let positions: Vec<Vector3<f64>> = rows
            .iter()
            .flat_map(|x| (0..20).map(move |k| (x, f64::from(k) * 0.02)))
            .map(|(x, y)| Vector3::new(x + 0.2 * y, y, 0.0))
            .collect();
        let gap_m = gap_at_end_m(&positions, 10);
        assert!((gap_m - 0.1).abs() < 0.02, "{gap_m}");
        let mut along: Vec<f64> = positions.iter().map(|p| p.x).collect();
        assert!(point_spacing_m(&mut along) < 0.02);
        assert!(gap_at_end_m(&[], 10).abs() < 1e-12);
    }

    #[test]
    fn the_edges_of_a_blurred_interval_are_found() {
        // The quantiles of a uniform law on [-0.3, 0.9], blurred by the nodes of a normal law.
        let sigma = 0.03;
        let blur = [-1.5, -0.5, 0.5, 1.5].map(|z| z * sigma / 1.25_f64.sqrt());
        let mut positions = Vec::new();
        for k in 0..100 {
            let u = -0.3 + 1.2 * (f64::from(k) + 0.5) / 100.0;
            positions.extend(blur.map(|b| u + b));
        }
        let (edges, at) = maximize(Vector2::new(-0.5, 1.2), |x: &Vector2<f64>| {
            let mut l = Likelihood::zero();
            for &u in &positions {
                let b = BlurredInterval::new(u, x[0], x[1], sigma);
                let length = x[1] - x[0];
                let probability = b.probability.max(1e-12);
                let gradient = Vector2::new(
                    b.by_low / probability + 1.0 / length,
                    b.by_high / probability - 1.0 / length,
                );
                l.add((probability / length).ln(), &gradient);
            }
            Some(l)
        })
        .expect("defined");
        assert!((edges - Vector2::new(-0.3, 0.9)).norm() < 0.01, "{edges}");
        assert!(at.gradient.norm() < 1e-2 * at.information.trace().sqrt());
    }
}
