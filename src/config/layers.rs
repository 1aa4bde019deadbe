//! Layers of configuration: defaults, main file, `.d` folder, command line. Later layers win; each value keeps its
//! origin.

use super::error::{ConfigError, ConfigProblem};
use super::key_lookup::{find_key, nearest_key};
use super::keys::KEYS;
use super::value::ConfigValue;
use patrold_engine::inspect::{Engine, EngineSettings};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Lines of a file that may be wrong before nothing of it is read.
const MAX_SYNTAX_ERRORS: usize = 20;
/// Keys whose value is a path.
pub(super) const PATH_KEYS: [&str; 2] = ["store.dir", "api.socket"];

/// Text of one configuration file.
#[derive(Debug, Clone)]
pub struct ConfigFile {
    /// Its path, for messages.
    pub path: PathBuf,
    /// Its content.
    pub text: String,
}

/// Where a value was set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ValueOrigin {
    /// The built-in default.
    Default,
    /// File and line.
    File(PathBuf, usize),
    /// A command-line flag.
    Flag,
}

/// The values in force.
#[derive(Debug, Clone)]
pub struct ConfigLayers {
    /// Value and origin by dotted name.
    pub values: BTreeMap<String, (ConfigValue, ValueOrigin)>,
    /// By dotted name where else it was set, the lowest layer first.
    pub(super) overridden: BTreeMap<String, Vec<ValueOrigin>>,
}

impl ConfigLayers {
    /// The defaults alone.
    pub fn defaults() -> Self {
        let values = KEYS
            .iter()
            .filter_map(|key| {
                let value = key.default_value()?;
                Some((key.name.to_owned(), (value, ValueOrigin::Default)))
            })
            .collect();
        Self {
            values,
            overridden: BTreeMap::new(),
        }
    }

    /// Gives thresholds that nothing sets the default of the engine in force: the engines' distances differ in size.
    pub fn apply_engine_thresholds(&mut self) {
        let engine = match self.values.get("novelty.engine") {
            Some((ConfigValue::Text(name), _)) => name.parse().unwrap_or(Engine::Standard),
            _ => Engine::Standard,
        };
        let novelty = EngineSettings::for_engine(engine).novelty;
        for (key, u_th) in [
            ("novelty.u_th_m", novelty.u_th_m),
            ("novelty.u_th_fm", novelty.u_th_fm),
        ] {
            if let Some((value, ValueOrigin::Default)) = self.values.get_mut(key) {
                *value = ConfigValue::Float(u_th);
            }
        }
    }

    /// Adds a file as the top layer. Returns its errors; its valid values take effect.
    pub fn add(&mut self, source: &ConfigFile) -> Vec<ConfigError> {
        let lines = LineFinder::new(&source.text);
        let mut reader = FileReader {
            path: &source.path,
            lines,
            found: Vec::new(),
            errors: Vec::new(),
        };
        let (table, errors) = DeTable::parse_recoverable(&source.text);
        if errors.is_empty() {
            reader.walk("", 1, table.get_ref());
        } else {
            let readable = without_syntax_errors(&source.text);
            reader.walk("", 1, DeTable::parse_recoverable(&readable).0.get_ref());
            // What follows from the syntax errors is no news.
            reader.errors.clear();
        }
        for error in errors {
            let line = error.span().map_or(0, |s| reader.lines.line_of(s.start));
            let first = error.message().lines().next().unwrap_or_default();
            reader.error(line, ConfigProblem::Syntax(first.to_owned()));
        }
        for (name, value, line) in reader.found {
            let origin = ValueOrigin::File(source.path.clone(), line);
            self.set(name, value, origin);
        }
        reader.errors
    }

    /// Sets a value from a command-line flag.
    pub fn set_from_flag(&mut self, name: &str, value: ConfigValue) {
        self.set(name.to_owned(), value, ValueOrigin::Flag);
    }

    fn set(&mut self, name: String, value: ConfigValue, origin: ValueOrigin) {
        if let Some((_, lower)) = self.values.insert(name.clone(), (value, origin)) {
            self.overridden.entry(name).or_default().push(lower);
        }
    }

