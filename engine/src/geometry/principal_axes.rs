//! Principal axes of a 3 x 3 covariance in closed form; thousands are needed per view.

use nalgebra::{Matrix3, Vector3};

/// Principal variances of a symmetric positive semi-definite matrix and the axis of the smallest one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PrincipalAxes {
    /// Ascending, none negative; the unit of the matrix. Exact to some 1e-15 of the largest.
    pub(super) variances: [f64; 3],
    /// Unit axis of the smallest variance; where the smallest two are equal, any axis across the third.
    pub(super) smallest_axis: Vector3<f64>,
}

impl PrincipalAxes {
    /// Trigonometric roots of the characteristic polynomial (Smith 1961); the axis is the largest cross product of two rows
    /// of `matrix - smallest * identity`.
    pub(super) fn from_covariance(matrix: &Matrix3<f64>) -> Self {
        let m = matrix;
        let middle = m.trace() / 3.0;
        let (xy, xz, yz) = (m[(0, 1)], m[(0, 2)], m[(1, 2)]);
        let (xx, yy, zz) = (m[(0, 0)] - middle, m[(1, 1)] - middle, m[(2, 2)] - middle);
        let off = xy * xy + xz * xz + yz * yz;
        let p = ((xx * xx + yy * yy + zz * zz + 2.0 * off) / 6.0).sqrt();
        if p <= f64::EPSILON * middle.abs() || !p.is_finite() {
            return Self {
                variances: [middle.max(0.0); 3],
                smallest_axis: Vector3::z(),
            };
        }
        let determinant =
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        let angle = (0.5 * determinant / (p * p * p)).clamp(-1.0, 1.0).acos() / 3.0;
        let (sin, cos) = angle.sin_cos();
        let largest = 2.0 * p * cos;
        // cos(angle + 120 deg).
        let smallest = 2.0 * p * (-0.5 * cos - 0.866_025_403_784_438_6 * sin);
        let variances = [smallest, -largest - smallest, largest].map(|v| (middle + v).max(0.0));
        let rows = [
            Vector3::new(xx - smallest, xy, xz),
            Vector3::new(xy, yy - smallest, yz),
            Vector3::new(xz, yz, zz - smallest),
        ];
        let crosses = [
            rows[0].cross(&rows[1]),
            rows[0].cross(&rows[2]),
            rows[1].cross(&rows[2]),
        ];
        let longest = crosses
            .into_iter()
            .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
            .unwrap_or_else(Vector3::zeros);
        let least_axis = longest
            .try_normalize(1e-7 * p * p)
            .unwrap_or_else(|| across(&rows));
        Self {
            variances,
            smallest_axis: least_axis,
        }
    }
}

/// An axis across all rows, for parallel rows.
fn across(rows: &[Vector3<f64>; 3]) -> Vector3<f64> {
    let longest = rows
        .iter()
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
        .copied()
        .unwrap_or_else(Vector3::zeros);
    let mut unit = Vector3::zeros();
    unit[longest.iamin()] = 1.0;
    longest
        .cross(&unit)
        .try_normalize(f64::MIN_POSITIVE)
        .unwrap_or_else(Vector3::z)
}

#[cfg(test)]
mod tests {
    use super::PrincipalAxes;
    use nalgebra::{Matrix3, SymmetricEigen, Vector3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_an_iterative_solver(root in proptest::array::uniform9(-1.0..1.0f64), thin in 0.0..1.0f64) {
            let root = Matrix3::from_row_slice(&root) * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, thin));
            let matrix = root * root.transpose();
            let found = PrincipalAxes::from_covariance(&matrix);
            let mut expected: Vec<f64> = SymmetricEigen::new(matrix).eigenvalues.iter().copied().collect();
            expected.sort_unstable_by(f64::total_cmp);
            let scale = expected[2].max(1e-300);
            for (got, want) in found.variances.iter().zip(&expected) {
                prop_assert!((got - want).abs() < 1e-12 * scale);
            }
            prop_assert!((found.smallest_axis.norm() - 1.0).abs() < 1e-12);
            let along = (matrix * found.smallest_axis).norm();
            prop_assert!(along < expected[0].max(0.0) + 1e-7 * scale, "{along} {expected:?}");
        }
    }

    #[test]
    fn spheres_lines_and_zero_have_axes() {
        for variances in [[1.0, 1.0, 1.0], [2.0, 0.0, 0.0], [0.0; 3], [3.0, 3.0, 0.0]] {
            let matrix = Matrix3::from_diagonal(&Vector3::from(variances));
            let found = PrincipalAxes::from_covariance(&matrix);
            assert!((found.smallest_axis.norm() - 1.0).abs() < 1e-12);
            let mut sorted = variances;
            sorted.sort_unstable_by(f64::total_cmp);
            assert!(
                (found.smallest_axis.dot(&(matrix * found.smallest_axis)) - sorted[0]).abs()
                    < 1e-12
            );
        }
    }
}
