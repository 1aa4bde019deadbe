//! Layers of configuration: defaults, the file, the folder beside it, the command line. Later ones win, and
//! each value remembers its origin.

use super::check::{Mistake, Problem, find, nearest};
use super::keys::KEYS;
use super::value::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Keys that name a file or folder of ours.
const PATH_KEYS: [&str; 2] = ["store.dir", "api.socket"];

/// Text of one configuration file.
#[derive(Debug, Clone)]
pub struct Source {
    /// Its path, for messages.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// Where a value came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The built-in default.
    Default,
    /// A line of a file.
    File(PathBuf, usize),
    /// A flag of the command line.
    Flag,
}

/// All values in force, by dotted name.
#[derive(Debug, Clone)]
pub struct Layers {
    /// Name to value and origin.
    pub values: BTreeMap<String, (Value, Origin)>,
}

impl Layers {
    /// The defaults alone.
    pub fn defaults() -> Self {
        let values = KEYS
            .iter()
            .filter_map(|key| {
                let value = key.default_value()?;
                Some((key.name.to_owned(), (value, Origin::Default)))
            })
            .collect();
        Self { values }
    }

    /// Lays one file over what is there; what is wrong in it is returned, the rest of it counts.
    pub fn add(&mut self, source: &Source) -> Vec<Mistake> {
        let lines = LineFinder::new(&source.text);
        let mut reading = Reading {
            path: &source.path,
            lines,
            found: Vec::new(),
            mistakes: Vec::new(),
        };
        let (table, errors) = DeTable::parse_recoverable(&source.text);
        if errors.is_empty() {
            reading.walk("", 1, table.get_ref());
        }
        for error in errors {
            let line = error.span().map_or(0, |s| reading.lines.line_of(s.start));
            let first = error.message().lines().next().unwrap_or_default();
            reading.mistake(line, Problem::Syntax(first.to_owned()));
        }
        for (name, value, line) in reading.found {
            let origin = Origin::File(source.path.clone(), line);
            self.values.insert(name, (value, origin));
        }
        reading.mistakes
    }

    /// Lays one flag of the command line over what is there.
    pub fn set_flag(&mut self, name: &str, value: Value) {
        self.values.insert(name.to_owned(), (value, Origin::Flag));
    }

    /// File and line of the first of `keys` that stands in a file, for a message about them all.
    pub(super) fn place(&self, keys: &[&str]) -> (PathBuf, usize) {
        let origins = || keys.iter().filter_map(|key| self.values.get(*key));
        let in_file = origins().find_map(|(_, origin)| match origin {
            Origin::File(path, line) => Some((path.clone(), *line)),
            Origin::Default | Origin::Flag => None,
        });
        let by_flag = || {
            let given = origins().any(|(_, origin)| *origin == Origin::Flag);
            given.then(|| (PathBuf::from("command line"), 0))
        };
        in_file
            .or_else(by_flag)
            .unwrap_or_else(|| (PathBuf::from("defaults"), 0))
    }

    /// Makes the paths that a file gives relative paths from `folder`, where the main file lies, so that they mean
    /// the same to every program that reads it.
    pub(super) fn anchor_paths(&mut self, folder: &Path) {
        for key in PATH_KEYS {
            if let Some((Value::Text(path), Origin::File(..))) = self.values.get_mut(key) {
                *path = folder.join(&*path).to_string_lossy().into_owned();
            }
        }
    }
}

struct Reading<'a> {
    path: &'a Path,
    lines: LineFinder,
    found: Vec<(String, Value, usize)>,
    mistakes: Vec<Mistake>,
}

impl Reading<'_> {
    fn walk(&mut self, prefix: &str, depth: usize, table: &DeTable<'_>) {
        for (key, value) in table {
            let name = format!("{prefix}{}", key.get_ref());
            let line = self.lines.line_of(key.span().start);
            match (value.get_ref(), may_be_table(&name, depth)) {
                (DeValue::Table(inner), true) => self.walk(&format!("{name}."), depth + 1, inner),
                (given, _) => self.leaf(name, given, line),
            }
        }
    }

    fn leaf(&mut self, name: String, given: &DeValue<'_>, line: usize) {
        let Some(key) = find(&name) else {
            let nearest = nearest(&name);
            return self.mistake(line, Problem::UnknownKey { key: name, nearest });
        };
        match key.kind.read(given) {
            Ok(value) => self.found.push((name, value, line)),
            Err(got) => {
                let expected = key.kind.to_string();
                let key = name;
                self.mistake(line, Problem::BadValue { key, expected, got });
            }
        }
    }

    fn mistake(&mut self, line: usize, problem: Problem) {
        self.mistakes.push(Mistake {
            file: self.path.to_owned(),
            line,
            problem,
        });
    }
}

/// Whether `name`, so many tables deep, may be a table: a section, `waypoint`, or `waypoint.NAME`.
fn may_be_table(name: &str, depth: usize) -> bool {
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
    use super::{Layers, Origin, Source};
    use crate::config::Value;
    use std::path::PathBuf;

    fn source(text: &str) -> Source {
        Source {
            path: PathBuf::from("patrold.toml"),
            text: text.to_owned(),
        }
    }

    #[test]
    fn every_mistake_is_told_at_once_with_its_line() {
        let mut layers = Layers::defaults();
        let mistakes = layers.add(&source(
            "[novelty]\nu_th = 0.1\nground = \"manhattan\"\n[laser]\nbaud = nan\n[lazer]\nport = \"x\"\n",
        ));
        let told: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
        assert_eq!(told.len(), 4, "{told:?}");
        assert!(told.contains(
            &"patrold.toml:2: unknown key novelty.u_th; did you mean novelty.u_th_m?".to_owned()
        ));
        assert!(
            told.iter()
                .any(|m| m.starts_with("patrold.toml:3: novelty.ground wants one of"))
        );
        assert!(
            told.iter()
                .any(|m| m.starts_with("patrold.toml:5: laser.baud wants a whole number"))
        );
        assert!(
            told.iter()
                .any(|m| m.starts_with("patrold.toml:6: unknown key lazer"))
        );
    }

    #[test]
    fn later_layers_win_and_are_remembered() {
        let mut layers = Layers::defaults();
        assert!(layers.add(&source("novelty.u_th_m = 0.25\n")).is_empty());
        layers.set_flag("novelty.ground", Value::Text("euclid".to_owned()));
        let (value, origin) = &layers.values["novelty.u_th_m"];
        assert_eq!(*value, Value::Float(0.25));
        assert_eq!(*origin, Origin::File(PathBuf::from("patrold.toml"), 1));
        assert_eq!(layers.values["novelty.ground"].1, Origin::Flag);
        assert_eq!(layers.values["sweep.mode"].1, Origin::Default);
    }

    #[test]
    fn waypoints_may_have_any_name() {
        let mut layers = Layers::defaults();
        let text = "[waypoint.\"dock.2\"]\nu_th_m = 0.002\n";
        assert!(layers.add(&source(text)).is_empty());
        assert_eq!(
            layers.values["waypoint.dock.2.u_th_m"].0,
            Value::Float(0.002)
        );
    }

    #[test]
    fn broken_toml_says_where() {
        let mistakes = Layers::defaults().add(&source("[novelty]\nu_th_m 0.1\n"));
        assert_eq!(mistakes[0].line, 2);
    }
}
