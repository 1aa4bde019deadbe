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

/// Reads a scene file; paths in it, and in those that it extends, are relative to the file that has them.
///
/// # Errors
/// The first error in any of its files, with file and line.
pub(super) fn load(path: &Path) -> Result<LoadedScene, Failure> {
    let name = path.to_string_lossy();
    let read = |file: &str| {
        read_text_up_to(Path::new(file), MAX_SETTINGS_BYTES).map_err(|error| error.to_string())
    };
    let scene = Scene::resolve(&name, &read).map_err(Failure::failed)?;
    let cloud = match &scene.cloud {
        Some(cloud) => Some(clouds::load(Path::new(&cloud.file), None)?.measured.points),
        None => None,
    };
    let world = scene.build(cloud.as_deref()).map_err(Failure::failed)?;
    Ok(LoadedScene {
        world: Arc::new(world),
        map_from_base: scene.map_from_base,
    })
}

#[cfg(test)]
mod tests {
    use super::load;
    use std::fs;

    #[test]
    fn a_scene_extends_one_of_another_folder_and_that_one_of_its_own() {
        let dir = tempfile::tempdir().expect("temp dir");
        let at = |name: &str| dir.path().join(name);
        for folder in ["site", "shipped"] {
            fs::create_dir(at(folder)).expect("made");
        }
        let office = "[[room]]\ncentre = [0, 0, 1.3]\nsize = [6, 4, 2.6]\n";
        let cloud = "extends = \"office.toml\"\n[cloud]\nfile = \"wall.xyz\"\n";
        for (file, text) in [
            ("shipped/office.toml", office),
            ("shipped/cloud.toml", cloud),
            ("shipped/wall.xyz", "1 0 1\n1 0.1 1\n1 0 1.1\n"),
            (
                "site/mine.toml",
                "extends = \"../shipped/cloud.toml\"\n[[sphere]]\nname = \"ball\"\ncentre = [1, 1, 0.5]\nradius_m = 0.2\n",
            ),
        ] {
            fs::write(at(file), text).expect("written");
        }
        let scene = load(&at("site/mine.toml"))
            .map_err(|e| e.to_string())
            .expect("loads");
        assert!(scene.world.object_named("ball").is_some());
        let absolute = format!("extends = {:?}\n", at("shipped/office.toml"));
        fs::write(at("site/absolute.toml"), absolute).expect("written");
        assert!(load(&at("site/absolute.toml")).is_ok());
        fs::write(at("site/wrong.toml"), "extends = \"office.toml\"\n").expect("written");
        let error = load(&at("site/wrong.toml"))
            .err()
            .expect("not there")
            .to_string();
        assert!(error.contains("site/office.toml"), "{error}");
    }
}
