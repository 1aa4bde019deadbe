//! Scene files, with the scenes they extend and the clouds they name.

use super::clouds;
use super::failure::Failure;
use crate::bounded_file::{MAX_SETTINGS_BYTES, read_text_up_to};
use patrold_engine::geometry::Pose;
use patrold_sim::world::{Scene, World};
use std::path::Path;
use std::sync::Arc;

pub(super) struct LoadedScene {
    pub world: Arc<World>,
    /// Pose of the robot's base on the map.
    pub map_from_base: Pose,
}

/// Reads a scene file; paths in it are relative to its folder.
///
/// # Errors
/// The first error in any of its files, with file and line.
pub(super) fn load(path: &Path) -> Result<LoadedScene, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.to_string_lossy();
    let read = |requested: &str| {
        let file = if requested == name {
            path.to_owned()
        } else {
            folder.join(requested)
        };
        read_text_up_to(&file, MAX_SETTINGS_BYTES).map_err(|error| error.to_string())
    };
    let scene = Scene::resolve(&name, &read).map_err(Failure::failed)?;
    let cloud = match &scene.cloud {
        Some(cloud) => Some(
            clouds::load(&folder.join(&cloud.file), None)?
                .measured
                .points,
        ),
        None => None,
    };
    let world = scene.build(cloud.as_deref()).map_err(Failure::failed)?;
    Ok(LoadedScene {
        world: Arc::new(world),
        map_from_base: scene.map_from_base,
    })
}
