//! A view that is bent at one instant: the best instant and turn are found together with the best pose.
//!
//! Point-to-plane least squares on the reference's flat places, as in registration, with more unknowns: a turn about
//! the pan axis, one about the tilt axis and a shift of the robot, which all points have from some instant on. Sums are kept per stretch of the
//! sweep, so that every instant is tried at the price of one pass.

use super::constants::{
    BEND_AGREE_M, BEND_ALIKE, BEND_GATES_M, BEND_POINTS, BEND_PRIOR_SD, BEND_SIGMA_M,
    BEND_STRETCHES, LEAST_BEND_GAIN,
};
use crate::geometry::{Landmarks, Passage, Pose, RangeDrift, Registration};
use crate::sweep::Sweep;
use nalgebra::{Point3, SMatrix, SVector, UnitQuaternion, Vector3};
use rayon::prelude::*;

/// Unknowns of a view that is not bent: six of the pose, two of the drift; and all of them.
const STRAIGHT: usize = 8;
const ALL: usize = 12;

type Matrix = SMatrix<f64, ALL, ALL>;
type Vector = SVector<f64, ALL>;

/// A bend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Share of the sweep that lies before it.
    pub after: f64,
    /// Turn about the pan axis of what lies after it, radians.
    pub pan_rad: f64,
    /// About the tilt axis, positive up.
    pub tilt_rad: f64,
    /// How far what lies after it is shifted, forward and left, metres.
    pub shift_m: [f64; 2],
    /// By how much more of the view agrees with the reference once it is bent back.
    pub gain: f64,
}

struct Sample {
    point: Point3<f64>,
    /// Tilt axis; the pan axis is z.
    axis: Vector3<f64>,
    stretch: usize,
}

/// Where a fit stands.
#[derive(Debug, Clone, Copy)]
struct Fit {
    pose: Pose,
    drift: RangeDrift,
    /// Bent from this stretch on; [`BEND_STRETCHES`]: nowhere.
    from: usize,
    /// Pan and tilt in radians, forward and left in metres.
    bend: [f64; 4],
}

/// Sums over a stretch.
#[derive(Clone)]
struct Sums {
    matrix: Matrix,
    vector: Vector,
}

/// The bend that explains `sweep` best, if any explains enough.
pub fn find(landmarks: &Landmarks, sweep: &Sweep, registration: &Registration) -> Option<Bend> {
    let samples = samples(sweep);
    let scene = Scene {
        landmarks,
        samples: &samples,
        origin: sweep.view.origin,
    };
    let start = Fit {
        pose: registration.current_from_reference.inverse(),
        drift: registration.drift,
        from: BEND_STRETCHES,
        bend: [0.0; 4],
    };
    let bent = scene.follow(start, true);
    let straight = scene.follow(start, false);
    let gain = scene.agreement(&bent) - scene.agreement(&straight).max(scene.agreement(&start));
    let after = bent.from as f64 / BEND_STRETCHES as f64;
    let smaller = after.min(1.0 - after);
    (gain >= LEAST_BEND_GAIN[0].max(LEAST_BEND_GAIN[1] * smaller) && smaller > 0.0).then(|| Bend {
        after,
        pan_rad: bent.bend[0],
        tilt_rad: bent.bend[1],
        shift_m: [bent.bend[2], bent.bend[3]],
        gain,
    })
}

fn samples(sweep: &Sweep) -> Vec<Sample> {
    let count = sweep.view.points.len();
    let step = count.div_ceil(BEND_POINTS).max(1);
    let mut samples = Vec::with_capacity(count / step + 1);
    for part in &sweep.parts {
        // A tilt up turns about the axis the other way.
        let axis = -part.tilt_axis.into_inner();
        for at in part.points.clone().step_by(step) {
            samples.extend(sweep.view.points.get(at).map(|point| Sample {
                point: *point,
                axis,
                stretch: at * BEND_STRETCHES / count.max(1),
            }));
        }
    }
    samples
}

struct Scene<'a> {
    landmarks: &'a Landmarks,
    samples: &'a [Sample],
    origin: Point3<f64>,
}

