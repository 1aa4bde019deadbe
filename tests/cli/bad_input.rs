//! Bad input: one line on standard error that names the thing, the right exit code, and nothing written.

use crate::harness::clouds;
use crate::harness::program::patrold;
use nalgebra::Point3;
use patrold::formats::write_ply;
use patrold::store::Store;
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A folder with everything that can be wrong.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let put = |name: &str, bytes: &[u8]| fs::write(dir.path().join(name), bytes).expect("written");
    let good = write_ply(&clouds::room(&[], 1));
    put("good.ply", &good);
    put("empty.ply", b"");
    put("none.ply", &write_ply(&[]));
    put(
        "prose.txt",
        b"Dear guard,\nthe hall was dark when I came.\n",
    );
    put(
        "prose.ply",
        b"Dear guard,\nthe hall was dark when I came.\n",
    );
    put("nan.ply", &write_ply(&[Point3::new(f64::NAN, 0.0, 0.0); 5]));
    put("cut.ply", &good[..good.len() - 7]);
    put("three.ply", &write_ply(&[Point3::origin(); 3]));
    fs::create_dir(dir.path().join("folder")).expect("folder");

    put("list.json", b"[1, 2]");
    put("cut.json", b"{\"weights\": [0.5, 0.5], \"means\": [[0, 0");
    put(
        "short.json",
        b"{\"weights\": [1], \"means\": [], \"covs\": []}",
    );
    put(
        "flat.json",
        b"{\"weights\": [1], \"means\": [[0, 0, 0]], \"covs\": [[0, 0, 0, 0, 0, 0]]}",
    );
    put(
        "negative.json",
        b"{\"weights\": [1], \"means\": [[0, 0, 0]], \"covs\": [[1, 0, 0, -1, 0, 1]]}",
    );

    put("unknown.toml", b"[novelty]\nu_th = 0.1\n");
    put("nan.toml", b"novelty.u_th_m = nan\n");
    put("zero.toml", b"novelty.u_th_m = 0\n");
    put("broken.toml", b"[novelty\n");
    put("binary.toml", &[0xff, 0xfe, 0x00]);
    put("nowhere.toml", b"store.dir = \"nowhere\"\n");
    put("file.toml", b"store.dir = \"good.ply\"\n");
    for kind in ["ours", "foreign", "newer", "garbage"] {
        put(
            &format!("{kind}.toml"),
            format!("store.dir = \"{kind}\"\n").as_bytes(),
        );
        fs::create_dir(dir.path().join(kind)).expect("folder");
    }
    drop(Store::open(&dir.path().join("ours")).expect("store"));
    drop(Store::open(&dir.path().join("newer")).expect("store"));
    let newer = Connection::open(dir.path().join("newer/patrold.db")).expect("opens");
    newer.pragma_update(None, "user_version", 99).expect("set");
    drop(newer);
    let foreign = Connection::open(dir.path().join("foreign/patrold.db")).expect("opens");
    foreign
        .execute_batch("CREATE TABLE cat (name TEXT)")
        .expect("table");
    drop(foreign);
    put("garbage/patrold.db", &[0x5a; 4096]);
    dir
}

/// Every file below `dir` with its size; SQLite's own side files aside.
fn listing(dir: &Path) -> BTreeMap<String, u64> {
    let mut found = BTreeMap::new();
    let mut folders = vec![dir.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("readable") {
            let path = entry.expect("an entry").path();
            let name = path.display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if !name.ends_with("-wal") && !name.ends_with("-shm") {
                found.insert(name, fs::metadata(&path).expect("metadata").len());
            }
        }
    }
    found
}

/// Arguments, exit code, and what the line must name.
type Case = (&'static [&'static str], i32, &'static [&'static str]);

