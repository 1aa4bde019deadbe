//! Finding and reading the files: the main file, then the folder beside it, in the order of names.

use super::check::{Mistake, Problem};
use super::layers::{Layers, Source};
use super::settings::Settings;
use super::value::Value;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file that is read when none is named.
pub const DEFAULT_FILE: &str = "/etc/patrold/patrold.toml";

/// A configuration that passed every check.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The settings in force.
    pub settings: Settings,
    /// Every value with its origin.
    pub layers: Layers,
    /// The files that were read, in order.
    pub files: Vec<PathBuf>,
}

/// Reads the configuration: defaults, `file` (or the default file where that exists), the `.d` folder beside
/// it, then `flags` of the command line.
///
/// # Errors
/// Every mistake of every file at once.
pub fn load(file: Option<&Path>, flags: &[(&str, Value)]) -> Result<Loaded, Vec<Mistake>> {
    let main = file.unwrap_or(Path::new(DEFAULT_FILE));
    let mut paths = Vec::new();
    if file.is_some() || main.exists() {
        paths.push(main.to_owned());
    }
    let mut mistakes = Vec::new();
    match folder_beside(main) {
        Ok(more) => paths.extend(more),
        Err((path, error)) => mistakes.push(unreadable(&path, &error)),
    }
    let mut layers = Layers::defaults();
    for path in &paths {
        match fs::read_to_string(path) {
            Ok(text) => {
                let path = path.clone();
                mistakes.extend(layers.add(&Source { path, text }));
            }
            Err(error) => mistakes.push(unreadable(path, &error)),
        }
    }
    layers.anchor_paths(main.parent().unwrap_or(Path::new("")));
    for (name, value) in flags {
        layers.set_flag(name, value.clone());
    }
    match Settings::build(&layers) {
        Ok(settings) if mistakes.is_empty() => Ok(Loaded {
            settings,
            layers,
            files: paths,
        }),
        Ok(_) => Err(mistakes),
        Err(more) => {
            mistakes.extend(more);
            Err(mistakes)
        }
    }
}

/// `patrold.toml` has its folder in `patrold.d`.
fn folder_beside(main: &Path) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
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

fn unreadable(path: &Path, error: &io::Error) -> Mistake {
    Mistake {
        file: path.to_owned(),
        line: 0,
        problem: Problem::Unreadable(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::load;
    use std::fs;

    #[test]
    fn the_folder_beside_the_file_wins_over_it_in_the_order_of_names() {
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
        let mistakes = load(Some(std::path::Path::new("no/such.toml")), &[]).expect_err("missing");
        assert!(
            mistakes[0]
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
