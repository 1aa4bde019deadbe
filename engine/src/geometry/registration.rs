//! Rigid registration: where did the current view stand, seen from the reference?
//!
//! Robust point-to-plane iterations on flat places, with a gate that narrows, from several starts;
//! the start that explains the largest share of the current surface wins.

use super::{Landmarks, Passage, Patch, Pose, RangeDrift, RollPitchYaw, Surfaces};
use nalgebra::{Matrix3, Matrix6, Point3, Vector3, Vector6};
use normal::NormalEquations;
use rayon::prelude::*;

mod normal;

/// A step shorter than this changes nothing, metres and radians.
const SMALL_STEP: f64 = 3e-5;

/// Places that one task sums up.
const PLACES_PER_TASK: usize = 1500;

/// What decides in a registration.
#[derive(Debug, Clone, PartialEq)]
pub struct RegistrationSettings {
    /// First gates of the starts, metres: how far surfaces may lie apart at first.
    pub start_gates_m: Vec<f64>,
    /// Yaws of further starts, radians, tried only where the plain starts explain little.
    pub start_yaws_rad: Vec<f64>,
    /// Factor by which the gate narrows at each stage.
    pub narrowing: f64,
    /// Iterations per stage.
    pub iterations: usize,
    /// Iterations of the last stage, which also settles the drift, at most.
    pub last_iterations: usize,
    /// Most current places used while the gate is wide, and at the last stage.
    pub places: [usize; 2],
    /// Share of explained current surface below which the views do not show the same place. Simulated quiet pairs lie
    /// at 0.86-0.96 (`tests/gates.rs`); half of that leaves room for what changed.
    pub least_share: f64,
    /// A direction is unobservable if less than this share of the surface resists moving along it.
    pub least_resistance: f64,
    /// How well the robot stops at a waypoint, one standard deviation: holds what surfaces do not.
    pub prior_sd_m: f64,
    /// The same for its heading, radians.
    pub prior_sd_rad: f64,
    /// How far all ranges may have drifted between two visits, one standard deviation.
    pub drift_sd_m: f64,
    /// The same per metre of range.
    pub drift_sd_per_m: f64,
}

impl Default for RegistrationSettings {
    fn default() -> Self {
        Self {
            // Gates of design section 5, with a wide one for turns of 10 deg seen at 5 m.
            start_gates_m: vec![0.8, 0.25, 0.08, 0.03],
            start_yaws_rad: [-8.0_f64, -4.0, 4.0, 8.0].map(f64::to_radians).to_vec(),
            narrowing: 0.6,
            iterations: 3,
            last_iterations: 8,
            places: [1200, 6000],
            least_share: 0.4,
            least_resistance: 0.004,
            prior_sd_m: 0.1,
            prior_sd_rad: 0.05,
            // The makers' bounds of the ranges are 10 mm and 1 %: the first as one deviation (a cold start may drift by
            // 15 mm), the second as three, for most of it is a bias of the one sensor that both visits share.
            drift_sd_m: 0.01,
            drift_sd_per_m: 0.003,
        }
    }
}

/// The outcome of a registration.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// Maps reference coordinates to current coordinates: `p_cur = R p_ref + t`.
    pub current_from_reference: Pose,
    /// What the current ranges lack (or have too much) against the reference's.
    pub drift: RangeDrift,
    /// Where the current sensor stood, in its view's frame, metres.
    pub current_origin: Point3<f64>,
    /// Whether the views agree after it and the last step was small.
    pub converged: bool,
    /// Share of current flat places that lie on the reference's surfaces.
    pub share: f64,
    /// Covariance of (translation, rotation vector) of the inverse, about the reference's frame:
    /// square metres and square radians.
    pub covariance: Matrix6<f64>,
    /// Directions that the surfaces do not fix, in words ("along (0.99, 0.05, 0.00)").
    pub unobservable: Vec<String>,
}

impl Registration {
    /// No correction at all, exactly known: the views share one frame.
    pub fn identity() -> Self {
        Self {
            current_from_reference: Pose::identity(),
            drift: RangeDrift::default(),
            current_origin: Point3::origin(),
            converged: true,
            share: 1.0,
            covariance: Matrix6::zeros(),
            unobservable: Vec::new(),
        }
    }

    /// Carries places of the current view into the reference's frame.
    pub fn reference_from_current(&self) -> Passage {
        Passage::to_reference(
            self.current_from_reference.inverse(),
            self.drift,
            self.current_origin,
        )
    }

    /// Covariance, square metres, of a current place carried to `p` in the reference's frame: far along what the
    /// surfaces leave open, small across it.
    pub fn covariance_at(&self, p: &Point3<f64>) -> Matrix3<f64> {
        let part = |row, column| -> Matrix3<f64> {
            self.covariance.fixed_view::<3, 3>(row, column).into_owned()
        };
        let turn = p.coords.cross_matrix();
        let mixed = part(0, 3) * turn;
        part(0, 0) + mixed + mixed.transpose() + turn.transpose() * part(3, 3) * turn
    }
}

