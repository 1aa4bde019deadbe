//! Which names a waypoint, and a pair of a manifest, may have: one rule wherever a name enters.

/// Longest name of a waypoint. It must fit into a file's name with a prefix and a suffix.
const MAX_WAYPOINT_NAME_BYTES: usize = 64;

/// Why `name` cannot name anything; `None`: it can. A name becomes a folder, an argument of a command and a line of a log.
pub fn name_error(name: &str) -> Option<String> {
    let why = if name.is_empty() {
        "is empty"
    } else if name.starts_with('.') {
        "begins with a dot"
    } else if name.starts_with('-') {
        "begins with a dash, as an option does"
    } else if name.contains(['/', '\\']) {
        "has a slash"
    } else if name.chars().any(char::is_control) {
        "has a control character"
    } else {
        return None;
    };
    Some(format!("the name {name:?} {why}; choose another"))
}

/// Why no waypoint can have this name; `None`: one can. It must also fit into the configuration's `[waypoint.NAME]`.
pub fn waypoint_name_error(name: &str) -> Option<String> {
    if let Some(why) = name_error(name) {
        return Some(why);
    }
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let valid = name.len() <= MAX_WAYPOINT_NAME_BYTES && name.chars().all(allowed);
    (!valid).then(|| {
        format!("a waypoint's name is 1 to {MAX_WAYPOINT_NAME_BYTES} letters, digits, '-', '_' or '.', got {name:?}")
    })
}

#[cfg(test)]
mod tests {
    use super::{name_error, waypoint_name_error};

    #[test]
    fn a_waypoint_has_a_name_that_is_no_path_option_or_line_end() {
        for valid in [
            "hall",
            "hall-2",
            "küche",
            "a.b_c",
            "7",
            "_x",
            &"x".repeat(64),
        ] {
            assert_eq!(waypoint_name_error(valid), None, "{valid}");
        }
        let long = "x".repeat(65);
        for invalid in [
            "",
            ".",
            "..",
            ".hidden",
            "-rf",
            "--json",
            "two words",
            "a/b",
            "/etc",
            "..\\a",
            "a\nb",
            "a\u{0}",
            "a\u{7f}",
            "a\u{85}b",
            "a;b",
            "$HOME",
            "a*",
            &long,
        ] {
            assert!(waypoint_name_error(invalid).is_some(), "{invalid:?}");
        }
    }

    #[test]
    fn a_pair_may_have_blanks_too() {
        assert_eq!(name_error("corridor, second visit"), None);
        for invalid in ["", "..", "-rf", "a/b", "a\tb"] {
            assert!(name_error(invalid).is_some(), "{invalid:?}");
        }
    }
}
