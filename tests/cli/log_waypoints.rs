//! `patrold waypoints`, and positions and units in the alarm log.

use crate::harness::schema;
use crate::log::{ids, novelty, record_time, run, store_folder};
use patrold::store::{NewVisit, Store};
use patrold_engine::novelty::Verdict;
use serde_json::{Value, json};
use std::fs;

#[test]
fn waypoints_are_listed_shown_and_forgotten() {
    let dir = store_folder();
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
        (&json!(3), &json!("changed"))
    );

    let asked = run(dir.path(), &["waypoints", "forget", "hall"]);
    assert_eq!(asked.code, 2, "{asked:?}");
    assert!(
        asked.err.contains("3 standing alarm(s)") && asked.err.contains("--yes"),
        "{}",
        asked.err
    );
    let gone = run(
        dir.path(),
        &["waypoints", "forget", "hall", "--yes", "--json"],
    );
    assert_eq!(gone.code, 0);
    schema::check("waypoint-forgotten", &gone.json());
    let left = run(dir.path(), &["waypoints", "list", "--json"]).json();
    assert_eq!(left["waypoints"].as_array().map(Vec::len), Some(1));
    assert_eq!(
        ids(&run(
            dir.path(),
            &["alarms", "list", "--json", "--state", "cleared"]
        )),
        [4, 3, 2, 1]
    );
}

#[test]
fn an_unknown_waypoint_is_an_error() {
    let dir = store_folder();
    run(dir.path(), &["waypoints", "forget", "dock", "--yes"]);
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
fn map_positions_are_reported_where_map_pose_is_configured() {
    let dir = store_folder();
    fs::write(
        dir.path().join("c.toml"),
        "store.dir = \"store\"\n[waypoint.hall]\nmap_pose = [10.0, 20.0, 90.0]\n",
    )
    .expect("written");
    let shown = run(dir.path(), &["alarms", "show", "3", "--json"]).json();
    schema::check("alarm", &shown);
    let point = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a point");
        list.iter().filter_map(Value::as_f64).collect()
    };
    let on_map = point(&shown["novelties"][0]["map_centre"]);
    for (got, expected) in on_map.iter().zip([10.0, 23.0, 0.0]) {
        assert!((got - expected).abs() < 1e-9, "{on_map:?}");
    }
    let elsewhere = run(dir.path(), &["alarms", "show", "1", "--json"]).json();
    assert_eq!(elsewhere["novelties"][0].get("map_centre"), None);
    let text = run(dir.path(), &["alarms", "show", "3"]).out;
    assert!(text.contains("on the map at 10.00, 23.00, 0.00"), "{text}");
    let csv = run(dir.path(), &["alarms", "export", "--format", "csv"]).out;
    assert!(
        csv.lines()
            .next()
            .is_some_and(|l| l.ends_with("map_x_m,map_y_m,map_z_m"))
    );
}

#[test]
fn a_distance_has_the_unit_of_its_ground_distance() {
    let dir = store_folder();
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
        novelties: &[novelty(6.0)],
        places: &[],
        same_place_m: 0.5,
    };
    store
        .record_visit(&fm, &record_time(20_000))
        .expect("recorded");
    let bare = run(dir.path(), &["alarms", "show", "5"]).out;
    assert!(bare.contains("d_GMM 0.012100, U_th 0.002000:"), "{bare}");
}

#[test]
fn an_older_version_is_shown_and_restored() {
    let dir = store_folder();
    let restore = |accept: &[&str]| {
        let command = ["waypoints", "restore", "hall", "1", "--json"];
        run(dir.path(), &[&command[..], accept].concat())
    };
    let standing = restore(&[]);
    assert_eq!(standing.code, 1);
    assert!(
        standing.err.contains("alarms 2, 3, 4 are not cleared")
            && standing.err.contains("--accept 2 --accept 3 --accept 4"),
        "{}",
        standing.err
    );
    let other = restore(&["--accept", "1"]);
    assert!(
        other.err.contains("alarm 1 cannot be accepted"),
        "{}",
        other.err
    );
    let restored = restore(&["--accept", "2", "3", "4"]);
    assert_eq!(restored.code, 0, "{restored:?}");
    schema::check("waypoint-restored", &restored.json());
    assert_eq!(restored.json()["version"], 2);
    let show = |version| {
        let args = ["waypoints", "show", "hall", "--version", version, "--json"];
        let json = run(dir.path(), &args).json();
        schema::check("waypoint-reference", &json);
        json
    };
    assert_eq!(
        (&show("1")["in_use"], &show("2")["in_use"]),
        (&json!(false), &json!(true))
    );
    assert_eq!(show("2")["frame"], "hall/1");
    let shown = run(dir.path(), &["waypoints", "show", "hall", "--json"]).json();
    schema::check("waypoint", &shown);
    assert_eq!(shown["standing_alarms"], 0);
    let gone = run(dir.path(), &["waypoints", "restore", "hall", "9"]);
    assert_eq!(gone.code, 1, "no such version");
    let open = run(dir.path(), &["alarms", "--state", "open", "--json"]);
    assert_eq!(ids(&open), [0i64; 0]);
}
