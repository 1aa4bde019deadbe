//! The building of the demo: four waypoints, each with its scene before and after the change.

use crate::cli::failure::Failure;
use patrold_sim::world::{Pose2d, Scene, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// The shipped scenes by file name.
const SCENE_FILES: &[(&str, &str)] = &[
    (
        "corridor.toml",
        include_str!("../../../config/scenes/corridor.toml"),
    ),
    (
        "corridor-person.toml",
        include_str!("../../../config/scenes/corridor-person.toml"),
    ),
    (
        "office.toml",
        include_str!("../../../config/scenes/office.toml"),
    ),
    (
        "office-door.toml",
        include_str!("../../../config/scenes/office-door.toml"),
    ),
    (
        "storeroom.toml",
        include_str!("../../../config/scenes/storeroom.toml"),
    ),
    (
        "storeroom-box-left.toml",
        include_str!("../../../config/scenes/storeroom-box-left.toml"),
    ),
    (
        "storeroom-taken.toml",
        include_str!("../../../config/scenes/storeroom-taken.toml"),
    ),
];

/// Waypoint, scene as taught, scene in the changed round, what changed.
const WAYPOINTS: &[[&str; 4]] = &[
    [
        "corridor",
        "corridor.toml",
        "corridor-person.toml",
        "a person appeared",
    ],
    [
        "office",
        "office.toml",
        "office-door.toml",
        "the door was opened",
    ],
    [
        "storeroom-1",
        "storeroom.toml",
        "storeroom-box-left.toml",
        "a box was left",
    ],
    [
        "storeroom-2",
        "storeroom.toml",
        "storeroom-taken.toml",
        "an object was removed",
    ],
];

/// Largest error of the robot's position in x and y, metres: usual for a navigator.
const MAX_STOP_ERROR_M: f64 = 0.04;
/// Largest error of its yaw, degrees.
const MAX_STOP_ERROR_DEG: f64 = 2.0;

pub(super) struct DemoWaypoint {
    pub name: &'static str,
    /// What changes here, in words.
    pub change: &'static str,
    pub before: Scene,
    pub after: Scene,
}

pub(super) fn demo_waypoints() -> Result<Vec<DemoWaypoint>, Failure> {
    WAYPOINTS
        .iter()
        .map(|[name, before, after, change]| {
            Ok(DemoWaypoint {
                name,
                change,
                before: load_scene(before)?,
                after: load_scene(after)?,
            })
        })
        .collect()
}

fn load_scene(name: &str) -> Result<Scene, Failure> {
    let load = |file: &str| {
        SCENE_FILES
            .iter()
            .find(|(known, _)| *known == file)
            .map(|(_, text)| (*text).to_owned())
            .ok_or_else(|| format!("no scene {file} in the demo"))
    };
    Scene::resolve(name, &load).map_err(Failure::failed)
}

pub(super) fn build_world(scene: &Scene) -> Result<Arc<World>, Failure> {
    scene.build(None).map(Arc::new).map_err(Failure::failed)
}

/// The robot's pose on the map: at the waypoint, or with the seed of a visit, off it by a random stop error.
pub(super) fn robot_pose(scene: &Scene, visit_seed: Option<u64>) -> Pose2d {
    let position = scene.map_from_base.translation.vector;
    let (_, _, yaw_rad) = scene.map_from_base.rotation.euler_angles();
    let mut pose = Pose2d {
        x_m: position.x,
        y_m: position.y,
        yaw_rad,
    };
    if let Some(seed) = visit_seed {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut error = |max: f64| rng.random_range(-max..=max);
        pose.x_m += error(MAX_STOP_ERROR_M);
        pose.y_m += error(MAX_STOP_ERROR_M);
        pose.yaw_rad += error(MAX_STOP_ERROR_DEG).to_radians();
    }
    pose
}
