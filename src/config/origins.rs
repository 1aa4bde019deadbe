//! Where files and flags set values: what an error about a setting quotes, so that one sees which file wins.

use super::layers::{ConfigLayers, ValueOrigin};
use std::collections::BTreeMap;
use std::fmt;

/// Where values were set, as the files were when they were read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SettingOrigins {
    /// By dotted name, the one in force first, then those it wins over. What has its default is absent.
    set_by: BTreeMap<String, Vec<ValueOrigin>>,
}

impl SettingOrigins {
    pub(super) fn from_layers(layers: &ConfigLayers) -> Self {
        let set = layers.values.iter().filter_map(|(name, (_, origin))| {
            let lower = layers.overridden.get(name).into_iter().flatten().rev();
            let all = std::iter::once(origin).chain(lower);
            let set: Vec<_> = all
                .filter(|origin| **origin != ValueOrigin::Default)
                .cloned()
                .collect();
            (!set.is_empty()).then(|| (name.clone(), set))
        });
        Self {
            set_by: set.collect(),
        }
    }

    /// The key for an error: `laser.port, set by b.toml:1, which wins over a.toml:7`.
    pub fn quote(&self, key: &str) -> String {
        let set: Vec<String> = self.set_by.get(key).map_or_else(Vec::new, |origins| {
            origins.iter().map(ToString::to_string).collect()
        });
        match set.as_slice() {
            [] => format!("{key}, its default"),
            [only] => format!("{key}, set by {only}"),
            [first, lower @ ..] => {
                format!(
                    "{key}, set by {first}, which wins over {}",
                    lower.join(", ")
                )
            }
        }
    }
}

impl fmt::Display for ValueOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File(path, line) => write!(f, "{}:{line}", path.display()),
            Self::Flag => f.write_str("command line"),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::config::{ConfigFile, ConfigLayers, ConfigValue, Settings};
    use std::path::PathBuf;

    #[test]
    fn a_setting_is_quoted_with_the_place_that_wins_and_those_that_lose() {
        let mut layers = ConfigLayers::defaults();
        let mut quoted = |path: &str, text: &str| {
            let (path, text) = (PathBuf::from(path), text.to_owned());
            assert_eq!(layers.add(&ConfigFile { path, text }), []);
            let settings = Settings::from_layers(&layers).expect("valid");
            settings.origins.quote("laser.port")
        };
        assert_eq!(quoted("a.toml", ""), "laser.port, its default");
        let by_hand = "[laser]\n\nport = \"tcp:10.0.0.2:10940\"\n";
        assert_eq!(quoted("a.toml", by_hand), "laser.port, set by a.toml:3");
        assert_eq!(
            quoted("a.d/10.toml", "laser.port = \"/dev/ttyACM0\"\n"),
            "laser.port, set by a.d/10.toml:1, which wins over a.toml:3"
        );
        layers.set_from_flag("laser.port", ConfigValue::Text("/dev/x".to_owned()));
        let settings = Settings::from_layers(&layers).expect("valid");
        assert_eq!(
            settings.origins.quote("laser.port"),
            "laser.port, set by command line, which wins over a.d/10.toml:1, a.toml:3"
        );
    }
}
