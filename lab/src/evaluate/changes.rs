//! What differs between the two visits.

use super::builder::{ball, cuboid, cylinder};
use super::constants::{FURTHEST_M, GAP_M, LEAST_MOVE, LEAST_SWING_DEG};
use super::draw::Draw;
use super::place::{Block, Place, Support, thing_of};
use nalgebra::Point3;
use patrold_sim::world::{Body, Object, PersonTable};

/// A class of change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Change {
    /// None.
    Quiet,
    /// A person has come.
    Person,
    /// A door has been opened, closed or moved.
    Door,
    /// A box with sides of 0.3 m and more has come.
    Box,
    /// A pillar has come.
    Pillar,
    /// A thing has gone.
    Removed,
    /// A thing has moved by more than its size.
    Moved,
    /// A ball of 0.3 m at 3 m has come.
    Ball30,
    /// A ball of 0.2 m at 2.5 m has come.
    Ball20,
    /// A ball of 0.1 m at 1 m has come.
    Ball10,
}

impl Change {
    /// Large changes.
    pub const LARGE: [Self; 6] = [
        Self::Person,
        Self::Door,
        Self::Box,
        Self::Pillar,
        Self::Removed,
        Self::Moved,
    ];
    /// Balls.
    pub const BALLS: [Self; 3] = [Self::Ball30, Self::Ball20, Self::Ball10];

