//! Finding a key by its dotted name, and the nearest one for a misspelt name.

use super::keys::{ConfigKey, KEYS, WAYPOINT_KEYS};

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

/// The valid name with the smallest edit distance to `name`.
pub(super) fn nearest_key(name: &str) -> String {
    let best = |candidates: Vec<String>| {
        candidates
            .into_iter()
            .min_by_key(|candidate| edit_distance(candidate, name))
            .unwrap_or_default()
    };
    match split_waypoint_key(name) {
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
fn edit_distance(a: &str, b: &str) -> usize {
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
}
