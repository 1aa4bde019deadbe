//! Rigid registration: the pose of the current view in the frame of the reference, and the drift of its ranges.
//!
//! Robust point-to-plane iterations on flat patches, with a gate that narrows, from several starts; the start with the
//! highest agreement wins (docs/novelty.md section 4).

use super::constants::SMALL_STEP;
use super::{DriftTransform, PlaneIndex, Pose, RangeDrift, Surfaces};
use agreement::Witnesses;
use covariance::covariance;
use matcher::{FindPatch, Matcher};
use nalgebra::{Matrix3, Matrix6, Point3};
use search::search;

mod agreement;
mod covariance;
mod matcher;
mod normal_equations;
mod search;
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
    /// The same where every direction that the surfaces fix counts alike: a floor agrees with itself wherever on it a robot is.
    pub agreement_by_direction: f64,
    /// Another pose that explains the view as well, if there is one: then nothing is known of either.
    pub rival: Option<Pose>,
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
            agreement_by_direction: 1.0,
            rival: None,
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
/// `origins` are the sensors of reference and current view: what a robot turns about, however far from it its frame begins;
/// `gate_m` is the distance within which surfaces count as the same in the end (some three sigmas of the noise); `guess` maps
/// reference to current coordinates.
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
    let exact: FindPatch = PlaneIndex::find_exact;
    let [few, many] = settings
        .max_points
        .map(|n| Witnesses::new(current, current_origin, n, settings));
    let start = guess.inverse();
    let found = search(&matcher, &few, start, current_origin, gate_m, settings);
    let many_points = &many.points;
    let (pose, drift) = matcher.refine(many_points, found.pose, current_origin, gate_m, settings);
    // The pose may have drifted along unobservable directions: there the guess is better.
    let transform = DriftTransform::to_reference(pose, drift, *current_origin);
    let unobserved = matcher
        .normal_equations(many_points, &transform, gate_m, exact)
        .unobservable_part(&matcher.motion(&start, &pose), settings);
    let (pose, drift) = if unobserved.norm() < SMALL_STEP {
        (pose, drift)
    } else {
        let back = matcher.moved(&pose, &-unobserved);
        matcher.refine(many_points, back, current_origin, gate_m, settings)
    };
    let refined = DriftTransform::to_reference(pose, drift, *current_origin);
    let normal = matcher.normal_equations(many_points, &refined, gate_m, exact);
    let blocks = matcher.blocks(&many, &refined, gate_m);
    let way = pose * current_origin - reference_origin;
    let (last_step, _) = normal.step(Some(&drift), settings, gate_m);
    let agreement = many.agreement(|p| matcher.agrees(&refined.apply(p), gate_m, exact));
    Registration {
        current_from_reference: pose.inverse(),
        drift,
        current_origin: *current_origin,
        reference_origin: *reference_origin,
        rival: found.rival.map(|pose| pose.inverse()),
        converged: found.rival.is_none()
            && agreement.mean >= settings.min_agreement
            && agreement.by_direction >= settings.min_agreement_by_direction
            && last_step.norm() < 0.5 * gate_m
            && normal.weight > 0.0,
        agreement: agreement.mean,
        agreement_by_direction: agreement.by_direction,
        covariance: covariance(&blocks, &way, settings),
        unobservable: normal.unobservable(settings),
    }
}

#[cfg(test)]
mod tests {
    use super::{RegistrationSettings, register};
    use crate::geometry::{PlaneIndex, Pose, RollPitchYaw, Surfaces};
    use nalgebra::{Point3, Translation3, Vector6};
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::collections::HashMap;

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

    /// `current` was seen from where `truth` moves the reference's sensor.
    fn registered(
        reference: &[Point3<f64>],
        current: &[Point3<f64>],
        truth: &Pose,
    ) -> super::Registration {
        register(
            &plane_index(reference),
            &surfaces(current),
            [&Point3::origin(), &(truth * Point3::origin())],
            &Pose::identity(),
            0.03,
            &RegistrationSettings::default(),
        )
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
            let found = registered(&reference, &current, &truth);
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
            let found = registered(&reference, &current, &truth);
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
        let found = registered(&corridor, &corridor, &Pose::identity());
        assert!(found.current_from_reference.translation.vector.norm() < 2e-3);
        assert_eq!(found.unobservable.len(), 1, "{:?}", found.unobservable);
    }

    /// A floor of 8 m x 8 m around the origin, and boxes of 1.2 m x 0.8 m x 2.4 m on it, each with the middle of its floor plan.
    fn hall(boxes: &[[f64; 2]]) -> Vec<Point3<f64>> {
        let steps = |from: f64, to: f64| {
            let n = ((to - from) / 0.04).round() as usize;
            (0..=n).map(move |i| from + (to - from) * i as f64 / n as f64)
        };
        let mut points: Vec<_> = steps(-4.0, 4.0)
            .flat_map(|x| steps(-4.0, 4.0).map(move |y| Point3::new(x, y, -0.8)))
            .collect();
        for [x, y] in boxes {
            for z in steps(-0.8, 1.6) {
                for side in [-1.0, 1.0] {
                    points.extend(steps(-0.6, 0.6).map(|u| Point3::new(x + u, y + 0.4 * side, z)));
                    points.extend(steps(-0.4, 0.4).map(|v| Point3::new(x + 0.6 * side, y + v, z)));
                }
            }
        }
        points
    }

