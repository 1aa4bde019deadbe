//! The weighted sums of one iteration: six of the pose, two of the drift of the ranges.

use super::{RegistrationSettings, jacobian};
use crate::geometry::{Patch, RangeDrift};
use nalgebra::{Matrix6, Point3, SMatrix, SVector, SymmetricEigen, Vector3, Vector6};

/// Translation and rotation vector, then the drift at range zero and per metre.
type Matrix8 = SMatrix<f64, 8, 8>;
type Vector8 = SVector<f64, 8>;

/// Sums over matched places.
pub(super) struct NormalEquations {
    matrix: Matrix8,
    vector: Vector8,
    pub weight: f64,
    square: f64,
    lever: f64,
}

impl NormalEquations {
    pub(super) fn new() -> Self {
        Self {
            matrix: Matrix8::zeros(),
            vector: Vector8::zeros(),
            weight: 0.0,
            square: 0.0,
            lever: 0.0,
        }
    }

    /// Adds a place `p` (reference frame) `e` metres above `patch`, met along the unit `ray` at `range_m`.
    #[inline]
    pub(super) fn add(
        &mut self,
        p: &Point3<f64>,
        ray: &Vector3<f64>,
        range_m: f64,
        patch: &Patch,
        gate_m: f64,
    ) {
        let e = patch.height_m(p);
        // Tukey's biweight: what lies a gate away has no say.
        let w = (1.0 - (e / gate_m).powi(2)).powi(2);
        let pose = jacobian(&patch.normal, p);
        let along = patch.normal.dot(ray);
        let j = Vector8::from([
            pose[0],
            pose[1],
            pose[2],
            pose[3],
            pose[4],
            pose[5],
            along,
            along * range_m,
        ]);
        // The lower triangle is enough until all is summed.
        for column in 0..8 {
            let scaled = w * j[column];
            for row in column..8 {
                self.matrix[(row, column)] += scaled * j[row];
            }
        }
        self.vector -= j * (w * e);
        self.weight += w;
        self.square += w * e * e;
        self.lever += w * p.coords.norm_squared();
    }

    /// The sums of both.
    pub(super) fn joined(mut self, other: &Self) -> Self {
        self.matrix += other.matrix;
        self.vector += other.vector;
        self.weight += other.weight;
        self.square += other.square;
        self.lever += other.lever;
        self
    }

    fn full(&self) -> Matrix8 {
        let mut full = self.matrix;
        full.fill_upper_triangle_with_lower_triangle();
        full
    }

    /// Root mean square lever arm: turns radians into metres, so that directions compare.
    fn lever_m(&self) -> f64 {
        (self.lever / self.weight.max(1e-9)).sqrt().max(0.1)
    }

    /// Eigenpairs of the pose's mean normal matrix with rotations measured in metres at the lever arm.
    fn directions(&self) -> (SymmetricEigen<f64, nalgebra::U6>, Vector6<f64>) {
        let l = self.lever_m();
        let scale = Vector6::new(1.0, 1.0, 1.0, 1.0 / l, 1.0 / l, 1.0 / l);
        let s = Matrix6::from_diagonal(&scale);
        let pose: Matrix6<f64> = self.full().fixed_view::<6, 6>(0, 0).into_owned();
        (
            SymmetricEigen::new(s * pose * s / self.weight.max(1e-9)),
            scale,
        )
    }

    /// The step that the sums ask for, along observable directions only, the pose's part no longer than the gate.
    /// `drift` is where the ranges stand; without it they are held.
    pub(super) fn step(
        &self,
        drift: Option<&RangeDrift>,
        settings: &RegistrationSettings,
        gate_m: f64,
    ) -> (Vector6<f64>, RangeDrift) {
        let still = RangeDrift::default();
        if self.weight <= 6.0 {
            return (Vector6::zeros(), still);
        }
        let (basis, mut open, scale) = self.basis(settings);
        let mut matrix_prior = Matrix8::zeros();
        let mut pull = self.vector / self.weight;
        if let Some(drift) = drift {
            let trust = self.noise_m2() / self.effective();
            for (i, (at, sd)) in [
                (drift.at_zero_m, settings.drift_sd_m),
                (drift.per_m, settings.drift_sd_per_m),
            ]
            .into_iter()
            .enumerate()
            {
                open[6 + i] = true;
                matrix_prior[(6 + i, 6 + i)] = trust / (sd * sd);
                pull[6 + i] -= trust / (sd * sd) * at;
            }
        }
        let mut system = basis.transpose() * (self.full() / self.weight + matrix_prior) * basis;
        let mut right = basis.transpose() * pull;
        for i in (0..8).filter(|i| !open[*i]) {
            system.fill_row(i, 0.0);
            system.fill_column(i, 0.0);
            system[(i, i)] = 1.0;
            right[i] = 0.0;
        }
        let Some(solved) = system.lu().solve(&right) else {
            return (Vector6::zeros(), still);
        };
        let step = basis * solved;
        let mut pose = step.fixed_rows::<6>(0).component_div(&scale);
        let longest = pose.norm();
        if longest > gate_m {
            pose *= gate_m / longest;
        }
        (
            scale.component_mul(&pose),
            RangeDrift {
                at_zero_m: step[6],
                per_m: step[7],
            },
        )
    }

