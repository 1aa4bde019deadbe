//! Fits a bend: from one instant of the sweep on, all points are rotated and shifted.
//!
//! Point-to-plane least squares on the reference's flat cells, as in registration, with four more unknowns: rotation
//! about the pan axis, rotation about the tilt axis, and a shift of the robot. The normal equations are summed per
//! stretch of the sweep, so that every instant is tried at the price of one pass.

use super::constants::{
    BEND_AGREEMENT_GATE_M, BEND_GATES_M, BEND_HEIGHT_SIGMA_M, BEND_POINTS,
    BEND_POINTS_PER_INDEPENDENT, BEND_PRIOR_SD, BEND_STRETCHES, MIN_BEND_GAIN,
    MIN_BEND_GAIN_OF_SMALLER_PART,
};
use crate::geometry::{DriftTransform, PlaneIndex, Pose, RangeDrift, Registration};
use crate::sweep::Sweep;
use nalgebra::{Point3, SMatrix, SVector, UnitQuaternion, Vector3};
use rayon::prelude::*;

/// Unknowns of a view that is not bent: six of the pose, two of the drift.
const STRAIGHT_UNKNOWNS: usize = 8;
/// With the four of the bend.
const UNKNOWNS: usize = 12;

type Matrix = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Vector = SVector<f64, UNKNOWNS>;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// Share of the sweep that lies before the bend.
    pub after: f64,
    /// Rotation about the pan axis of what lies after the bend.
    pub pan_rad: f64,
    /// The same about the tilt axis, positive up.
    pub tilt_rad: f64,
    /// Shift of what lies after the bend, forward and left.
    pub shift_m: [f64; 2],
}

struct SweepSample {
    point: Point3<f64>,
    /// The pan axis is z.
    tilt_axis: Vector3<f64>,
    stretch: usize,
}

/// Estimate of all unknowns.
#[derive(Debug, Clone, Copy)]
struct BendFit {
    pose: Pose,
    drift: RangeDrift,
    /// The first stretch after the bend; [`BEND_STRETCHES`] if there is no bend.
    bent_from: usize,
    /// Pan and tilt in radians, forward and left in metres.
    bend: [f64; 4],
}

#[derive(Clone)]
struct BendEquations {
    matrix: Matrix,
    vector: Vector,
}

/// The best bend, if it explains enough more of the sweep than none.
pub(super) fn find(
    reference_planes: &PlaneIndex,
    sweep: &Sweep,
    registration: &Registration,
) -> Option<Bend> {
    let samples = samples(sweep);
    let problem = BendProblem {
        reference_planes,
        samples: &samples,
        origin: sweep.view.origin,
    };
    let start = BendFit {
        pose: registration.current_from_reference.inverse(),
        drift: registration.drift,
        bent_from: BEND_STRETCHES,
        bend: [0.0; 4],
    };
    let bent = problem.solve(start, true);
    let straight = problem.solve(start, false);
    let gain =
        problem.agreement(&bent) - problem.agreement(&straight).max(problem.agreement(&start));
    let after = bent.bent_from as f64 / BEND_STRETCHES as f64;
    let smaller = after.min(1.0 - after);
    (gain >= MIN_BEND_GAIN.max(MIN_BEND_GAIN_OF_SMALLER_PART * smaller) && smaller > 0.0).then(
        || Bend {
            after,
            pan_rad: bent.bend[0],
            tilt_rad: bent.bend[1],
            shift_m: [bent.bend[2], bent.bend[3]],
        },
    )
}

fn samples(sweep: &Sweep) -> Vec<SweepSample> {
    let count = sweep.view.points.len();
    let step = count.div_ceil(BEND_POINTS).max(1);
    let mut samples = Vec::with_capacity(count / step + 1);
    for part in &sweep.pan_segments {
        // Tilting up is a negative rotation about the axis.
        let tilt_axis = -part.tilt_axis.into_inner();
        for i in part.points.clone().step_by(step) {
            samples.extend(sweep.view.points.get(i).map(|point| SweepSample {
                point: *point,
                tilt_axis,
                stretch: i * BEND_STRETCHES / count.max(1),
            }));
        }
    }
    samples
}

