//! The alarm log and the waypoints as the command line shows them, from a database that the library filled.

use crate::harness::program::{Ran, patrold};
use crate::harness::schema;
use nalgebra::{Matrix3, Point3};
use patrold::geometry::View;
use patrold::mixture::{Gaussian, Mixture};
use patrold::novelty::Verdict;
use patrold::patrol::{MethodsRecord, NoveltyRecord, ShapeRecord};
use patrold::store::{NewReference, NewVisit, Stamp, Store, SweepRecord};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// 2027-01-15T08:00:00Z and so many seconds.
fn stamp(second: i64) -> Stamp {
    Stamp {
        at: jiff::Timestamp::from_second(1_800_000_000 + second).expect("a time"),
        boot_id: "boot-1".to_owned(),
    }
}

fn mixture() -> Mixture {
    let component = Gaussian {
        mean: Point3::origin(),
        covariance: Matrix3::identity(),
    };
    Mixture {
        weights: vec![1.0],
        components: vec![component],
    }
}

fn thing(x: f64) -> NoveltyRecord {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let shape = ShapeRecord {
        class: "sphere".to_owned(),
        method: "covariance".to_owned(),
        probability: 0.9,
        alternatives: Vec::new(),
        centre: [x, 0.0, 0.0],
        centre_sd: [0.01; 3],
        rotation: unit,
        size: [0.3; 3],
        size_sd: [0.02; 3],
        exponents: None,
        residual_m: 0.004,
        inliers: 120,
    };
    NoveltyRecord {
        kind: "appeared".to_owned(),
        moved_from: None,
        centre: [x, 0.0, 0.0],
        covariance: unit,
        extent: [0.3; 3],
        points: 120,
        mass: 0.01,
        contribution: 0.002,
        support: 400.0,
        shape: Some(shape.clone()),
        shapes: MethodsRecord {
            covariance: Some(shape),
            ransac: None,
        },
        parts: Vec::new(),
    }
}

fn teach(store: &mut Store, waypoint: &str, second: i64) {
    let view = View::bare(vec![Point3::new(1.0, 2.0, second as f64)], Point3::origin());
    let sweep = SweepRecord {
        view: Some(&view),
        raw: None,
        quality: "{}",
    };
    let new = NewReference {
        waypoint,
        sweep,
        mixture: &mixture(),
        engine: "{}",
        seed: 7,
    };
    store.teach(&new, &stamp(second)).expect("taught");
}

fn visit(store: &mut Store, waypoint: &str, verdict: Verdict, seen: &[NoveltyRecord], second: i64) {
    let view = View::bare(vec![Point3::new(9.0, 2.0, second as f64)], Point3::origin());
    let visit = NewVisit {
        waypoint,
        reference_id: Some(store.reference(waypoint).expect("reference").id),
        sweep: Some(SweepRecord {
            view: Some(&view),
            raw: None,
            quality: "{}",
        }),
        verdict,
        reason: "d_GMM reaches U_th",
        d_gmm: Some(0.0021),
        u_th: 0.0005,
        seed: 7,
        engine: r#"{"ground": "w2"}"#,
        report: "{}",
        novelties: seen,
        same_place_m: 0.5,
    };
    store
        .record_visit(&visit, &stamp(second))
        .expect("recorded");
}

/// Alarms 1 (dock, cleared), 2 (hall, acknowledged) and 3 (hall, open, two things), raised an hour apart.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 10);
    visit(&mut store, "dock", Verdict::Changed, &[thing(1.0)], 3600);
    visit(&mut store, "dock", Verdict::Quiet, &[], 3700);
    visit(&mut store, "hall", Verdict::Changed, &[thing(1.0)], 7200);
    store
        .acknowledge(2, "ana", Some("the \"red\" bin, again"), &stamp(7300))
        .expect("acknowledged");
    visit(
        &mut store,
        "hall",
        Verdict::Changed,
        &[thing(3.0), thing(5.0)],
        10_800,
    );
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    dir
}

fn run(dir: &Path, args: &[&str]) -> Ran {
    patrold(dir, &[args, &["--config", "c.toml"]].concat())
}

fn ids(ran: &Ran) -> Vec<i64> {
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check("alarms-list", &json);
    let all = json["alarms"].as_array().expect("a list");
    all.iter().filter_map(|a| a["id"].as_i64()).collect()
}