    /// Eigenvectors of the pose as columns, in metres and radians, and the drift as it is; which of them the surfaces fix
    /// (the drift is closed until it is asked for); and what scales radians to metres.
    fn basis(&self, settings: &RegistrationSettings) -> (Matrix8, [bool; 8], Vector6<f64>) {
        let (eigen, scale) = self.directions();
        let mut basis = Matrix8::identity();
        let mut open = [false; 8];
        for (i, axis) in eigen.eigenvectors.column_iter().enumerate() {
            open[i] = eigen.eigenvalues[i] >= settings.least_resistance;
            basis
                .fixed_view_mut::<6, 1>(0, i)
                .copy_from(&scale.component_mul(&axis));
        }
        (basis, open, scale)
    }

    /// Directions that the surfaces do not fix, unit vectors in scaled coordinates, and the scale.
    fn left_open(&self, settings: &RegistrationSettings) -> (Vec<Vector6<f64>>, Vector6<f64>) {
        let (eigen, scale) = self.directions();
        let pairs = eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter());
        let axes = pairs
            .filter(|(value, _)| **value < settings.least_resistance)
            .map(|(_, axis)| axis.into_owned())
            .collect();
        (axes, scale)
    }

    /// The part of `way` (translation, rotation vector) along what the surfaces do not fix.
    pub(super) fn along_left_open(
        &self,
        way: &Vector6<f64>,
        settings: &RegistrationSettings,
    ) -> Vector6<f64> {
        let (axes, scale) = self.left_open(settings);
        let scaled = way.component_div(&scale);
        let part: Vector6<f64> = axes.iter().map(|axis| axis * axis.dot(&scaled)).sum();
        scale.component_mul(&part)
    }

    /// Errors of neighbouring places go together: one in ten counts.
    fn effective(&self) -> f64 {
        (self.weight / 10.0).max(1.0)
    }

    fn noise_m2(&self) -> f64 {
        (self.square / self.weight.max(1e-9)).max(1e-6)
    }

    /// Covariance of the pose. Along what surfaces leave open no step was made: the prior alone holds it, however little
    /// resistance there was.
    pub(super) fn covariance(&self, settings: &RegistrationSettings) -> Matrix6<f64> {
        let sd = [
            settings.prior_sd_m,
            settings.prior_sd_m,
            settings.prior_sd_m,
            settings.prior_sd_rad,
            settings.prior_sd_rad,
            settings.prior_sd_rad,
            settings.drift_sd_m,
            settings.drift_sd_per_m,
        ];
        let variances = Vector8::from(sd.map(|s| s * s));
        let prior = Matrix8::from_diagonal(&variances.map(|v| 1.0 / v));
        let scale = self.effective() / self.weight.max(1e-9) / self.noise_m2();
        let (basis, open, _) = self.basis(settings);
        let mut information = basis.transpose() * (self.full() * scale) * basis;
        for i in (0..6).filter(|i| !open[*i]) {
            information.fill_row(i, 0.0);
            information.fill_column(i, 0.0);
        }
        let told = basis
            .try_inverse()
            .map(|back| back.transpose() * information * back)
            .and_then(|information| (information + prior).try_inverse());
        told.unwrap_or_else(|| Matrix8::from_diagonal(&variances))
            .fixed_view::<6, 6>(0, 0)
            .into_owned()
    }

    /// Directions that the surfaces do not fix, in words.
    pub(super) fn unobservable(&self, settings: &RegistrationSettings) -> Vec<String> {
        let (axes, _) = self.left_open(settings);
        let told = |axis: &Vector6<f64>| {
            let (shift, turn) = (axis.fixed_rows::<3>(0), axis.fixed_rows::<3>(3));
            let (word, v) = if shift.norm() >= turn.norm() {
                ("along", shift.normalize())
            } else {
                ("about", turn.normalize())
            };
            format!("{word} ({:.2}, {:.2}, {:.2})", v.x, v.y, v.z)
        };
        axes.iter().map(told).collect()
    }
}
