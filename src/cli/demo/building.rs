//! The demo's building: four places, each as it should be and as it is in the changed round.

use crate::cli::failure::Failure;
use patrold_sim::world::{Scene, Stand, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// The scenes that ship, by the name of their file.
const SCENES: &[(&str, &str)] = &[
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

/// Waypoint, the place as taught, the place in the changed round, what happened.
const PLACES: &[[&str; 4]] = &[
    [
        "corridor",
        "corridor.toml",
        "corridor-person.toml",
        "a person stands there",
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
        "a thing was taken away",
    ],
];

/// How far a robot stops off its waypoint, metres either way: a navigator's usual centimetres.
const STOP_ERROR_M: f64 = 0.04;
/// The same for its heading, degrees.
const STOP_ERROR_DEG: f64 = 2.0;

/// One place of the round.
pub struct Place {
    /// Its waypoint's name.
    pub waypoint: &'static str,
    /// What happens to it in the changed round.
    pub story: &'static str,
    /// As it should be.
    pub before: Scene,
    /// As it is in the changed round.
    pub after: Scene,
}

/// All places.
///
/// # Errors
/// A shipped scene does not read.
pub fn places() -> Result<Vec<Place>, Failure> {
    PLACES
        .iter()
        .map(|[waypoint, before, after, story]| {
            Ok(Place {
                waypoint,
                story,
                before: scene(before)?,
                after: scene(after)?,
            })
        })
        .collect()
}

fn scene(name: &str) -> Result<Scene, Failure> {
    let load = |file: &str| {
        SCENES
            .iter()
            .find(|(known, _)| *known == file)
            .map(|(_, text)| (*text).to_owned())
            .ok_or_else(|| format!("no scene {file} in the demo"))
    };
    Scene::resolve(name, &load).map_err(Failure::failed)
}

/// What stands around, for the rays.
///
/// # Errors
/// The scene does not build.
pub fn world(scene: &Scene) -> Result<Arc<World>, Failure> {
    scene.build(None).map(Arc::new).map_err(Failure::failed)
}

/// Where the robot stops: at the waypoint when it is taught, a little off it on a revisit.
pub fn stand(scene: &Scene, visit: Option<u64>) -> Stand {
    let at = scene.map_from_base.translation.vector;
    let (_, _, yaw_rad) = scene.map_from_base.rotation.euler_angles();
    let mut stand = Stand {
        x_m: at.x,
        y_m: at.y,
        yaw_rad,
    };
    if let Some(seed) = visit {
        let mut chance = ChaCha8Rng::seed_from_u64(seed);
        let mut off = |most: f64| chance.random_range(-most..=most);
        stand.x_m += off(STOP_ERROR_M);
        stand.y_m += off(STOP_ERROR_M);
        stand.yaw_rad += off(STOP_ERROR_DEG).to_radians();
    }
    stand
}
