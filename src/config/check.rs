//! What can be wrong with a configuration, told so that it can be mended: file, line, nearest key.

use super::keys::{KEYS, Key, WAYPOINT_KEYS};
use std::fmt;
use std::path::PathBuf;

/// One mistake in one file.
#[derive(Debug, Clone, PartialEq)]
pub struct Mistake {
    /// The file.
    pub file: PathBuf,
    /// Line in it, from 1; 0 where the file as a whole is meant.
    pub line: usize,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub enum Problem {
    /// The file cannot be read.
    Unreadable(String),
    /// The file is not TOML.
    Syntax(String),
    /// No such key; the nearest one that exists.
    UnknownKey {
        /// The key as it was written.
        key: String,
        /// The nearest valid name.
        nearest: String,
    },
    /// The key does not accept this value.
    BadValue {
        /// The key.
        key: String,
        /// What it accepts.
        expected: String,
        /// What stands there.
        got: String,
    },
    /// Two settings contradict each other.
    Contradiction(String),
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "cannot be read: {why}"),
            Self::Syntax(why) => write!(f, "is not TOML: {why}"),
            Self::UnknownKey { key, nearest } => {
                write!(f, "unknown key {key}; did you mean {nearest}?")
            }
            Self::BadValue { key, expected, got } => {
                write!(f, "{key} wants {expected}, got {got}")
            }
            Self::Contradiction(what) => write!(f, "{what}"),
        }
    }
}

/// The key called `name`, if there is one; `waypoint.NAME.key` finds the waypoint's key.
pub(super) fn find(name: &str) -> Option<&'static Key> {
    match waypoint_parts(name) {
        Some((_, key)) => WAYPOINT_KEYS.iter().find(|k| k.name == key),
        None => KEYS.iter().find(|k| k.name == name),
    }
}

/// `waypoint.NAME.key` cut into NAME and key.
pub(super) fn waypoint_parts(name: &str) -> Option<(&str, &str)> {
    name.strip_prefix("waypoint.")?.rsplit_once('.')
}

/// The valid name that looks most like `name`.
pub(super) fn nearest(name: &str) -> String {
    let best = |candidates: Vec<String>| {
        candidates
            .into_iter()
            .min_by_key(|candidate| edits(candidate, name))
            .unwrap_or_default()
    };
    match waypoint_parts(name) {
        Some((waypoint, _)) => best(
            WAYPOINT_KEYS
                .iter()
                .map(|k| format!("waypoint.{waypoint}.{}", k.name))
                .collect(),
        ),
        None => best(KEYS.iter().map(|k| k.name.to_owned()).collect()),
    }
}

/// Levenshtein distance in characters.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::{edits, nearest};

    #[test]
    fn known_edit_distances() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("same", "same"), 0);
    }

    #[test]
    fn a_slip_finds_its_key() {
        assert_eq!(nearest("novelty.uth_m"), "novelty.u_th_m");
        assert_eq!(nearest("laser.prot"), "laser.port");
        assert_eq!(nearest("waypoint.hall.u_th"), "waypoint.hall.u_th_m");
    }
}
