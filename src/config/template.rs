//! The shipped configuration file: every key with description, kind, unit and default, commented out.

use super::keys::{ConfigKey, KEYS};
use super::waypoint_keys::WAYPOINT_KEYS;
use std::fmt::Write as _;

const HEADER: &str = "\
# Configuration of patrold. Every key with its default, commented out; an empty file is valid.
# `patrold config check` checks a change, `patrold config show` shows the values in force, `systemctl reload patrold`
# applies a change to the running service. Files in patrold.d/*.toml beside this one override it.
";

/// Text of `config/patrold.toml`.
pub fn template() -> String {
    let mut text = HEADER.to_owned();
    let mut section = "";
    for key in KEYS {
        let (own_section, name) = key.name.split_once('.').unwrap_or(("", key.name));
        if own_section != section {
            section = own_section;
            let _ = write!(text, "\n[{section}]\n");
        }
        describe(&mut text, key, name);
    }
    text.push_str(
        "\n# One table for each waypoint that differs, by its name.\n# [waypoint.NAME]\n",
    );
    for key in WAYPOINT_KEYS {
        describe(&mut text, key, key.name);
    }
    text
}

fn describe(text: &mut String, key: &ConfigKey, name: &str) {
    let unit = if key.unit.is_empty() {
        String::new()
    } else {
        format!(" [{}]", key.unit)
    };
    // Writing to a String cannot fail.
    let _ = writeln!(text, "# {} ({}){unit}", key.description, key.kind);
    let _ = writeln!(text, "# {name} = {}", key.default);
}

#[cfg(test)]
mod tests {
    use super::template;
    use crate::config::{ConfigFile, ConfigLayers, Settings};
    use std::path::PathBuf;

    fn shipped() -> PathBuf {
        patrold_test_support::workspace_root().join("config/patrold.toml")
    }

    #[test]
    fn the_shipped_file_is_this_text() {
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(shipped(), template()).expect("written");
        }
        let text = std::fs::read_to_string(shipped()).expect("config/patrold.toml");
        assert_eq!(text, template(), "UPDATE_EXPECT=1 cargo test rewrites it");
    }

    #[test]
    fn uncommented_it_changes_nothing() {
        let uncommented: String = template()
            .lines()
            .map_while(|line| (!line.contains("One table for each")).then_some(line))
            .map(|line| match line.strip_prefix("# ") {
                Some(setting) if setting.split(" = ").next().is_some_and(is_key) => setting,
                _ => line,
            })
            .fold(String::new(), |text, line| text + line + "\n");
        let mut layers = ConfigLayers::defaults();
        let path = PathBuf::from("shipped");
        let errors = layers.add(&ConfigFile {
            path,
            text: uncommented.clone(),
        });
        assert!(errors.is_empty(), "{errors:?}");
        assert!(
            uncommented
                .lines()
                .filter(|l| l.contains(" = ") && !l.starts_with('#'))
                .count()
                > 30
        );
        let mut settings = Settings::from_layers(&layers).expect("valid");
        settings.origins = Settings::defaults().origins;
        assert_eq!(settings, Settings::defaults());
    }

    fn is_key(word: &str) -> bool {
        word.chars()
            .all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit())
    }
}
