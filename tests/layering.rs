//! The house's rules, kept by reading the tree: which way imports point, who may touch the clock, the serial
//! port, the database and tokio, and what a file looks like.

#[path = "layering/rules.rs"]
mod rules;
#[path = "layering/source.rs"]
mod source;

use rules::{CORRIDOR, Rule};
use source::{Source, tree};

fn keeps(rule: Rule) {
    let broken: Vec<String> = tree().iter().flat_map(rule).collect();
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

/// What `rule` says of a file that never was.
fn says(rule: Rule, path: &str, text: &str) -> usize {
    rule(&Source::new(path, text)).len()
}

#[test]
fn the_tree_is_read() {
    let files = tree();
    for path in ["src/lib.rs", "drivers/scip/src/lib.rs", "tests/layering.rs"] {
        assert!(
            files.iter().any(|f| f.path == path),
            "{path} of {}",
            files.len()
        );
    }
}

#[test]
fn imports_point_one_way() {
    let rule = rules::imports_point_one_way;
    assert_eq!(
        says(rule, "src/mixture/em.rs", "use crate::geometry::View;"),
        0
    );
    assert_eq!(
        says(rule, "src/mixture/em.rs", "use crate::novelty::detect;"),
        1
    );
    assert_eq!(
        says(
            rule,
            "src/mixture/em.rs",
            "use crate::{geometry::View, shape::retrieve};"
        ),
        1
    );
    assert_eq!(
        says(
            rule,
            "src/mixture/em.rs",
            "mod tests { fn f() { crate::store::Store::open(x) } }"
        ),
        1
    );
    assert_eq!(
        says(
            rule,
            "src/mixture/em.rs",
            "// crate::store\nlet x = \"crate::cli\";"
        ),
        0
    );
    assert_eq!(
        says(rule, "src/world/cast.rs", "use crate::store::Store;"),
        1
    );
    assert_eq!(
        says(rule, "src/world/cast.rs", "use crate::formats::read_cloud;"),
        0
    );
    assert_eq!(
        says(rule, "src/newroom/mod.rs", "use crate::geometry::View;"),
        1
    );
    assert_eq!(
        says(
            rule,
            "src/main.rs",
            "patrold::cli::run(); patrold::store::x()"
        ),
        1
    );
    keeps(rule);
}

#[test]
fn scip_and_ptu_are_bytes_and_instants_only() {
    let rule = rules::drivers_are_pure;
    for bad in [
        "use std::time::Instant;",
        "use std::time::{Duration, SystemTime};",
        "use std::{io, fmt};",
        "let t = std::thread::spawn(f);",
        "use std::io::Read;",
        "use patrold_engine::geometry::Pose;",
        "use patrold_link::Serial;",
        "use patrold_ptu::Head;",
        "tokio::spawn(f)",
    ] {
        assert_eq!(says(rule, "drivers/scip/src/frame.rs", bad), 1, "{bad}");
    }
    assert_eq!(
        says(rule, "drivers/ptu/src/head.rs", "use patrold_scip::Scan;"),
        1
    );
    assert_eq!(
        says(
            rule,
            "drivers/ptu/src/head.rs",
            "use std::time::Duration; use crate::Instant;"
        ),
        0
    );
    assert_eq!(
        says(rule, "drivers/link/src/tcp.rs", "use std::io::Read;"),
        0
    );
    assert_eq!(
        says(rule, "drivers/link/src/tcp.rs", "use patrold_scip::Scan;"),
        1
    );
    keeps(rule);
}

#[test]
fn drivers_depend_on_no_room_and_not_on_each_other() {
    for driver in ["link", "scip", "ptu"] {
        let text = source::read(&format!("drivers/{driver}/Cargo.toml"));
        assert_eq!(rules::foreign_driver_dependencies(driver, &text), [""; 0]);
    }
    let bad = "[dependencies]\nthiserror.workspace = true\npatrold-link.workspace = true\n";
    assert_eq!(rules::foreign_driver_dependencies("scip", bad).len(), 1);
    assert_eq!(
        rules::foreign_driver_dependencies("scip", "[dev-dependencies]\npatrold = \"1\"").len(),
        1
    );
}

#[test]
fn each_outside_crate_has_one_home() {
    let rule = rules::outside_crates_have_homes;
    assert_eq!(
        says(rule, "src/devices/port.rs", "serialport::new(x, 9600)"),
        1
    );
    assert_eq!(
        says(
            rule,
            "drivers/link/src/serial.rs",
            "serialport::new(x, 9600)"
        ),
        0
    );
    assert_eq!(
        says(rule, "src/cli/alarms.rs", "use rusqlite::Connection;"),
        1
    );
    assert_eq!(
        says(rule, "src/distance/simplex.rs", "pulp::Arch::new()"),
        1
    );
    assert_eq!(
        says(rule, "src/devices/laser.rs", "use tokio::sync::mpsc;"),
        1
    );
    assert_eq!(
        says(rule, "src/service/run.rs", "use tokio::sync::mpsc;"),
        0
    );
    keeps(rule);
}

#[test]
fn time_and_chance_are_arguments() {
    let rule = rules::no_clock_no_chance;
    for bad in [
        "let t = Instant::now();",
        "std::time::SystemTime::UNIX_EPOCH",
        "jiff::Timestamp::now()",
        "Zoned::now()",
        "rand::rng()",
        "let r = thread_rng();",
        "rand::random::<f64>()",
        "ChaCha8Rng::from_os_rng()",
    ] {
        assert_eq!(says(rule, "src/mixture/em.rs", bad), 1, "{bad}");
        assert_eq!(says(rule, "src/cli/fit.rs", bad), 0, "{bad}");
    }
    assert_eq!(
        says(
            rule,
            "src/store/handle.rs",
            "let t = Stamp::text(Timestamp::from_second(1));"
        ),
        0
    );
    keeps(rule);
}

#[test]
fn nothing_is_unsafe() {
    let rule = rules::no_unsafe;
    assert_eq!(
        says(rule, "src/mixture/kernel.rs", "fn f() { unsafe { g() } }"),
        1
    );
    assert_eq!(
        says(rule, "src/lib.rs", "#![forbid(unsafe_code)] // unsafe"),
        0
    );
    keeps(rule);
}

#[test]
fn front_pages_introduce_and_never_work() {
    let rule = rules::front_pages_introduce;
    assert_eq!(
        says(
            rule,
            "src/scan/mod.rs",
            "//! Takes a, gives b.\nmod beam;\npub use beam::Beam;\n"
        ),
        0
    );
    assert_eq!(says(rule, "src/scan/mod.rs", "//! Scans.\nmod beam;\n"), 1);
    assert_eq!(
        says(rule, "src/scan/mod.rs", "//! Takes a.\npub fn f() {}\n"),
        1
    );
    assert_eq!(
        says(rule, "src/scan/sub/mod.rs", "//! A sub-room.\nmod beam;\n"),
        0
    );
    assert_eq!(
        says(
            rule,
            "src/scan/mod.rs",
            &format!("//! Takes a.\n{}", "mod a;\n".repeat(80))
        ),
        1
    );
    assert_eq!(says(rule, "src/lib.rs", "//! House.\nfn f() {}\n"), 1);
    keeps(rule);
}

#[test]
fn every_file_says_what_it_is_and_is_of_one_idea() {
    let rule = rules::files_are_of_one_idea;
    assert_eq!(says(rule, "src/scan/beam.rs", "//! A beam.\n"), 0);
    assert_eq!(says(rule, "src/scan/beam.rs", "use std::fmt;\n"), 1);
    let long = format!("//! A.\n{}", "const A: u8 = 1;\n".repeat(420));
    assert_eq!(says(rule, "src/scan/beam.rs", &long), 1);
    let tested = format!(
        "//! A.\n#[cfg(test)]\nmod tests {{}}\n{}",
        "// t\n".repeat(420)
    );
    assert_eq!(says(rule, "src/scan/beam.rs", &tested), 0);
    keeps(rule);
}

#[test]
fn nothing_is_a_stub() {
    let rule = rules::no_stubs;
    for word in ["todo", "unimplemented"] {
        assert_eq!(
            says(rule, "src/scan/beam.rs", &format!("fn f() {{ {word}!() }}")),
            1
        );
    }
    assert_eq!(
        says(rule, "src/scan/beam.rs", &["// FIX", "ME later"].concat()),
        1
    );
    keeps(rule);
}

#[test]
fn the_table_of_contents_is_in_corridor_order() {
    let lib = Source::new("src/lib.rs", &source::read("src/lib.rs"));
    assert_eq!(rules::contents_out_of_order(&lib.code), [""; 0]);
    assert_eq!(
        rules::contents_out_of_order("pub mod geometry;\npub mod shape;\npub mod novelty;").len(),
        1
    );
    assert_eq!(rules::contents_out_of_order("pub mod cellar;").len(), 1);
    let rooms = source::rooms();
    for room in &rooms {
        assert!(
            CORRIDOR.contains(&room.as_str()),
            "src/{room} has no place in the corridor"
        );
        assert!(
            lib.code.contains(&format!("pub mod {room};")),
            "lib.rs does not list {room}"
        );
    }
}
