//! Changes between the two visits.

use super::builder::{cuboid, cylinder, sphere};
use super::constants::{
    BALL_TRIES, GAP_M, LASER_OVER_BASE_M, MAX_DISTANCE_M, MIN_MOVE_SIZES, MIN_SWING_DEG,
    POSITION_TRIES,
};
use super::place::{OccupiedBox, SimulatedPlace, SupportSurface, object_name};
use super::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::{Body, PersonTable, SceneObject};

/// A class of change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ChangeClass {
    /// No change.
    Quiet,
    /// A new person.
    Person,
    /// A door opened, closed or moved.
    Door,
    /// A new box with sides of 0.3 m and more.
    Box,
    /// A new pillar.
    Pillar,
    /// An object removed.
    Removed,
    /// An object moved by more than its size.
    Moved,
    /// A new ball of 0.3 m at 3 m.
    Ball30,
    /// A new ball of 0.2 m at 2.5 m.
    Ball20,
    /// A new ball of 0.1 m at 1 m.
    Ball10,
}

impl ChangeClass {
    /// The large changes.
    pub const LARGE: [Self; 6] = [
        Self::Person,
        Self::Door,
        Self::Box,
        Self::Pillar,
        Self::Removed,
        Self::Moved,
    ];
    /// The balls.
    pub const BALLS: [Self; 3] = [Self::Ball30, Self::Ball20, Self::Ball10];

    /// The name in names of pairs and in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Quiet => "quiet",
            Self::Person => "person",
            Self::Door => "door",
            Self::Box => "box",
            Self::Pillar => "pillar",
            Self::Removed => "removed",
            Self::Moved => "moved",
            Self::Ball30 => "ball30",
            Self::Ball20 => "ball20",
            Self::Ball10 => "ball10",
        }
    }

    /// Diameter and distance of a ball, metres.
    pub fn ball(self) -> Option<(f64, f64)> {
        match self {
            Self::Ball30 => Some((0.3, 3.0)),
            Self::Ball20 => Some((0.2, 2.5)),
            Self::Ball10 => Some((0.1, 1.0)),
            _ => None,
        }
    }
}

/// A place before and after a change.
#[derive(Debug, Clone)]
pub(crate) struct ChangedPlace {
    pub before: SimulatedPlace,
    /// With the robot's pose of `before`.
    pub after: SimulatedPlace,
    /// Names of the objects that appeared, disappeared or moved.
    pub objects: Vec<String>,
    pub description: String,
}

/// Name of a new object; no object of a place has it.
const NEW_OBJECT: &str = "new";

/// One random change of this class in `place`; `None` where there is no room for it.
pub(crate) fn apply_change(
    change: ChangeClass,
    place: &SimulatedPlace,
    rng: &mut SeededRng,
) -> Option<ChangedPlace> {
    match change {
        ChangeClass::Quiet => Some(ChangedPlace {
            before: place.clone(),
            after: place.clone(),
            objects: Vec::new(),
            description: "nothing".to_owned(),
        }),
        ChangeClass::Person => {
            let height_m = rng.uniform(1.5, 1.95);
            let at = free_position(place, rng, [0.28; 2], height_m, true)?;
            let yaw_deg = rng.uniform(-180.0, 180.0);
            let person = PersonTable {
                name: None,
                reflectance: None,
                at: at.into(),
                height_m,
                yaw_deg,
            };
            Some(add_object(place, Body::Person(person), "person"))
        }
        ChangeClass::Box => {
            let size = [0, 1, 2].map(|_| rng.uniform(0.3, 0.8));
            let reach = 0.5 * f64::hypot(size[0], size[1]);
            let floor = rng.chance(0.8);
            let at = free_position(place, rng, [reach; 2], size[2], floor)?;
            let yaw_deg = rng.uniform(-180.0, 180.0);
            let centre = [at.x, at.y, at.z + size[2] / 2.0];
            Some(add_object(place, cuboid(centre, size, yaw_deg), "box"))
        }
        ChangeClass::Pillar => {
            let (radius, height) = (rng.uniform(0.1, 0.3), rng.uniform(1.0, 2.2));
            let at = free_position(place, rng, [radius; 2], height, true)?;
            let centre = [at.x, at.y, at.z + height / 2.0];
            let body = cylinder(centre, [0.0, 0.0, 1.0], radius, height);
            Some(add_object(place, body, "pillar"))
        }
        ChangeClass::Removed => {
            let removed = rng.choose(&place.removable)?.clone();
            let mut after = place.clone();
            after.objects.retain(|o| object_name(&o.name) != removed);
            Some(ChangedPlace {
                before: place.clone(),
                after,
                description: format!("{removed} taken away"),
                objects: vec![removed],
            })
        }
        ChangeClass::Moved => move_object(place, rng),
        ChangeClass::Door => swing_door(place, rng),
        ChangeClass::Ball30 | ChangeClass::Ball20 | ChangeClass::Ball10 => {
            let (diameter_m, distance_m) = change.ball()?;
            add_ball(place, rng, diameter_m / 2.0, distance_m)
        }
    }
}