/// Finds the pose between two views from their surfaces, and by how much the ranges drifted since the reference's visit;
/// `current_origin` is where the current sensor stood, `gate_m` is the distance within which
/// surfaces count as the same at the end (some three sigmas of the noise). `current` may be known
/// to stand off: `guess` maps reference to current coordinates.
pub fn register(
    reference: &Landmarks,
    current: &Surfaces,
    current_origin: &Point3<f64>,
    guess: &Pose,
    gate_m: f64,
    settings: &RegistrationSettings,
) -> Registration {
    let scene = Scene(reference);
    let plain = |pose| Passage::to_reference(pose, RangeDrift::default(), *current_origin);
    let (rough, exact): (Find, Find) = (Landmarks::roughly, Landmarks::exactly);
    let flat: Vec<Point3<f64>> = current
        .patches
        .iter()
        .filter(|p| p.flat)
        .map(|p| p.mean)
        .collect();
    let every = |most: usize| -> Vec<Point3<f64>> {
        let step = flat.len().div_ceil(most.max(1)).max(1);
        flat.iter().step_by(step).copied().collect()
    };
    let (few, many) = (every(settings.places[0]), every(settings.places[1]));
    let start = guess.inverse();
    let mut starts: Vec<(Pose, f64)> = settings
        .start_gates_m
        .iter()
        .map(|gate| (start, *gate))
        .collect();
    let mut best = (start, scene.agreement(&few, &plain(start), gate_m, rough));
    for round in 0..2 {
        // In parallel, judged in the order of the starts: the answer never depends on threads.
        let found: Vec<(Pose, f64)> = starts
            .par_iter()
            .map(|(from, first_gate_m)| {
                let pose = scene.anneal(
                    &few,
                    *from,
                    current_origin,
                    [*first_gate_m, gate_m],
                    settings,
                );
                (pose, scene.agreement(&few, &plain(pose), gate_m, rough))
            })
            .collect();
        for candidate in found {
            if candidate.1 > best.1 {
                best = candidate;
            }
        }
        if round == 1 || best.1 > 0.5 * (1.0 + settings.least_share) {
            break;
        }
        let widest = settings.start_gates_m.first().copied().unwrap_or(0.25);
        starts = settings
            .start_yaws_rad
            .iter()
            .map(|yaw| {
                let turn = RollPitchYaw {
                    roll_rad: 0.0,
                    pitch_rad: 0.0,
                    yaw_rad: *yaw,
                }
                .with_translation([0.0; 3]);
                (start * turn, widest)
            })
            .collect();
    }
    let (pose, drift) = scene.settle(&many, best.0, current_origin, gate_m, settings);
    // On the way here the pose may have walked along what the surfaces hardly fix: there the guess is better.
    let at = Passage::to_reference(pose, drift, *current_origin);
    let walked = scene
        .normal_equations(&many, &at, gate_m, exact)
        .along_left_open(&logarithm(&(pose * start.inverse())), settings);
    let (pose, drift) = if walked.norm() < SMALL_STEP {
        (pose, drift)
    } else {
        let back = exponential(&-walked) * pose;
        scene.settle(&many, back, current_origin, gate_m, settings)
    };
    let settled = Passage::to_reference(pose, drift, *current_origin);
    let normal = scene.normal_equations(&many, &settled, gate_m, exact);
    let (last_step, _) = normal.step(Some(&drift), settings, gate_m);
    let share = scene.agreement(&many, &settled, gate_m, exact);
    Registration {
        current_from_reference: pose.inverse(),
        drift,
        current_origin: *current_origin,
        converged: share >= settings.least_share
            && last_step.norm() < 0.5 * gate_m
            && normal.weight > 0.0,
        share,
        covariance: normal.covariance(settings),
        unobservable: normal.unobservable(settings),
    }
}

/// Derivative of a place's height over a plane with normal `u` by (translation, rotation vector).
fn jacobian(u: &Vector3<f64>, p: &Point3<f64>) -> Vector6<f64> {
    let turn = p.coords.cross(u);
    Vector6::new(u.x, u.y, u.z, turn.x, turn.y, turn.z)
}

/// How planes are found: fast while poses are guesses, exactly in the end.
type Find = for<'a> fn(&'a Landmarks, &Point3<f64>, f64) -> Option<&'a Patch>;

/// What is asked of the reference.
struct Scene<'a>(&'a Landmarks);

