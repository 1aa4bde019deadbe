//! `config check`, `config show`, and the configuration of other commands.

use crate::harness::clouds;
use crate::harness::program::patrold;
use crate::harness::schema;
use serde_json::{Value, json};
use std::fs;

fn folder(text: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    fs::write(dir.path().join("c.toml"), text).expect("written");
    dir
}

#[test]
fn check_accepts_a_valid_file() {
    let dir = folder("");
    let ran = patrold(
        dir.path(),
        &["config", "check", "--config", "c.toml", "--json"],
    );
    assert_eq!(ran.code, 0);
    schema::check("config-check", &ran.json());
    assert_eq!(
        ran.json(),
        json!({"valid": true, "files": ["c.toml"], "mistakes": [], "warnings": []})
    );
    let ran = patrold(dir.path(), &["config", "check", "--config", "c.toml"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "valid: c.toml\n"));
}

#[test]
fn the_shipped_file_is_valid_and_changes_nothing() {
    let shipped = patrold_test_support::workspace_root().join("config/patrold.toml");
    let dir = folder("");
    let path = shipped.to_string_lossy();
    let ran = patrold(dir.path(), &["config", "check", "--config", &path]);
    assert_eq!(ran.code, 0, "{ran:?}");
}

#[test]
fn check_lists_every_error() {
    let dir = folder("[novelty]\nuth_m = 0.1\nground = \"l1\"\n[laser]\nport = 3\n");
    let ran = patrold(
        dir.path(),
        &["config", "check", "--config", "c.toml", "--json"],
    );
    assert_eq!((ran.code, ran.err.as_str()), (2, ""));
    let json = ran.json();
    schema::check("config-check", &json);
    assert_eq!(json["valid"], false);
    let lines: Vec<&Value> = json["mistakes"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|m| &m["line"])
        .collect();
    assert_eq!(lines.len(), 3);
    let ran = patrold(dir.path(), &["config", "check", "--config", "c.toml"]);
    assert_eq!((ran.code, ran.out.as_str()), (2, ""));
    let errors: Vec<&str> = ran.err.lines().collect();
    assert_eq!(errors.len(), 3, "{errors:?}");
    assert!(
        errors
            .iter()
            .all(|line| line.starts_with("patrold: c.toml:")),
        "{errors:?}"
    );
    assert!(
        ran.err
            .contains("patrold: c.toml:2: unknown key novelty.uth_m; did you mean novelty.u_th_m?")
    );
}

#[test]
fn show_reports_the_origin_of_each_value() {
    let dir = folder("novelty.u_th_m = 0.003\n[waypoint.hall]\nu_th_m = 0.004\n");
    fs::create_dir(dir.path().join("c.d")).expect("folder");
    fs::write(dir.path().join("c.d/1.toml"), "[log]\nlevel = \"debug\"\n").expect("written");
    let ran = patrold(
        dir.path(),
        &["config", "show", "--config", "c.toml", "--json"],
    );
    assert_eq!(ran.code, 0, "{ran:?}");
    let json = ran.json();
    schema::check("config-show", &json);
    assert_eq!(json["files"], json!(["c.toml", "c.d/1.toml"]));
    let setting = |key: &str| {
        let all = json["settings"].as_array().expect("a list");
        let one = all.iter().find(|s| s["key"] == key);
        one.unwrap_or_else(|| panic!("{key}")).clone()
    };
    assert_eq!(setting("novelty.u_th_m")["value"], 0.003);
    assert_eq!(setting("novelty.u_th_m")["from"], "c.toml:1");
    assert_eq!(setting("log.level")["from"], "c.d/1.toml:2");
    assert_eq!(setting("novelty.ground")["from"], "default");
    assert_eq!(setting("waypoint.hall.u_th_m")["value"], 0.004);
    let text = patrold(dir.path(), &["config", "show", "--config", "c.toml"]);
    assert!(text.out.contains("novelty.u_th_m"), "{}", text.out);
}

#[test]
fn flags_override_the_file() {
    let dir = clouds::folder();
    fs::write(
        dir.path().join("c.toml"),
        "[novelty]\nu_th_m = 0.25\n[mixture]\nseed = 3\n",
    )
    .expect("written");
    let run = |extra: &[&str]| {
        let args = [
            &[
                "compare",
                "then.ply",
                "again.ply",
                "--json",
                "--config",
                "c.toml",
            ],
            extra,
        ]
        .concat();
        patrold(dir.path(), &args).json()
    };
    let file = run(&[]);
    assert_eq!((&file["u_th"], &file["seed"]), (&json!(0.25), &json!(3)));
    let flags = run(&["--u-th", "0.5", "--seed", "4"]);
    assert_eq!((&flags["u_th"], &flags["seed"]), (&json!(0.5), &json!(4)));
}

#[test]
fn relative_paths_start_at_the_folder_of_the_file() {
    let dir = folder("");
    fs::create_dir(dir.path().join("etc")).expect("folder");
    fs::write(dir.path().join("etc/c.toml"), "store.dir = \"store\"\n").expect("written");
    drop(patrold::store::Store::open(&dir.path().join("etc/store")).expect("store"));
    for (from, file) in [
        (dir.path().to_owned(), "etc/c.toml"),
        (dir.path().join("etc"), "c.toml"),
    ] {
        let ran = patrold(&from, &["waypoints", "--config", file, "--json"]);
        assert_eq!(ran.code, 0, "{ran:?}");
    }
}