    fn moved(x: f64, y: f64, yaw_deg: f64) -> Pose {
        RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: yaw_deg.to_radians(),
        }
        .with_translation([x, y, 0.0])
    }

    #[test]
    fn a_hall_of_few_things_is_registered_from_afar() {
        let reference = hall(&[[2.0, 1.2], [-1.0, 2.4], [1.0, -2.1]]);
        for truth in [moved(0.2, -0.2, 14.0), moved(-0.1, 0.25, -12.0)] {
            let current: Vec<_> = reference.iter().map(|p| truth * p).collect();
            let found = registered(&reference, &current, &truth);
            let off = found.current_from_reference * truth.inverse();
            assert!(found.converged && found.rival.is_none());
            assert!(off.translation.vector.norm() < 0.01, "{off}");
            assert!(off.rotation.angle() < 0.005, "{off}");
        }
    }

    #[test]
    fn a_floor_alone_does_not_make_two_views_match() {
        let reference = hall(&[[2.0, 1.2], [-1.0, 2.4], [1.0, -2.1]]);
        // Other things on the same floor.
        let current = hall(&[[-2.4, -1.0], [2.6, -0.8], [-0.2, -3.1]]);
        let found = registered(&reference, &current, &Pose::identity());
        assert!(found.agreement > 0.6, "{}", found.agreement);
        assert!(
            found.agreement_by_direction < 0.55,
            "{}",
            found.agreement_by_direction
        );
        assert!(!found.converged);
    }

    #[test]
    fn two_poses_that_explain_a_view_alike_are_rivals() {
        // A round hall of 12 walls, 30 deg from one to the next.
        let mut round = hall(&[]);
        round.retain(|p| p.xy().coords.norm() < 3.0);
        for k in 0..12 {
            let turn = moved(0.0, 0.0, 30.0 * f64::from(k));
            for i in -19..=19 {
                for j in 0..=60 {
                    let wall = Point3::new(3.0, 0.042 * f64::from(i), 0.04 * f64::from(j) - 0.8);
                    round.push(turn * wall);
                }
            }
        }
        let with = |boxes: &[[f64; 2]]| -> Vec<Point3<f64>> {
            let things = hall(boxes).into_iter().filter(|p| p.z > -0.8);
            round.iter().copied().chain(things).collect()
        };
        let half = moved(0.0, 0.0, 15.0);
        let turned = |points: Vec<Point3<f64>>| -> Vec<Point3<f64>> {
            points.iter().map(|p| half * p).collect()
        };
        // With other things in it, nothing says which way it was turned.
        let reference = with(&[[1.5, 0.8], [-0.6, -1.7]]);
        let current = turned(with(&[[-1.4, 1.1], [1.6, -1.0]]));
        let found = registered(&reference, &current, &half);
        let rival = found.rival.expect("a rival");
        let apart = (rival.inverse() * found.current_from_reference)
            .rotation
            .angle();
        assert!(apart.to_degrees() > 20.0, "{apart}");
        assert!(!found.converged);
        // With the same things in it, they do.
        let found = registered(&reference, &turned(reference.clone()), &half);
        let off = (found.current_from_reference * half.inverse()).rotation;
        assert!(found.converged && found.rival.is_none());
        assert!(off.angle() < 0.005, "{off}");
    }

    #[test]
    fn the_stated_covariance_holds_where_neighbours_err_together() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (reference, planes) = (room(), plane_index(&room()));
        let mut within = 0;
        for _ in 0..40 {
            // Every piece of 0.4 m is off by an error of its own, 5 mm in standard deviation.
            let mut errors: HashMap<[i32; 3], f64> = HashMap::new();
            let mut normal = |key: [i32; 3]| {
                *errors.entry(key).or_insert_with(|| {
                    let sum: f64 = (0..12).map(|_| rng.random::<f64>()).sum();
                    0.005 * (sum - 6.0)
                })
            };
            let current: Vec<_> = reference
                .iter()
                .map(|p| {
                    let e = normal([p.x, p.y, p.z].map(|c| (c / 0.4).floor() as i32));
                    p + p.coords.normalize() * e
                })
                .collect();
            let found = register(
                &planes,
                &surfaces(&current),
                [&Point3::origin(); 2],
                &Pose::identity(),
                0.03,
                &RegistrationSettings::default(),
            );
            let off = found.current_from_reference.inverse();
            let (shift, turn) = (off.translation.vector, off.rotation.scaled_axis());
            let error = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
            let inverse = found.covariance.try_inverse().expect("a covariance");
            // The .95 quantile of chi-square with six degrees of freedom.
            within += usize::from(error.dot(&(inverse * error)) < 12.59);
        }
        // 38 are expected; fewer than 33 have a chance of 1 in 1,000.
        assert!(within >= 33, "{within} of 40");
    }
}
