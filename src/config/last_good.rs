//! The last configuration that was in force, kept in the store's folder: a start with a bad one uses it.

use super::error::ConfigError;
use super::layers::{ConfigFile, ConfigLayers, PATH_KEYS, ValueOrigin};
use super::load::{LoadedConfig, load_leniently};
use super::settings::Settings;
use super::toml_text::toml_line;
use super::value::ConfigValue;
use crate::bounded_file::{MAX_SETTINGS_BYTES, read_text_up_to};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf, absolute};

/// Its name in the store's folder.
const FILE_NAME: &str = "last-good.toml";
const HEADER: &str = "# The configuration that was in force last, written by patrold: used where the files of the configuration have
# mistakes. Changes belong there.
";

/// Keeps what is in force: written aside, synced, renamed.
///
/// # Errors
/// The folder cannot be written; what was kept before stays.
pub fn keep_last_good(loaded: &LoadedConfig) -> io::Result<()> {
    let folder = &loaded.settings.store.dir;
    let path = folder.join(FILE_NAME);
    let text = to_toml(&loaded.layers)?;
    if read_text_up_to(&path, MAX_SETTINGS_BYTES).is_ok_and(|kept| kept == text) {
        return Ok(());
    }
    let aside = path.with_extension("toml.tmp");
    let written = File::create(&aside).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    written
        .and_then(|()| fs::rename(&aside, &path))
        .inspect_err(|_| {
            // Nothing is left where the disk is full.
            let _ = fs::remove_file(&aside);
        })?;
    File::open(folder)?.sync_all()
}

/// What was in force last, where the configuration in `file` (or the default file) is refused for `errors`.
///
/// # Errors
/// `errors`, and those of the kept configuration where there is one.
pub fn load_last_good(
    file: Option<&Path>,
    errors: Vec<ConfigError>,
) -> Result<LoadedConfig, Vec<ConfigError>> {
    // The place of the store is read from the bad one; where that cannot be read at all, it is the default place.
    let settings =
        load_leniently(file).map_or_else(|_| Settings::defaults(), |(settings, _)| settings);
    let path = settings.store.dir.join(FILE_NAME);
    let Ok(text) = read_text_up_to(&path, MAX_SETTINGS_BYTES) else {
        return Err(errors);
    };
    let mut layers = ConfigLayers::defaults();
    let file = ConfigFile {
        path: path.clone(),
        text,
    };
    let mut more = layers.add(&file);
    layers.apply_engine_thresholds();
    match Settings::from_layers(&layers) {
        Ok(settings) if more.is_empty() => Ok(LoadedConfig {
            settings,
            layers,
            files: vec![path],
            refused: errors,
        }),
        result => {
            more.extend(result.err().unwrap_or_default());
            Err(errors.into_iter().chain(more).collect())
        }
    }
}

/// All values that differ from the defaults, a line each.
fn to_toml(layers: &ConfigLayers) -> io::Result<String> {
    let mut text = HEADER.to_owned();
    for (name, (value, origin)) in &layers.values {
        let value = match value {
            ConfigValue::Text(path) if PATH_KEYS.contains(&name.as_str()) => {
                let path: PathBuf = absolute(path)?;
                ConfigValue::Text(path.to_string_lossy().into_owned())
            }
            value => value.clone(),
        };
        if *origin != ValueOrigin::Default {
            text.push_str(&toml_line(name, &value));
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::{FILE_NAME, keep_last_good, load_last_good};
    use crate::config::{Settings, load};
    use std::fs;

    #[test]
    fn a_kept_configuration_is_the_one_that_was_in_force() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        let text = "store.dir = \"log\"\nrobot.name = \"a \\\"b\\\" \\u00e9\\u001b\"\nnovelty.engine = \"paper\"\n\
                    sweep.pans_deg = [0.0, 90.0]\nptu.home_at_start = false\nlaser.baud = 19200\n\
                    [waypoint.\"dock.2\"]\nu_th_m = 1e-7\nmap_pose = [1.5, -2.0, 90.0]\n";
        fs::write(&file, text).expect("written");
        let loaded = load(Some(&file), &[]).expect("valid");
        assert!(keep_last_good(&loaded).is_err(), "no folder yet");
        fs::create_dir(dir.path().join("log")).expect("folder");
        keep_last_good(&loaded).expect("kept");
        keep_last_good(&loaded).expect("kept again");

        for bad in [
            "store.dir = \"log\"\nlaser.baud = \"fast\"\n",
            "store.dir = \"log\"\n[novelty\n",
        ] {
            fs::write(&file, bad).expect("written");
            let errors = load(Some(&file), &[]).expect_err("bad");
            let good = load_last_good(Some(&file), errors.clone()).expect("the last good one");
            // They come from another file now.
            let origins = loaded.settings.origins.clone();
            let settings = Settings {
                origins,
                ..good.settings
            };
            assert_eq!(settings, loaded.settings);
            assert_eq!((good.refused, good.files.len()), (errors, 1));
        }
        let kept = dir.path().join("log").join(FILE_NAME);
        let left: Vec<_> = fs::read_dir(dir.path().join("log"))
            .expect("folder")
            .collect();
        assert_eq!(left.len(), 1, "nothing aside");
        fs::write(&kept, "laser.baud = 7\n").expect("damaged");
        let errors = load(Some(&file), &[]).expect_err("bad");
        assert_eq!(
            load_last_good(Some(&file), errors).expect_err("both").len(),
            2
        );
        fs::remove_file(&kept).expect("removed");
        let errors = load(Some(&file), &[]).expect_err("bad");
        assert_eq!(
            load_last_good(Some(&file), errors.clone()).expect_err("none"),
            errors
        );
    }
}
