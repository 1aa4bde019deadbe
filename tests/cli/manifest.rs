//! `compare --manifest`: many pairs, one line each, one exit code.

use crate::harness::clouds;
use crate::harness::program::{CommandOutput, patrold};
use crate::harness::schema;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn pair(name: &str, reference: &str, current: &str) -> Value {
    json!({"name": name, "reference": reference, "current": current})
}

fn run(dir: &Path, pairs: &[Value]) -> CommandOutput {
    let manifest = json!({"pairs": pairs, "units": "m", "truth": {"any": "thing"}});
    fs::write(dir.join("pairs.json"), manifest.to_string()).expect("written");
    patrold(dir, &["compare", "--manifest", "pairs.json", "--json"])
}

#[test]
fn each_pair_has_a_line_in_order_and_a_failure_stops_no_other() {
    let dir = clouds::folder();
    let pairs = [
        pair("noise", "then.ply", "again.ply"),
        pair("lost", "then.ply", "nowhere.ply"),
        pair("crate", "then.ply", "now.ply"),
        pair("same", "then.ply", "then.ply"),
    ];
    let ran = run(dir.path(), &pairs);
    assert_eq!(ran.code, 1, "{ran:?}");
    let lines = ran.json_lines();
    let names: Vec<&str> = lines.iter().filter_map(|l| l["name"].as_str()).collect();
    assert_eq!(names, ["noise", "lost", "crate", "same"]);
    for (line, form) in lines
        .iter()
        .zip(["compare", "compare-error", "compare", "compare"])
    {
        schema::check(form, line);
    }
    assert!(
        lines[1]["error"]
            .as_str()
            .is_some_and(|e| e.contains("nowhere.ply")),
        "{}",
        lines[1]
    );
    assert_eq!(lines[2]["verdict"], "changed");
}

#[test]
fn the_exit_code_is_that_of_the_worst_result() {
    let dir = clouds::folder();
    let same = pair("same", "then.ply", "then.ply");
    let changed = pair("crate", "then.ply", "now.ply");
    assert_eq!(run(dir.path(), std::slice::from_ref(&same)).code, 0);
    assert_eq!(run(dir.path(), &[changed, same]).code, 10);
    assert_eq!(run(dir.path(), &[]).code, 0);
}

#[test]
fn paths_are_relative_to_the_manifest() {
    let dir = clouds::folder();
    let inner = dir.path().join("inner");
    fs::create_dir(&inner).expect("folder");
    let manifest = json!({"pairs": [{
        "name": "crate", "reference": "../then.ply", "current": "../now.ply", "labels_out": "labels.txt",
        "sensor_origin": [0, 0, 0], "nochange": false,
    }]});
    fs::write(inner.join("pairs.json"), manifest.to_string()).expect("written");
    let ran = patrold(dir.path(), &["compare", "--manifest", "inner/pairs.json"]);
    assert_eq!(ran.code, 10, "{ran:?}");
    schema::check("compare", &ran.json());
    let labels = fs::read_to_string(inner.join("labels.txt")).expect("beside the manifest");
    assert!(labels.contains('1'));
}

#[test]
fn a_pair_of_a_manifest_gives_the_same_line_alone() {
    let dir = clouds::folder();
    let mut from_manifest = run(
        dir.path(),
        &[
            pair("same", "then.ply", "again.ply"),
            pair("now", "then.ply", "now.ply"),
        ],
    )
    .json_lines()
    .pop()
    .expect("two lines");
    let mut alone = patrold(dir.path(), &["compare", "then.ply", "now.ply", "--json"]).json();
    for json in [&mut from_manifest, &mut alone] {
        json.as_object_mut().expect("an object").remove("timing_ms");
    }
    assert_eq!(from_manifest, alone);
}

#[test]
fn a_malformed_pair_is_one_error_line_and_the_others_run() {
    let dir = clouds::folder();
    let pairs = [
        json!({"name": "half", "reference": "then.ply"}),
        json!({"reference": "then.ply"}),
        json!(7),
        pair("same", "then.ply", "then.ply"),
    ];
    let ran = run(dir.path(), &pairs);
    assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{ran:?}");
    let lines = ran.json_lines();
    let names: Vec<&Value> = lines.iter().map(|l| &l["name"]).collect();
    assert_eq!(names, ["half", "1", "2", "same"]);
    for line in &lines[..3] {
        schema::check("compare-error", line);
    }
    assert!(
        lines[0]["error"]
            .as_str()
            .is_some_and(|e| e.contains("current")),
        "{}",
        lines[0]
    );
    schema::check("compare", &lines[3]);
}

#[test]
fn origins_of_the_command_line_apply_to_pairs_without_their_own() {
    let dir = clouds::folder();
    let mut own = pair("own", "then.ply", "again.ply");
    own["sensor_origin"] = json!([0, 0, 0]);
    let manifest = json!({"pairs": [pair("bare", "then.ply", "again.ply"), own]});
    fs::write(dir.path().join("pairs.json"), manifest.to_string()).expect("written");
    let lines = |flags: &[&str]| {
        let args = [&["compare", "--manifest", "pairs.json"], flags].concat();
        let mut lines = patrold(dir.path(), &args).json_lines();
        for line in &mut lines {
            let line = line.as_object_mut().expect("an object");
            line.remove("timing_ms");
            line.remove("name");
        }
        lines
    };
    let alone = |flags: &[&str]| {
        let args = [&["compare", "then.ply", "again.ply", "--json"], flags].concat();
        let mut line = patrold(dir.path(), &args).json();
        let object = line.as_object_mut().expect("an object");
        object.remove("timing_ms");
        object.remove("name");
        line
    };
    let flags = ["--sensor-origin", "0.4,0.3,0.2"];
    let [bare, own] = &lines(&flags)[..] else {
        panic!("two lines")
    };
    assert_eq!(*bare, alone(&flags));
    assert_eq!(*own, alone(&[]));
    assert_ne!(bare, own);
}

#[test]
fn an_empty_manifest_says_so_and_a_byte_order_mark_is_passed_over() {
    let dir = clouds::folder();
    let ran = run(dir.path(), &[]);
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(ran.err.contains("`pairs` is empty"), "{ran:?}");
    let manifest = json!({"pairs": [pair("same", "then.ply", "then.ply")]});
    let marked = format!("\u{feff}{manifest}");
    fs::write(dir.path().join("marked.json"), marked).expect("written");
    let ran = patrold(dir.path(), &["compare", "--manifest", "marked.json"]);
    assert_eq!(ran.code, 0, "{ran:?}");
}

#[test]
fn no_pair_writes_over_a_cloud_of_another() {
    let dir = clouds::folder();
    let before = fs::read(dir.path().join("now.ply")).expect("a cloud");
    let mut first = pair("first", "then.ply", "again.ply");
    first["labels_out"] = json!("now.ply");
    let ran = run(dir.path(), &[first, pair("second", "then.ply", "now.ply")]);
    let lines = ran.json_lines();
    let error = lines[0]["error"].as_str().expect("refused");
    assert!(error.contains("is an input of this command"), "{error}");
    assert_eq!(lines[1]["verdict"], "changed");
    let after = fs::read(dir.path().join("now.ply")).expect("still there");
    assert!(before == after);
}