impl Scene<'_> {
    /// Where the sample lies once it is bent back.
    fn straightened(&self, sample: &Sample, fit: &Fit) -> Point3<f64> {
        if sample.stretch < fit.from {
            return sample.point;
        }
        let [pan, tilt, forward, left] = fit.bend;
        let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * pan + sample.axis * tilt);
        let shift = Vector3::new(forward, left, 0.0);
        self.origin + turn * (sample.point - self.origin) + shift
    }

    fn follow(&self, start: Fit, may_bend: bool) -> Fit {
        let mut fit = start;
        for gate_m in BEND_GATES_M {
            if let Some(next) = self.improved(&fit, gate_m, may_bend) {
                fit = next;
            }
        }
        fit
    }

    /// One pass: all places found anew, pose, drift and bend solved together, for the best instant.
    fn improved(&self, fit: &Fit, gate_m: f64, may_bend: bool) -> Option<Fit> {
        let stretches = self.sums(fit, gate_m);
        let mut all = Sums::default();
        stretches.iter().for_each(|sums| all.add(sums));
        let straight = all.unbent();
        let (mut gain, mut solved, mut from) = {
            let (gain, solved) = straight.solve(fit)?;
            (gain, solved, BEND_STRETCHES)
        };
        if may_bend {
            let mut later = Sums::default();
            for stretch in (1..BEND_STRETCHES).rev() {
                later.add(&stretches[stretch]);
                let mut sums = straight.clone();
                sums.bend_by(&later);
                if let Some((better, how)) = sums.solve(fit).filter(|(g, _)| *g > gain) {
                    (gain, solved, from) = (better, how, stretch);
                }
            }
        }
        let step = Pose::new(
            Vector3::new(solved[0], solved[1], solved[2]),
            Vector3::new(solved[3], solved[4], solved[5]),
        );
        Some(Fit {
            pose: step * fit.pose,
            drift: RangeDrift {
                at_zero_m: fit.drift.at_zero_m + solved[6],
                per_m: fit.drift.per_m + solved[7],
            },
            from,
            bend: std::array::from_fn(|i| solved[STRAIGHT + i]),
        })
    }

    fn sums(&self, fit: &Fit, gate_m: f64) -> Vec<Sums> {
        let passage = Passage::to_reference(fit.pose, fit.drift, self.origin);
        let eye = fit.pose * self.origin;
        let part = |samples: &[Sample]| {
            let mut sums = vec![Sums::default(); BEND_STRETCHES];
            for sample in samples {
                let straight = self.straightened(sample, fit);
                let place = passage.carry(&straight);
                let Some(patch) = self.landmarks.exactly(&place, gate_m) else {
                    continue;
                };
                let normal = patch.normal;
                let height_m = patch.height_m(&place);
                let ray = place - eye;
                let range_m = ray.norm().max(1e-9);
                let along = normal.dot(&ray) / range_m;
                let turn = place.coords.cross(&normal);
                let arm = straight - self.origin;
                let bent_by =
                    |axis: &Vector3<f64>| normal.dot(&(fit.pose.rotation * axis.cross(&arm)));
                let shifted_by = |axis: Vector3<f64>| normal.dot(&(fit.pose.rotation * axis));
                let bends = [
                    bent_by(&Vector3::z()),
                    bent_by(&sample.axis),
                    shifted_by(Vector3::x()),
                    shifted_by(Vector3::y()),
                ];
                // The height that the place would have unbent: the whole bend is solved for, not a further one.
                let unbent_m = if sample.stretch < fit.from {
                    height_m
                } else {
                    let bent_m: f64 = bends.iter().zip(fit.bend).map(|(b, by)| b * by).sum();
                    height_m - bent_m
                };
                let j = Vector::from([
                    normal.x,
                    normal.y,
                    normal.z,
                    turn.x,
                    turn.y,
                    turn.z,
                    along,
                    along * range_m,
                    bends[0],
                    bends[1],
                    bends[2],
                    bends[3],
                ]);
                // Tukey's biweight: what lies a gate away has no say.
                let weight = (1.0 - (height_m / gate_m).powi(2)).powi(2);
                let sums = &mut sums[sample.stretch.min(BEND_STRETCHES - 1)];
                sums.matrix += j * j.transpose() * weight;
                sums.vector -= j * (weight * unbent_m);
            }
            sums
        };
        // Parts of one size, summed in their order: the answer never depends on threads.
        let parts: Vec<Vec<Sums>> = self.samples.par_chunks(1000).map(part).collect();
        let mut total = vec![Sums::default(); BEND_STRETCHES];
        for part in &parts {
            for (sum, more) in total.iter_mut().zip(part) {
                sum.add(more);
            }
        }
        total
    }

    /// Mean over the samples of 1 - (height / gate)^2, none counting as 0.
    fn agreement(&self, fit: &Fit) -> f64 {
        let passage = Passage::to_reference(fit.pose, fit.drift, self.origin);
        let agrees = |sample: &Sample| {
            let place = passage.carry(&self.straightened(sample, fit));
            let patch = self.landmarks.exactly(&place, BEND_AGREE_M);
            patch.map_or(0.0, |patch| {
                1.0 - (patch.height_m(&place) / BEND_AGREE_M).powi(2)
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

impl Default for Sums {
    fn default() -> Self {
        Self {
            matrix: Matrix::zeros(),
            vector: Vector::zeros(),
        }
    }
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.matrix += other.matrix;
        self.vector += other.vector;
    }

    /// The same with no point bent.
    fn unbent(&self) -> Self {
        let mut unbent = self.clone();
        for i in STRAIGHT..ALL {
            unbent.matrix.fill_row(i, 0.0);
            unbent.matrix.fill_column(i, 0.0);
            unbent.vector[i] = 0.0;
        }
        unbent
    }

    /// Bends the points of `later`.
    fn bend_by(&mut self, later: &Self) {
        for i in STRAIGHT..ALL {
            self.matrix.set_row(i, &later.matrix.row(i));
            self.matrix.set_column(i, &later.matrix.column(i));
            self.vector[i] = later.vector[i];
        }
    }

    /// By how much the squares of the heights shrink, and the unknowns.
    fn solve(&self, fit: &Fit) -> Option<(f64, Vector)> {
        let mut matrix = self.matrix;
        let mut vector = self.vector;
        for (i, sd) in BEND_PRIOR_SD.iter().enumerate() {
            let pull = BEND_SIGMA_M * BEND_SIGMA_M * BEND_ALIKE / (sd * sd);
            matrix[(i, i)] += pull;
            // The drift's prior is about none, that of the pose about where it stands.
            match i {
                6 => vector[i] -= pull * fit.drift.at_zero_m,
                7 => vector[i] -= pull * fit.drift.per_m,
                _ => {}
            }
        }
        let solved = matrix.cholesky()?.solve(&vector);
        Some((vector.dot(&solved), solved))
    }
}
