//! Lays points of the current view on the planes of the reference.

use super::agreement::Witnesses;
use super::covariance::MatchBlock;
use super::normal_equations::{MatchedPoint, NormalEquations};
use super::settings::RegistrationSettings;
use crate::geometry::constants::{POINTS_PER_TASK, SMALL_STEP};
use crate::geometry::{DriftTransform, PlaneIndex, Pose, RangeDrift, SurfacePatch};
use nalgebra::{Point3, Translation3, Vector3, Vector6};
use rayon::prelude::*;

/// How planes are found: fast while poses are guesses, exactly in the end.
pub(super) type FindPatch =
    for<'a> fn(&'a PlaneIndex, &Point3<f64>, f64) -> Option<&'a SurfacePatch>;

/// Matches current points with the planes of the reference.
pub(super) struct Matcher<'a> {
    pub(super) planes: &'a PlaneIndex,
    /// Rotations are about this point of the reference frame: about one far away, they would be long ways.
    pub(super) pivot: Point3<f64>,
}

impl Matcher<'_> {
    /// 1 - (height over the reference's surface / gate)^2 of a point in the reference's frame, 0 without a surface.
    pub(super) fn agrees(&self, p: &Point3<f64>, gate_m: f64, find: FindPatch) -> f64 {
        find(self.planes, p, gate_m).map_or(0.0, |patch| {
            let e = patch.height_m(p) / gate_m;
            1.0 - e * e
        })
    }

    /// Iterates while the gate narrows from the first to the last, without drift.
    pub(super) fn anneal(
        &self,
        points: &[Point3<f64>],
        from: Pose,
        origin: &Point3<f64>,
        [first_gate_m, last_gate_m]: [f64; 2],
        settings: &RegistrationSettings,
    ) -> Pose {
        let mut pose = from;
        let mut gate_m = first_gate_m.max(last_gate_m);
        loop {
            for _ in 0..settings.iterations {
                let transform = DriftTransform::to_reference(pose, RangeDrift::default(), *origin);
                let normal =
                    self.normal_equations(points, &transform, gate_m, PlaneIndex::find_approximate);
                let (step, _) = normal.step(None, settings, gate_m);
                pose = self.moved(&pose, &step);
                if step.norm() < SMALL_STEP {
                    break;
                }
            }
            if gate_m <= last_gate_m {
                return pose;
            }
            gate_m = (gate_m * settings.gate_factor).max(last_gate_m);
        }
    }

    /// The last stage: planes found exactly, pose and drift together.
    pub(super) fn refine(
        &self,
        points: &[Point3<f64>],
        from: Pose,
        origin: &Point3<f64>,
        gate_m: f64,
        settings: &RegistrationSettings,
    ) -> (Pose, RangeDrift) {
        let (mut pose, mut drift) = (from, RangeDrift::default());
        for _ in 0..settings.last_iterations {
            let transform = DriftTransform::to_reference(pose, drift, *origin);
            let normal = self.normal_equations(points, &transform, gate_m, PlaneIndex::find_exact);
            let (step, more) = normal.step(Some(&drift), settings, gate_m);
            pose = self.moved(&pose, &step);
            drift.at_zero_m += more.at_zero_m;
            drift.per_m += more.per_m;
            if step.norm() < SMALL_STEP {
                break;
            }
        }
        (pose, drift)
    }

    /// `pose` after the step (translation, rotation vector about the pivot).
    pub(super) fn moved(&self, pose: &Pose, step: &Vector6<f64>) -> Pose {
        about(&self.pivot, &exponential(step)) * pose
    }

    /// The step that leads from pose `from` to pose `to`.
    pub(super) fn motion(&self, from: &Pose, to: &Pose) -> Vector6<f64> {
        let back = Translation3::from(-self.pivot.coords);
        logarithm(&(back * (to * from.inverse()) * back.inverse()))
    }

    pub(super) fn normal_equations(
        &self,
        points: &[Point3<f64>],
        transform: &DriftTransform,
        gate_m: f64,
        find: FindPatch,
    ) -> NormalEquations {
        let sensor = transform.pose * transform.origin();
        let part = |points: &[Point3<f64>]| {
            let mut sums = NormalEquations::new();
            for p in points {
                if let Some(matched) = self.matched(transform.apply(p), &sensor, gate_m, find) {
                    sums.add(&matched, gate_m);
                }
            }
            sums
        };
        // Parts of one size, summed in their order: the result never depends on threads.
        let parts: Vec<NormalEquations> = points.par_chunks(POINTS_PER_TASK).map(part).collect();
        parts
            .iter()
            .fold(NormalEquations::new(), NormalEquations::merged)
    }

    /// The matches of each block of a view, with planes found exactly.
    pub(super) fn blocks(
        &self,
        view: &Witnesses,
        transform: &DriftTransform,
        gate_m: f64,
    ) -> Vec<MatchBlock> {
        let sensor = transform.pose * transform.origin();
        let mut blocks: Vec<MatchBlock> = (0..view.block_shares.mean.len())
            .map(|_| MatchBlock::new())
            .collect();
        for (p, block) in view.points.iter().zip(&view.blocks) {
            let at = transform.apply(p);
            if let Some(matched) = self.matched(at, &sensor, gate_m, PlaneIndex::find_exact) {
                blocks[*block as usize].add(&matched, gate_m);
            }
        }
        blocks
    }

    /// What `p` in the reference's frame says, seen from `sensor`, if it matches a plane.
    fn matched(
        &self,
        p: Point3<f64>,
        sensor: &Point3<f64>,
        gate_m: f64,
        find: FindPatch,
    ) -> Option<MatchedPoint> {
        let patch = find(self.planes, &p, gate_m)?;
        let ray = p - sensor;
        let range_m = ray.norm().max(1e-9);
        Some(MatchedPoint {
            lever: p - self.pivot,
            ray: ray / range_m,
            range_m,
            height_m: patch.height_m(&p),
            normal: patch.normal,
        })
    }
}

/// `motion`, of which the rotation is about `pivot`.
pub(super) fn about(pivot: &Point3<f64>, motion: &Pose) -> Pose {
    let there = Translation3::from(pivot.coords);
    there * motion * there.inverse()
}

/// The pose of (translation, rotation vector).
fn exponential(step: &Vector6<f64>) -> Pose {
    Pose::new(
        Vector3::new(step[0], step[1], step[2]),
        Vector3::new(step[3], step[4], step[5]),
    )
}

/// The inverse of [`exponential`].
fn logarithm(pose: &Pose) -> Vector6<f64> {
    let (shift, rotation) = (pose.translation.vector, pose.rotation.scaled_axis());
    Vector6::new(
        shift.x, shift.y, shift.z, rotation.x, rotation.y, rotation.z,
    )
}