fn hold(cases: &[Case]) {
    let dir = folder();
    let before = listing(dir.path());
    let mut wrong = Vec::new();
    for (args, code, names) in cases {
        let ran = patrold(dir.path(), args);
        let lines: Vec<&str> = ran.err.lines().collect();
        let one_line = lines.len() == 1 && lines[0].starts_with("patrold: ");
        let named = names.iter().all(|name| ran.err.contains(name));
        if ran.code != *code || !one_line || !named || !ran.out.is_empty() {
            wrong.push(format!("{args:?} (wants {code}, {names:?}): {ran:?}"));
        }
        let after = listing(dir.path());
        if after != before {
            wrong.push(format!("{args:?} left {after:?}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn clouds_that_are_none() {
    hold(&[
        (
            &["compare", "missing.ply", "good.ply"],
            1,
            &["missing.ply", "check the path"],
        ),
        (
            &["compare", "good.ply", "missing.ply"],
            1,
            &["missing.ply", "check the path"],
        ),
        (
            &["compare", "good.ply", "empty.ply"],
            1,
            &["empty.ply", "empty file", "expected a PLY"],
        ),
        (
            &["compare", "good.ply", "none.ply"],
            1,
            &["none.ply", "no finite point", "again"],
        ),
        (
            &["compare", "none.ply", "good.ply"],
            1,
            &["none.ply", "no finite point"],
        ),
        (
            &["compare", "prose.txt", "good.ply"],
            1,
            &["prose.txt", "line 1", "expected"],
        ),
        (
            &["compare", "prose.ply", "good.ply"],
            1,
            &["prose.ply", "line 1", "expected"],
        ),
        (
            &["compare", "good.ply", "nan.ply"],
            1,
            &["nan.ply", "no finite point among 5"],
        ),
        (
            &["compare", "good.ply", "cut.ply"],
            1,
            &["cut.ply", "expected"],
        ),
        (
            &["compare", "good.ply", "folder"],
            1,
            &["folder", "is a folder"],
        ),
        (&["fit", "missing.ply"], 1, &["missing.ply"]),
        (&["fit", "nan.ply"], 1, &["nan.ply", "no finite point"]),
        (
            &["fit", "three.ply", "--components", "9"],
            1,
            &["three.ply"],
        ),
        (&["shapes", "prose.ply"], 1, &["prose.ply"]),
        (&["shapes", "three.ply"], 1, &["three.ply"]),
    ]);
}

#[test]
fn outputs_that_cannot_be_written() {
    hold(&[
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--labels-out",
                "no/such/l.txt",
            ],
            1,
            &["no/such/l.txt", "make it"],
        ),
        (
            &["compare", "good.ply", "good.ply", "--labels-out", "folder"],
            1,
            &["folder"],
        ),
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--novelty-out",
                "no/n.ply",
            ],
            1,
            &["no/n.ply"],
        ),
        (
            &[
                "compare",
                "good.ply",
                "good.ply",
                "--json",
                "--labels-out",
                "/proc/l.txt",
            ],
            1,
            &["/proc/l.txt"],
        ),
        (
            &[
                "alarms",
                "export",
                "--config",
                "ours.toml",
                "--out",
                "no/a.jsonl",
            ],
            1,
            &["no/a.jsonl"],
        ),
    ]);
}

#[test]
fn mixtures_that_are_none() {
    hold(&[
        (
            &["distance", "missing.json", "missing.json"],
            1,
            &["missing.json"],
        ),
        (&["distance", "list.json", "list.json"], 1, &["list.json"]),
        (&["distance", "cut.json", "cut.json"], 1, &["cut.json"]),
        (
            &["distance", "short.json", "short.json"],
            1,
            &["short.json"],
        ),
        (
            &["fit", "good.ply", "--init", "prose.txt"],
            1,
            &["prose.txt"],
        ),
        (
            &["fit", "good.ply", "--init", "negative.json"],
            1,
            &["negative.json"],
        ),
        (
            &["fit", "good.ply", "--tolerance", "nan"],
            2,
            &["--tolerance"],
        ),
        (&["shapes", "good.ply", "--epsilon", "0"], 2, &["--epsilon"]),
        (
            &["shapes", "good.ply", "--points", "--method", "covariance"],
            2,
            &["--points", "--method covariance"],
        ),
    ]);
}

#[test]
fn manifests_that_are_none() {
    hold(&[
        (
            &["compare", "--manifest", "missing.json"],
            1,
            &["missing.json"],
        ),
        (&["compare", "--manifest", "prose.txt"], 1, &["prose.txt"]),
        (&["compare", "--manifest", "list.json"], 1, &["list.json"]),
        (
            &["compare", "--manifest", "flat.json"],
            1,
            &["flat.json", "pairs"],
        ),
        (&["compare", "--manifest", "folder"], 1, &["folder"]),
    ]);
}

