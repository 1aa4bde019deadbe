//! How far one Gaussian is from another.

use super::bures::Bures;
use super::constants::FM_FLOOR_M2;
use crate::mixture::symmetric::{Eigen, OneSided};
use crate::mixture::{Gaussian, Mixture};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The ground distance d_ij of Eq. 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Ground {
    /// Gaussian Wasserstein-2, metres; a metric.
    #[default]
    W2,
    /// Between the means, metres.
    Euclid,
    /// Foerstner-Moonen of the covariances (Eq. 10) plus the means' distance over 1 m; no unit.
    Fm,
}

/// Wasserstein-2 distance between two Gaussians, not squared, metres:
/// `|m_a - m_b|^2 + tr(S_a + S_b - 2 (S_a^1/2 S_b S_a^1/2)^1/2)`, the root of it. A metric, defined
/// for singular covariances, and free of the cancellation in that difference.
pub fn w2(a: &Gaussian, b: &Gaussian) -> f64 {
    Bures::new(a).distance(&Bures::new(b))
}

/// Distance between the means, metres.
pub fn euclid(a: &Gaussian, b: &Gaussian) -> f64 {
    (a.mean - b.mean).norm()
}

/// Foerstner-Moonen distance of the covariances (Eq. 10), their eigenvalues raised to [`FM_FLOOR_M2`],
/// plus the distance of the means over 1 m. Dimensionless.
pub fn fm(a: &Gaussian, b: &Gaussian) -> f64 {
    fm_of_factors(a, b, &whitener(a), &floored_root(b))
}

fn floored_root(g: &Gaussian) -> Matrix3<f64> {
    Eigen::of(&g.covariance).map(|l| l.max(FM_FLOOR_M2).sqrt())
}

fn whitener(g: &Gaussian) -> Matrix3<f64> {
    Eigen::of(&g.covariance).map(|l| 1.0 / l.max(FM_FLOOR_M2).sqrt())
}

fn fm_of_factors(
    a: &Gaussian,
    b: &Gaussian,
    whitener_a: &Matrix3<f64>,
    root_b: &Matrix3<f64>,
) -> f64 {
    if a == b {
        return 0.0;
    }
    // Singular values of A^-1/2 B^1/2 are square roots of the generalised eigenvalues.
    let logs = OneSided::of(&(whitener_a * root_b))
        .values()
        .map(|s| 2.0 * s.ln());
    logs.norm() + euclid(a, b)
}

