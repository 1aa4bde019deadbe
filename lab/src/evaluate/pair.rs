//! One simulated pair with its truth.

use super::changes::{ChangeClass, ChangedPlace, apply_change};
use super::constants::{MAX_SCENES, MIN_SHARE_IN_VIEW, MIN_VISIBLE_POINTS, UNEVEN_FLOOR};
use super::place::SimulatedPlace;
use super::plan::{PairPlan, PoseErrorClass};
use super::point_labels::{
    PointLabel, SimulatedVisit, point_labels, share_in_view, visible_points,
};
use super::seeded_rng::SeededRng;
use super::sensor::{SensorSetup, SensorSweep};
use nalgebra::Point3;
use patrold_engine::geometry::{Pose, RollPitchYaw, View};
use patrold_sim::world::{Body, SceneError, World};

/// Why a pair cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PairError {
    /// No random scene showed the change.
    #[error("pair {name}: no visible {change} in {MAX_SCENES} scenes; report it")]
    NoScene {
        /// Name of the pair.
        name: String,
        /// Class of the change.
        change: &'static str,
    },
    /// Its place cannot be cast.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// A pair of sweeps with its ground truth. Of two values the first is of the reference, the second of the revisit.
#[derive(Debug, Clone)]
pub struct SimulatedPair {
    /// Its plan.
    pub plan: PairPlan,
    /// The change, for people.
    pub change_description: String,
    /// Its sweeps.
    pub sweeps: [SensorSweep; 2],
    /// True labels of their points.
    pub labels: [Vec<PointLabel>; 2],
    /// True pose correction.
    pub current_from_reference: Pose,
    /// Its place at the reference.
    reference_place: SimulatedPlace,
    /// The seed that it was simulated under.
    seed: u64,
}

impl SimulatedPair {
    /// The pair of this plan under this seed.
    ///
    /// # Errors
    /// No scene in which the change is visible.
    pub fn simulate(plan: &PairPlan, seed: u64) -> Result<Self, PairError> {
        let mut rng = SeededRng::new(seed, plan.rng_stream());
        let setup = plan.sensor.setup(&mut rng.fork());
        let error = pose_error(plan.pose_error, &mut rng.fork());
        let mut scenes = rng.fork();
        for _ in 0..MAX_SCENES {
            let mut rng = scenes.fork();
            let Some(place) = plan.place.build(&mut rng) else {
                continue;
            };
            let Some(changed) = apply_change(plan.change, &place, &mut rng) else {
                continue;
            };
            if let Some(pair) = Self::of_change(plan, seed, &changed, &setup, &error) {
                return Ok(pair);
            }
        }
        Err(PairError::NoScene {
            name: plan.name(),
            change: plan.change.as_str(),
        })
    }

    /// The pair of a change, if it is visible.
    fn of_change(
        plan: &PairPlan,
        seed: u64,
        changed: &ChangedPlace,
        setup: &SensorSetup,
        error: &Pose,
    ) -> Option<Self> {
        let worlds = [&changed.before, &changed.after].map(|p| p.world().ok());
        let [Some(before), Some(after)] = &worlds else {
            return None;
        };
        let reference = changed.before.map_from_base();
        let poses = [reference, reference * error];
        let visit = |side: usize, world| SimulatedVisit {
            world,
            map_from_base: poses[side],
            origin: setup.patterns[side].origin(),
        };
        let visits = [visit(0, before), visit(1, after)];
        if !is_visible(plan.change, changed, &visits, setup) {
            return None;
        }
        let worlds: [&World; 2] = [before, after];
        let sweeps = [0, 1].map(|side| setup.sweep(worlds[side], &poses[side], side));
        let labels = [0, 1].map(|side| {
            point_labels(
                &sweeps[side].hits,
                &visits[side],
                &visits[1 - side],
                &changed.objects,
                setup,
            )
        });
        Some(Self {
            plan: *plan,
            change_description: changed.description.clone(),
            sweeps,
            labels,
            current_from_reference: poses[1].inverse() * poses[0],
            reference_place: changed.before.clone(),
            seed,
        })
    }

