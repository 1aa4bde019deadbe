//! Finds and reads the files: the main file, then those of the `.d` folder beside it in order of name.

use super::error::{ConfigError, ConfigProblem};
use super::layers::{ConfigFile, ConfigLayers};
use super::settings::Settings;
use super::value::ConfigValue;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Read when no file is named.
const DEFAULT_FILE: &str = "/etc/patrold/patrold.toml";

/// A configuration without errors.
#[derive(Debug, Clone)]
pub struct LoadedConfig {
    /// The settings in force.
    pub settings: Settings,
    /// All values with their origins.
    pub layers: ConfigLayers,
    /// The files that were read, in order.
    pub files: Vec<PathBuf>,
}

/// Reads the configuration: defaults, `file` (or the default file if it exists), the `.d` folder beside it, then the
/// command-line `flags`.
///
/// # Errors
/// All errors of all files.
pub fn load(
    file: Option<&Path>,
    flags: &[(&str, ConfigValue)],
) -> Result<LoadedConfig, Vec<ConfigError>> {
    let main = file.unwrap_or(Path::new(DEFAULT_FILE));
    let mut paths = Vec::new();
    if file.is_some() || main.exists() {
        paths.push(main.to_owned());
    }
    let mut errors = Vec::new();
    match files_beside(main) {
        Ok(more) => paths.extend(more),
        Err((path, error)) => errors.push(unreadable(&path, &error)),
    }
    let mut layers = ConfigLayers::defaults();
    for path in &paths {
        match fs::read_to_string(path) {
            Ok(text) => {
                let path = path.clone();
                errors.extend(layers.add(&ConfigFile { path, text }));
            }
            Err(error) => errors.push(unreadable(path, &error)),
        }
    }
    layers.anchor_paths(main.parent().unwrap_or(Path::new("")));
    for (name, value) in flags {
        layers.set_from_flag(name, value.clone());
    }
    layers.apply_engine_thresholds();
    match Settings::from_layers(&layers) {
        Ok(settings) if errors.is_empty() => Ok(LoadedConfig {
            settings,
            layers,
            files: paths,
        }),
        Ok(_) => Err(errors),
        Err(more) => {
            errors.extend(more);
            Err(errors)
        }
    }
}

/// The files of `patrold.d/` beside `patrold.toml`.
fn files_beside(main: &Path) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
    let folder = main.with_extension("d");
    let entries = match fs::read_dir(&folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err((folder, error)),
    };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    Ok(files)
}

fn unreadable(path: &Path, error: &io::Error) -> ConfigError {
    ConfigError {
        file: path.to_owned(),
        line: 0,
        problem: ConfigProblem::Unreadable(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::load;
    use std::fs;

    #[test]
    fn files_of_the_folder_win_over_the_main_file_in_order_of_name() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        fs::write(&file, "novelty.u_th_m = 0.1\nrobot.name = \"a\"\n").expect("written");
        fs::create_dir(dir.path().join("patrold.d")).expect("folder");
        fs::write(
            dir.path().join("patrold.d/20.toml"),
            "novelty.u_th_m = 0.3\n",
        )
        .expect("20");
        fs::write(
            dir.path().join("patrold.d/10.toml"),
            "novelty.u_th_m = 0.2\n",
        )
        .expect("10");
        let loaded = load(Some(&file), &[]).expect("valid");
        assert_eq!(loaded.settings.novelty.u_th_m, 0.3);
        assert_eq!(loaded.settings.robot.name, "a");
        assert_eq!(loaded.files.len(), 3);
    }

    #[test]
    fn a_named_file_must_exist() {
        let errors = load(Some(std::path::Path::new("no/such.toml")), &[]).expect_err("missing");
        assert!(
            errors[0]
                .to_string()
                .starts_with("no/such.toml: cannot be read")
        );
    }

    #[test]
    fn paths_are_relative_to_the_folder_of_the_main_file() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        fs::write(&file, "store.dir = \"store\"\n").expect("written");
        fs::create_dir(dir.path().join("patrold.d")).expect("folder");
        fs::write(
            dir.path().join("patrold.d/1.toml"),
            "api.socket = \"run/s\"\n",
        )
        .expect("1");
        let settings = load(Some(&file), &[]).expect("valid").settings;
        assert_eq!(settings.store.dir, dir.path().join("store"));
        assert_eq!(settings.api.socket, dir.path().join("run/s"));
        fs::write(&file, "store.dir = \"/var/s\"\n").expect("written");
        let settings = load(Some(&file), &[]).expect("valid").settings;
        assert_eq!(settings.store.dir, std::path::Path::new("/var/s"));
    }
}
