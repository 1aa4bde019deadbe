//! One simulated pair with its truth.

use super::changes::{Change, Changed, make};
use super::constants::{ATTEMPTS, LEAST_IN_VIEW, LEAST_POINTS, UNEVEN};
use super::draw::Draw;
use super::plan::{Planned, PoseError};
use super::sensor::{Setting, Sweep};
use super::truth::{Label, Visit, labels, share_in_view, visible_points};
use nalgebra::Point3;
use patrold_engine::geometry::{Pose, RollPitchYaw};
use patrold_sim::world::{Body, World};

/// Why there is no pair.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PairError {
    /// Chance never made the wanted change visible.
    #[error("pair {name}: no visible {change} in {ATTEMPTS} scenes; report it")]
    NoScene {
        /// The pair.
        name: String,
        /// Its class.
        change: &'static str,
    },
}

/// A pair: two sweeps and what is true of them. Side 0 is the reference, side 1 the revisit.
#[derive(Debug, Clone)]
pub struct Pair {
    /// What it is of.
    pub planned: Planned,
    /// The change in a word or two.
    pub told: String,
    /// Both sweeps.
    pub sweeps: [Sweep; 2],
    /// The truth about their points.
    pub labels: [Vec<Label>; 2],
    /// The truth about where the robot stood.
    pub current_from_reference: Pose,
}

impl Pair {
    /// The pair of this plan under this seed.
    ///
    /// # Errors
    /// No scene in which the change is visible.
    pub fn take(planned: &Planned, seed: u64) -> Result<Self, PairError> {
        let mut chance = Draw::new(seed, planned.stream());
        let setting = planned.sensor.setting(&mut chance.fork());
        let error = pose_error(planned.pose, &mut chance.fork());
        let mut scenes = chance.fork();
        for _ in 0..ATTEMPTS {
            let mut draw = scenes.fork();
            let Some(place) = planned.place.build(&mut draw) else {
                continue;
            };
            let Some(changed) = make(planned.change, &place, &mut draw) else {
                continue;
            };
            if let Some(pair) = Self::of(planned, &changed, &setting, &error) {
                return Ok(pair);
            }
        }
        Err(PairError::NoScene {
            name: planned.name(),
            change: planned.change.word(),
        })
    }

    /// The pair of a change, if it is visible.
    fn of(planned: &Planned, changed: &Changed, setting: &Setting, error: &Pose) -> Option<Self> {
        let worlds = [&changed.before, &changed.after].map(|p| p.world().ok());
        let [Some(then), Some(now)] = &worlds else {
            return None;
        };
        let reference = changed.before.map_from_base();
        let poses = [reference, reference * error];
        let visit = |side: usize, world| Visit {
            world,
            map_from_base: poses[side],
            origin: setting.patterns[side].origin(),
        };
        let visits = [visit(0, then), visit(1, now)];
        if !is_visible(planned.change, changed, &visits, setting) {
            return None;
        }
        let worlds: [&World; 2] = [then, now];
        let sweeps = [0, 1].map(|side| setting.sweep(worlds[side], &poses[side], side));
        let labels = [0, 1].map(|side| {
            labels(
                &sweeps[side].met,
                &visits[side],
                &visits[1 - side],
                &changed.things,
                setting,
            )
        });
        Some(Self {
            planned: *planned,
            told: changed.told.clone(),
            sweeps,
            labels,
            current_from_reference: poses[1].inverse() * poses[0],
        })
    }
}

/// The pose of the revisit's base in the reference's.
fn pose_error(class: PoseError, draw: &mut Draw) -> Pose {
    let (shift, turn_deg) = match class {
        PoseError::None => return Pose::identity(),
        PoseError::Small => (draw.within(0.0, 0.05), draw.within(0.0, 2.0)),
        PoseError::Large => (draw.within(0.05, 0.1), draw.within(2.0, 5.0)),
    };
    let way = draw.within(0.0, std::f64::consts::TAU);
    let turn_deg = draw.sign() * turn_deg;
    let uneven = if draw.chance(0.5) { 1.0 } else { 0.0 };
    let mut small = |most: f64| uneven * draw.within(-most, most);
    let (roll, pitch, z) = (small(UNEVEN.0), small(UNEVEN.0), small(UNEVEN.1));
    RollPitchYaw {
        roll_rad: roll.to_radians(),
        pitch_rad: pitch.to_radians(),
        yaw_rad: turn_deg.to_radians(),
    }
    .with_translation([shift * way.cos(), shift * way.sin(), z])
}

fn is_visible(
    change: Change,
    changed: &Changed,
    visits: &[Visit<'_>; 2],
    setting: &Setting,
) -> bool {
    let points =
        |own: usize| visible_points(&visits[own], &visits[1 - own], &changed.things, setting);
    match change {
        Change::Quiet => true,
        Change::Person | Change::Box | Change::Pillar => points(1) >= LEAST_POINTS,
        Change::Removed => points(0) >= LEAST_POINTS,
        Change::Moved => points(0) >= LEAST_POINTS && points(1) >= LEAST_POINTS,
        Change::Door => points(0) + points(1) >= LEAST_POINTS,
        Change::Ball30 | Change::Ball20 | Change::Ball10 => {
            let ball = changed.after.objects.last();
            let Some(Body::Sphere(ball)) = ball.map(|o| &o.body) else {
                return false;
            };
            let thing = changed.things.first().map_or("", String::as_str);
            let centre = Point3::from(ball.centre);
            share_in_view(&visits[1], centre, ball.radius_m, thing, setting) >= LEAST_IN_VIEW
                && visits[0].looks_through(&centre, setting)
        }
    }
}
