//! A place: its objects, the pose of the robot in it, and where more objects can be put.

use super::constants::ROBOT_HALF_M;
use super::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_engine::geometry::{Pose, RollPitchYaw};
use patrold_sim::world::{Pose2d, Scene, SceneError, SceneObject, World};

/// A flat area on which objects can be put.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportSurface {
    /// Its middle, map frame, metres.
    pub centre: [f64; 2],
    /// Half its size along its own axes, metres.
    pub half: [f64; 2],
    pub yaw_deg: f64,
    /// Height of its middle, metres.
    pub z_m: f64,
    /// Rise per metre along x of the map.
    pub grade: f64,
    /// Whether robots and people stand on it.
    pub floor: bool,
}

impl SupportSurface {
    /// A point on it, at least `margin_m` from its edge; `None` where it is too small.
    pub fn random_point(&self, rng: &mut SeededRng, margin_m: f64) -> Option<Point3<f64>> {
        let [x, y] = self.half.map(|h| h - margin_m);
        let (u, v) = (rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (sin, cos) = self.yaw_deg.to_radians().sin_cos();
        let (u, v) = (u * x, v * y);
        let point = [
            self.centre[0] + cos * u - sin * v,
            self.centre[1] + sin * u + cos * v,
        ];
        Some(Point3::new(point[0], point[1], self.height_at(point)))
    }

    /// Its height at this point of the map, metres.
    pub fn height_at(&self, point: [f64; 2]) -> f64 {
        self.z_m + self.grade * (point[0] - self.centre[0])
    }
}

/// A box along the map's axes that an object occupies, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OccupiedBox {
    /// Corner of the least coordinates.
    pub low: [f64; 3],
    /// Corner of the greatest coordinates.
    pub high: [f64; 3],
}

impl OccupiedBox {
    /// The box of these sizes that stands on `at`.
    pub fn standing(at: Point3<f64>, half: [f64; 2], height_m: f64) -> Self {
        Self {
            low: [at.x - half[0], at.y - half[1], at.z],
            high: [at.x + half[0], at.y + half[1], at.z + height_m],
        }
    }

    /// Whether the two are nearer than `gap_m` in plan while their heights overlap; standing on each other is no overlap.
    pub fn collides(&self, other: &Self, gap_m: f64) -> bool {
        const TOUCH_M: f64 = 0.01;
        (0..3).all(|axis| {
            let gap = if axis == 2 { -TOUCH_M } else { gap_m };
            self.low[axis] - gap < other.high[axis] && other.low[axis] - gap < self.high[axis]
        })
    }

    /// What `objects` occupy, one box for each solid; the ground occupies nothing.
    pub fn of_objects(objects: &[SceneObject]) -> Vec<Self> {
        let above_ground = |o: &&SceneObject| object_name(&o.name) != GROUND;
        let solids = objects
            .iter()
            .filter(above_ground)
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

/// Name of the ground.
pub(crate) const GROUND: &str = "ground";

/// The object that a part belongs to: its name up to the first `/`.
pub(crate) fn object_name(name: &str) -> &str {
    name.split('/').next().unwrap_or(name)
}

/// A place. Its objects are called `NAME` or `NAME/PART`.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedPlace {
    pub objects: Vec<SceneObject>,
    pub robot_pose: Pose2d,
    /// Height of the pan-tilt's base, map frame, metres.
    pub base_height_m: f64,
    /// Where objects can be put.
    pub supports: Vec<SupportSurface>,
    /// Objects that may be taken away: nothing stands on them.
    pub removable: Vec<String>,
    /// Names of doors.
    pub doors: Vec<String>,
}

impl SimulatedPlace {
    /// Pose of the robot's base in the map.
    pub fn map_from_base(&self) -> Pose {
        RollPitchYaw {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: self.robot_pose.yaw_rad,
        }
        .with_translation([self.robot_pose.x_m, self.robot_pose.y_m, self.base_height_m])
    }

    /// The world for ray casting.
    ///
    /// # Errors
    /// Never: it has no recorded cloud.
    pub fn world(&self) -> Result<World, SceneError> {
        let scene = Scene {
            map_from_base: self.map_from_base(),
            objects: self.objects.clone(),
            cloud: None,
        };
        scene.build(None)
    }

    /// What the objects and the robot occupy.
    pub fn occupied(&self) -> Vec<OccupiedBox> {
        let mut boxes = OccupiedBox::of_objects(&self.objects);
        boxes.push(self.robot_box());
        boxes
    }

    /// What the robot occupies, up to the laser.
    pub fn robot_box(&self) -> OccupiedBox {
        OccupiedBox {
            low: [
                self.robot_pose.x_m - ROBOT_HALF_M,
                self.robot_pose.y_m - ROBOT_HALF_M,
                -2.0,
            ],
            high: [
                self.robot_pose.x_m + ROBOT_HALF_M,
                self.robot_pose.y_m + ROBOT_HALF_M,
                self.base_height_m + ROBOT_HALF_M,
            ],
        }
    }
}
