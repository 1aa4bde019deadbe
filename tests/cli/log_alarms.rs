//! `patrold alarms`: list, filters, show, ack, export.

use crate::harness::program::patrold;
use crate::harness::schema;
use crate::log::{ids, novelty, run, store_folder, visit};
use patrold::store::Store;
use patrold_engine::novelty::Verdict;
use serde_json::json;
use std::fs;

#[test]
fn every_filter_selects_its_alarms() {
    let dir = store_folder();
    for (filter, expected) in [
        (&[][..], &[4, 3, 2, 1][..]),
        (&["--since", "2027-01-15T09:30:00Z"], &[4, 3, 2]),
        (&["--since", "2027-01-15T11:00:00+01:00"], &[4, 3, 2]),
        (&["--until", "2027-01-15T10:00:00Z"], &[2, 1]),
        (&["--until", "2027-01-15"], &[]),
        (
            &[
                "--since",
                "2027-01-15T09:30:00Z",
                "--until",
                "2027-01-15T10:30:00Z",
            ],
            &[2],
        ),
        (&["--waypoint", "hall"], &[4, 3, 2]),
        (&["--state", "open"], &[4, 3]),
        (&["--state", "acknowledged"], &[2]),
        (&["--state", "cleared"], &[1]),
        (&["--limit", "1"], &[4]),
        (&["--limit", "0"], &[]),
        (
            &[
                "--waypoint",
                "hall",
                "--state",
                "acknowledged",
                "--limit",
                "5",
            ],
            &[2],
        ),
    ] {
        let listed = ids(&run(
            dir.path(),
            &[&["alarms", "list", "--json"], filter].concat(),
        ));
        assert_eq!(listed, expected, "{filter:?}");
        assert_eq!(
            ids(&run(dir.path(), &[&["alarms", "--json"], filter].concat())),
            expected
        );
    }
}

#[test]
fn show_prints_all_about_one_alarm() {
    let dir = store_folder();
    let ran = run(dir.path(), &["alarms", "show", "2", "--json"]);
    let json = ran.json();
    schema::check("alarm", &json);
    assert_eq!(json["state"], "acknowledged");
    assert_eq!(json["acknowledged_by"], "ana");
    assert_eq!(json["frame"], "hall/1");
    assert_eq!(json["raised_at"], "2027-01-15T10:00:00.000Z");
    assert_eq!(json["novelties"][0]["shape"]["class"], "sphere");
    let text = run(dir.path(), &["alarms", "show", "2"]);
    assert!(
        text.out.contains("alarm 2 at hall: acknowledged"),
        "{}",
        text.out
    );
    let table = run(dir.path(), &["alarms"]);
    assert!(
        table.out.contains("appeared at 3.00, 0.00, 0.00"),
        "{}",
        table.out
    );
}

#[test]
fn an_acknowledgement_is_stored() {
    let dir = store_folder();
    let ran = run(
        dir.path(),
        &[
            "alarms",
            "ack",
            "3",
            "--by",
            "bo",
            "--note",
            "cleaner's cart",
            "--json",
        ],
    );
    assert_eq!(ran.code, 0, "{ran:?}");
    schema::check("alarm", &ran.json());
    let after = run(dir.path(), &["alarms", "show", "3", "--json"]).json();
    assert_eq!(after, ran.json());
    assert_eq!(
        (&after["state"], &after["note"]),
        (&json!("acknowledged"), &json!("cleaner's cart"))
    );
}

#[test]
fn alarms_are_exported_as_json_lines_and_csv() {
    let dir = store_folder();
    let ran = run(dir.path(), &["alarms", "export"]);
    let lines = ran.json_lines();
    assert_eq!(lines.len(), 4);
    lines.iter().for_each(|line| schema::check("alarm", line));

    let csv = run(dir.path(), &["alarms", "export", "--format", "csv"]).out;
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 4, "a line per novelty: {csv}");
    let columns = lines[0].split(',').count();
    assert_eq!(lines[1].split(',').count(), columns);
    assert!(csv.contains("\"the \"\"red\"\" bin, again\""), "{csv}");

    let written = run(
        dir.path(),
        &["alarms", "export", "--format", "csv", "--out", "a.csv"],
    );
    assert_eq!((written.code, written.out.as_str()), (0, ""));
    assert_eq!(
        fs::read_to_string(dir.path().join("a.csv")).expect("written"),
        csv
    );

    let none = run(dir.path(), &["alarms", "export", "--until", "2020-01-01"]);
    assert_eq!((none.code, none.out.as_str()), (0, ""), "no alarm, no line");
}

#[test]
fn an_empty_database_has_empty_lists() {
    let dir = tempfile::tempdir().expect("temp dir");
    drop(Store::open(&dir.path().join("store")).expect("store"));
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    assert_eq!(ids(&run(dir.path(), &["alarms", "--json"])), [0i64; 0]);
    let waypoints = run(dir.path(), &["waypoints", "--json"]);
    schema::check("waypoints-list", &waypoints.json());
    assert_eq!(run(dir.path(), &["alarms"]).out, "no alarms\n");
}

#[test]
fn options_may_stand_before_and_after_the_action() {
    let dir = store_folder();
    let before = patrold(
        dir.path(),
        &[
            "alarms", "--config", "c.toml", "--json", "--state", "open", "list",
        ],
    );
    assert_eq!(ids(&before), [4, 3]);
    let both = run(
        dir.path(),
        &[
            "alarms",
            "--waypoint",
            "hall",
            "list",
            "--state",
            "open",
            "--json",
        ],
    );
    assert_eq!(ids(&both), [4, 3]);
    let exported = patrold(
        dir.path(),
        &["alarms", "--config", "c.toml", "--limit", "1", "export"],
    );
    assert_eq!(exported.json()["id"], 4);
    for contradictory in [
        &["alarms", "--limit", "1", "show", "3"][..],
        &["alarms", "export", "--json", "--format", "csv"],
    ] {
        let ran = run(dir.path(), contradictory);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{contradictory:?}");
    }
}

#[test]
fn the_status_shows_things_as_they_were_last_seen() {
    let dir = store_folder();
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    let seen = [novelty(3.06), novelty(5.0)];
    visit(&mut store, "hall", Verdict::Changed, &seen, 14_400);
    store.close();
    let ran = run(dir.path(), &["status", "--json"]);
    let json = ran.json();
    schema::check("status-report", &json);
    let incidents = json["incidents"].as_array().expect("a list");
    let what = |id: i64| {
        let found = incidents.iter().find(|incident| incident["id"] == id);
        found.expect("it stands")["what"][0].as_str().expect("text")
    };
    assert!(what(3).contains("at 3.06, 0.00, 0.00"), "{}", what(3));
    assert!(what(4).contains("at 5.00, 0.00, 0.00"), "{}", what(4));
}
