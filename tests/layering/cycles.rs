//! Circles of files: files of one crate that need each other to be understood.

use std::collections::{BTreeMap, BTreeSet};

use super::source::{Item, Name, Scope, Source};

/// Halves of one thing: a file and its child that may use each other.
const HALVES: [(&str, &str); 2] = [
    ("src/devices/plan.rs", "src/devices/plan/stream.rs"),
    ("src/devices/station.rs", "src/devices/station/travel.rs"),
];

type Modules<'a> = BTreeMap<&'a str, &'a Source>;
/// Files that each file uses, with the names used of them.
type Uses<'a> = BTreeMap<&'a str, BTreeMap<&'a str, BTreeSet<&'a str>>>;

/// The steps of circles, as `file -> file: names used`.
pub(crate) fn circles(files: &[Source]) -> Vec<String> {
    let (uses, mut found) = (uses(files), Vec::new());
    for (from, used) in &uses {
        for (to, names) in used {
            if reached(&uses, to).contains(from) {
                let names: Vec<&str> = names.iter().copied().collect();
                found.push(format!("{from} -> {to}: {}", names.join(", ")));
            }
        }
    }
    found
}

fn uses(files: &[Source]) -> Uses<'_> {
    let sources = files.iter().filter(|file| file.root().is_some());
    let sources = sources.filter(|file| file.path != "src/main.rs");
    let modules: Modules = sources.map(|file| (file.module.as_str(), file)).collect();
    let mut uses = Uses::new();
    for file in modules.values() {
        // A `mod.rs` that passes a name on does not use it.
        let passes_on = |scope: Scope| scope.public && file.is_front();
        let names = file.names.iter().filter(|name| !name.scope.test);
        for name in names.filter(|name| !passes_on(name.scope)) {
            let Some((to, item)) = definition(&modules, &name.place, 0) else {
                continue;
            };
            let from = file.path.as_str();
            if from != to && !HALVES.contains(&(from, to)) && !HALVES.contains(&(to, from)) {
                let names = uses.entry(from).or_default().entry(to).or_default();
                names.insert(item);
            }
        }
    }
    uses
}

/// Files that a file leads to, in however many steps.
fn reached<'a>(uses: &Uses<'a>, from: &'a str) -> BTreeSet<&'a str> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(at) = open.pop() {
        let next = uses.get(at).into_iter().flat_map(BTreeMap::keys);
        open.extend(next.filter(|next| seen.insert(**next)));
    }
    seen
}

/// The file that defines the item at `place`, and the item, through imports on the way.
fn definition<'a>(modules: &Modules<'a>, place: &str, steps: usize) -> Option<(&'a str, &'a str)> {
    let mut cuts = place.rmatch_indices('/').map(|(at, _)| at);
    let cut = cuts.find(|at| modules.contains_key(&place[..*at]))?;
    let (file, path) = (modules[&place[..cut]], &place[cut + 1..]);
    let (first, rest) = path.split_at(path.find('/').unwrap_or(path.len()));
    let is_it = |item: &&Item| item.name == first && item.kind != "mod" && !item.scope.test;
    if let Some(item) = file.items.iter().find(is_it) {
        return Some((&file.path, &item.name));
    }
    let binds = |name: &Name| name.scope.import && !name.scope.test && name.alias == first;
    let mut bound = file.names.iter().filter(|name| binds(name) && steps < 20);
    bound.find_map(|name| definition(modules, &(name.place.clone() + rest), steps + 1))
}