    /// Its word in names and tables.
    pub fn word(self) -> &'static str {
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

/// A place as it was and as it is.
#[derive(Debug, Clone)]
pub struct Changed {
    /// As it was.
    pub before: Place,
    /// As it is; the robot's stand is that of the reference.
    pub after: Place,
    /// Things that came, went or moved.
    pub things: Vec<String>,
    /// In a word or two.
    pub told: String,
}

/// A name that nothing of a place has.
const NEW: &str = "new";

/// Makes one change of this class in `place`; `None` where chance found no room for it.
pub fn make(change: Change, place: &Place, draw: &mut Draw) -> Option<Changed> {
    match change {
        Change::Quiet => Some(Changed {
            before: place.clone(),
            after: place.clone(),
            things: Vec::new(),
            told: "nothing".to_owned(),
        }),
        Change::Person => {
            let height_m = draw.within(1.5, 1.95);
            let at = spot(place, draw, [0.28; 2], height_m, true)?;
            let yaw_deg = draw.within(-180.0, 180.0);
            let person = PersonTable {
                name: None,
                reflectance: None,
                at: at.into(),
                height_m,
                yaw_deg,
            };
            Some(come(place, Body::Person(person), "person"))
        }
        Change::Box => {
            let size = [0, 1, 2].map(|_| draw.within(0.3, 0.8));
            let reach = 0.5 * f64::hypot(size[0], size[1]);
            let floor = draw.chance(0.8);
            let at = spot(place, draw, [reach; 2], size[2], floor)?;
            let yaw_deg = draw.within(-180.0, 180.0);
            let centre = [at.x, at.y, at.z + size[2] / 2.0];
            Some(come(place, cuboid(centre, size, yaw_deg), "box"))
        }
        Change::Pillar => {
            let (radius, height) = (draw.within(0.1, 0.3), draw.within(1.0, 2.2));
            let at = spot(place, draw, [radius; 2], height, true)?;
            let centre = [at.x, at.y, at.z + height / 2.0];
            let body = cylinder(centre, [0.0, 0.0, 1.0], radius, height);
            Some(come(place, body, "pillar"))
        }
        Change::Removed => {
            let thing = draw.pick(&place.removable)?.clone();
            let mut after = place.clone();
            after.objects.retain(|o| thing_of(&o.name) != thing);
            Some(Changed {
                before: place.clone(),
                after,
                told: format!("{thing} taken away"),
                things: vec![thing],
            })
        }
        Change::Moved => moved(place, draw),
        Change::Door => door(place, draw),
        Change::Ball30 | Change::Ball20 | Change::Ball10 => {
            let (diameter_m, distance_m) = change.ball()?;
            ball_at(place, draw, diameter_m / 2.0, distance_m)
        }
    }
}

fn come(place: &Place, body: Body, told: &str) -> Changed {
    let mut after = place.clone();
    after.objects.push(Object {
        name: NEW.to_owned(),
        body,
    });
    Changed {
        before: place.clone(),
        after,
        things: vec![NEW.to_owned()],
        told: told.to_owned(),
    }
}

/// A free place within the laser's reach for something of this footprint and height, on the floor or on a top.
fn spot(
    place: &Place,
    draw: &mut Draw,
    half: [f64; 2],
    height_m: f64,
    floor: bool,
) -> Option<Point3<f64>> {
    const TRIES: usize = 60;
    let blocks = place.blocks();
    let supports: Vec<&Support> = place.supports.iter().filter(|s| s.floor == floor).collect();
    for _ in 0..TRIES {
        let support = draw.pick(&supports)?;
        let margin = half[0].max(half[1]);
        let Some(at) = support.draw(draw, margin * 0.8) else {
            continue;
        };
        let own = Block::standing(at, half, height_m);
        let away = f64::hypot(at.x - place.stand.x_m, at.y - place.stand.y_m);
        if away < FURTHEST_M && blocks.iter().all(|b| !b.meets(&own, GAP_M)) {
            return Some(at);
        }
    }
    None
}

fn bounds_of(place: &Place, thing: &str) -> Option<Block> {
    let own: Vec<Object> = place
        .objects
        .iter()
        .filter(|o| thing_of(&o.name) == thing)
        .cloned()
        .collect();
    Block::all_of(&own).into_iter().reduce(|a, b| Block {
        low: [0, 1, 2].map(|i| a.low[i].min(b.low[i])),
        high: [0, 1, 2].map(|i| a.high[i].max(b.high[i])),
    })
}

/// A removable thing, elsewhere on the floor: further than its own size.
fn moved(place: &Place, draw: &mut Draw) -> Option<Changed> {
    let thing = draw.pick(&place.removable)?.clone();
    let was = bounds_of(place, &thing)?;
    let size = [0, 1, 2].map(|i| was.high[i] - was.low[i]);
    let mut without = place.clone();
    without.objects.retain(|o| thing_of(&o.name) != thing);
    let half = [size[0] / 2.0, size[1] / 2.0];
    let at = spot(&without, draw, half, size[2], true)?;
    let shift = [
        at.x - (was.low[0] + was.high[0]) / 2.0,
        at.y - (was.low[1] + was.high[1]) / 2.0,
        at.z - was.low[2],
    ];
    if f64::hypot(shift[0], shift[1]) < LEAST_MOVE * f64::hypot(size[0], size[1]) {
        return None;
    }
    let mut after = place.clone();
    for object in &mut after.objects {
        if thing_of(&object.name) == thing {
            let (_, at) = object.body.place();
            *at = [0, 1, 2].map(|i| at[i] + shift[i]);
        }
    }
    Some(Changed {
        before: place.clone(),
        after,
        told: format!("{thing} moved by {:.2} m", f64::hypot(shift[0], shift[1])),
        things: vec![thing],
    })
}

/// A door at another angle; it passes through nothing.
fn door(place: &Place, draw: &mut Draw) -> Option<Changed> {
    let name = draw.pick(&place.doors)?.clone();
    let mut after = place.clone();
    let object = after.objects.iter_mut().find(|o| o.name == name)?;
    let Body::Door(leaf) = &mut object.body else {
        return None;
    };
    let was = leaf.angle_deg;
    // The leaf swings to the side of its hinge: shut it points along the wall, so the sign says which way is in.
    let inward = swing(leaf.hinge, leaf.yaw_deg);
    leaf.angle_deg = if was != 0.0 && draw.chance(0.5) {
        0.0
    } else {
        inward * draw.within(LEAST_SWING_DEG, 105.0)
    };
    let now = leaf.angle_deg;
    if (now - was).abs() < LEAST_SWING_DEG {
        return None;
    }
    let leaf = Object {
        name: name.clone(),
        body: object.body.clone(),
    };
    let swung = Block::all_of(std::slice::from_ref(&leaf));
    let robot = place.robot();
    if swung.iter().any(|b| b.meets(&robot, 0.0)) {
        return None;
    }
    Some(Changed {
        before: place.clone(),
        after,
        told: format!("{name} from {was:.0} to {now:.0} deg"),
        things: vec![name],
    })
}

/// Sign of the angles that open a door into the room about the origin.
fn swing(hinge: [f64; 3], yaw_deg: f64) -> f64 {
    let (sin, cos) = (yaw_deg + 90.0).to_radians().sin_cos();
    // Where a quarter turn to the left carries the leaf: towards the middle of the room or away from it.
    if cos * -hinge[0] + sin * -hinge[1] > 0.0 {
        1.0
    } else {
        -1.0
    }
}

/// A ball at this distance from the laser, on the floor, on furniture, or on a box that stood there before.
fn ball_at(place: &Place, draw: &mut Draw, radius_m: f64, distance_m: f64) -> Option<Changed> {
    const TRIES: usize = 40;
    let mut before = place.clone();
    let laser_z = place.base_height_m + super::builder::LASER_OVER_BASE_M;
    let blocks = place.blocks();
    for _ in 0..TRIES {
        let support = draw.pick(&place.supports)?;
        let (bearing, lift) = (draw.within(-2.0, 2.0), draw.within(0.2, 1.0));
        let raised = support.floor && draw.chance(0.4);
        let base_z = support.z_m + if raised { lift } else { 0.0 };
        let down = laser_z - (base_z + radius_m);
        let level_sq = distance_m * distance_m - down * down;
        if level_sq <= 0.0 {
            continue;
        }
        let (sin, cos) = (place.stand.yaw_rad + bearing).sin_cos();
        let level = level_sq.sqrt();
        let at = Point3::new(
            place.stand.x_m + level * cos,
            place.stand.y_m + level * sin,
            base_z,
        );
        if support.grade != 0.0 || !holds(support, [at.x, at.y], radius_m) {
            continue;
        }
        let own = Block::standing(at, [radius_m; 2], 2.0 * radius_m);
        if blocks.iter().any(|b| b.meets(&own, 0.01)) {
            continue;
        }
        if raised {
            let half = draw.within(0.08, 0.2);
            let foot = Point3::new(at.x, at.y, support.z_m);
            let stand = Block::standing(foot, [half; 2], lift);
            if blocks.iter().any(|b| b.meets(&stand, 0.01)) {
                continue;
            }
            let centre = [at.x, at.y, support.z_m + lift / 2.0];
            before.objects.push(Object {
                name: "pedestal".to_owned(),
                body: cuboid(centre, [2.0 * half, 2.0 * half, lift], 0.0),
            });
        }
        let body = ball([at.x, at.y, at.z + radius_m], radius_m);
        let on = if support.floor && !raised {
            "the floor"
        } else {
            "furniture"
        };
        let told = format!("ball of {:.1} m on {on}", 2.0 * radius_m);
        return Some(come(&before, body, &told));
    }
    None
}

/// Whether a support reaches at least `margin_m` around a place.
fn holds(support: &Support, place: [f64; 2], margin_m: f64) -> bool {
    let (sin, cos) = support.yaw_deg.to_radians().sin_cos();
    let d = [place[0] - support.centre[0], place[1] - support.centre[1]];
    let own = [cos * d[0] + sin * d[1], cos * d[1] - sin * d[0]];
    (0..2).all(|i| own[i].abs() + margin_m.min(0.05) <= support.half[i])
}
