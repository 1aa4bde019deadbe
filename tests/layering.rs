//! Rules that crates cannot hold: who may use what, which files know each other, what a file and a citation look like.

#[path = "layering/citations.rs"]
mod citations;
#[path = "layering/cycles.rs"]
mod cycles;
#[path = "layering/rules.rs"]
mod rules;
#[path = "layering/source.rs"]
mod source;

use citations::missing;
use source::{FILES, Source, TREE, mark_tests, read};

/// Holds the tree to a rule that examples (`path: text`, more files after `|`) keep or break.
fn holds(rule: fn(&[Source]) -> Vec<String>, kept: &[&str], broken: &[&str]) {
    let source = |file: &str| {
        let (path, text) = file.trim().split_once(": ").expect("path: text");
        Source::new(path, text)
    };
    let keeps = |files: &str| rule(&mark_tests(files.split('|').map(source).collect())).is_empty();
    kept.iter()
        .for_each(|files| assert!(keeps(files), "{files}"));
    broken
        .iter()
        .for_each(|files| assert!(!keeps(files), "{files}"));
    none(rule(&TREE));
}

#[test]
fn the_tree_is_read() {
    let is_read = |path: &str| TREE.iter().any(|file| file.path == path);
    assert!(is_read("engine/src/geometry/mod.rs") && is_read("tests/layering.rs"));
    assert!(is_read("drivers/scip/src/lib.rs") && is_read("src/main.rs"));
}

fn none(against: Vec<String>) {
    assert!(against.is_empty(), "\n{}\n", against.join("\n"));
}

#[test]
fn sim_and_lab_stand_aside() {
    let kept = [
        "src/cli/demo.rs: use patrold_sim::world::Scene;",
        "src/store/row.rs: #[cfg(test)] mod tests { use patrold_sim::world::Scene; }",
        "src/store/mod.rs: #[cfg(test)] mod kit; | src/store/kit.rs: use patrold_sim::world::Scene;",
        "sim/src/scene.rs: use patrold_engine::{formats::Cloud, geometry::View};",
    ];
    let broken = [
        "src/devices/head.rs: fn f() { patrold_sim::world::x() }",
        "sim/src/scene.rs: use patrold_engine::{geometry::View, shape::Shape};",
    ];
    holds(rules::sim_and_lab_stand_aside, &kept, &broken);
    let of = rules::own_crates;
    for folder in [
        "drivers/link",
        "drivers/fault-text",
        "drivers/heard",
        "drivers/scip",
        "drivers/ptu",
        "engine",
    ] {
        let manifest = read(&format!("{folder}/Cargo.toml"));
        let mut used = match manifest.contains("[dependencies]") {
            true => of(&manifest, "dependencies"),
            false => Vec::new(),
        };
        // The emulated devices share the grammar of their faults, the drivers what any line shows, and nothing else.
        if ["drivers/scip", "drivers/ptu"].contains(&folder) {
            used.retain(|name| !["patrold-fault-text", "patrold-heard"].contains(&name.as_str()));
        }
        none(used);
        let tests = match manifest.contains("[dev-dependencies]") {
            true => of(&manifest, "dev-dependencies"),
            false => Vec::new(),
        };
        assert!(tests.iter().all(|name| name == "patrold-test-support"));
    }
    let manifest = "dependencies = { patrold-sim = 1, nalgebra = 1 }";
    assert_eq!(of(manifest, "dependencies"), ["patrold-sim"]);
}

#[test]
fn outside_crates_have_homes() {
    let kept = [
        "src/service/run.rs: use tokio::sync::mpsc; // rusqlite::Row\nconst A: &str = \"rusqlite::Row\";",
    ];
    let broken = [
        "src/devices/laser.rs: use tokio::sync::mpsc;",
        "engine/src/mixture/em.rs: fn f() { assert!(pulp::Arch::new()) }",
    ];
    holds(rules::outside_crates_have_homes, &kept, &broken);
}

#[test]
fn time_and_chance_are_arguments() {
    let kept = [
        "src/cli/fit.rs: fn f() { Instant::now() }",
        "engine/src/a.rs: #[cfg(test)] fn f() { rand::rng() }",
        "drivers/scip/src/a.rs: use std::time::Duration; use crate::Instant;",
    ];
    let broken = [
        "src/store/a.rs: fn f() { jiff::Timestamp::now() }",
        "engine/src/a.rs: fn f() { vec![rand::random::<f64>()] }",
        "sim/src/a.rs: use rand::rngs::{ChaCha8Rng, SysRng};",
        "drivers/scip/src/a.rs: use std::{fmt, io};",
        "drivers/ptu/src/a.rs: fn f() { std::thread::sleep(D) }",
    ];
    holds(rules::time_and_chance_are_arguments, &kept, &broken);
}

