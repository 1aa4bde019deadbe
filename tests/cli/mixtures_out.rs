//! `--mixtures-out`: what is written is what was compared.

use crate::harness::clouds;
use crate::harness::program::patrold;
use crate::rejudge::{rejudge, store_folder_with};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// `patrold distance` on the two files in `dir/folder`.
fn distance(dir: &Path, folder: &str) -> f64 {
    let files = ["gamma", "theta"].map(|name| format!("{folder}/{name}.json"));
    let ran = patrold(dir, &["distance", &files[0], &files[1], "--json"]);
    assert_eq!(ran.code, 0, "{ran:?}");
    ran.json()["d"].as_f64().expect("a distance")
}

fn assert_same(distance: f64, d_gmm: &Value) {
    let d_gmm = d_gmm.as_f64().expect("d_gmm");
    assert!((distance - d_gmm).abs() < 1e-12, "{distance} and {d_gmm}");
}

#[test]
fn the_distance_of_the_files_is_that_of_the_verdict() {
    let dir = clouds::folder();
    for current in ["now.ply", "again.ply", "then.ply"] {
        let args = ["compare", "then.ply", current, "--json", "--mixtures-out"];
        let ran = patrold(dir.path(), &[&args[..], &["out/m"]].concat());
        let json = ran.json();
        let gamma = fs::read_to_string(dir.path().join("out/m/gamma.json")).expect("written");
        let gamma: Value = serde_json::from_str(&gamma).expect("JSON");
        assert_eq!(
            gamma["weights"].as_array().map(Vec::len),
            json["reference"]["components"].as_u64().map(|n| n as usize),
            "{current}"
        );
        assert_same(distance(dir.path(), "out/m"), &json["d_gmm"]);
        assert_eq!(
            ran.code == 10,
            json["d_gmm"].as_f64() > Some(5e-4),
            "{json}"
        );
    }
}

#[test]
fn pairs_of_a_manifest_have_folders_of_their_own() {
    let dir = clouds::folder();
    let pair = |name: &str, current: &str| json!({"name": name, "reference": "then.ply", "current": current});
    let pairs = [
        pair("crate", "now.ply"),
        pair("noise", "again.ply"),
        pair("../crate", "now.ply"),
        pair("crate", "again.ply"),
    ];
    let manifest = json!({"pairs": pairs});
    fs::write(dir.path().join("pairs.json"), manifest.to_string()).expect("written");
    let args = ["compare", "--manifest", "pairs.json", "--mixtures-out", "m"];
    let ran = patrold(dir.path(), &args);
    assert_eq!(ran.code, 1, "{ran:?}");
    let lines = ran.json_lines();
    assert_same(distance(dir.path(), "m/crate"), &lines[0]["d_gmm"]);
    assert_same(distance(dir.path(), "m/noise"), &lines[1]["d_gmm"]);
    for (line, why) in [
        (2, "the name \"../crate\" begins with a dot"),
        (3, "another pair"),
    ] {
        let error = lines[line]["error"].as_str().expect("an error");
        assert!(error.contains(why), "{error}");
    }
    assert!(!dir.path().join("crate").exists());
}

#[test]
fn a_visit_judged_again_writes_them_too() {
    let dir = store_folder_with(&[]);
    let ran = rejudge(dir.path(), &["1", "--json", "--mixtures-out", "m"]);
    assert_eq!(ran.code, 10, "{ran:?}");
    assert_same(distance(dir.path(), "m"), &ran.json()["judged"]["d_gmm"]);
    // An incomplete sweep is compared with nothing.
    let ran = rejudge(dir.path(), &["3", "--mixtures-out", "none"]);
    assert_eq!((ran.code, dir.path().join("none").exists()), (11, false));
}
