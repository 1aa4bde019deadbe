//! Rigid registration: the pose of the current view in the frame of the reference, and the drift of its ranges.
//!
//! Robust point-to-plane iterations on flat patches, with a gate that narrows, from several starts; the start with the
//! highest agreement wins (docs/novelty.md section 4).

use super::constants::{POINTS_PER_TASK, SMALL_STEP};
use super::{DriftTransform, PlaneIndex, Pose, RangeDrift, RollPitchYaw, SurfacePatch, Surfaces};
use nalgebra::{Matrix3, Matrix6, Point3, Translation3, Vector3, Vector6};
use normal_equations::{MatchedPoint, NormalEquations};
use rayon::prelude::*;

mod normal_equations;
mod settings;

pub use settings::RegistrationSettings;

/// The result of a registration.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// Maps reference coordinates to current coordinates: `p_cur = R p_ref + t`.
    pub current_from_reference: Pose,
    /// What must be added to the current ranges to agree with the reference's.
    pub drift: RangeDrift,
    /// The current sensor in the frame of its view, metres.
    pub current_origin: Point3<f64>,
    /// The reference's sensor in the frame of its view, metres: what the views can turn about.
    pub reference_origin: Point3<f64>,
    /// Whether the views agree and the last step was small.
    pub converged: bool,
    /// Mean over current flat patches of 1 - (height over the reference's surface / gate)^2, 0 beyond the gate.
    pub agreement: f64,
    /// Covariance of (translation, rotation vector) of the inverse, about the reference's sensor: square metres and square
    /// radians.
    pub covariance: Matrix6<f64>,
    /// Directions that the surfaces do not fix, as text ("along (0.99, 0.05, 0.00)").
    pub unobservable: Vec<String>,
}

impl Registration {
    /// No correction, exactly known: the views share one frame.
    pub fn identity() -> Self {
        Self {
            current_from_reference: Pose::identity(),
            drift: RangeDrift::default(),
            current_origin: Point3::origin(),
            reference_origin: Point3::origin(),
            converged: true,
            agreement: 1.0,
            covariance: Matrix6::zeros(),
            unobservable: Vec::new(),
        }
    }

    /// Maps points of the current view into the reference frame.
    pub(crate) fn reference_from_current(&self) -> DriftTransform {
        DriftTransform::to_reference(
            self.current_from_reference.inverse(),
            self.drift,
            self.current_origin,
        )
    }

    /// Covariance, square metres, of a current point mapped to `p` in the reference frame: large along unobservable
    /// directions, small across them.
    pub fn covariance_at(&self, p: &Point3<f64>) -> Matrix3<f64> {
        let part = |row, column| -> Matrix3<f64> {
            self.covariance.fixed_view::<3, 3>(row, column).into_owned()
        };
        let cross = (p - self.reference_origin).cross_matrix();
        let mixed = part(0, 3) * cross;
        part(0, 0) + mixed + mixed.transpose() + cross.transpose() * part(3, 3) * cross
    }
}

/// Finds the pose between two views from their surfaces, and the drift of the ranges since the reference's visit.
/// `origins` are the sensors of reference and current view: what a robot turns about, however far from it its frame begins; `gate_m` is the distance within which surfaces count as the same in
/// the end (some three sigmas of the noise); `guess` maps reference to current coordinates.
pub(crate) fn register(
    reference: &PlaneIndex,
    current: &Surfaces,
    origins: [&Point3<f64>; 2],
    guess: &Pose,
    gate_m: f64,
    settings: &RegistrationSettings,
) -> Registration {
    let [reference_origin, current_origin] = origins;
    let matcher = Matcher {
        planes: reference,
        pivot: *reference_origin,
    };
    let plain = |pose| DriftTransform::to_reference(pose, RangeDrift::default(), *current_origin);
    let (rough, exact): (FindPatch, FindPatch) =
        (PlaneIndex::find_approximate, PlaneIndex::find_exact);
    let flat: Vec<Point3<f64>> = current
        .patches
        .iter()
        .filter(|p| p.flat)
        .map(|p| p.mean)
        .collect();
    let sample = |max_points: usize| -> Vec<Point3<f64>> {
        let step = flat.len().div_ceil(max_points.max(1)).max(1);
        flat.iter().step_by(step).copied().collect()
    };
    let (few, many) = (
        sample(settings.max_points[0]),
        sample(settings.max_points[1]),
    );
    let start = guess.inverse();
    let mut starts: Vec<(Pose, f64)> = settings
        .start_gates_m
        .iter()
        .map(|gate| (start, *gate))
        .collect();
    let mut best = (start, matcher.agreement(&few, &plain(start), gate_m, rough));
    for round in 0..2 {
        // In parallel, compared in the order of the starts: the result never depends on threads.
        let found: Vec<(Pose, f64)> = starts
            .par_iter()
            .map(|(from, first_gate_m)| {
                let pose = matcher.anneal(
                    &few,
                    *from,
                    current_origin,
                    [*first_gate_m, gate_m],
                    settings,
                );
                (pose, matcher.agreement(&few, &plain(pose), gate_m, rough))
            })
            .collect();
        for candidate in found {
            if candidate.1 > best.1 {
                best = candidate;
            }
        }
        if round == 1 || best.1 > 0.5 * (1.0 + settings.min_agreement) {
            break;
        }
        let widest = settings.start_gates_m.first().copied().unwrap_or(0.25);
        starts = settings
            .start_yaws_rad
            .iter()
            .map(|yaw| {
                let rotation = RollPitchYaw {
                    roll_rad: 0.0,
                    pitch_rad: 0.0,
                    yaw_rad: *yaw,
                }
                .with_translation([0.0; 3]);
                (start * about(current_origin, &rotation), widest)
            })
            .collect();
    }
    let (pose, drift) = matcher.refine(&many, best.0, current_origin, gate_m, settings);
    // The pose may have drifted along unobservable directions: there the guess is better.
    let transform = DriftTransform::to_reference(pose, drift, *current_origin);
    let unobserved = matcher
        .normal_equations(&many, &transform, gate_m, exact)
        .unobservable_part(&matcher.motion(&start, &pose), settings);
    let (pose, drift) = if unobserved.norm() < SMALL_STEP {
        (pose, drift)
    } else {
        let back = matcher.moved(&pose, &-unobserved);
        matcher.refine(&many, back, current_origin, gate_m, settings)
    };
    let refined = DriftTransform::to_reference(pose, drift, *current_origin);
    let normal = matcher.normal_equations(&many, &refined, gate_m, exact);
    let (last_step, _) = normal.step(Some(&drift), settings, gate_m);
    let agreement = matcher.agreement(&many, &refined, gate_m, exact);
    Registration {
        current_from_reference: pose.inverse(),
        drift,
        current_origin: *current_origin,
        reference_origin: *reference_origin,
        converged: agreement >= settings.min_agreement
            && last_step.norm() < 0.5 * gate_m
            && normal.weight > 0.0,
        agreement,
        covariance: normal.covariance(settings),
        unobservable: normal.unobservable(settings),
    }
}