#[test]
fn modules_use_those_listed_before() {
    let kept = [
        "engine/src/lib.rs: pub mod scan; pub mod sweep; | engine/src/sweep/a.rs: use crate::scan::B;",
        "src/main.rs: fn main() { patrold::cli::run() }",
    ];
    let broken = [
        "engine/src/lib.rs: mod scan; mod sweep; | engine/src/scan/a.rs: fn f(_: crate::sweep::B) {}",
        "src/lib.rs: mod a; mod b; | src/a/c.rs: #[cfg(test)] mod tests { use super::super::super::b::B; }",
        "lab/src/lib.rs: mod evaluate; mod reproduce; | lab/src/reproduce/a.rs: use crate::evaluate::B;",
        "src/main.rs: fn main() { patrold::store::x() }",
    ];
    holds(rules::modules_use_those_listed_before, &kept, &broken);
}

#[test]
fn files_do_not_go_in_circles() {
    let kept = [
        "src/a/mod.rs: mod b; mod c; pub use b::B; | src/a/b.rs: pub struct B; | src/a/c.rs: use super::B; struct C;",
        "src/a.rs: pub struct A; #[cfg(test)] use crate::b::B; | src/b.rs: use crate::a::A; pub struct B;",
    ];
    let broken = [
        "src/a.rs: use crate::b::B; struct A; | src/b.rs: fn b() { vec![crate::a::A] } struct B;",
        "src/a/mod.rs: mod b; pub use {b::B, c::C as D}; | src/a/b.rs: use super::D; struct B; | src/a/c.rs: impl super::B {} struct C;",
        "src/a.rs: mod b; use b::B; const A: B = B; | src/a/b.rs: pub struct B; use super::A;",
    ];
    holds(cycles::circles, &kept, &broken);
}

#[test]
fn citations_have_their_documents() {
    let code = "const A: &str = \"section 5\";";
    let says = |cited: &str| missing("src/a.rs", &format!("{code}\n/// See {cited}\n{code}")).len();
    let kept =
        "scip2 sections 3 and 4; Schnabel's section 4.5; paper section III.C; docs/shapes.md";
    for cited in kept.split("; ") {
        assert_eq!(says(cited), 0, "{cited}");
    }
    let broken = "section 3; scip2 section 99; scip2 sections\n/// 3, 99; design section 5; ../a.md; none.rs";
    for cited in broken.split("; ") {
        assert_eq!(says(cited), 1, "{cited}");
    }
    let tags = "\n| [S] | Maker |\n| [L1] | Log |\n\n[S p5, L1] [calc] [L2, H] [I:repo#3]";
    assert_eq!(missing("docs/protocols/a.md", tags).len(), 3);
    let cites = |path: &&String| path.ends_with(".rs") || path.ends_with(".md");
    let files = FILES.iter().filter(cites);
    none(files.flat_map(|path| missing(path, &read(path))).collect());
}

#[test]
fn files_are_of_one_idea() {
    let long = "// a\n".repeat(420);
    let tested = format!("src/a.rs: //! A.\n#[cfg(test)]\nmod tests {{}}\n{long}");
    let kept = [
        "src/a/mod.rs: //! A.\nmod b;\n#[cfg(test)] mod tests { fn f() {} }",
        &tested,
    ];
    let long = format!("src/a.rs: //! A.\n{long}");
    let note = concat!("src/a.rs: //! A.\nfn f() { todo", "!() }");
    let broken = [
        "src/a.rs: use std::fmt;",
        "src/a/mod.rs: //! A.\nfn f() {}",
        &long,
        note,
    ];
    holds(rules::files_are_of_one_idea, &kept, &broken);
}

#[test]
fn public_types_have_one_name_each() {
    let kept = ["src/a.rs: pub struct A; | src/b.rs: struct A; #[cfg(test)] pub struct A;"];
    let broken = ["src/a.rs: pub struct A; | sim/src/b.rs: pub(crate) enum A {}"];
    holds(rules::public_types_have_one_name_each, &kept, &broken);
}
