//! `evaluate`: its JSON, the same for any number of threads; its dumped pairs, judged the same by `compare`.

use crate::harness::program::patrold;
use crate::harness::schema;
use serde_json::Value;
use std::fs;

/// The report without times.
fn without_times(mut report: Value) -> Value {
    report["seconds"] = Value::Null;
    for row in report["rows"].as_array_mut().into_iter().flatten() {
        row["verdict_ms"] = Value::Null;
    }
    report
}

#[test]
fn the_report_fits_its_schema_and_does_not_depend_on_threads() {
    let dir = tempfile::tempdir().expect("temp dir");
    let with = |threads: &str| {
        let pairs = [
            "--pair",
            "quiet-0",
            "--pair",
            "person-1",
            "--pair",
            "rings-ball20-0",
        ];
        let mut args = vec!["evaluate", "--json", "--threads", threads];
        args.extend(pairs);
        let ran = patrold(dir.path(), &args);
        assert_eq!(ran.code, 0, "{ran:?}");
        ran.json()
    };
    let report = with("1");
    schema::check("evaluate", &report);
    assert_eq!(report["pairs"], 3);
    assert_eq!(without_times(report), without_times(with("3")));
}

#[test]
fn thresholds_from_quiet_visits_do_not_depend_on_threads_or_on_other_pairs() {
    let dir = tempfile::tempdir().expect("temp dir");
    let with = |more: &[&str]| {
        let some = ["evaluate", "--json", "--view", "bare", "--engine", "both"];
        let quiet = [
            "--u-th",
            "quiet",
            "--quiet-visits",
            "2",
            "--pair",
            "quiet-4",
        ];
        let ran = patrold(dir.path(), &[&some[..], &quiet, more].concat());
        assert_eq!(ran.code, 0, "{ran:?}");
        let report = ran.json();
        schema::check("evaluate", &report);
        report
    };
    let pairs = ["--pair", "box-4", "--threads"];
    let report = with(&[&pairs[..], &["1"]].concat());
    assert_eq!(report["quiet_visits"], 2);
    assert_eq!(
        without_times(report.clone()),
        without_times(with(&[&pairs[..], &["2"]].concat()))
    );
    // One quiet and one changed pair in one kind of place: over all, and in that kind.
    let rows = report["separation"].as_array().expect("rows");
    let of =
        |engine: &str| -> Vec<&Value> { rows.iter().filter(|r| r["engine"] == engine).collect() };
    assert_eq!((of("standard").len(), of("paper").len()), (2, 2));
    let standard = of("standard")[0];
    assert_eq!(
        (&standard["auc"], &standard["of"]),
        (&1.0.into(), &"all".into())
    );
    assert_eq!(standard["found"]["count"], 1);
    // Without changed pairs nothing is separated.
    assert_eq!(with(&[])["separation"], Value::Array(Vec::new()));
}

#[test]
fn dumped_pairs_are_judged_as_in_the_run() {
    let dir = tempfile::tempdir().expect("temp dir");
    let args = [
        "--pair", "box-0", "--view", "bare", "--dump", "pairs", "--json",
    ];
    let ran = patrold(dir.path(), &[&["evaluate"], &args[..]].concat());
    let report = ran.json();
    let changed = &report["rows"][0]["changed"]["count"];

    let text = fs::read_to_string(dir.path().join("pairs/manifest.json")).expect("a manifest");
    let manifest: Value = serde_json::from_str(&text).expect("JSON");
    let pair = &manifest["pairs"][0];
    assert_eq!(
        (&pair["name"], &pair["changed"]),
        (&"box-0".into(), &true.into())
    );
    let compared = patrold(
        dir.path(),
        &["compare", "--manifest", "pairs/manifest.json", "--json"],
    );
    let line = compared.json();
    schema::check("compare", &line);
    assert_eq!(line["verdict"] == "changed", *changed == 1, "{line}");

    let labels = pair["current_labels"].as_str().expect("a file");
    let labels = fs::read_to_string(dir.path().join("pairs").join(labels)).expect("labels");
    assert_eq!(
        Value::from(labels.lines().count()),
        line["current"]["points"]
    );
    assert!(labels.lines().filter(|l| *l == "1").count() > 20);
}

#[test]
fn unknown_names_are_refused_with_the_known_ones() {
    let dir = tempfile::tempdir().expect("temp dir");
    for (args, names) in [
        (["--place", "moon"], "office, corridor"),
        (["--sensor", "eye"], "urg, urg-1.5"),
        (["--pair", "tree-1"], "such as quiet-17"),
        (["--pairs", "0"], "no pair is left"),
        (["--u-th", "loud"], "engine, quiet"),
        (["--quiet-visits", "0"], "1..=1000"),
    ] {
        let ran = patrold(dir.path(), &[&["evaluate"], &args[..]].concat());
        assert_eq!(ran.code, 2, "{ran:?}");
        assert!(ran.err.contains(names), "{ran:?}");
    }
}
