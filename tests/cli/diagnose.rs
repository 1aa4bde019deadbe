//! The bundle for support.

use crate::harness::program::patrold;
use crate::harness::schema;
use crate::log::{run, store_folder};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

fn unpacked(dir: &Path, archive: &str) -> Vec<(String, String)> {
    let ran = Command::new("tar")
        .args(["xf", archive])
        .current_dir(dir)
        .output();
    let ran = ran.expect("tar runs");
    assert!(ran.status.success(), "{ran:?}");
    let entries = fs::read_dir(dir.join("patrold-diagnose")).expect("its folder");
    let mut files: Vec<(String, String)> = entries
        .map(|entry| {
            let entry = entry.expect("an entry");
            let text = fs::read(entry.path()).expect("readable");
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, String::from_utf8_lossy(&text).into_owned())
        })
        .collect();
    files.sort();
    files
}

fn part<'a>(files: &'a [(String, String)], name: &str) -> &'a str {
    let found = files.iter().find(|(file, _)| file == name);
    &found.unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn a_bundle_has_log_configuration_and_store_and_lists_what_it_has_not() {
    let dir = store_folder();
    let config = fs::read_to_string(dir.path().join("c.toml")).expect("there");
    let ports = "laser.port = \"no-laser\"\nptu.port = \"no-ptu\"\n";
    let more = format!("{config}{ports}api.socket = \"p.sock\" # a remark with hunter2\n");
    fs::write(dir.path().join("c.toml"), more).expect("written");
    let ran = run(dir.path(), &["diagnose", "--out", "b.tar", "--json"]);
    assert_eq!(ran.code, 0, "{ran:?}");
    let report = ran.json();
    schema::check("diagnose", &report);
    let mode = fs::metadata(dir.path().join("b.tar"))
        .expect("there")
        .permissions();
    assert_eq!(mode.mode() & 0o777, 0o600);

    let files = unpacked(dir.path(), "b.tar");
    let contents: Value = serde_json::from_str(part(&files, "contents.json")).expect("JSON");
    assert_eq!(contents, report["parts"]);
    for listed in contents.as_array().expect("a list") {
        let name = listed["name"].as_str().expect("a name");
        let there = files.iter().find(|(file, _)| file == name);
        assert_eq!(
            there.map(|(_, text)| text.len() as u64),
            listed["bytes"].as_u64(),
            "{name}"
        );
        assert_ne!(
            listed["missing_because"].is_null(),
            there.is_none(),
            "{name}"
        );
    }
    let lines = |name| {
        part(&files, name)
            .lines()
            .map(|l| serde_json::from_str(l).expect("JSON"))
            .collect::<Vec<Value>>()
    };
    assert_eq!(lines("visits.jsonl").len(), 4);
    assert_eq!(lines("alarms.jsonl").len(), 4);
    assert!(part(&files, "store.txt").contains("patrold.db"));
    let status: Value = serde_json::from_str(part(&files, "status.json")).expect("JSON");
    schema::check("status-report", &status);
    let settings: Value = serde_json::from_str(part(&files, "configuration.json")).expect("JSON");
    let keys: Vec<&Value> = settings["settings"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|s| &s["key"])
        .collect();
    assert!(keys.contains(&&"laser.port".into()) && keys.len() > 40);
    let devices: Value = serde_json::from_str(part(&files, "devices.json")).expect("JSON");
    assert!(
        devices["laser"]["error"]
            .as_str()
            .is_some_and(|e| e.contains("no-laser")),
        "{devices}"
    );
    assert!(files.iter().all(|(_, text)| !text.contains("hunter2")));
}

#[test]
fn a_bundle_overwrites_nothing_and_is_made_without_a_store_too() {
    let dir = tempfile::tempdir().expect("temp dir");
    let at = |name: &str| dir.path().join(name);
    fs::write(at("c.toml"), "store.dir = \"none\"\napi.socket = \"p.sock\"\nlaser.port = \"l\"\nptu.port = \"p\"\nlaser.prot = 1\n").expect("written");
    fs::write(at("there"), "kept").expect("written");
    std::os::unix::fs::symlink("there", at("link")).expect("a link");
    for taken in ["there", "link", "c.toml"] {
        let ran = patrold(
            dir.path(),
            &["diagnose", "--out", taken, "--config", "c.toml"],
        );
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{ran:?}");
        assert!(
            ran.err.contains("exists already") && ran.err.lines().count() == 1,
            "{ran:?}"
        );
    }
    assert_eq!(fs::read(at("there")).expect("there"), b"kept");
    let ran = patrold(
        dir.path(),
        &["diagnose", "--out", "b.tar", "--config", "c.toml"],
    );
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(ran.out.contains("no database here"), "{ran:?}");
    let files = unpacked(dir.path(), "b.tar");
    assert!(part(&files, "configuration.json").contains("laser.prot"));
    assert!(files.iter().all(|(name, _)| name != "visits.jsonl"));
    // Half a bundle is none.
    let ran = patrold(
        dir.path(),
        &["diagnose", "--out", "c.tar", "--config", "none.toml"],
    );
    assert_eq!(ran.code, 2, "{ran:?}");
    assert!(!at("c.tar").exists());
}
