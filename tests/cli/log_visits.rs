//! `patrold visits` and `patrold events`: list, filters, show; local time, unset clocks, hostile texts.

use crate::harness::program::{CommandOutput, command, patrold};
use crate::harness::schema;
use crate::log::{novelty, record_time, run, teach, visit, visit_at};
use patrold::patrol::severity::Severity;
use patrold::store::{RecordTime, Store};
use patrold_engine::novelty::Verdict;
use std::fs;
use std::path::Path;

/// A clock that was not set yet.
fn unset(second: i64) -> RecordTime {
    RecordTime {
        at: jiff::Timestamp::from_second(second).expect("a time"),
        boot_id: "boot-2".to_owned(),
    }
}

/// Visits 1 (dock, changed), 2 (hall, quiet), 3 (hall, changed, unset clock), 4 (dock, quiet), 5 (hall, not observed); hall was
/// forgotten before 5 and taught again. An hour apart from 09:00 UTC.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 10);
    visit(&mut store, "dock", Verdict::Changed, &[novelty(1.0)], 3600);
    visit(&mut store, "hall", Verdict::Quiet, &[], 7200);
    visit_at(
        &mut store,
        "hall",
        Verdict::Changed,
        &[novelty(2.0)],
        &unset(7),
    );
    visit(&mut store, "dock", Verdict::Quiet, &[], 10_800);
    store
        .forget_waypoint("hall", &record_time(10_900))
        .expect("forgotten");
    teach(&mut store, "hall", 11_000);
    visit(&mut store, "hall", Verdict::NotObserved, &[], 14_400);
    for (second, severity, device, text) in [
        (1, Severity::Info, "service", "patrold started"),
        (2, Severity::Error, "laser", "laser lost"),
        (3, Severity::Warning, "ptu", "slow"),
        (4, Severity::Error, "ptu", "ptu lost"),
    ] {
        store
            .note_event(severity, device, text, &record_time(3600 * second))
            .expect("noted");
    }
    store
        .note_event(Severity::Info, "laser", "laser found", &unset(9))
        .expect("noted");
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    dir
}

fn ids(ran: &CommandOutput, list: &str) -> Vec<i64> {
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check(&format!("{list}-list"), &json);
    let rows = json[list].as_array().expect("a list");
    rows.iter().filter_map(|row| row["id"].as_i64()).collect()
}

fn listed(dir: &Path, list: &str, filter: &[&str]) -> Vec<i64> {
    ids(&run(dir, &[&[list, "--json"], filter].concat()), list)
}

const NINE: &str = "2027-01-15T09:00:00Z";
const TEN: &str = "2027-01-15T10:00:00Z";

#[test]
fn every_filter_of_visits_selects_its_own() {
    let dir = folder();
    for (filter, expected) in [
        (&[][..], &[5, 4, 3, 2, 1][..]),
        (&["--since", TEN], &[5, 4, 3, 2]),
        (&["--since", "2027-01-15T10:00:00.001Z"], &[5, 4, 3]),
        (&["--until", NINE], &[3, 1]),
        (&["--until", "2027-01-15T08:59:59.999Z"], &[3]),
        (&["--since", NINE, "--until", TEN], &[3, 2, 1]),
        (&["--waypoint", "hall"], &[5, 3, 2]),
        (&["--waypoint", "hall", "--limit", "2"], &[5, 3]),
        (&["--waypoint", "dock"], &[4, 1]),
        (&["--verdict", "changed"], &[3, 1]),
        (&["--verdict", "quiet", "--since", TEN], &[4, 2]),
        (&["--verdict", "not_observed"], &[5]),
        (&["--verdict", "changed", "--waypoint", "dock"], &[1]),
        (
            &["--verdict", "quiet", "--waypoint", "hall", "--until", TEN],
            &[2],
        ),
        (&["--limit", "1"], &[5]),
        (&["--limit", "0"], &[]),
    ] {
        assert_eq!(listed(dir.path(), "visits", filter), expected, "{filter:?}");
    }
    let before_the_word = run(dir.path(), &["visits", "list", "--limit", "2", "--json"]);
    assert_eq!(ids(&before_the_word, "visits"), [5, 4]);
    let nobody = run(dir.path(), &["visits", "--waypoint", "attic"]);
    assert_eq!((nobody.code, nobody.out.as_str()), (1, ""));
    assert!(
        nobody.err.contains("the log knows: dock, hall"),
        "{nobody:?}"
    );
}

