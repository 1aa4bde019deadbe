//! Ground distances: how far one Gaussian is from another.

use super::bures::BuresGaussian;
use super::constants::FM_FLOOR_M2;
use crate::mixture::linalg::{Eigen, OneSidedSvd};
use crate::mixture::{Gaussian, Mixture};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The ground distance d_ij of paper Eq. 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum GroundDistance {
    /// Wasserstein-2, metres: `sqrt(|m_a - m_b|^2 + tr(S_a + S_b - 2 (S_a^1/2 S_b S_a^1/2)^1/2))`. A metric, accurate for
    /// singular covariances and equal Gaussians too.
    #[default]
    W2,
    /// Distance of the means, metres.
    Euclid,
    /// Foerstner-Moonen distance of the covariances (paper Eq. 10), their eigenvalues raised to (1 mm)^2, plus the distance of
    /// the means over 1 m; no unit.
    Fm,
}

fn euclid(a: &Gaussian, b: &Gaussian) -> f64 {
    (a.mean - b.mean).norm()
}

fn floored_root(g: &Gaussian) -> Matrix3<f64> {
    Eigen::new(&g.covariance).map(|l| l.max(FM_FLOOR_M2).sqrt())
}

fn whitener(g: &Gaussian) -> Matrix3<f64> {
    Eigen::new(&g.covariance).map(|l| 1.0 / l.max(FM_FLOOR_M2).sqrt())
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
    let logs = OneSidedSvd::new(&(whitener_a * root_b))
        .values()
        .map(|s| 2.0 * s.ln());
    logs.norm() + euclid(a, b)
}

/// Costs between the components of one mixture (rows) and those of another (columns).
#[derive(Debug, Clone, PartialEq)]
pub struct CostMatrix {
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

impl CostMatrix {
    /// From row-major values; `None` unless there are `rows * columns` of them.
    pub fn from_rows(rows: usize, columns: usize, values: Vec<f64>) -> Option<Self> {
        (rows.checked_mul(columns) == Some(values.len())).then_some(Self {
            rows,
            columns,
            values,
        })
    }

    /// From row-major values, of which there must be `rows * columns`.
    pub(crate) fn new(rows: usize, columns: usize, values: Vec<f64>) -> Self {
        debug_assert_eq!(rows * columns, values.len());
        Self {
            rows,
            columns,
            values,
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All costs, row-major.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// One cost; `None` outside the matrix.
    pub fn get(&self, row: usize, column: usize) -> Option<f64> {
        let inside = row < self.rows && column < self.columns;
        inside.then(|| self.values[row * self.columns + column])
    }
}

/// Ground distances between all components of `a` and `b`. Runs in the caller's rayon pool.
pub fn cost_matrix(a: &Mixture, b: &Mixture, ground: GroundDistance) -> CostMatrix {
    let values = match ground {
        GroundDistance::W2 => table(
            a,
            b,
            BuresGaussian::new,
            BuresGaussian::new,
            BuresGaussian::distance,
        ),
        GroundDistance::Euclid => table(a, b, |g| *g, |g| *g, euclid),
        GroundDistance::Fm => table(
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

/// Row-major costs; `left` and `right` factor each component once.
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
    use super::{GroundDistance, cost_matrix, euclid, floored_root, fm_of_factors, whitener};
    use crate::distance::bures::BuresGaussian;
    use crate::distance::constants::FM_FLOOR_M2;
    use crate::mixture::{Gaussian, Mixture};
    use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
    use proptest::prelude::*;

    fn w2(a: &Gaussian, b: &Gaussian) -> f64 {
        BuresGaussian::new(a).distance(&BuresGaussian::new(b))
    }

    fn fm(a: &Gaussian, b: &Gaussian) -> f64 {
        fm_of_factors(a, b, &whitener(a), &floored_root(b))
    }

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
            let e = crate::mixture::linalg::Eigen::new(&a.covariance);
            let d = Matrix3::from_diagonal(&Vector3::from(s.map(|s| s * s)));
            let b = Gaussian { covariance: e.vectors * d * e.vectors.transpose(), ..a };
            let expected = (e.values.map(|l| l.max(0.0).sqrt()) - Vector3::from(s)).norm();
            prop_assert!((w2(&a, &b) - expected).abs() < 1e-7);
        }

        #[test]
        fn fm_is_finite_and_symmetric(a in gaussian(), b in gaussian()) {
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
        let costs = cost_matrix(&m, &m, GroundDistance::W2);
        assert_eq!(costs.get(0, 0), Some(0.0));
        assert!((costs.get(1, 0).expect("inside") - 21f64.sqrt()).abs() < 1e-14);
        assert_eq!(
            (costs.get(0, 2), costs.rows(), costs.columns()),
            (None, 2, 2)
        );
    }
}