/// How planes are found: fast while poses are guesses, exactly in the end.
type FindPatch = for<'a> fn(&'a PlaneIndex, &Point3<f64>, f64) -> Option<&'a SurfacePatch>;

/// Matches current points with the planes of the reference.
struct Matcher<'a> {
    planes: &'a PlaneIndex,
    /// Rotations are about this point of the reference frame: about one far away, they would be long ways.
    pivot: Point3<f64>,
}

impl Matcher<'_> {
    /// Mean over the points of 1 - (height / gate)^2, with 0 for points without a plane.
    fn agreement(
        &self,
        points: &[Point3<f64>],
        transform: &DriftTransform,
        gate_m: f64,
        find: FindPatch,
    ) -> f64 {
        let sum: f64 = points
            .iter()
            .map(|p| {
                let p = transform.apply(p);
                find(self.planes, &p, gate_m).map_or(0.0, |patch| {
                    let e = patch.height_m(&p) / gate_m;
                    1.0 - e * e
                })
            })
            .sum();
        sum / (points.len() as f64).max(1.0)
    }

    /// Iterates while the gate narrows from the first to the last, without drift.
    fn anneal(
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
    fn refine(
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
    fn moved(&self, pose: &Pose, step: &Vector6<f64>) -> Pose {
        about(&self.pivot, &exponential(step)) * pose
    }

    /// The step that leads from pose `from` to pose `to`.
    fn motion(&self, from: &Pose, to: &Pose) -> Vector6<f64> {
        let back = Translation3::from(-self.pivot.coords);
        logarithm(&(back * (to * from.inverse()) * back.inverse()))
    }

    fn normal_equations(
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
                let p = transform.apply(p);
                if let Some(patch) = find(self.planes, &p, gate_m) {
                    let ray = p - sensor;
                    let range_m = ray.norm().max(1e-9);
                    let matched = MatchedPoint {
                        lever: p - self.pivot,
                        ray: ray / range_m,
                        range_m,
                        height_m: patch.height_m(&p),
                        normal: patch.normal,
                    };
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
}

/// `motion`, of which the rotation is about `pivot`.
fn about(pivot: &Point3<f64>, motion: &Pose) -> Pose {
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

#[cfg(test)]
mod tests {
    use super::{RegistrationSettings, register};
    use crate::geometry::{PlaneIndex, Pose, RollPitchYaw, Surfaces};
    use nalgebra::{Point3, Translation3};
    use proptest::prelude::*;

    /// A box room with a cupboard, 5 m x 4 m x 2.5 m, sampled on its surfaces.
    fn room() -> Vec<Point3<f64>> {
        let mut points = Vec::new();
        let n = 60;
        for i in 0..n {
            for j in 0..n {
                let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                points.push(Point3::new(-2.0 + 5.0 * u, -2.0 + 4.0 * v, -1.0));
                points.push(Point3::new(-2.0, -2.0 + 4.0 * u, -1.0 + 2.5 * v));
                points.push(Point3::new(3.0, -2.0 + 4.0 * u, -1.0 + 2.5 * v));
                points.push(Point3::new(-2.0 + 5.0 * u, 2.0, -1.0 + 2.5 * v));
                points.push(Point3::new(-2.0 + 5.0 * u, -2.0, -1.0 + 2.5 * v));
                if i < 20 && j < 30 {
                    points.push(Point3::new(1.0 + 2.0 * u, 1.5, -1.0 + 2.0 * v));
                }
            }
        }
        points
    }

    fn plane_index(points: &[Point3<f64>]) -> PlaneIndex {
        PlaneIndex::new(&surfaces(points))
    }

    fn surfaces(points: &[Point3<f64>]) -> Surfaces {
        Surfaces::fit(points, &Point3::origin(), 0.02, 0.0, 0.08)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn poses_of_a_quarter_metre_and_ten_degrees_are_found(
            x in -0.17..0.17, y in -0.17..0.17, yaw in -0.17..0.17, tilt in -0.03..0.03,
        ) {
            let truth = RollPitchYaw { roll_rad: tilt, pitch_rad: -tilt, yaw_rad: yaw }
                .with_translation([x, y, 0.02]);
            let reference = room();
            let current: Vec<_> = reference.iter().map(|p| truth * p).collect();
            let found = register(
                &plane_index(&reference), &surfaces(&current), [&Point3::origin(), &(truth * Point3::origin())],
                &Pose::identity(), 0.03,
                &RegistrationSettings::default(),
            );
            let off = found.current_from_reference * truth.inverse();
            prop_assert!(found.converged);
            prop_assert!(found.unobservable.is_empty(), "{:?}", found.unobservable);
            prop_assert!(off.translation.vector.norm() < 0.005, "{off}");
            prop_assert!(off.rotation.angle() < 0.003);
        }
    }

    #[test]
    fn where_the_frame_begins_does_not_matter() {
        let turn = RollPitchYaw {
            roll_rad: 0.01,
            pitch_rad: 0.0,
            yaw_rad: 0.1,
        }
        .with_translation([0.1, -0.05, 0.02]);
        let sensor = [Point3::origin(), turn * Point3::origin()];
        let (reference, settings) = (room(), RegistrationSettings::default());
        let found = [[0.0, 0.0, 0.0], [30.0, 10.0, 0.0], [-2000.0, 700.0, 50.0]].map(|shift| {
            let shift = Translation3::from(shift);
            let place: Vec<_> = reference.iter().map(|p| shift * p).collect();
            let current: Vec<_> = reference.iter().map(|p| shift * (turn * p)).collect();
            let origins = sensor.map(|p| shift * p);
            let surfaces = |points: &[Point3<f64>], at| Surfaces::fit(points, at, 0.02, 0.0, 0.08);
            let found = register(
                &PlaneIndex::new(&surfaces(&place, &origins[0])),
                &surfaces(&current, &origins[1]),
                [&origins[0], &origins[1]],
                &Pose::identity(),
                0.03,
                &settings,
            );
            let off = shift.inverse() * found.current_from_reference * shift * turn.inverse();
            assert!(found.converged && found.unobservable.is_empty());
            assert!(off.translation.vector.norm() < 0.005 && off.rotation.angle() < 0.003);
            found.covariance_at(&(shift * Point3::new(3.0, 0.0, 0.0)))
        });
        for covariance in &found[1..] {
            assert!((covariance - found[0]).norm() < 0.2 * found[0].norm());
        }
    }

    #[test]
    fn drift_of_ranges_is_separated_from_the_pose() {
        let truth = RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: 0.035,
        }
        .with_translation([0.04, -0.03, 0.0]);
        let (reference, origin) = (room(), truth * Point3::origin());
        for longer in [(0.015, 0.0), (0.0, 0.003)] {
            let current: Vec<_> = reference
                .iter()
                .map(|p| {
                    let v = truth * p - origin;
                    origin + v * (1.0 + longer.0 / v.norm() + longer.1)
                })
                .collect();
            let found = register(
                &plane_index(&reference),
                &surfaces(&current),
                [&Point3::origin(), &origin],
                &Pose::identity(),
                0.03,
                &RegistrationSettings::default(),
            );
            let off = found.current_from_reference * truth.inverse();
            assert!(
                off.translation.vector.norm() < 0.01 && off.rotation.angle() < 0.002,
                "{off}"
            );
            let drift_m = found.drift.at_zero_m + 2.5 * found.drift.per_m;
            assert!(
                (drift_m + longer.0 + 2.5 * longer.1).abs() < 0.003,
                "{:?}",
                found.drift
            );
        }
    }

    #[test]
    fn an_endless_corridor_is_unobservable_along_its_axis() {
        let corridor: Vec<_> = room()
            .into_iter()
            .filter(|p| p.x > -1.9 && p.x < 2.9 && p.y != 1.5)
            .collect();
        let s = surfaces(&corridor);
        let found = register(
            &PlaneIndex::new(&s),
            &s,
            [&Point3::origin(); 2],
            &Pose::identity(),
            0.03,
            &RegistrationSettings::default(),
        );
        assert!(found.current_from_reference.translation.vector.norm() < 2e-3);
        assert_eq!(found.unobservable.len(), 1, "{:?}", found.unobservable);
    }
}
