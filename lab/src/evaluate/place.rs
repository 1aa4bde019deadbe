//! A place with its things, where the robot stands in it, and where more things can be put.

use super::draw::Draw;
use nalgebra::Point3;
use patrold_engine::geometry::{Pose, RollPitchYaw};
use patrold_sim::world::{Object, Scene, SceneError, Stand, World};

/// A flat area on which things can be put.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// Its middle, map, metres.
    pub centre: [f64; 2],
    /// Half its size along its own axes, metres.
    pub half: [f64; 2],
    /// How it is turned, degrees.
    pub yaw_deg: f64,
    /// Height of its middle, metres.
    pub z_m: f64,
    /// Rise per metre along x of the map.
    pub grade: f64,
    /// Whether it is ground that a robot and people stand on.
    pub floor: bool,
}

impl Support {
    /// A place on it, at least `margin_m` from its rim; `None` where it is too small.
    pub fn draw(&self, draw: &mut Draw, margin_m: f64) -> Option<Point3<f64>> {
        let [x, y] = self.half.map(|h| h - margin_m);
        let (u, v) = (draw.within(-1.0, 1.0), draw.within(-1.0, 1.0));
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (sin, cos) = self.yaw_deg.to_radians().sin_cos();
        let (u, v) = (u * x, v * y);
        let place = [
            self.centre[0] + cos * u - sin * v,
            self.centre[1] + sin * u + cos * v,
        ];
        Some(Point3::new(place[0], place[1], self.height_at(place)))
    }

    /// Its height over this place of the map, metres.
    pub fn height_at(&self, place: [f64; 2]) -> f64 {
        self.z_m + self.grade * (place[0] - self.centre[0])
    }
}

/// A box along the map's axes that something fills, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Least corner.
    pub low: [f64; 3],
    /// Greatest corner.
    pub high: [f64; 3],
}

impl Block {
    /// The block of these sizes that stands on `at`.
    pub fn standing(at: Point3<f64>, half: [f64; 2], height_m: f64) -> Self {
        Self {
            low: [at.x - half[0], at.y - half[1], at.z],
            high: [at.x + half[0], at.y + half[1], at.z + height_m],
        }
    }

    /// Whether the two come nearer than `gap_m` in plan while their heights overlap. What touches from above or below
    /// does not overlap.
    pub fn meets(&self, other: &Self, gap_m: f64) -> bool {
        const TOUCH_M: f64 = 0.01;
        (0..3).all(|axis| {
            let gap = if axis == 2 { -TOUCH_M } else { gap_m };
            self.low[axis] - gap < other.high[axis] && other.low[axis] - gap < self.high[axis]
        })
    }

    /// What `objects` fill, one block for each of their solids; the ground fills nothing.
    pub fn all_of(objects: &[Object]) -> Vec<Self> {
        let solid = |o: &&Object| thing_of(&o.name) != GROUND;
        let solids = objects
            .iter()
            .filter(solid)
            .flat_map(|o| o.body.solids().into_iter());
        solids
            .map(|s| {
                let bounds = s.bounds();
                Self {
                    low: bounds.low.into(),
                    high: bounds.high.into(),
                }
            })
            .collect()
    }
}

/// Name of the thing that the ground is.
pub const GROUND: &str = "ground";

/// The thing that an object is a part of: its name up to the first `/`.
pub fn thing_of(name: &str) -> &str {
    name.split('/').next().unwrap_or(name)
}

/// A place. Its objects are called `thing` or `thing/part`.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Everything in it.
    pub objects: Vec<Object>,
    /// Where the robot stands.
    pub stand: Stand,
    /// Height of the pan-tilt's base, map, metres.
    pub base_height_m: f64,
    /// Where things can be put.
    pub supports: Vec<Support>,
    /// Things that may be taken away: nothing stands on them.
    pub removable: Vec<String>,
    /// Doors.
    pub doors: Vec<String>,
}

impl Place {
    /// Pose of the robot's base in the map.
    pub fn map_from_base(&self) -> Pose {
        RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: self.stand.yaw_rad,
        }
        .with_translation([self.stand.x_m, self.stand.y_m, self.base_height_m])
    }

    /// The world that rays meet.
    ///
    /// # Errors
    /// None for places of boxes and balls; a recorded cloud would be missing.
    pub fn world(&self) -> Result<World, SceneError> {
        let scene = Scene {
            map_from_base: self.map_from_base(),
            objects: self.objects.clone(),
            cloud: None,
        };
        scene.build(None)
    }

    /// What fills the place, and the robot.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = Block::all_of(&self.objects);
        blocks.push(self.robot());
        blocks
    }

    /// What the robot fills, from floor to laser.
    pub fn robot(&self) -> Block {
        const HALF_M: f64 = 0.3;
        Block {
            low: [self.stand.x_m - HALF_M, self.stand.y_m - HALF_M, -2.0],
            high: [
                self.stand.x_m + HALF_M,
                self.stand.y_m + HALF_M,
                self.base_height_m + HALF_M,
            ],
        }
    }
}