struct BendProblem<'a> {
    reference_planes: &'a PlaneIndex,
    samples: &'a [SweepSample],
    origin: Point3<f64>,
}

impl BendProblem<'_> {
    /// The sample with the bend undone.
    fn straightened(&self, sample: &SweepSample, fit: &BendFit) -> Point3<f64> {
        if sample.stretch < fit.bent_from {
            return sample.point;
        }
        let [pan, tilt, forward, left] = fit.bend;
        let rotation =
            UnitQuaternion::from_scaled_axis(Vector3::z() * pan + sample.tilt_axis * tilt);
        let shift = Vector3::new(forward, left, 0.0);
        self.origin + rotation * (sample.point - self.origin) + shift
    }

    fn solve(&self, start: BendFit, may_bend: bool) -> BendFit {
        let mut fit = start;
        for gate_m in BEND_GATES_M {
            if let Some(next) = self.iterate(&fit, gate_m, may_bend) {
                fit = next;
            }
        }
        fit
    }

    /// One iteration: planes are matched again; pose, drift and bend are solved together, for the best instant.
    fn iterate(&self, fit: &BendFit, gate_m: f64, may_bend: bool) -> Option<BendFit> {
        let stretches = self.normal_equations(fit, gate_m);
        let mut all = BendEquations::default();
        stretches.iter().for_each(|stretch| all.add(stretch));
        let straight = all.without_bend();
        let (mut gain, mut solved, mut bent_from) = {
            let (gain, solved) = straight.solve(fit)?;
            (gain, solved, BEND_STRETCHES)
        };
        if may_bend {
            let mut later = BendEquations::default();
            for stretch in (1..BEND_STRETCHES).rev() {
                later.add(&stretches[stretch]);
                let mut equations = straight.clone();
                equations.set_bend(&later);
                if let Some((better, how)) = equations.solve(fit).filter(|(g, _)| *g > gain) {
                    (gain, solved, bent_from) = (better, how, stretch);
                }
            }
        }
        let step = Pose::new(
            Vector3::new(solved[0], solved[1], solved[2]),
            Vector3::new(solved[3], solved[4], solved[5]),
        );
        Some(BendFit {
            pose: step * fit.pose,
            drift: RangeDrift {
                at_zero_m: fit.drift.at_zero_m + solved[6],
                per_m: fit.drift.per_m + solved[7],
            },
            bent_from,
            bend: std::array::from_fn(|i| solved[STRAIGHT_UNKNOWNS + i]),
        })
    }

    fn normal_equations(&self, fit: &BendFit, gate_m: f64) -> Vec<BendEquations> {
        let reference_from_sweep = DriftTransform::to_reference(fit.pose, fit.drift, self.origin);
        let sensor = fit.pose * self.origin;
        let part = |samples: &[SweepSample]| {
            let mut equations = vec![BendEquations::default(); BEND_STRETCHES];
            for sample in samples {
                let straight = self.straightened(sample, fit);
                let point = reference_from_sweep.apply(&straight);
                let Some(patch) = self.reference_planes.find_exact(&point, gate_m) else {
                    continue;
                };
                let normal = patch.normal;
                let height_m = patch.height_m(&point);
                let ray = point - sensor;
                let range_m = ray.norm().max(1e-9);
                let along = normal.dot(&ray) / range_m;
                let rotation = point.coords.cross(&normal);
                let arm = straight - self.origin;
                let bent_by =
                    |axis: &Vector3<f64>| normal.dot(&(fit.pose.rotation * axis.cross(&arm)));
                let shifted_by = |axis: Vector3<f64>| normal.dot(&(fit.pose.rotation * axis));
                let bends = [
                    bent_by(&Vector3::z()),
                    bent_by(&sample.tilt_axis),
                    shifted_by(Vector3::x()),
                    shifted_by(Vector3::y()),
                ];
                // Height without the bend: the whole bend is solved for, not an increment.
                let unbent_m = if sample.stretch < fit.bent_from {
                    height_m
                } else {
                    let bent_m: f64 = bends.iter().zip(fit.bend).map(|(b, by)| b * by).sum();
                    height_m - bent_m
                };
                let j = Vector::from([
                    normal.x,
                    normal.y,
                    normal.z,
                    rotation.x,
                    rotation.y,
                    rotation.z,
                    along,
                    along * range_m,
                    bends[0],
                    bends[1],
                    bends[2],
                    bends[3],
                ]);
                // Tukey's biweight: zero at the gate.
                let weight = (1.0 - (height_m / gate_m).powi(2)).powi(2);
                let stretch = &mut equations[sample.stretch.min(BEND_STRETCHES - 1)];
                stretch.matrix += j * j.transpose() * weight;
                stretch.vector -= j * (weight * unbent_m);
            }
            equations
        };
        // Parts of fixed size, summed in order: the result does not depend on the number of threads.
        let parts: Vec<Vec<BendEquations>> = self.samples.par_chunks(1000).map(part).collect();
        let mut total = vec![BendEquations::default(); BEND_STRETCHES];
        for part in &parts {
            for (sum, more) in total.iter_mut().zip(part) {
                sum.add(more);
            }
        }
        total
    }

    /// Mean over the samples of 1 - (height / gate)^2; a sample without a plane counts as 0.
    fn agreement(&self, fit: &BendFit) -> f64 {
        let reference_from_sweep = DriftTransform::to_reference(fit.pose, fit.drift, self.origin);
        let agrees = |sample: &SweepSample| {
            let point = reference_from_sweep.apply(&self.straightened(sample, fit));
            let patch = self
                .reference_planes
                .find_exact(&point, BEND_AGREEMENT_GATE_M);
            patch.map_or(0.0, |patch| {
                1.0 - (patch.height_m(&point) / BEND_AGREEMENT_GATE_M).powi(2)
            })
        };
        let parts: Vec<f64> = self
            .samples
            .par_chunks(1000)
            .map(|samples| samples.iter().map(agrees).sum())
            .collect();
        parts.iter().sum::<f64>() / (self.samples.len() as f64).max(1.0)
    }
}