    /// File and line of the first of `keys` that a file sets, for an error about all of them.
    pub(super) fn location(&self, keys: &[&str]) -> (PathBuf, usize) {
        let origins = || keys.iter().filter_map(|key| self.values.get(*key));
        let in_file = origins().find_map(|(_, origin)| match origin {
            ValueOrigin::File(path, line) => Some((path.clone(), *line)),
            ValueOrigin::Default | ValueOrigin::Flag => None,
        });
        let by_flag = || {
            let given = origins().any(|(_, origin)| *origin == ValueOrigin::Flag);
            given.then(|| (PathBuf::from("command line"), 0))
        };
        in_file
            .or_else(by_flag)
            .unwrap_or_else(|| (PathBuf::from("defaults"), 0))
    }

    /// Resolves relative paths set by a file against `folder`, that of the main file, so that they do not depend on the
    /// working directory.
    pub(super) fn anchor_paths(&mut self, folder: &Path) {
        for key in PATH_KEYS {
            if let Some((ConfigValue::Text(path), ValueOrigin::File(..))) = self.values.get_mut(key)
            {
                *path = folder.join(&*path).to_string_lossy().into_owned();
            }
        }
    }
}

/// The text with the lines of syntax errors blank, one after the other; all is blank where that leads nowhere.
fn without_syntax_errors(text: &str) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    for _ in 0..MAX_SYNTAX_ERRORS {
        let readable = lines.join("\n");
        let (_, errors) = DeTable::parse_recoverable(&readable);
        let at = errors
            .first()
            .map(|error| error.span().map_or(0, |span| span.start));
        let Some(at) = at else {
            return readable;
        };
        // An error at the very end belongs to the last line that has something.
        let line = LineFinder::new(&readable).line_of(at).min(lines.len());
        match lines[..line]
            .iter()
            .rposition(|line| !line.trim().is_empty())
        {
            Some(wrong) => lines[wrong] = "",
            None => break,
        }
    }
    String::new()
}

struct FileReader<'a> {
    path: &'a Path,
    lines: LineFinder,
    found: Vec<(String, ConfigValue, usize)>,
    errors: Vec<ConfigError>,
}

impl FileReader<'_> {
    fn walk(&mut self, prefix: &str, depth: usize, table: &DeTable<'_>) {
        for (key, value) in table {
            let name = format!("{prefix}{}", key.get_ref());
            let line = self.lines.line_of(key.span().start);
            match (value.get_ref(), is_table_name(&name, depth)) {
                (DeValue::Table(inner), true) => self.walk(&format!("{name}."), depth + 1, inner),
                (given, _) => self.read_value(name, given, line),
            }
        }
    }

    fn read_value(&mut self, name: String, given: &DeValue<'_>, line: usize) {
        let Some(key) = find_key(&name) else {
            let nearest = nearest_key(&name);
            return self.error(line, ConfigProblem::UnknownKey { key: name, nearest });
        };
        match key.kind.parse(given) {
            Ok(value) => self.found.push((name, value, line)),
            Err(got) => {
                let expected = key.kind.to_string();
                let key = name;
                self.error(line, ConfigProblem::BadValue { key, expected, got });
            }
        }
    }

    fn error(&mut self, line: usize, problem: ConfigProblem) {
        self.errors.push(ConfigError {
            file: self.path.to_owned(),
            line,
            problem,
        });
    }
}

/// Whether `name` at this nesting depth may be a table: a section, `waypoint`, or `waypoint.NAME`.
fn is_table_name(name: &str, depth: usize) -> bool {
    if name == "waypoint" || name.starts_with("waypoint.") {
        return depth <= 2;
    }
    depth == 1 && KEYS.iter().any(|k| k.name.starts_with(&format!("{name}.")))
}

struct LineFinder {
    starts: Vec<usize>,
}

impl LineFinder {
    fn new(text: &str) -> Self {
        let after_breaks = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            starts: std::iter::once(0).chain(after_breaks).collect(),
        }
    }

    fn line_of(&self, byte: usize) -> usize {
        self.starts.partition_point(|start| *start <= byte)
    }
}

