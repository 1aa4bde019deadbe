//! Bad input: one line on standard error that names the file or argument, the right exit code, and nothing written.

use crate::harness::clouds;
use crate::harness::program::patrold;
use nalgebra::Point3;
use patrold::store::Store;
use patrold_engine::formats::write_ply;
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A folder with files that are wrong in every way.
pub(crate) fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let put = |name: &str, bytes: &[u8]| fs::write(dir.path().join(name), bytes).expect("written");
    let good = write_ply(&clouds::room_points(&[], 1));
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
        "beamless.json",
        b"{\"weights\": [1], \"means\": [[0, 0, 0]], \"covs\": [[1, 0, 0, 1, 0, 1]], \"beams\": [0]}",
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

/// Every file below `dir` with its size, without the `-wal` and `-shm` files of SQLite.
pub(crate) fn listing(dir: &Path) -> BTreeMap<String, u64> {
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

/// Arguments, exit code, and parts of the error line.
pub(crate) type FailureCase = (&'static [&'static str], i32, &'static [&'static str]);

pub(crate) fn check_failures(cases: &[FailureCase]) {
    let dir = folder();
    let before = listing(dir.path());
    let mut wrong = Vec::new();
    for (args, code, names) in cases {
        let ran = patrold(dir.path(), args);
        let lines: Vec<&str> = ran.err.lines().collect();
        let one_line = lines.len() == 1 && lines[0].starts_with("patrold: ");
        let named = names.iter().all(|name| ran.err.contains(name));
        if ran.code != *code || !one_line || !named || !ran.out.is_empty() {
            wrong.push(format!("{args:?} (expected {code}, {names:?}): {ran:?}"));
        }
        let after = listing(dir.path());
        if after != before {
            wrong.push(format!("{args:?} left {after:?}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