impl Scene<'_> {
    /// Mean over the places of 1 - (height / gate)^2, none counting as 0: high where many places
    /// lie well on the reference's surfaces.
    fn agreement(&self, places: &[Point3<f64>], passage: &Passage, gate_m: f64, find: Find) -> f64 {
        let sum: f64 = places
            .iter()
            .map(|p| {
                let p = passage.carry(p);
                find(self.0, &p, gate_m).map_or(0.0, |patch| {
                    let e = patch.height_m(&p) / gate_m;
                    1.0 - e * e
                })
            })
            .sum();
        sum / (places.len() as f64).max(1.0)
    }

    /// Follows the gate from the first to the last, ranges taken as they are.
    fn anneal(
        &self,
        places: &[Point3<f64>],
        from: Pose,
        origin: &Point3<f64>,
        [first_gate_m, last_gate_m]: [f64; 2],
        settings: &RegistrationSettings,
    ) -> Pose {
        let mut pose = from;
        let mut gate_m = first_gate_m.max(last_gate_m);
        loop {
            for _ in 0..settings.iterations {
                let at = Passage::to_reference(pose, RangeDrift::default(), *origin);
                let normal = self.normal_equations(places, &at, gate_m, Landmarks::roughly);
                let (step, _) = normal.step(None, settings, gate_m);
                pose = exponential(&step) * pose;
                if step.norm() < SMALL_STEP {
                    break;
                }
            }
            if gate_m <= last_gate_m {
                return pose;
            }
            gate_m = (gate_m * settings.narrowing).max(last_gate_m);
        }
    }

    /// The last stage: planes found exactly, pose and drift together.
    fn settle(
        &self,
        places: &[Point3<f64>],
        from: Pose,
        origin: &Point3<f64>,
        gate_m: f64,
        settings: &RegistrationSettings,
    ) -> (Pose, RangeDrift) {
        let (mut pose, mut drift) = (from, RangeDrift::default());
        for _ in 0..settings.last_iterations {
            let at = Passage::to_reference(pose, drift, *origin);
            let normal = self.normal_equations(places, &at, gate_m, Landmarks::exactly);
            let (step, more) = normal.step(Some(&drift), settings, gate_m);
            pose = exponential(&step) * pose;
            drift.at_zero_m += more.at_zero_m;
            drift.per_m += more.per_m;
            if step.norm() < SMALL_STEP {
                break;
            }
        }
        (pose, drift)
    }

    fn normal_equations(
        &self,
        places: &[Point3<f64>],
        passage: &Passage,
        gate_m: f64,
        find: Find,
    ) -> NormalEquations {
        let eye = passage.pose * passage.origin();
        let part = |places: &[Point3<f64>]| {
            let mut sums = NormalEquations::new();
            for p in places {
                let p = passage.carry(p);
                if let Some(patch) = find(self.0, &p, gate_m) {
                    let ray = p - eye;
                    let range_m = ray.norm().max(1e-9);
                    sums.add(&p, &(ray / range_m), range_m, patch, gate_m);
                }
            }
            sums
        };
        // Parts of one size, summed in their order: the answer never depends on threads.
        let parts: Vec<NormalEquations> = places.par_chunks(PLACES_PER_TASK).map(part).collect();
        parts
            .iter()
            .fold(NormalEquations::new(), NormalEquations::joined)
    }
}

fn exponential(step: &Vector6<f64>) -> Pose {
    Pose::new(
        Vector3::new(step[0], step[1], step[2]),
        Vector3::new(step[3], step[4], step[5]),
    )
}

/// The inverse of [`exponential`].
fn logarithm(pose: &Pose) -> Vector6<f64> {
    let (shift, turn) = (pose.translation.vector, pose.rotation.scaled_axis());
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

#[cfg(test)]
mod tests {
    use super::{RegistrationSettings, register};
    use crate::geometry::{Landmarks, Pose, RollPitchYaw, Surfaces};
    use nalgebra::Point3;
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

    fn landmarks(points: &[Point3<f64>]) -> Landmarks {
        Landmarks::of(&surfaces(points))
    }

    fn surfaces(points: &[Point3<f64>]) -> Surfaces {
        Surfaces::of(points, &Point3::origin(), 0.02, 0.0, 0.08)
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
                &landmarks(&reference), &surfaces(&current), &(truth * Point3::origin()), &Pose::identity(), 0.03,
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
    fn ranges_that_drifted_are_told_apart_from_the_pose() {
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
                &landmarks(&reference),
                &surfaces(&current),
                &origin,
                &Pose::identity(),
                0.03,
                &RegistrationSettings::default(),
            );
            let off = found.current_from_reference * truth.inverse();
            assert!(
                off.translation.vector.norm() < 0.01 && off.rotation.angle() < 0.002,
                "{off}"
            );
            let told_m = found.drift.at_zero_m + 2.5 * found.drift.per_m;
            assert!(
                (told_m + longer.0 + 2.5 * longer.1).abs() < 0.003,
                "{:?}",
                found.drift
            );
        }
    }

    #[test]
    fn an_endless_corridor_is_told() {
        let corridor: Vec<_> = room()
            .into_iter()
            .filter(|p| p.x > -1.9 && p.x < 2.9 && p.y != 1.5)
            .collect();
        let s = surfaces(&corridor);
        let found = register(
            &Landmarks::of(&s),
            &s,
            &Point3::origin(),
            &Pose::identity(),
            0.03,
            &RegistrationSettings::default(),
        );
        assert!(found.current_from_reference.translation.vector.norm() < 2e-3);
        assert_eq!(found.unobservable.len(), 1, "{:?}", found.unobservable);
    }
}