impl Default for BendEquations {
    fn default() -> Self {
        Self {
            matrix: Matrix::zeros(),
            vector: Vector::zeros(),
        }
    }
}

impl BendEquations {
    fn add(&mut self, other: &Self) {
        self.matrix += other.matrix;
        self.vector += other.vector;
    }

    /// Without the unknowns of the bend.
    fn without_bend(&self) -> Self {
        let mut unbent = self.clone();
        for i in STRAIGHT_UNKNOWNS..UNKNOWNS {
            unbent.matrix.fill_row(i, 0.0);
            unbent.matrix.fill_column(i, 0.0);
            unbent.vector[i] = 0.0;
        }
        unbent
    }

    /// Sets the rows and columns of the bend from the points of `later`, which lie after it.
    fn set_bend(&mut self, later: &Self) {
        for i in STRAIGHT_UNKNOWNS..UNKNOWNS {
            self.matrix.set_row(i, &later.matrix.row(i));
            self.matrix.set_column(i, &later.matrix.column(i));
            self.vector[i] = later.vector[i];
        }
    }

    /// Decrease of the sum of squared heights, and the step of the unknowns.
    fn solve(&self, fit: &BendFit) -> Option<(f64, Vector)> {
        let mut matrix = self.matrix;
        let mut vector = self.vector;
        for (i, sd) in BEND_PRIOR_SD.iter().enumerate() {
            let prior =
                BEND_HEIGHT_SIGMA_M * BEND_HEIGHT_SIGMA_M * BEND_POINTS_PER_INDEPENDENT / (sd * sd);
            matrix[(i, i)] += prior;
            // The prior of the drift is centred at zero, that of the pose at its present value.
            match i {
                6 => vector[i] -= prior * fit.drift.at_zero_m,
                7 => vector[i] -= prior * fit.drift.per_m,
                _ => {}
            }
        }
        let solved = matrix.cholesky()?.solve(&vector);
        Some((vector.dot(&solved), solved))
    }
}
