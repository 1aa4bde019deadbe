//! Each rule takes one file and says what in it breaks the rule.

use super::source::Source;

/// A rule: what a file does against it, one line each.
pub type Rule = fn(&Source) -> Vec<String>;

/// The rooms in the order in which data walks them; a room may use itself and those before it.
pub const CORRIDOR: [&str; 23] = [
    "geometry",
    "formats",
    "scan",
    "sweep",
    "mixture",
    "distance",
    "novelty",
    "shape",
    "inspect",
    "lost_steps",
    "report",
    "blob",
    "world",
    "emulator",
    "evaluate",
    "reproduce",
    "alarm",
    "patrol",
    "config",
    "store",
    "devices",
    "service",
    "cli",
];

/// Rooms that use less than their place in the corridor would let them: those that stand beside one another.
const NARROWER: [(&str, &[&str]); 1] = [("reproduce", &[])];

/// Outside crates, and the folders that may name them.
const HOMES: [(&str, &[&str]); 5] = [
    ("plotters", &["src/cli/reproduce/"]),
    ("pulp", &["engine/src/mixture/instructions.rs"]),
    ("serialport", &["drivers/link/"]),
    ("rusqlite", &["src/store/"]),
    ("tokio", &["src/service/", "src/cli/"]),
];

/// Folders that may ask for the time, or for chance.
const CLOCKED: [&str; 4] = ["drivers/link/", "src/devices/", "src/service/", "src/cli/"];

const LONGEST_FRONT_PAGE: usize = 60;
const LONGEST_FILE: usize = 400;

/// A room uses itself and rooms before it; `main` uses `cli` alone.
pub fn imports_point_one_way(file: &Source) -> Vec<String> {
    if file.path == "src/main.rs" {
        let used = paths_after(&file.code, "patrold::");
        return told(file, used.iter().filter(|u| *u != "cli"), "main uses");
    }
    let Some(room) = file.room() else {
        return Vec::new();
    };
    let Some(place) = CORRIDOR.iter().position(|r| *r == room) else {
        return vec![format!(
            "{}: room {room} has no place in the corridor",
            file.path
        )];
    };
    let narrower = NARROWER
        .iter()
        .find(|(r, _)| *r == room)
        .map(|(_, uses)| uses);
    let used = paths_after(&file.code, "crate::");
    let against = |used: &&String| {
        let at = CORRIDOR.iter().position(|r| r == used);
        let allowed = narrower.is_none_or(|list| *used == room || list.contains(&used.as_str()));
        at.is_some_and(|at| at > place || !allowed)
    };
    told(file, used.iter().filter(against), &format!("{room} uses"))
}

/// `scip` and `ptu` have no clock, thread, IO or async; no driver knows the house or another driver.
pub fn drivers_are_pure(file: &Source) -> Vec<String> {
    let Some(driver) = file.driver() else {
        return Vec::new();
    };
    let mut found: Vec<String> = [
        "patrold_link",
        "patrold_scip",
        "patrold_ptu",
        "patrold_engine",
        "patrold_sim",
        "patrold",
    ]
    .into_iter()
    .filter(|name| *name != format!("patrold_{driver}") && has_word(&file.code, name))
    .map(str::to_owned)
    .collect();
    if driver != "link" {
        let std = paths_after(&file.code, "std::");
        let time = paths_after(&file.code, "time::");
        found.extend(
            std.into_iter()
                .filter(|name| ["io", "thread", "net", "fs"].contains(&name.as_str())),
        );
        found.extend(
            time.into_iter()
                .filter(|name| ["Instant", "SystemTime"].contains(&name.as_str())),
        );
        found.extend(has_word(&file.code, "tokio").then(|| "tokio".to_owned()));
    }
    told(file, found.iter(), "a driver names")
}

/// Dependencies of a driver's manifest on the house or on other drivers.
pub fn foreign_driver_dependencies(driver: &str, manifest: &str) -> Vec<String> {
    let own = format!("patrold-{driver}");
    manifest
        .lines()
        .filter(|line| {
            line.starts_with("patrold")
                && !line.starts_with(&own)
                && !line.starts_with("patrold-test-support")
        })
        .map(str::to_owned)
        .collect()
}

/// Each outside crate of [`HOMES`] is named at home alone.
pub fn outside_crates_have_homes(file: &Source) -> Vec<String> {
    if !is_source(file) {
        return Vec::new();
    }
    let away = |(name, homes): &(&str, &[&str])| {
        let at_home = homes.iter().any(|home| file.path.starts_with(home));
        (!at_home && has_word(&file.code, name)).then(|| (*name).to_owned())
    };
    let found: Vec<String> = HOMES.iter().filter_map(away).collect();
    told(file, found.iter(), "away from its home:")
}

/// Time and chance are arguments everywhere but in [`CLOCKED`].
pub fn no_clock_no_chance(file: &Source) -> Vec<String> {
    if !is_source(file) || CLOCKED.iter().any(|home| file.path.starts_with(home)) {
        return Vec::new();
    }
    let code: String = file.code.split_whitespace().collect();
    let words = [
        "SystemTime",
        "thread_rng",
        "ThreadRng",
        "OsRng",
        "from_os_rng",
    ];
    let calls = [
        "Instant::now",
        "Timestamp::now",
        "Zoned::now",
        "rand::rng()",
        "rand::random",
    ];
    let found: Vec<String> = words
        .into_iter()
        .filter(|word| has_word(&file.code, word))
        .chain(calls.into_iter().filter(|call| code.contains(call)))
        .map(str::to_owned)
        .collect();
    told(file, found.iter(), "time or chance:")
}

