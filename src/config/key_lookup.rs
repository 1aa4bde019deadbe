//! Finding a key by its dotted name, and the nearest one for a misspelt name.

use super::keys::{ConfigKey, KEYS};
use super::waypoint_keys::WAYPOINT_KEYS;

/// The key called `name`; `waypoint.NAME.key` finds the waypoint's key.
pub(super) fn find_key(name: &str) -> Option<&'static ConfigKey> {
    match split_waypoint_key(name) {
        Some((_, key)) => WAYPOINT_KEYS.iter().find(|k| k.name == key),
        None => KEYS.iter().find(|k| k.name == name),
    }
}

/// Splits `waypoint.NAME.key` into NAME and key.
pub(super) fn split_waypoint_key(name: &str) -> Option<(&str, &str)> {
    name.strip_prefix("waypoint.")?.rsplit_once('.')
}

/// The valid name nearest to `name`, whatever its case: a key, a key without its section, or a section as `[section]`.
pub(super) fn nearest_key(name: &str) -> String {
    let lower = name.to_lowercase();
    if let Some((waypoint, _)) = split_waypoint_key(name) {
        let keys = WAYPOINT_KEYS.iter();
        let names = keys.map(|k| format!("waypoint.{waypoint}.{}", k.name));
        return nearest(names.map(|candidate| (edit_distance(&candidate, name), candidate)));
    }
    let keys = KEYS.iter().map(|key| {
        let whole = edit_distance(key.name, &lower);
        // A key that stands outside of its section.
        let alone = key
            .name
            .split_once('.')
            .map(|(_, alone)| edit_distance(alone, &lower));
        let outside = alone.filter(|_| !lower.contains('.')).unwrap_or(usize::MAX);
        (whole.min(outside), key.name.to_owned())
    });
    let mut sections: Vec<&str> = KEYS
        .iter()
        .filter_map(|key| Some(key.name.split_once('.')?.0))
        .collect();
    sections.push("waypoint");
    sections.dedup();
    let sections = sections.into_iter().map(|section| {
        let outside = if lower.contains('.') {
            usize::MAX
        } else {
            edit_distance(section, &lower)
        };
        (outside, format!("[{section}]"))
    });
    // Of equally near names the section: it is shorter.
    nearest(sections.chain(keys))
}

fn nearest(candidates: impl Iterator<Item = (usize, String)>) -> String {
    let best = candidates.min_by_key(|(distance, _)| *distance);
    best.map(|(_, name)| name).unwrap_or_default()
}

/// Levenshtein distance in characters.
pub fn edit_distance(a: &str, b: &str) -> usize {
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
    use super::{edit_distance, nearest_key};

    #[test]
    fn known_edit_distances() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("same", "same"), 0);
    }

    #[test]
    fn a_typo_suggests_the_nearest_key() {
        assert_eq!(nearest_key("novelty.uth_m"), "novelty.u_th_m");
        assert_eq!(nearest_key("laser.prot"), "laser.port");
        assert_eq!(nearest_key("waypoint.hall.u_th"), "waypoint.hall.u_th_m");
    }

    #[test]
    fn a_section_and_a_key_without_its_section_are_found() {
        for (given, meant) in [
            ("Novelty", "[novelty]"),
            ("NOVELTY", "[novelty]"),
            ("lazer", "[laser]"),
            ("waypoints", "[waypoint]"),
            ("u_th", "novelty.u_th_m"),
            ("u_th_m", "novelty.u_th_m"),
            ("U_th_m", "novelty.u_th_m"),
            ("keep_days", "store.keep_days"),
            ("Novelty.u_th_m", "novelty.u_th_m"),
            ("novelty.U_TH_M", "novelty.u_th_m"),
        ] {
            assert_eq!(nearest_key(given), meant, "{given}");
        }
    }
}
