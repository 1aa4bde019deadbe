//! How far a component is the only one that describes its surface: its posterior (paper Eq. 8), averaged over its plate.

use super::Gaussian;
use super::constants::{FUSION_SURFACE_SIGMA_M, OWN_SHARE_POINTS_PER_SIDE, OWN_SHARE_REACH_SIGMAS};
use super::gaussian::GaussianDensity;
use super::linalg::Eigen;
use nalgebra::{Point3, Vector3};

/// ln of each component's mean posterior over its plate, in 0..=1 as a share: 0 (ln 1) where no other component is near,
/// ln 1/2 where another with as many beams lies on it.
///
/// `masses` (above zero) are the beams. Covariances are widened by [`FUSION_SURFACE_SIGMA_M`], since two visits see one
/// surface that far apart. The plate is the uniform one of the component's two largest variances.
pub(super) fn log_own_shares(components: &[Gaussian], masses: &[f64]) -> Vec<f64> {
    let all: Vec<WidenedComponent> = components
        .iter()
        .zip(masses)
        .map(|(gaussian, mass)| WidenedComponent::new(gaussian, *mass))
        .collect();
    all.iter().map(|own| own.log_own_share(&all)).collect()
}

struct WidenedComponent {
    /// `None` only where the entries of the covariance overflow.
    density: Option<GaussianDensity>,
    log_mass: f64,
    mean: Point3<f64>,
    /// Half the sides of the plate along its axes, metres.
    half_sides: [Vector3<f64>; 2],
    /// From the mean to a corner of the plate, metres.
    corner_m: f64,
    /// Greatest standard deviation after widening, metres.
    widest_m: f64,
}

impl WidenedComponent {
    fn new(gaussian: &Gaussian, mass: f64) -> Self {
        let eigen = Eigen::new(&gaussian.covariance);
        let widened = Gaussian {
            mean: gaussian.mean,
            covariance: eigen.map(|l| l.max(0.0) + FUSION_SURFACE_SIGMA_M.powi(2)),
        };
        let half = |axis: usize| {
            let sigma = eigen.values[axis].max(0.0).sqrt();
            eigen.vectors.column(axis) * (3f64.sqrt() * sigma)
        };
        let half_sides = [half(1), half(2)];
        Self {
            density: GaussianDensity::new(&widened),
            log_mass: mass.ln(),
            mean: gaussian.mean,
            half_sides,
            corner_m: (half_sides[0] + half_sides[1]).norm(),
            widest_m: (eigen.values[2].max(0.0) + FUSION_SURFACE_SIGMA_M.powi(2)).sqrt(),
        }
    }

    /// ln of mass times density.
    fn log_at(&self, x: &Point3<f64>) -> f64 {
        let density = self.density.as_ref();
        density.map_or(f64::NEG_INFINITY, |d| self.log_mass + d.log_at(x))
    }

    /// The points of a grid of midpoints over the plate.
    fn plate_points(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        let at = |i: usize| (2 * i + 1) as f64 / OWN_SHARE_POINTS_PER_SIDE as f64 - 1.0;
        (0..OWN_SHARE_POINTS_PER_SIDE * OWN_SHARE_POINTS_PER_SIDE).map(move |i| {
            let (row, column) = (i / OWN_SHARE_POINTS_PER_SIDE, i % OWN_SHARE_POINTS_PER_SIDE);
            self.mean + self.half_sides[0] * at(row) + self.half_sides[1] * at(column)
        })
    }

    fn log_own_share(&self, all: &[Self]) -> f64 {
        if self.density.is_none() {
            return 0.0;
        }
        let is_near = |other: &&Self| {
            let apart = (other.mean - self.mean).norm();
            apart <= self.corner_m + OWN_SHARE_REACH_SIGMAS * other.widest_m
        };
        let near: Vec<&Self> = all.iter().filter(is_near).collect();
        let mut logs = Vec::with_capacity(near.len());
        let posteriors: Vec<f64> = self
            .plate_points()
            .map(|x| {
                logs.clear();
                logs.extend(near.iter().map(|other| other.log_at(&x)));
                self.log_at(&x) - log_sum_exp(&logs)
            })
            .collect();
        log_sum_exp(&posteriors) - (posteriors.len() as f64).ln()
    }
}

fn log_sum_exp(logs: &[f64]) -> f64 {
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    best + logs.iter().map(|l| (l - best).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::log_own_shares;
    use crate::mixture::Gaussian;
    use nalgebra::{Matrix3, Point3, Vector3};

    fn plate(mean: [f64; 3], side_m: f64) -> Gaussian {
        let variance = side_m * side_m / 12.0;
        Gaussian {
            mean: Point3::from(mean),
            covariance: Matrix3::from_diagonal(&Vector3::new(variance, variance, 1e-4)),
        }
    }

    fn shares(components: &[Gaussian], masses: &[f64]) -> Vec<f64> {
        let logs = log_own_shares(components, masses);
        logs.into_iter().map(f64::exp).collect()
    }

    #[test]
    fn alone_it_is_one_and_on_a_copy_the_share_of_the_beams() {
        let near = |got: f64, expected: f64| assert!((got - expected).abs() < 1e-9, "{got}");
        let wall = plate([0.0; 3], 1.0);
        near(shares(&[wall], &[5.0])[0], 1.0);
        let copies = shares(&[wall, wall], &[30.0, 10.0]);
        near(copies[0], 0.75);
        near(copies[1], 0.25);
        // Ten metres on, and behind: a plate apart by 30 times the joint thickness takes nothing.
        let apart = shares(
            &[
                wall,
                plate([10.0, 0.0, 0.0], 1.0),
                plate([0.0, 0.0, 0.45], 1.0),
            ],
            &[1.0; 3],
        );
        apart.iter().for_each(|share| near(*share, 1.0));
    }

    #[test]
    fn a_surface_seen_some_millimetres_off_is_the_same() {
        let offset = |d: f64| {
            shares(
                &[plate([0.0; 3], 1.0), plate([0.0, 0.0, d], 1.0)],
                &[1.0; 2],
            )[0]
        };
        // Thickness 1 cm, widened by 1 cm: the other's density is e^(-d^2 / 4e-4) of its peak.
        for d in [0.0, 0.004, 0.02, 0.06] {
            let expected = 1.0 / (1.0 + (-d * d / 4e-4f64).exp());
            assert!((offset(d) - expected).abs() < 1e-9, "{d}");
        }
        assert!(offset(0.004) < 0.51 && offset(0.06) > 0.999);
    }

    #[test]
    fn a_component_buried_in_another_keeps_a_finite_logarithm() {
        let logs = log_own_shares(
            &[plate([0.0; 3], 1.0), plate([0.0; 3], 1.0)],
            &[1e-300, 1e300],
        );
        assert!((logs[0] + 600.0 * std::f64::consts::LN_10).abs() < 1e-6 && logs[1].abs() < 1e-9);
    }
}
