//! The rules: each takes files and says what in them is against it, one line each.

use std::collections::{BTreeMap, BTreeSet};

use super::source::{Name, Scope, Source};

/// Outside crates, and the only places that may name them.
const HOMES: [(&str, &str); 5] = [
    ("plotters::", "src/cli/reproduce/"),
    ("pulp::", "engine/src/mixture/instructions.rs"),
    ("rusqlite::", "src/store/"),
    ("serialport::", "drivers/link/"),
    ("tokio::", "src/service/ src/cli/"),
];
/// Places that may ask for the time, or for chance.
const CLOCKED: &str = "drivers/link/ src/devices/ src/service/ src/cli/";
const TIME_AND_CHANCE: &str = "Instant::now Timestamp::now Zoned::now SystemTime rand::rng \
    rand::random make_rng from_os_rng ThreadRng OsRng SysRng";
const TYPES: [&str; 4] = ["struct", "enum", "trait", "type"];
/// What the two protocols leave to their callers.
const EFFECTS: &str = "std::fs std::io std::net std::thread std::time::Instant tokio";

/// `cli` alone names the simulation and the lab; the simulation knows geometry and formats alone.
pub(crate) fn sim_and_lab_stand_aside(files: &[Source]) -> Vec<String> {
    let known = "patrold_engine::geometry patrold_engine::formats";
    names_against(files, |file, name| {
        let aside = is_below(&name.path, "patrold_sim:: patrold_lab::");
        let deep = is_below(&name.path, "patrold_engine::") && !is_below(&name.path, known);
        let above = is_below(&file.path, "src/") && !is_below(&file.path, "src/cli/");
        !name.scope.test && (aside && above || deep && is_below(&file.path, "sim/"))
    })
}

/// Crates of ours that a manifest names under `kind`.
pub(crate) fn own_crates(manifest: &str, kind: &str) -> Vec<String> {
    let manifest: toml::Table = manifest.parse().expect("a manifest");
    let names = manifest[kind].as_table().expect("a table").keys();
    let own = names.filter(|name| name.starts_with("patrold"));
    own.cloned().collect()
}

/// Outside crates of [`HOMES`] are named at home alone.
pub(crate) fn outside_crates_have_homes(files: &[Source]) -> Vec<String> {
    names_against(files, |file, name| {
        let away = |home| !is_below(&file.path, home);
        HOMES
            .iter()
            .any(|(of, home)| is_below(&name.path, of) && away(home))
    })
}

/// Time and chance are arguments; the two protocols have no input, output or threads either.
pub(crate) fn time_and_chance_are_arguments(files: &[Source]) -> Vec<String> {
    names_against(files, |file, name| {
        let path = format!("::{}::", name.path);
        let is = |ask| path.contains(&format!("::{ask}::"));
        let asks = !name.scope.test && TIME_AND_CHANCE.split(' ').any(is);
        let pure = is_below(&file.path, "drivers/scip/ drivers/ptu/");
        asks && !is_below(&file.path, CLOCKED) || pure && is_below(&name.path, EFFECTS)
    })
}

/// A module uses itself and what its crate's `lib.rs` lists before it; `main` uses `cli`.
pub(crate) fn modules_use_those_listed_before(files: &[Source]) -> Vec<String> {
    let listed = |root: &str, place: &str| {
        let module = place.strip_prefix(root)?.split('/').nth(1)?;
        let lib = format!("{root}/lib.rs");
        let lib = files.iter().find(|file| file.path == lib)?;
        let mut modules = lib.items.iter().filter(|item| item.kind == "mod");
        modules.position(|item| item.name == module)
    };
    names_against(files, |file, name| match file.root() {
        _ if file.path == "src/main.rs" => {
            is_below(&name.path, "patrold::") && !is_below(&name.path, "patrold::cli")
        }
        Some("lab/src") if is_below(&file.module, "lab/src/reproduce") => {
            is_below(&name.place, "lab/src/evaluate")
        }
        Some(root) if !is_below(root, "drivers/") => {
            let from = listed(root, &file.module);
            from.is_some() && listed(root, &name.place) > from
        }
        _ => false,
    })
}

/// `mod.rs` and `lib.rs` introduce and never work; every file says what it is and is of one idea.
pub(crate) fn files_are_of_one_idea(files: &[Source]) -> Vec<String> {
    let stubs = ["todo", "unimplemented"].map(|stub| format!("{stub}!("));
    let mut broken = Vec::new();
    for file in files {
        let (part, front, text) = (file.root().is_some(), file.is_front(), file.text.as_str());
        let lines = text.lines().filter(|l| !front || !l.starts_with("//!"));
        let lines: Vec<&str> = lines.collect();
        let tests = |pair: &[&str]| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod tests");
        let lines = lines.windows(2).position(tests).unwrap_or(lines.len());
        let stub = text.contains(concat!("FIX", "ME")) || stubs.iter().any(|s| text.contains(s));
        for (wrong, what) in [
            (!text.starts_with("//! "), "does not say what it is"),
            (part && lines > if front { 60 } else { 400 }, "is too long"),
            (part && front && file.works, "has a function"),
            (stub, "has a stub"),
        ] {
            broken.extend(wrong.then(|| format!("{} {what}", file.path)));
        }
    }
    broken
}

/// A type that its file shows to others has a name of its own.
pub(crate) fn public_types_have_one_name_each(files: &[Source]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for file in files.iter().filter(|file| file.root().is_some()) {
        let public = |scope: Scope| scope.public && !scope.test;
        for item in file
            .items
            .iter()
            .filter(|item| TYPES.contains(&&*item.kind) && public(item.scope))
        {
            places.entry(&item.name).or_default().push(&file.path);
        }
    }
    places.retain(|_, files| files.len() > 1);
    let line = |(name, files): (&str, Vec<_>)| format!("{name}: {}", files.join(", "));
    places.into_iter().map(line).collect()
}

/// What the crates name against a rule, each once.
fn names_against(files: &[Source], against: impl Fn(&Source, &Name) -> bool) -> Vec<String> {
    let mut found = BTreeSet::new();
    for file in files.iter().filter(|file| file.root().is_some()) {
        let names = file.names.iter().filter(|name| against(file, name));
        found.extend(names.map(|name| format!("{}: {}", file.path, name.path)));
    }
    found.into_iter().collect()
}

fn is_below(path: &str, places: &str) -> bool {
    places.split(' ').any(|place| path.starts_with(place))
}