/// Costs between every component of one mixture (rows) and every one of another (columns).
#[derive(Debug, Clone, PartialEq)]
pub struct CostMatrix {
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

impl CostMatrix {
    /// From row-major values; `None` if they are not `rows * columns` many.
    pub fn from_rows(rows: usize, columns: usize, values: Vec<f64>) -> Option<Self> {
        (rows.checked_mul(columns) == Some(values.len())).then_some(Self {
            rows,
            columns,
            values,
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Row-major values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// One cost; `None` outside the matrix.
    pub fn get(&self, row: usize, column: usize) -> Option<f64> {
        let inside = row < self.rows && column < self.columns;
        inside.then(|| self.values[row * self.columns + column])
    }
}

/// All ground distances between the components of `a` and `b`; factors of the covariances are made
/// once per component. Works in the rayon pool that the caller stands in.
pub fn cost_matrix(a: &Mixture, b: &Mixture, ground: Ground) -> CostMatrix {
    let values = match ground {
        Ground::W2 => table(a, b, Bures::new, Bures::new, Bures::distance),
        Ground::Euclid => table(a, b, |g| *g, |g| *g, euclid),
        Ground::Fm => table(
            a,
            b,
            |g| (*g, whitener(g)),
            |g| (*g, floored_root(g)),
            |(g, w), (h, r)| fm_of_factors(g, h, w, r),
        ),
    };
    CostMatrix {
        rows: a.len(),
        columns: b.len(),
        values,
    }
}

/// Row-major costs from what each side's components are made into once.
fn table<L: Sync, R: Sync>(
    a: &Mixture,
    b: &Mixture,
    left: impl Fn(&Gaussian) -> L,
    right: impl Fn(&Gaussian) -> R,
    cost: impl Fn(&L, &R) -> f64 + Sync,
) -> Vec<f64> {
    let left: Vec<L> = a.components.iter().map(left).collect();
    let right: Vec<R> = b.components.iter().map(right).collect();
    let mut values = vec![0.0; left.len() * right.len()];
    values
        .par_chunks_mut(right.len().max(1))
        .zip(&left)
        .for_each(|(row, l)| {
            row.iter_mut()
                .zip(&right)
                .for_each(|(v, r)| *v = cost(l, r))
        });
    values
}

#[cfg(test)]
mod tests {
    use super::{Ground, cost_matrix, euclid, fm, w2};
    use crate::distance::constants::FM_FLOOR_M2;
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use proptest::prelude::*;

    /// Gaussians of every rank from spot to full, as thin as a millimetre.
    fn gaussian() -> impl Strategy<Value = Gaussian> {
        let sigma = prop_oneof![Just(0.0), Just(1e-3), 0.01..2.0f64];
        (
            proptest::array::uniform3(-3.0..3.0f64),
            proptest::array::uniform3(-3.0..3.0f64),
            proptest::array::uniform3(sigma),
        )
            .prop_map(|(mean, turn, sigmas)| {
                let r = Rotation3::from_scaled_axis(Vector3::from(turn)).into_inner();
                let d = Matrix3::from_diagonal(&Vector3::from(sigmas.map(|s| s * s)));
                Gaussian {
                    mean: Point3::from(mean),
                    covariance: r * d * r.transpose(),
                }
            })
    }

    proptest! {
        #[test]
        fn w2_is_a_metric(a in gaussian(), b in gaussian(), c in gaussian()) {
            prop_assert_eq!(w2(&a, &a), 0.0);
            prop_assert!((w2(&a, &b) - w2(&b, &a)).abs() < 1e-9);
            prop_assert!(w2(&a, &c) <= w2(&a, &b) + w2(&b, &c) + 1e-9);
            prop_assert!(w2(&a, &b) >= euclid(&a, &b));
        }

        #[test]
        fn w2_of_common_axes_is_the_distance_of_the_sigmas(a in gaussian(), s in proptest::array::uniform3(0.0..2.0f64)) {
            let e = crate::mixture::symmetric::Eigen::of(&a.covariance);
            let d = Matrix3::from_diagonal(&Vector3::from(s.map(|s| s * s)));
            let b = Gaussian { covariance: e.vectors * d * e.vectors.transpose(), ..a };
            let expected = (e.values.map(|l| l.max(0.0).sqrt()) - Vector3::from(s)).norm();
            prop_assert!((w2(&a, &b) - expected).abs() < 1e-7);
        }

        #[test]
        fn fm_is_symmetric_and_does_not_see_scale_of_both(a in gaussian(), b in gaussian()) {
            prop_assert!(fm(&a, &b).is_finite());
            prop_assert!((fm(&a, &b) - fm(&b, &a)).abs() < 1e-6);
        }
    }

    #[test]
    fn worked_examples() {
        let ball = |x: f64, sigma: f64| Gaussian {
            mean: Point3::new(x, 0.0, 0.0),
            covariance: Matrix3::identity() * sigma * sigma,
        };
        // 3 m apart, sigmas 1 and 3 in three axes: sqrt(9 + 3 * 4).
        assert!((w2(&ball(0.0, 1.0), &ball(3.0, 3.0)) - 21f64.sqrt()).abs() < 1e-14);
        // A spot is as far from a ball as the ball is wide.
        assert!((w2(&ball(0.0, 0.0), &ball(0.0, 2.0)) - 12f64.sqrt()).abs() < 1e-14);
        // ln of variances 9 in three axes, plus 3 m.
        assert!(
            (fm(&ball(0.0, 1.0), &ball(3.0, 3.0)) - (3f64.sqrt() * 9f64.ln() + 3.0)).abs() < 1e-13
        );
        let floor = ball(0.0, FM_FLOOR_M2.sqrt());
        assert!(fm(&ball(0.0, 0.0), &floor).abs() < 1e-12);
        let m = Mixture {
            weights: vec![0.5; 2],
            components: vec![ball(0.0, 1.0), ball(3.0, 3.0)],
        };
        let costs = cost_matrix(&m, &m, Ground::W2);
        assert_eq!(costs.get(0, 0), Some(0.0));
        assert!((costs.get(1, 0).expect("inside") - 21f64.sqrt()).abs() < 1e-14);
        assert_eq!(
            (costs.get(0, 2), costs.rows(), costs.columns()),
            (None, 2, 2)
        );
    }
}
