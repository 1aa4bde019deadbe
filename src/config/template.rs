//! The commented file that ships: every key with its unit, its default and when to change it.

use super::keys::{KEYS, Key, WAYPOINT_KEYS};
use std::fmt::Write as _;

const HEADER: &str = "\
# patrold's configuration. Every key stands here with its default, commented out: an empty file is valid.
# Check a change with `patrold config check`, see what is in force with `patrold config show`, and apply it to
# the running service with `systemctl reload patrold`. Files in patrold.d/*.toml beside this one win over it.
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

fn describe(text: &mut String, key: &Key, name: &str) {
    let unit = if key.unit.is_empty() {
        String::new()
    } else {
        format!(" [{}]", key.unit)
    };
    // Writing to a String cannot fail.
    let _ = writeln!(text, "# {} ({}){unit}", key.about, key.kind);
    let _ = writeln!(text, "# {name} = {}", key.default);
}

#[cfg(test)]
mod tests {
    use super::template;
    use crate::config::{Layers, Settings, Source};
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
        assert_eq!(
            text,
            template(),
            "UPDATE_EXPECT=1 cargo test writes it anew"
        );
    }

    #[test]
    fn with_its_comment_signs_taken_off_it_changes_nothing() {
        let uncommented: String = template()
            .lines()
            .map_while(|line| (!line.contains("One table for each")).then_some(line))
            .map(|line| match line.strip_prefix("# ") {
                Some(setting) if setting.split(" = ").next().is_some_and(is_key) => setting,
                _ => line,
            })
            .fold(String::new(), |text, line| text + line + "\n");
        let mut layers = Layers::defaults();
        let path = PathBuf::from("shipped");
        let mistakes = layers.add(&Source {
            path,
            text: uncommented.clone(),
        });
        assert!(mistakes.is_empty(), "{mistakes:?}");
        assert!(
            uncommented
                .lines()
                .filter(|l| l.contains(" = ") && !l.starts_with('#'))
                .count()
                > 30
        );
        assert_eq!(
            Settings::build(&layers).expect("valid"),
            Settings::defaults()
        );
    }

    fn is_key(word: &str) -> bool {
        word.chars()
            .all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit())
    }
}
