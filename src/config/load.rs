//! Finds and reads the files: the main file, then those of the `.d` folder beside it in order of name. What editors and package
//! managers leave there is passed over.

use super::error::{ConfigError, ConfigProblem};
use super::layers::{ConfigFile, ConfigLayers};
use super::settings::Settings;
use super::value::ConfigValue;
use crate::bounded_file::{MAX_SETTINGS_BYTES, read_text_up_to};
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
    /// Why the files of the configuration are not in force; empty where they are.
    pub refused: Vec<ConfigError>,
}

/// All that the files say, right or wrong.
struct ReadFiles {
    layers: ConfigLayers,
    files: Vec<PathBuf>,
    errors: Vec<ConfigError>,
    /// Whether the main file could not be read.
    main_unreadable: bool,
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
    let ReadFiles {
        mut layers,
        files,
        mut errors,
        ..
    } = read_files(file);
    for (name, value) in flags {
        layers.set_from_flag(name, value.clone());
    }
    layers.apply_engine_thresholds();
    match Settings::from_layers(&layers) {
        Ok(settings) if errors.is_empty() => Ok(LoadedConfig {
            settings,
            layers,
            files,
            refused: Vec::new(),
        }),
        Ok(_) => Err(errors),
        Err(more) => {
            errors.extend(more);
            Err(errors)
        }
    }
}

/// Reads what is right in the configuration, for commands that need little of it: the place of the store, the socket, poses on the
/// map. The errors of all files come with it.
///
/// # Errors
/// The main file cannot be read, so that nothing is known.
pub fn load_leniently(
    file: Option<&Path>,
) -> Result<(Settings, Vec<ConfigError>), Vec<ConfigError>> {
    let mut read = read_files(file);
    if read.main_unreadable {
        return Err(read.errors);
    }
    read.layers.apply_engine_thresholds();
    let (settings, contradictions) = Settings::from_layers_leniently(&read.layers);
    read.errors.extend(contradictions);
    Ok((settings, read.errors))
}

/// The main file: `file`, or the default one.
pub(super) fn main_file(file: Option<&Path>) -> &Path {
    file.unwrap_or(Path::new(DEFAULT_FILE))
}

/// The folder whose files come after the main file.
pub fn drop_in_folder(file: Option<&Path>) -> PathBuf {
    main_file(file).with_extension("d")
}

fn read_files(file: Option<&Path>) -> ReadFiles {
    let main = main_file(file);
    let mut files = Vec::new();
    if file.is_some() || main.exists() {
        files.push(main.to_owned());
    }
    let mut errors = Vec::new();
    match files_beside(main) {
        Ok(more) => files.extend(more),
        Err((path, error)) => errors.push(unreadable(&path, &error)),
    }
    let mut layers = ConfigLayers::defaults();
    let mut main_unreadable = false;
    for path in &files {
        match read_text_up_to(path, MAX_SETTINGS_BYTES) {
            Ok(text) => {
                let path = path.clone();
                errors.extend(layers.add(&ConfigFile { path, text }));
            }
            Err(error) => {
                main_unreadable |= path == main;
                errors.push(unreadable(path, &error));
            }
        }
    }
    layers.anchor_paths(main.parent().unwrap_or(Path::new("")));
    ReadFiles {
        layers,
        files,
        errors,
        main_unreadable,
    }
}

/// The files of `patrold.d/` beside `patrold.toml`.
fn files_beside(main: &Path) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
    let folder = drop_in_folder(Some(main));
    let entries = match fs::read_dir(&folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err((folder, error)),
    };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| is_drop_in(path))
        .collect();
    files.sort();
    Ok(files)
}

/// Whether a file of the folder counts: `NAME.toml`. Hidden files, locks and what ends otherwise (`x.toml~`, `#x.toml#`,
/// `x.toml.bak`, `x.toml.dpkg-old`, `.x.toml.swp`, `.#x.toml`) are leftovers.
fn is_drop_in(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.ends_with(".toml") && !name.starts_with(['.', '#', '~'])
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
    use super::{load, load_leniently};
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn leftovers_of_editors_and_packages_are_passed_over() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        fs::write(&file, "").expect("written");
        let folder = dir.path().join("patrold.d");
        fs::create_dir(&folder).expect("folder");
        fs::write(folder.join("x.toml"), "novelty.u_th_m = 0.2\n").expect("x");
        for leftover in [
            "x.toml~",
            "#x.toml#",
            "x.toml.bak",
            "x.toml.swp",
            ".x.toml.swp",
            ".x.toml",
            "x.toml.dpkg-old",
            "x.toml.dpkg-dist",
            "x.toml.ucf-new",
            "x.toml.rpmsave",
            "x.toml.orig",
            "~x.toml",
            "README",
        ] {
            fs::write(folder.join(leftover), "novelty.u_th_m = 0.9\nnonsense\n").expect("leftover");
        }
        // The lock of Emacs: a link to nowhere.
        symlink("ana@host.123", folder.join(".#x.toml")).expect("link");
        let loaded = load(Some(&file), &[]).expect("valid");
        assert_eq!(loaded.settings.novelty.u_th_m, 0.2);
        assert_eq!(loaded.files, [file, folder.join("x.toml")]);
    }

    #[test]
    fn what_is_right_is_read_from_a_file_with_errors() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        for (wrong, errors) in [
            ("novelty.u_th = 1\n", 1),
            ("novelty.u_th_m 0.1\n", 1),
            (
                "laser.baud = 1\nnovelty.ground = \"fm\"\nnovelty.u_th_m = 0.1\n",
                2,
            ),
        ] {
            let text = format!("store.dir = \"log\"\n{wrong}[api]\nsocket = \"s\"\n");
            fs::write(&file, text).expect("written");
            assert!(load(Some(&file), &[]).is_err());
            let (settings, found) = load_leniently(Some(&file)).expect("read");
            assert_eq!(found.len(), errors, "{found:?}");
            assert_eq!(settings.store.dir, dir.path().join("log"));
            assert_eq!(settings.api.socket, dir.path().join("s"));
        }
        assert!(load_leniently(Some(&dir.path().join("none.toml"))).is_err());
    }

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