#[cfg(test)]
mod tests {
    use super::{ConfigFile, ConfigLayers, ValueOrigin};
    use crate::config::ConfigValue;
    use patrold_engine::inspect::{Engine, EngineSettings};
    use std::path::PathBuf;

    fn source(text: &str) -> ConfigFile {
        ConfigFile {
            path: PathBuf::from("patrold.toml"),
            text: text.to_owned(),
        }
    }

    #[test]
    fn all_errors_are_reported_at_once_with_their_lines() {
        let mut layers = ConfigLayers::defaults();
        let errors = layers.add(&source(
            "[novelty]\nu_th = 0.1\nground = \"manhattan\"\n[laser]\nbaud = nan\n[lazer]\nport = \"x\"\n[ptu]\nport = \"tcp:host\"\n",
        ));
        let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
        assert_eq!(texts.len(), 5, "{texts:?}");
        assert!(texts.contains(
            &"patrold.toml:2: unknown key novelty.u_th; did you mean novelty.u_th_m?".to_owned()
        ));
        assert!(
            texts
                .iter()
                .any(|m| m.starts_with("patrold.toml:3: novelty.ground wants one of"))
        );
        assert!(
            texts
                .iter()
                .any(|m| m.starts_with("patrold.toml:5: laser.baud wants a whole number"))
        );
        assert!(
            texts
                .iter()
                .any(|m| m.starts_with("patrold.toml:6: unknown key lazer"))
        );
        assert!(
            texts
                .iter()
                .any(|m| m.starts_with("patrold.toml:9: ptu.port wants a serial device"))
        );
    }

    #[test]
    fn later_layers_win_and_values_keep_their_origin() {
        let mut layers = ConfigLayers::defaults();
        assert!(layers.add(&source("novelty.u_th_m = 0.25\n")).is_empty());
        layers.set_from_flag("novelty.ground", ConfigValue::Text("euclid".to_owned()));
        let (value, origin) = &layers.values["novelty.u_th_m"];
        assert_eq!(*value, ConfigValue::Float(0.25));
        assert_eq!(*origin, ValueOrigin::File(PathBuf::from("patrold.toml"), 1));
        assert_eq!(layers.values["novelty.ground"].1, ValueOrigin::Flag);
        assert_eq!(layers.values["sweep.mode"].1, ValueOrigin::Default);
    }

    #[test]
    fn waypoints_may_have_any_name() {
        let mut layers = ConfigLayers::defaults();
        let text = "[waypoint.\"dock.2\"]\nu_th_m = 0.002\n";
        assert!(layers.add(&source(text)).is_empty());
        assert_eq!(
            layers.values["waypoint.dock.2.u_th_m"].0,
            ConfigValue::Float(0.002)
        );
    }

    #[test]
    fn a_syntax_error_has_its_line() {
        let errors = ConfigLayers::defaults().add(&source("[novelty]\nu_th_m 0.1\n"));
        assert_eq!(errors[0].line, 2);
    }

    #[test]
    fn an_engine_has_its_own_threshold_unless_one_is_set() {
        let u_th = |text: &str| {
            let mut layers = ConfigLayers::defaults();
            assert!(layers.add(&source(text)).is_empty());
            layers.apply_engine_thresholds();
            layers.values["novelty.u_th_m"].0.clone()
        };
        let of = |engine| ConfigValue::Float(EngineSettings::for_engine(engine).novelty.u_th_m);
        assert_eq!(u_th(""), of(Engine::Standard));
        let paper = "novelty.engine = \"paper\"\n";
        assert_eq!(u_th(paper), of(Engine::Paper));
        let alone = "novelty.engine = \"paper-independent\"\n";
        assert_eq!(u_th(alone), of(Engine::PaperIndependent));
        assert_ne!(u_th(alone), u_th(""));
        let set = format!("{alone}novelty.u_th_m = 0.0005\n");
        assert_eq!(u_th(&set), ConfigValue::Float(0.0005));
    }
}