#[test]
fn every_filter_of_events_selects_its_own() {
    let dir = folder();
    for (filter, expected) in [
        (&[][..], &[5, 4, 3, 2, 1][..]),
        (&["--since", TEN], &[5, 4, 3, 2]),
        (&["--until", NINE], &[5, 1]),
        (&["--level", "error"], &[4, 2]),
        (&["--device", "laser"], &[5, 2]),
        (&["--level", "error", "--device", "ptu"], &[4]),
        (&["--level", "error", "--until", TEN], &[2]),
        (&["--device", "laser", "--until", NINE], &[5]),
        (&["--limit", "2"], &[5, 4]),
    ] {
        assert_eq!(listed(dir.path(), "events", filter), expected, "{filter:?}");
    }
    let table = run(dir.path(), &["events"]).out;
    assert!(
        table.contains("laser found") && table.contains("(clock not set)"),
        "{table}"
    );
}

#[test]
fn a_visit_is_shown_with_its_sweep_and_alarm() {
    let dir = folder();
    let ran = run(dir.path(), &["visits", "show", "3", "--json"]);
    let json = ran.json();
    schema::check("visit-detail", &json);
    assert_eq!(json["waypoint"], "hall");
    assert_eq!(
        (&json["clock_unset"], &json["alarms"][0]),
        (&true.into(), &2.into())
    );
    assert_eq!(
        (&json["boot_id"], &json["frame"]),
        (&"boot-2".into(), &"hall/1".into())
    );
    assert_eq!(json["novelties"][0]["centre"][0], 2.0);
    let text = run(dir.path(), &["visits", "show", "3"]).out;
    for part in [
        "visit 3 at hall: changed",
        "(clock not set)",
        "patrold rejudge 3",
        "alarms show 2",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let unknown = run(dir.path(), &["visits", "show", "99"]);
    assert_eq!(unknown.code, 1);
    assert!(unknown.err.contains("no visit 99"), "{unknown:?}");
}

#[test]
fn people_read_local_time_and_programs_utc() {
    let dir = folder();
    let in_zone = |args: &[&str]| {
        let output = command(dir.path(), &[args, &["--config", "c.toml"]].concat())
            .env("TZ", "EET-2EEST,M3.5.0/3,M10.5.0/4")
            .output()
            .expect("runs");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let table = in_zone(&["visits"]);
    assert!(table.contains("2027-01-15 11:00:00 EET"), "{table}");
    assert!(in_zone(&["visits", "--json"]).contains("2027-01-15T09:00:00.000Z"));
    // Eleven in this zone is nine in UTC.
    let until = in_zone(&["visits", "--json", "--until", "2027-01-15T11:00"]);
    let json: serde_json::Value = serde_json::from_str(&until).expect("JSON");
    assert_eq!(json["visits"].as_array().map(Vec::len), Some(2), "{until}");
    let shown = in_zone(&["alarms", "show", "1"]);
    assert!(shown.contains("raised 2027-01-15 11:00:00 EET"), "{shown}");
}

#[test]
fn an_alarm_of_an_unset_clock_is_never_left_out() {
    let dir = folder();
    for filter in [
        &["--since", "2027-01-15T12:30:00Z"][..],
        &["--until", "2020-01-01"],
    ] {
        assert_eq!(listed(dir.path(), "alarms", filter), [2], "{filter:?}");
    }
    assert_eq!(run(dir.path(), &["alarms", "--since", "-1h"]).code, 0);
    let table = run(dir.path(), &["alarms", "--until", "2020-01-01"]).out;
    assert!(table.contains("(clock not set)"), "{table}");
}

#[test]
fn hostile_texts_reach_neither_terminal_nor_spreadsheet() {
    let dir = folder();
    let note = "=cmd|'/c calc'!A0 \u{1b}[2J\u{9b}31m";
    let acked = run(
        dir.path(),
        &["alarms", "ack", "1", "--by", "\u{1b}[1mbo", "--note", note],
    );
    assert_eq!(acked.code, 0, "{acked:?}");
    for args in [
        &["alarms"][..],
        &["alarms", "show", "1"],
        &["alarms", "export"],
        &["alarms", "export", "--format", "csv"],
        &["visits"],
        &["events"],
    ] {
        let ran = run(dir.path(), args);
        let hostile = |c: char| c.is_control() && c != '\n';
        assert!(!ran.out.contains(hostile), "{args:?}: {:?}", ran.out);
    }
    assert!(!acked.out.contains('\u{1b}'));
    let csv = run(dir.path(), &["alarms", "export", "--format", "csv"]).out;
    assert!(csv.contains(",\"'=cmd|"), "{csv}");
    let json = run(dir.path(), &["alarms", "show", "1", "--json"]).json();
    assert_eq!(json["note"], note, "JSON keeps it");
    let by = json["acknowledged_by"].as_str().expect("a name");
    assert!(by.starts_with("\u{1b}[1mbo (user "), "{by:?}");
}

#[test]
fn an_answer_is_kept_and_the_newest_counts() {
    let dir = folder();
    let answer = |args: &[&str]| {
        let ran = run(
            dir.path(),
            &[&["alarms", "ack", "1", "--json"], args].concat(),
        );
        schema::check("alarm", &ran.json());
        ran.json()["answer"].clone()
    };
    assert_eq!(answer(&[]), serde_json::Value::Null);
    assert_eq!(answer(&["--confirmed"]), "confirmed");
    assert_eq!(answer(&["--false-alarm"]), "false_alarm");
    assert_eq!(answer(&[]), "false_alarm");
    let other = run(dir.path(), &["alarms", "show", "2", "--json"]).json();
    assert!(other["answer"].is_null(), "{other}");
    let both = patrold(
        dir.path(),
        &[
            "alarms",
            "ack",
            "1",
            "--confirmed",
            "--false-alarm",
            "--config",
            "c.toml",
        ],
    );
    assert_eq!(both.code, 2);
}

#[test]
fn alarms_are_selected_by_what_the_thing_is_and_where() {
    let dir = folder();
    let places = "[waypoint.hall]\nmap_pose = [10.0, 20.0, 30.0]\n";
    fs::write(
        dir.path().join("c.toml"),
        format!("store.dir = \"store\"\n{places}"),
    )
    .expect("written");
    for (filter, expected) in [
        (&["--kind", "appeared"][..], &[2, 1][..]),
        (&["--kind", "disappeared"], &[]),
        (&["--class", "sphere"], &[2, 1]),
        (&["--class", "box"], &[]),
        (&["--min-size", "0.3"], &[2, 1]),
        (&["--min-size", "0.31"], &[]),
        (&["--max-size", "0.3"], &[2, 1]),
        (&["--max-size", "0.29"], &[]),
        // The hall's thing is at 2, 0, the dock's at 1, 0.
        (
            &[
                "--waypoint",
                "hall",
                "--near",
                "2.5,0.5",
                "--within",
                "0.71",
            ],
            &[2],
        ),
        (
            &[
                "--waypoint",
                "hall",
                "--near",
                "2.5,0.5",
                "--within",
                "0.70",
            ],
            &[],
        ),
        (&["--waypoint", "dock", "--near", "2,0"], &[1]),
        (&["--waypoint", "dock", "--near", "2.1,0"], &[]),
        (
            &[
                "--waypoint",
                "dock",
                "--near",
                "2,0",
                "--kind",
                "disappeared",
            ],
            &[],
        ),
        (
            &[
                "--waypoint",
                "dock",
                "--near",
                "2,0",
                "--class",
                "sphere",
                "--limit",
                "1",
            ],
            &[1],
        ),
        // Turned left by 30 degrees: 2 m ahead of the hall's base is 1.732 m and 1 m further on the map.
        (&["--map-near", "11.732,21", "--within", "0.01"], &[2]),
        (&["--map-near", "12,20"], &[]),
    ] {
        assert_eq!(listed(dir.path(), "alarms", filter), expected, "{filter:?}");
    }
    for refused in [
        &["--near", "1,2"][..],
        &["--within", "2"],
        &["--near", "a,b"],
        &["--class", "cat"],
    ] {
        let ran = run(dir.path(), &[&["alarms", "list"], refused].concat());
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{refused:?}");
    }
    let shown = run(dir.path(), &["alarms", "show", "2"]).out;
    for part in [
        "2.0 m from the waypoint, straight ahead",
        "0.30 m high, 0.30 m wide, 0.30 m deep",
        "on the map at 11.73, 21.00",
    ] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    let json = run(dir.path(), &["alarms", "show", "2", "--json"]).json();
    schema::check("alarm", &json);
    assert_eq!(json["novelties"][0]["position"]["distance_m"], 2.0);
}

#[test]
fn an_export_of_several_pages_has_every_alarm_once() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    teach(&mut store, "hall", 0);
    for second in 1..=420 {
        let seen = [novelty(second as f64 * 10.0)];
        visit(&mut store, "hall", Verdict::Changed, &seen, second);
    }
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    let exported = |more: &[&str]| -> Vec<i64> {
        let ran = run(dir.path(), &[&["alarms", "export"], more].concat());
        ran.json_lines()
            .iter()
            .filter_map(|line| line["id"].as_i64())
            .collect()
    };
    assert_eq!(exported(&[]), (1..=420).rev().collect::<Vec<i64>>());
    assert_eq!(
        exported(&["--limit", "400"]),
        (21..=420).rev().collect::<Vec<i64>>()
    );
    assert_eq!(exported(&["--limit", "201"]).len(), 201);
}