fn add_object(place: &SimulatedPlace, body: Body, description: &str) -> ChangedPlace {
    let mut after = place.clone();
    after.objects.push(SceneObject {
        name: NEW_OBJECT.to_owned(),
        body,
    });
    ChangedPlace {
        before: place.clone(),
        after,
        objects: vec![NEW_OBJECT.to_owned()],
        description: description.to_owned(),
    }
}

/// A free position within the laser's reach for an object of this footprint and height, on the floor or on furniture.
fn free_position(
    place: &SimulatedPlace,
    rng: &mut SeededRng,
    half: [f64; 2],
    height_m: f64,
    floor: bool,
) -> Option<Point3<f64>> {
    let occupied = place.occupied();
    let supports: Vec<&SupportSurface> =
        place.supports.iter().filter(|s| s.floor == floor).collect();
    for _ in 0..POSITION_TRIES {
        let support = rng.choose(&supports)?;
        let margin = half[0].max(half[1]);
        let Some(at) = support.random_point(rng, margin * 0.8) else {
            continue;
        };
        let own = OccupiedBox::standing(at, half, height_m);
        let away = f64::hypot(at.x - place.robot_pose.x_m, at.y - place.robot_pose.y_m);
        if away < MAX_DISTANCE_M && occupied.iter().all(|b| !b.collides(&own, GAP_M)) {
            return Some(at);
        }
    }
    None
}

fn bounds_of(place: &SimulatedPlace, name: &str) -> Option<OccupiedBox> {
    let own: Vec<SceneObject> = place
        .objects
        .iter()
        .filter(|o| object_name(&o.name) == name)
        .cloned()
        .collect();
    OccupiedBox::of_objects(&own)
        .into_iter()
        .reduce(|a, b| OccupiedBox {
            low: [0, 1, 2].map(|i| a.low[i].min(b.low[i])),
            high: [0, 1, 2].map(|i| a.high[i].max(b.high[i])),
        })
}

/// A removable object elsewhere on the floor: further away than its own size.
fn move_object(place: &SimulatedPlace, rng: &mut SeededRng) -> Option<ChangedPlace> {
    let name = rng.choose(&place.removable)?.clone();
    let old = bounds_of(place, &name)?;
    let size = [0, 1, 2].map(|i| old.high[i] - old.low[i]);
    let mut without = place.clone();
    without.objects.retain(|o| object_name(&o.name) != name);
    let half = [size[0] / 2.0, size[1] / 2.0];
    let at = free_position(&without, rng, half, size[2], true)?;
    let shift = [
        at.x - (old.low[0] + old.high[0]) / 2.0,
        at.y - (old.low[1] + old.high[1]) / 2.0,
        at.z - old.low[2],
    ];
    if f64::hypot(shift[0], shift[1]) < MIN_MOVE_SIZES * f64::hypot(size[0], size[1]) {
        return None;
    }
    let mut after = place.clone();
    for object in &mut after.objects {
        if object_name(&object.name) == name {
            let (_, at) = object.body.position_mut();
            *at = [0, 1, 2].map(|i| at[i] + shift[i]);
        }
    }
    Some(ChangedPlace {
        before: place.clone(),
        after,
        description: format!("{name} moved by {:.2} m", f64::hypot(shift[0], shift[1])),
        objects: vec![name],
    })
}

