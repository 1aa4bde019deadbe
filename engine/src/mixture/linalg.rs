//! Eigenvalues and singular values of 3 x 3 matrices, accurate for thin and singular ones.

use nalgebra::{Matrix3, Vector3};

/// Sweeps over the three off-diagonal pairs; Jacobi converges quadratically, and a 3 x 3 matrix needs at most six.
const MAX_SWEEPS: usize = 16;

/// Eigenvalues and eigenvectors of a symmetric matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Eigen {
    /// Ascending.
    pub values: Vector3<f64>,
    /// Column `i` belongs to `values[i]`; the columns are orthonormal, each with its largest entry positive.
    pub vectors: Matrix3<f64>,
}

impl Eigen {
    /// Cyclic Jacobi. The matrix is symmetrised first.
    pub(crate) fn new(symmetric: &Matrix3<f64>) -> Self {
        let mut a = (symmetric + symmetric.transpose()) * 0.5;
        let mut v = Matrix3::identity();
        for _ in 0..MAX_SWEEPS {
            let off = a[(0, 1)].abs() + a[(0, 2)].abs() + a[(1, 2)].abs();
            if off == 0.0 || off.is_nan() {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                let apq = a[(p, q)];
                // An entry below the rounding of both its diagonals changes neither.
                if apq.abs() <= f64::EPSILON * 1e-2 * (a[(p, p)].abs() * a[(q, q)].abs()).sqrt() {
                    a[(p, q)] = 0.0;
                    a[(q, p)] = 0.0;
                    continue;
                }
                let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * apq);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                a[(p, p)] -= t * apq;
                a[(q, q)] += t * apq;
                a[(p, q)] = 0.0;
                a[(q, p)] = 0.0;
                let r = 3 - p - q;
                let (arp, arq) = (a[(r, p)], a[(r, q)]);
                a[(r, p)] = c * arp - s * arq;
                a[(p, r)] = a[(r, p)];
                a[(r, q)] = s * arp + c * arq;
                a[(q, r)] = a[(r, q)];
                rotate_columns(&mut v, p, q, c, s);
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
        let values = Vector3::from_fn(|i, _| a[(order[i], order[i])]);
        let mut vectors = Matrix3::from_fn(|r, c| v[(r, order[c])]);
        for mut column in vectors.column_iter_mut() {
            if column[column.iamax()] < 0.0 {
                column.neg_mut();
            }
        }
        Self { values, vectors }
    }

    /// The matrix with `f` applied to its eigenvalues.
    pub(crate) fn map(&self, f: impl Fn(f64) -> f64) -> Matrix3<f64> {
        let scaled = Matrix3::from_fn(|r, c| self.vectors[(r, c)] * f(self.values[c]));
        scaled * self.vectors.transpose()
    }
}

/// Singular value decomposition `matrix * right = scaled_left`: the columns of `scaled_left` are orthogonal, and their norms
/// are the singular values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OneSidedSvd {
    /// Orthogonal columns u_i s_i.
    pub scaled_left: Matrix3<f64>,
    /// Orthonormal columns v_i.
    pub right: Matrix3<f64>,
}

impl OneSidedSvd {
    /// One-sided Jacobi (Hestenes 1958): keeps the relative accuracy of small singular values, which the eigenvalues of
    /// `matrix^T matrix` would lose.
    pub(crate) fn new(matrix: &Matrix3<f64>) -> Self {
        let mut u = *matrix;
        let mut v = Matrix3::identity();
        for _ in 0..MAX_SWEEPS {
            let mut rotated = false;
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                let (alpha, beta) = (u.column(p).norm_squared(), u.column(q).norm_squared());
                let gamma = u.column(p).dot(&u.column(q));
                // Below the smallest normal number there are no digits to rotate by.
                if gamma.abs() <= f64::EPSILON * (alpha * beta).sqrt()
                    || gamma.abs() < f64::MIN_POSITIVE
                {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                rotate_columns(&mut u, p, q, c, c * t);
                rotate_columns(&mut v, p, q, c, c * t);
            }
            if !rotated {
                break;
            }
        }
        Self {
            scaled_left: u,
            right: v,
        }
    }

