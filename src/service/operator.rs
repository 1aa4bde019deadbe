//! Who asks for something, as the kernel knows the user. A name that is given adds to it and never replaces it.

use std::fs;

/// The user with this id, and in front of it the name that was given.
pub fn operator(given: Option<&str>, uid: u32) -> String {
    let users = fs::read_to_string("/etc/passwd").unwrap_or_default();
    signed(given, &user_name(&users, uid))
}

fn signed(given: Option<&str>, user: &str) -> String {
    match given {
        Some(name) if name != user => format!("{name} (user {user})"),
        _ => user.to_owned(),
    }
}

/// The name in the text of passwd(5); `uid N` where it has none.
fn user_name(users: &str, uid: u32) -> String {
    let is_user = |line: &&str| line.split(':').nth(2) == Some(uid.to_string().as_str());
    let name = users
        .lines()
        .find(is_user)
        .and_then(|line| line.split(':').next());
    name.map_or_else(|| format!("uid {uid}"), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::{operator, signed, user_name};

    #[test]
    fn a_name_adds_to_the_user_and_never_replaces_it() {
        let users = "root:x:0:0:root:/root:/bin/sh\nana:x:1000:1000::/home/ana:/bin/sh\n";
        assert_eq!(user_name(users, 1000), "ana");
        assert_eq!(user_name(users, 100), "uid 100");
        assert_eq!(signed(Some("bo"), "ana"), "bo (user ana)");
        assert_eq!(signed(Some("ana"), "ana"), "ana");
        assert_eq!(signed(None, "ana"), "ana");
        assert!(operator(Some("somebody else"), 0).starts_with("somebody else (user "));
    }
}