/// A door at another angle; it does not swing into the robot.
fn swing_door(place: &SimulatedPlace, rng: &mut SeededRng) -> Option<ChangedPlace> {
    let name = rng.choose(&place.doors)?.clone();
    let mut after = place.clone();
    let object = after.objects.iter_mut().find(|o| o.name == name)?;
    let Body::Door(leaf) = &mut object.body else {
        return None;
    };
    let old_deg = leaf.angle_deg;
    let inward = inward_sign(leaf.hinge, leaf.yaw_deg);
    leaf.angle_deg = if old_deg != 0.0 && rng.chance(0.5) {
        0.0
    } else {
        inward * rng.uniform(MIN_SWING_DEG, 105.0)
    };
    let new_deg = leaf.angle_deg;
    if (new_deg - old_deg).abs() < MIN_SWING_DEG {
        return None;
    }
    let leaf = SceneObject {
        name: name.clone(),
        body: object.body.clone(),
    };
    let swung = OccupiedBox::of_objects(std::slice::from_ref(&leaf));
    let robot = place.robot_box();
    if swung.iter().any(|b| b.collides(&robot, 0.0)) {
        return None;
    }
    Some(ChangedPlace {
        before: place.clone(),
        after,
        description: format!("{name} from {old_deg:.0} to {new_deg:.0} deg"),
        objects: vec![name],
    })
}

/// Sign of the angles that open a door into the room about the origin.
fn inward_sign(hinge: [f64; 3], yaw_deg: f64) -> f64 {
    let (sin, cos) = (yaw_deg + 90.0).to_radians().sin_cos();
    // Whether a quarter turn to the left swings the leaf towards the middle of the room.
    if cos * -hinge[0] + sin * -hinge[1] > 0.0 {
        1.0
    } else {
        -1.0
    }
}

/// A ball at this distance from the laser, on the floor, on furniture, or on a box that is there before, too.
fn add_ball(
    place: &SimulatedPlace,
    rng: &mut SeededRng,
    radius_m: f64,
    distance_m: f64,
) -> Option<ChangedPlace> {
    let mut before = place.clone();
    let laser_z = place.base_height_m + LASER_OVER_BASE_M;
    let occupied = place.occupied();
    for _ in 0..BALL_TRIES {
        let support = rng.choose(&place.supports)?;
        let (bearing, height) = (rng.uniform(-2.0, 2.0), rng.uniform(0.2, 1.0));
        let raised = support.floor && rng.chance(0.4);
        let base_z = support.z_m + if raised { height } else { 0.0 };
        let down = laser_z - (base_z + radius_m);
        let level_sq = distance_m * distance_m - down * down;
        if level_sq <= 0.0 {
            continue;
        }
        let (sin, cos) = (place.robot_pose.yaw_rad + bearing).sin_cos();
        let level = level_sq.sqrt();
        let at = Point3::new(
            place.robot_pose.x_m + level * cos,
            place.robot_pose.y_m + level * sin,
            base_z,
        );
        if support.grade != 0.0 || !contains_disc(support, [at.x, at.y], radius_m) {
            continue;
        }
        let own = OccupiedBox::standing(at, [radius_m; 2], 2.0 * radius_m);
        if occupied.iter().any(|b| b.collides(&own, 0.01)) {
            continue;
        }
        if raised {
            let half = rng.uniform(0.08, 0.2);
            let foot = Point3::new(at.x, at.y, support.z_m);
            let pedestal = OccupiedBox::standing(foot, [half; 2], height);
            if occupied.iter().any(|b| b.collides(&pedestal, 0.01)) {
                continue;
            }
            let centre = [at.x, at.y, support.z_m + height / 2.0];
            before.objects.push(SceneObject {
                name: "pedestal".to_owned(),
                body: cuboid(centre, [2.0 * half, 2.0 * half, height], 0.0),
            });
        }
        let body = sphere([at.x, at.y, at.z + radius_m], radius_m);
        let on = if support.floor && !raised {
            "the floor"
        } else {
            "furniture"
        };
        let description = format!("ball of {:.1} m on {on}", 2.0 * radius_m);
        return Some(add_object(&before, body, &description));
    }
    None
}

/// Whether a support reaches `margin_m`, at most 5 cm, beyond a point.
fn contains_disc(support: &SupportSurface, point: [f64; 2], margin_m: f64) -> bool {
    let (sin, cos) = support.yaw_deg.to_radians().sin_cos();
    let d = [point[0] - support.centre[0], point[1] - support.centre[1]];
    let own = [cos * d[0] + sin * d[1], cos * d[1] - sin * d[0]];
    (0..2).all(|i| own[i].abs() + margin_m.min(0.05) <= support.half[i])
}