/// Nothing is unsafe.
pub fn no_unsafe(file: &Source) -> Vec<String> {
    let found = has_word(&file.code, "unsafe").then(|| "unsafe".to_owned());
    told(file, found.iter(), "names")
}

/// Front pages (`mod.rs` and the house's `lib.rs`) are short, have no functions, and those of rooms say what they take and give.
pub fn front_pages_introduce(file: &Source) -> Vec<String> {
    let front = file.path.ends_with("/mod.rs") || file.path == "src/lib.rs";
    if !front || !is_source(file) || file.path.contains("/tests/") {
        return Vec::new();
    }
    let mut broken = Vec::new();
    let (before_tests, code) = (before_tests(&file.text), before_tests(&file.code));
    let lines = before_tests.lines().count();
    if lines > LONGEST_FRONT_PAGE {
        broken.push(format!("{lines} lines, at most {LONGEST_FRONT_PAGE}"));
    }
    if has_word(code, "fn") {
        broken.push("has a function".to_owned());
    }
    let of_room = file
        .room()
        .is_some_and(|room| file.path.ends_with(&format!("src/{room}/mod.rs")));
    if of_room && !file.text.starts_with("//! Takes") {
        broken.push("does not begin with what the room takes".to_owned());
    }
    told(file, broken.iter(), "front page:")
}

/// Every file begins by saying what it is; no file of source is longer than its idea.
pub fn files_are_of_one_idea(file: &Source) -> Vec<String> {
    let mut broken = Vec::new();
    if !file.text.starts_with("//! ") {
        broken.push("does not begin with what it is".to_owned());
    }
    let lines = before_tests(&file.text).lines().count();
    if is_source(file) && lines > LONGEST_FILE {
        broken.push(format!(
            "{lines} lines before its tests, at most {LONGEST_FILE}"
        ));
    }
    told(file, broken.iter(), "the file")
}

/// Nothing is a stub.
pub fn no_stubs(file: &Source) -> Vec<String> {
    let code = ["todo", "unimplemented"].map(|word| format!("{word}!"));
    let note = ["FIX", "ME"].concat();
    let stubs = code.iter().filter(|stub| file.code.contains(stub.as_str()));
    let found: Vec<String> = stubs
        .chain(file.text.contains(&note).then_some(&note))
        .cloned()
        .collect();
    told(file, found.iter(), "names")
}

/// Rooms of the table of contents that stand before one that comes earlier in the corridor, or in none.
pub fn contents_out_of_order(lib: &str) -> Vec<String> {
    let listed: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    let place = |room: &str| CORRIDOR.iter().position(|r| *r == room);
    let unknown = listed.iter().filter(|room| place(room).is_none());
    let turned = listed
        .windows(2)
        .filter(|pair| place(pair[0]) > place(pair[1]));
    unknown
        .map(|room| format!("{room} has no place in the corridor"))
        .chain(turned.map(|pair| format!("{} stands before {}", pair[0], pair[1])))
        .collect()
}

fn told<'a>(file: &Source, found: impl Iterator<Item = &'a String>, what: &str) -> Vec<String> {
    found
        .map(|name| format!("{}: {what} {name}", file.path))
        .collect()
}

/// Whether the file is part of the program, not of `tests/` or `benches/`.
fn is_source(file: &Source) -> bool {
    let source = ["src/", "engine/src/", "sim/src/", "lab/src/"];
    source.iter().any(|s| file.path.starts_with(s)) || file.driver().is_some()
}

/// What stands before the first module of tests.
fn before_tests(text: &str) -> &str {
    let inline = text.match_indices("#[cfg(test)]").find(|(at, mark)| {
        let next = text[at + mark.len()..].trim_start();
        next.starts_with("mod ") && next.lines().next().is_some_and(|line| line.contains('{'))
    });
    inline.map_or(text, |(at, _)| &text[..at])
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether `word` stands in `code` as a whole name.
fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + word.len()..].chars().next();
        !before.is_some_and(is_name) && !after.is_some_and(is_name)
    })
}

/// First names that follow `prefix` in paths, also inside braces (`prefix{a::b, c}` has `a` and `c`).
fn paths_after(code: &str, prefix: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].chars().next_back().is_some_and(is_name) {
            continue;
        }
        let rest = code[at + prefix.len()..].trim_start();
        match rest.strip_prefix('{') {
            None => names.push(rest.chars().take_while(|c| is_name(*c)).collect()),
            Some(list) => names.extend(names_of_list(list)),
        }
    }
    names.sort();
    names.dedup();
    names
}

fn names_of_list(list: &str) -> Vec<String> {
    let mut names = vec![String::new()];
    let (mut depth, mut in_path) = (0, false);
    for c in list.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                names.push(String::new());
                in_path = false;
            }
            ':' => in_path = true,
            c if depth == 0 && !in_path && is_name(c) => {
                if let Some(name) = names.last_mut() {
                    name.push(c);
                }
            }
            _ => {}
        }
    }
    names
}
