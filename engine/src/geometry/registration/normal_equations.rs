//! The normal equations of one iteration: six unknowns of the pose, two of the drift of the ranges.

use super::settings::RegistrationSettings;
use crate::geometry::RangeDrift;
use crate::geometry::constants::{CORRELATED_POINTS, MIN_LEVER_M, MIN_NOISE_M2};
use nalgebra::{Matrix6, SMatrix, SVector, SymmetricEigen, Vector3, Vector6};

/// Translation and rotation vector, then the drift at range zero and per metre.
pub(super) type Matrix8 = SMatrix<f64, 8, 8>;
pub(super) type Vector8 = SVector<f64, 8>;

/// A current point in the reference frame that matches a plane there.
pub(super) struct MatchedPoint {
    /// From what rotations are about to the point, metres.
    pub(super) lever: Vector3<f64>,
    /// Direction from the current sensor, a unit vector.
    pub(super) ray: Vector3<f64>,
    /// Distance from the current sensor, metres.
    pub(super) range_m: f64,
    /// Height over the plane, metres.
    pub(super) height_m: f64,
    /// Normal of the plane.
    pub(super) normal: Vector3<f64>,
}

impl MatchedPoint {
    /// Tukey's biweight: points a gate away have no weight.
    #[inline]
    pub(super) fn weight(&self, gate_m: f64) -> f64 {
        (1.0 - (self.height_m / gate_m).powi(2)).powi(2)
    }

    /// Derivative of the height by the unknowns.
    #[inline]
    pub(super) fn derivative(&self) -> Vector8 {
        let pose = jacobian(&self.normal, &self.lever);
        let along = self.normal.dot(&self.ray);
        Vector8::from([
            pose[0],
            pose[1],
            pose[2],
            pose[3],
            pose[4],
            pose[5],
            along,
            along * self.range_m,
        ])
    }
}

/// Weighted sums over matched points.
pub(super) struct NormalEquations {
    matrix: Matrix8,
    vector: Vector8,
    /// Sum of the weights.
    pub(super) weight: f64,
    /// Weighted sum of squared residuals, square metres.
    pub(super) residual2: f64,
    /// Weighted sum of squared levers, square metres.
    lever2: f64,
}

impl NormalEquations {
    pub(super) fn new() -> Self {
        Self {
            matrix: Matrix8::zeros(),
            vector: Vector8::zeros(),
            weight: 0.0,
            residual2: 0.0,
            lever2: 0.0,
        }
    }

    /// Adds a match.
    #[inline]
    pub(super) fn add(&mut self, point: &MatchedPoint, gate_m: f64) {
        let (e, w, j) = (point.height_m, point.weight(gate_m), point.derivative());
        // The lower triangle is enough until all is summed.
        for column in 0..8 {
            let scaled = w * j[column];
            for row in column..8 {
                self.matrix[(row, column)] += scaled * j[row];
            }
        }
        self.vector -= j * (w * e);
        self.weight += w;
        self.residual2 += w * e * e;
        self.lever2 += w * point.lever.norm_squared();
    }

    pub(super) fn merged(mut self, other: &Self) -> Self {
        self.matrix += other.matrix;
        self.vector += other.vector;
        self.weight += other.weight;
        self.residual2 += other.residual2;
        self.lever2 += other.lever2;
        self
    }

    /// Weighted sum of the products of derivatives.
    pub(super) fn full(&self) -> Matrix8 {
        let mut full = self.matrix;
        full.fill_upper_triangle_with_lower_triangle();
        full
    }

    /// Root mean square lever arm: turns radians into metres, so that directions can be compared.
    fn lever_m(&self) -> f64 {
        (self.lever2 / self.weight.max(1e-9))
            .sqrt()
            .max(MIN_LEVER_M)
    }

    /// Eigenpairs of the pose's mean normal matrix with rotations in metres at the lever arm, and the scale from there to
    /// radians.
    pub(super) fn eigenpairs(&self) -> (SymmetricEigen<f64, nalgebra::U6>, Vector6<f64>) {
        let l = self.lever_m();
        let scale = Vector6::new(1.0, 1.0, 1.0, 1.0 / l, 1.0 / l, 1.0 / l);
        let s = Matrix6::from_diagonal(&scale);
        let pose: Matrix6<f64> = self.full().fixed_view::<6, 6>(0, 0).into_owned();
        (
            SymmetricEigen::new(s * pose * s / self.weight.max(1e-9)),
            scale,
        )
    }