    /// The sweep of another visit, number `visit`, to the place of the reference, where nothing changed. Its sensor is the
    /// pair's; its noise and the robot's pose are drawn as those of the pair's revisit, from a stream of its own.
    ///
    /// # Errors
    /// Never: the place was cast for the pair.
    pub(crate) fn quiet_visit(&self, visit: u32) -> Result<View, PairError> {
        let mut own = SeededRng::new(self.seed, self.plan.visit_stream(visit));
        let mut pair_sensor = SeededRng::new(self.seed, self.plan.rng_stream()).fork();
        let setup = self
            .plan
            .sensor
            .setup_at_visit(&mut pair_sensor, &mut own.fork());
        let error = pose_error(self.plan.pose_error, &mut own.fork());
        let world = self.reference_place.world()?;
        let map_from_base = self.reference_place.map_from_base() * error;
        Ok(setup.sweep(&world, &map_from_base, 1).view)
    }
}

/// The pose of the revisit's base in the reference's.
fn pose_error(class: PoseErrorClass, rng: &mut SeededRng) -> Pose {
    let (shift, turn_deg) = match class {
        PoseErrorClass::None => return Pose::identity(),
        PoseErrorClass::Small => (rng.uniform(0.0, 0.05), rng.uniform(0.0, 2.0)),
        PoseErrorClass::Large => (rng.uniform(0.05, 0.1), rng.uniform(2.0, 5.0)),
        PoseErrorClass::Wide => (rng.uniform(0.1, 0.2), rng.uniform(5.0, 8.0)),
        PoseErrorClass::Widest => (rng.uniform(0.2, 0.3), rng.uniform(8.0, 15.0)),
    };
    let direction = rng.uniform(0.0, std::f64::consts::TAU);
    let turn_deg = rng.sign() * turn_deg;
    let uneven = if rng.chance(0.5) { 1.0 } else { 0.0 };
    let mut small = |max: f64| uneven * rng.uniform(-max, max);
    let (max_deg, max_m) = UNEVEN_FLOOR;
    let (roll, pitch, z) = (small(max_deg), small(max_deg), small(max_m));
    RollPitchYaw {
        roll_rad: roll.to_radians(),
        pitch_rad: pitch.to_radians(),
        yaw_rad: turn_deg.to_radians(),
    }
    .with_translation([shift * direction.cos(), shift * direction.sin(), z])
}

fn is_visible(
    change: ChangeClass,
    changed: &ChangedPlace,
    visits: &[SimulatedVisit<'_>; 2],
    setup: &SensorSetup,
) -> bool {
    let points =
        |own: usize| visible_points(&visits[own], &visits[1 - own], &changed.objects, setup);
    match change {
        ChangeClass::Quiet => true,
        ChangeClass::Person | ChangeClass::Box | ChangeClass::Pillar => {
            points(1) >= MIN_VISIBLE_POINTS
        }
        ChangeClass::Removed => points(0) >= MIN_VISIBLE_POINTS,
        ChangeClass::Moved => points(0) >= MIN_VISIBLE_POINTS && points(1) >= MIN_VISIBLE_POINTS,
        ChangeClass::Door => points(0) + points(1) >= MIN_VISIBLE_POINTS,
        ChangeClass::Ball30 | ChangeClass::Ball20 | ChangeClass::Ball10 => {
            let ball = changed.after.objects.last();
            let Some(Body::Sphere(ball)) = ball.map(|o| &o.body) else {
                return false;
            };
            let name = changed.objects.first().map_or("", String::as_str);
            let centre = Point3::from(ball.centre);
            share_in_view(&visits[1], centre, ball.radius_m, name, setup) >= MIN_SHARE_IN_VIEW
                && visits[0].saw_through(&centre, setup)
        }
    }
}
