//! The shipped scenes, and where the robot stands in them.

use nalgebra::Point3;
use patrold_sim::world::{Pose2d, Scene, World};
use std::sync::Arc;

pub(super) fn scene(name: &str) -> Scene {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    Scene::resolve(name, &load).expect("a shipped scene")
}

pub(super) fn world(name: &str) -> Arc<World> {
    Arc::new(scene(name).build(None).expect("builds"))
}

/// Pose of the robot of a scene, displaced by metres forward and left and degrees to the left.
pub(super) fn displaced_pose(name: &str, (x_m, y_m, yaw_deg): (f64, f64, f64)) -> Pose2d {
    let map_from_base = scene(name).map_from_base;
    let position = map_from_base * Point3::new(x_m, y_m, 0.0);
    Pose2d {
        x_m: position.x,
        y_m: position.y,
        yaw_rad: map_from_base.rotation.euler_angles().2 + yaw_deg.to_radians(),
    }
}