    /// The Gauss-Newton step along observable directions, the pose's part no longer than the gate. `drift` is the present
    /// drift; without it the drift stays fixed.
    pub(super) fn step(
        &self,
        drift: Option<&RangeDrift>,
        settings: &RegistrationSettings,
        gate_m: f64,
    ) -> (Vector6<f64>, RangeDrift) {
        let no_drift = RangeDrift::default();
        if self.weight <= 6.0 {
            return (Vector6::zeros(), no_drift);
        }
        let (basis, mut free, scale) = self.basis(settings);
        let mut prior = Matrix8::zeros();
        let mut gradient = self.vector / self.weight;
        if let Some(drift) = drift {
            let noise_m2 = self.noise_m2() / self.effective_points();
            for (i, (present, sd)) in [
                (drift.at_zero_m, settings.drift_sd_m),
                (drift.per_m, settings.drift_sd_per_m),
            ]
            .into_iter()
            .enumerate()
            {
                free[6 + i] = true;
                prior[(6 + i, 6 + i)] = noise_m2 / (sd * sd);
                gradient[6 + i] -= noise_m2 / (sd * sd) * present;
            }
        }
        let mut system = basis.transpose() * (self.full() / self.weight + prior) * basis;
        let mut right = basis.transpose() * gradient;
        for i in (0..8).filter(|i| !free[*i]) {
            system.fill_row(i, 0.0);
            system.fill_column(i, 0.0);
            system[(i, i)] = 1.0;
            right[i] = 0.0;
        }
        let Some(solved) = system.lu().solve(&right) else {
            return (Vector6::zeros(), no_drift);
        };
        let step = basis * solved;
        let mut pose = step.fixed_rows::<6>(0).component_div(&scale);
        let length = pose.norm();
        if length > gate_m {
            pose *= gate_m / length;
        }
        (
            scale.component_mul(&pose),
            RangeDrift {
                at_zero_m: step[6],
                per_m: step[7],
            },
        )
    }

    /// Eigenvectors of the pose as columns, in metres and radians, and the unit vectors of the drift; which of them are free
    /// to move (those the surfaces fix; not the drift); and the scale of [`eigenpairs`](Self::eigenpairs).
    pub(super) fn basis(
        &self,
        settings: &RegistrationSettings,
    ) -> (Matrix8, [bool; 8], Vector6<f64>) {
        let (eigen, scale) = self.eigenpairs();
        let mut basis = Matrix8::identity();
        let mut free = [false; 8];
        for (i, axis) in eigen.eigenvectors.column_iter().enumerate() {
            free[i] = eigen.eigenvalues[i] >= settings.min_observability;
            basis
                .fixed_view_mut::<6, 1>(0, i)
                .copy_from(&scale.component_mul(&axis));
        }
        (basis, free, scale)
    }

    /// Directions that the surfaces do not fix, unit vectors in scaled coordinates, and the scale.
    fn unobservable_axes(
        &self,
        settings: &RegistrationSettings,
    ) -> (Vec<Vector6<f64>>, Vector6<f64>) {
        let (eigen, scale) = self.eigenpairs();
        let pairs = eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter());
        let axes = pairs
            .filter(|(value, _)| **value < settings.min_observability)
            .map(|(_, axis)| axis.into_owned())
            .collect();
        (axes, scale)
    }

    /// The part of `motion` (translation, rotation vector) along directions that the surfaces do not fix.
    pub(super) fn unobservable_part(
        &self,
        motion: &Vector6<f64>,
        settings: &RegistrationSettings,
    ) -> Vector6<f64> {
        let (axes, scale) = self.unobservable_axes(settings);
        let scaled = motion.component_div(&scale);
        let part: Vector6<f64> = axes.iter().map(|axis| axis * axis.dot(&scaled)).sum();
        scale.component_mul(&part)
    }

    /// Number of independent points: errors of neighbours go together.
    pub(super) fn effective_points(&self) -> f64 {
        (self.weight / CORRELATED_POINTS).max(1.0)
    }

    pub(super) fn noise_m2(&self) -> f64 {
        (self.residual2 / self.weight.max(1e-9)).max(MIN_NOISE_M2)
    }

    /// Directions that the surfaces do not fix, as text.
    pub(super) fn unobservable(&self, settings: &RegistrationSettings) -> Vec<String> {
        let (axes, _) = self.unobservable_axes(settings);
        let format_axis = |axis: &Vector6<f64>| {
            let (shift, rotation) = (axis.fixed_rows::<3>(0), axis.fixed_rows::<3>(3));
            let (preposition, v) = if shift.norm() >= rotation.norm() {
                ("along", shift.normalize())
            } else {
                ("about", rotation.normalize())
            };
            format!("{preposition} ({:.2}, {:.2}, {:.2})", v.x, v.y, v.z)
        };
        axes.iter().map(format_axis).collect()
    }
}

/// Derivative of the height of a point over a plane with normal `u` by (translation, rotation vector), `lever` from what the
/// rotation is about.
pub(super) fn jacobian(u: &Vector3<f64>, lever: &Vector3<f64>) -> Vector6<f64> {
    let rotation = lever.cross(u);
    Vector6::new(u.x, u.y, u.z, rotation.x, rotation.y, rotation.z)
}