    /// Singular values, unordered.
    pub(crate) fn values(&self) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.scaled_left.column(i).norm())
    }

    /// The nearest orthogonal matrix. For a singular matrix it is one of several.
    pub(crate) fn polar(&self) -> Matrix3<f64> {
        let values = self.values();
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
        let mut left = Matrix3::identity();
        let mut done: [Option<Vector3<f64>>; 3] = [None; 3];
        for (rank, &i) in order.iter().enumerate() {
            let mut u: Vector3<f64> = self.scaled_left.column(i).into();
            let floor = f64::EPSILON * values[order[0]];
            if values[i] <= floor || values[i] < f64::MIN_POSITIVE {
                u = completion(&done[..rank]);
            } else {
                u /= values[i];
            }
            for earlier in done.iter().flatten() {
                u -= earlier * earlier.dot(&u);
            }
            let u = u
                .try_normalize(0.0)
                .unwrap_or_else(|| completion(&done[..rank]));
            done[rank] = Some(u);
            left.set_column(i, &u);
        }
        left * self.right.transpose()
    }
}

/// A unit vector orthogonal to those given (at most two).
fn completion(done: &[Option<Vector3<f64>>]) -> Vector3<f64> {
    let mut known = done.iter().flatten();
    match (known.next(), known.next()) {
        (Some(a), Some(b)) => a.cross(b),
        (Some(a), None) => {
            let axis = Vector3::ith(a.iamin(), 1.0);
            let orthogonal = a.cross(&axis);
            orthogonal / orthogonal.norm()
        }
        _ => Vector3::x(),
    }
}

fn rotate_columns(m: &mut Matrix3<f64>, p: usize, q: usize, c: f64, s: f64) {
    for row in 0..3 {
        let (mp, mq) = (m[(row, p)], m[(row, q)]);
        m[(row, p)] = c * mp - s * mq;
        m[(row, q)] = s * mp + c * mq;
    }
}

#[cfg(test)]
mod tests {
    use super::{Eigen, OneSidedSvd};
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    fn any_matrix() -> impl Strategy<Value = Matrix3<f64>> {
        proptest::array::uniform9(-2.0..2.0f64).prop_map(|a| Matrix3::from_row_slice(&a))
    }

    proptest! {
        #[test]
        fn eigenvectors_rebuild_the_matrix(a in any_matrix()) {
            let s = a * a.transpose();
            let eigen = Eigen::new(&s);
            prop_assert!((eigen.map(|l| l) - s).amax() < 1e-13 * (1.0 + s.amax()));
            prop_assert!((eigen.vectors.transpose() * eigen.vectors - Matrix3::identity()).amax() < 1e-14);
            prop_assert!(eigen.values[0] <= eigen.values[1] && eigen.values[1] <= eigen.values[2]);
            let root = eigen.map(|l| l.max(0.0).sqrt());
            prop_assert!((root * root - s).amax() < 1e-12 * (1.0 + s.amax()));
        }

        #[test]
        fn polar_factor_is_orthogonal_and_symmetrises(a in any_matrix(), rank in 0usize..4) {
            let mut a = a;
            for column in rank..3 { a.column_mut(column).fill(0.0); }
            let svd = OneSidedSvd::new(&a);
            let polar = svd.polar();
            prop_assert!((polar.transpose() * polar - Matrix3::identity()).amax() < 1e-13);
            let h = polar.transpose() * a;
            prop_assert!((h - h.transpose()).amax() < 1e-12);
            prop_assert!((h.trace() - svd.values().sum()).abs() < 1e-12);
        }
    }

    #[test]
    fn small_eigenvalues_of_a_thin_diagonal_survive() {
        let thin = Matrix3::from_diagonal(&nalgebra::Vector3::new(4.0, 1e-14, 1.0));
        assert_eq!(Eigen::new(&thin).values.as_slice(), &[1e-14, 1.0, 4.0]);
    }
}