#[test]
fn configurations_with_mistakes() {
    let dir = folder();
    let before = listing(dir.path());
    for (file, names) in [
        (
            "unknown.toml",
            &[
                "unknown.toml:2",
                "novelty.u_th;",
                "did you mean novelty.u_th_m?",
            ][..],
        ),
        ("nan.toml", &["nan.toml:1", "novelty.u_th_m wants a number"]),
        (
            "zero.toml",
            &["zero.toml:1", "novelty.u_th_m wants a number"],
        ),
        ("broken.toml", &["broken.toml:1", "is not TOML"]),
        ("binary.toml", &["binary.toml"]),
        ("missing.toml", &["missing.toml", "cannot be read"]),
        ("folder", &["folder", "cannot be read"]),
    ] {
        for command in [
            &["config", "check"][..],
            &["config", "show"],
            &["compare", "good.ply", "good.ply"],
            &["alarms"],
            &["alarms", "ack", "1"],
            &["waypoints"],
        ] {
            let ran = patrold(dir.path(), &[command, &["--config", file]].concat());
            let told = format!("{command:?} with {file}: {ran:?}");
            assert_eq!(
                (ran.code, ran.out.as_str(), ran.err.lines().count()),
                (2, "", 1),
                "{told}"
            );
            assert!(ran.err.starts_with("patrold: "), "{told}");
            assert!(names.iter().all(|name| ran.err.contains(name)), "{told}");
        }
    }
    assert_eq!(listing(dir.path()), before);
}

#[test]
fn stores_that_are_not_there_or_not_ours() {
    hold(&[
        (
            &["alarms", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database", "store.dir"],
        ),
        (
            &["alarms", "ack", "1", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database"],
        ),
        (
            &["waypoints", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db"],
        ),
        (
            &["alarms", "--config", "file.toml"],
            1,
            &["good.ply", "store.dir"],
        ),
        (
            &["alarms", "--config", "foreign.toml"],
            1,
            &["foreign/patrold.db", "not a patrold database", "store.dir"],
        ),
        (
            &["alarms", "ack", "1", "--config", "foreign.toml"],
            1,
            &["foreign/patrold.db", "store.dir"],
        ),
        (
            &["alarms", "--config", "newer.toml"],
            1,
            &["newer/patrold.db", "newer patrold", "install"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "newer.toml"],
            1,
            &["newer/patrold.db", "newer patrold"],
        ),
        (
            &["alarms", "--config", "garbage.toml"],
            1,
            &["garbage/patrold.db", "not a patrold database"],
        ),
        (
            &["alarms", "ack", "1", "--config", "garbage.toml"],
            1,
            &["garbage/patrold.db", "not a patrold database"],
        ),
        (
            &["alarms", "show", "42", "--config", "ours.toml"],
            1,
            &["alarm 42", "patrold alarms list"],
        ),
        (
            &["alarms", "ack", "42", "--config", "ours.toml"],
            1,
            &["alarm 42", "patrold alarms list"],
        ),
        (
            &["waypoints", "show", "hall", "--config", "ours.toml"],
            1,
            &["\"hall\"", "patrold teach hall"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "ours.toml"],
            1,
            &["\"hall\"", "known: none yet"],
        ),
    ]);
}

#[test]
fn wrong_usage_exits_2_and_says_what_is_right() {
    let dir = folder();
    let before = listing(dir.path());
    for args in [
        &[][..],
        &["guard"],
        &["compare"],
        &["compare", "good.ply"],
        &["compare", "good.ply", "good.ply", "--frobnicate"],
        &["compare", "good.ply", "good.ply", "--u-th", "0"],
        &["compare", "good.ply", "good.ply", "--u-th", "-1"],
        &["compare", "good.ply", "good.ply", "--u-th", "nan"],
        &["compare", "good.ply", "good.ply", "--seed", "-1"],
        &["compare", "good.ply", "good.ply", "--engine", "best"],
        &["compare", "good.ply", "good.ply", "--sensor-origin", "1,2"],
        &[
            "compare",
            "good.ply",
            "good.ply",
            "--sensor-origin",
            "1,2,nan",
        ],
        &["compare", "good.ply", "good.ply", "--manifest", "list.json"],
        &["fit", "good.ply", "--components", "0"],
        &["fit", "good.ply", "--components", "some"],
        &["fit", "good.ply", "--max-components", "0"],
        &["fit", "good.ply", "--threads", "0"],
        &[
            "fit",
            "good.ply",
            "--components",
            "3",
            "--init",
            "flat.json",
        ],
        &["distance", "flat.json", "flat.json", "--ground", "l1"],
        &["distance", "flat.json", "flat.json", "--repeat", "0"],
        &["shapes", "good.ply", "--method", "guess"],
        &["alarms", "show", "first"],
        &["alarms", "list", "--state", "lost"],
        &["alarms", "list", "--since", "yesterday-ish"],
        &["alarms", "list", "--limit", "-3"],
        &["config"],
    ] {
        let ran = patrold(dir.path(), args);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{args:?}: {ran:?}");
        assert!(
            ran.err.contains("Usage") || ran.err.contains("--help"),
            "{args:?}: {}",
            ran.err
        );
        assert!(
            !ran.err.contains("stack backtrace"),
            "{args:?}: {}",
            ran.err
        );
    }
    assert_eq!(listing(dir.path()), before);
}