#[test]
fn every_filter_narrows_the_list() {
    let dir = folder();
    for (filter, expected) in [
        (&[][..], &[3, 2, 1][..]),
        (&["--since", "2027-01-15T09:30:00Z"], &[3, 2]),
        (&["--since", "2027-01-15T11:00:00+01:00"], &[3, 2]),
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
        (&["--waypoint", "hall"], &[3, 2]),
        (&["--state", "open"], &[3]),
        (&["--state", "acknowledged"], &[2]),
        (&["--state", "cleared"], &[1]),
        (&["--limit", "1"], &[3]),
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
fn one_alarm_is_shown_with_all_that_is_known() {
    let dir = folder();
    let ran = run(dir.path(), &["alarms", "show", "2", "--json"]);
    let json = ran.json();
    schema::check("alarm", &json);
    assert_eq!(json["state"], "acknowledged");
    assert_eq!(json["acknowledged_by"], "ana");
    assert_eq!(json["frame"], "hall/1");
    assert_eq!(json["raised_at"], "2027-01-15T10:00:00.000Z");
    assert_eq!(json["novelties"][0]["shape"]["class"], "sphere");
    let people = run(dir.path(), &["alarms", "show", "2"]);
    assert!(
        people.out.contains("alarm 2 at hall: acknowledged"),
        "{}",
        people.out
    );
    let table = run(dir.path(), &["alarms"]);
    assert!(
        table.out.contains("appeared at 3.00, 0.00, 0.00"),
        "{}",
        table.out
    );
}

#[test]
fn acknowledging_is_kept() {
    let dir = folder();
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
    let dir = folder();
    let ran = run(dir.path(), &["alarms", "export"]);
    let lines = ran.json_lines();
    assert_eq!(lines.len(), 3);
    lines.iter().for_each(|line| schema::check("alarm", line));

    let csv = run(dir.path(), &["alarms", "export", "--format", "csv"]).out;
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 4, "a line per thing: {csv}");
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
fn waypoints_are_listed_shown_and_forgotten() {
    let dir = folder();
    let list = run(dir.path(), &["waypoints", "--json"]);
    let json = list.json();
    schema::check("waypoints-list", &json);
    let names: Vec<&Value> = json["waypoints"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|w| &w["name"])
        .collect();
    assert_eq!(names, ["dock", "hall"]);

    let shown = run(dir.path(), &["waypoints", "show", "hall", "--json"]).json();
    schema::check("waypoint", &shown);
    assert_eq!(
        (&shown["standing_alarms"], &shown["last_verdict"]),
        (&json!(2), &json!("changed"))
    );

    let gone = run(dir.path(), &["waypoints", "forget", "hall", "--json"]);
    assert_eq!(gone.code, 0);
    schema::check("waypoint-forgotten", &gone.json());
    let left = run(dir.path(), &["waypoints", "list", "--json"]).json();
    assert_eq!(left["waypoints"].as_array().map(Vec::len), Some(1));
    assert_eq!(
        ids(&run(
            dir.path(),
            &["alarms", "list", "--json", "--state", "cleared"]
        )),
        [3, 2, 1]
    );
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
fn flags_may_stand_before_the_command_as_after_it() {
    let dir = folder();
    let before = patrold(
        dir.path(),
        &[
            "alarms", "--config", "c.toml", "--json", "--state", "open", "list",
        ],
    );
    assert_eq!(ids(&before), [3]);
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
    assert_eq!(ids(&both), [3]);
    let exported = patrold(
        dir.path(),
        &["alarms", "--config", "c.toml", "--limit", "1", "export"],
    );
    assert_eq!(exported.json()["id"], 3);
    for senseless in [
        &["alarms", "--limit", "1", "show", "3"][..],
        &["alarms", "export", "--json", "--format", "csv"],
    ] {
        let ran = run(dir.path(), senseless);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{senseless:?}");
    }
}

#[test]
fn a_waypoint_that_the_log_never_heard_of_is_an_error() {
    let dir = folder();
    run(dir.path(), &["waypoints", "forget", "dock"]);
    for args in [
        &["alarms", "--waypoint", "hal"][..],
        &["alarms", "export", "--waypoint", "hal"],
    ] {
        let ran = run(dir.path(), args);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""));
        assert!(
            ran.err
                .contains("unknown waypoint \"hal\"; the log knows: dock, hall"),
            "{}",
            ran.err
        );
    }
    assert_eq!(
        ids(&run(
            dir.path(),
            &["alarms", "--json", "--waypoint", "dock"]
        )),
        [1]
    );
}

#[test]
fn places_on_the_map_are_told_where_they_are_configured() {
    let dir = folder();
    fs::write(
        dir.path().join("c.toml"),
        "store.dir = \"store\"\n[waypoint.hall]\nmap_pose = [10.0, 20.0, 90.0]\n",
    )
    .expect("written");
    let shown = run(dir.path(), &["alarms", "show", "3", "--json"]).json();
    schema::check("alarm", &shown);
    let place = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a place");
        list.iter().filter_map(Value::as_f64).collect()
    };
    let on_map = place(&shown["novelties"][0]["map_centre"]);
    for (got, expected) in on_map.iter().zip([10.0, 23.0, 0.0]) {
        assert!((got - expected).abs() < 1e-9, "{on_map:?}");
    }
    let elsewhere = run(dir.path(), &["alarms", "show", "1", "--json"]).json();
    assert_eq!(elsewhere["novelties"][0].get("map_centre"), None);
    let people = run(dir.path(), &["alarms", "show", "3"]).out;
    assert!(
        people.contains("on the map at 10.00, 23.00, 0.00"),
        "{people}"
    );
    let csv = run(dir.path(), &["alarms", "export", "--format", "csv"]).out;
    assert!(
        csv.lines()
            .next()
            .is_some_and(|l| l.ends_with("map_x_m,map_y_m,map_z_m"))
    );
}

#[test]
fn a_distance_is_told_with_the_unit_of_its_ground() {
    let dir = folder();
    let metres = run(dir.path(), &["alarms", "show", "3"]).out;
    assert!(
        metres.contains("d_GMM 0.002100 m, U_th 0.000500 m:"),
        "{metres}"
    );
    assert_eq!(
        run(dir.path(), &["alarms", "show", "3", "--json"]).json()["ground"],
        "w2"
    );
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    let fm = NewVisit {
        waypoint: "dock",
        reference_id: Some(store.reference("dock").expect("reference").id),
        sweep: None,
        verdict: Verdict::Changed,
        reason: "d_GMM reaches U_th",
        d_gmm: Some(0.0121),
        u_th: 0.002,
        seed: 7,
        engine: r#"{"ground": "fm"}"#,
        report: "{}",
        novelties: &[thing(1.0)],
        same_place_m: 0.5,
    };
    store.record_visit(&fm, &stamp(20_000)).expect("recorded");
    let bare = run(dir.path(), &["alarms", "show", "4"]).out;
    assert!(bare.contains("d_GMM 0.012100, U_th 0.002000:"), "{bare}");
}
