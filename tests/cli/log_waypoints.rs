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
fn an_unknown_waypoint_is_an_error() {
    let dir = store_folder();
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
        novelties: &[novelty(1.0)],
        same_place_m: 0.5,
    };
    store
        .record_visit(&fm, &record_time(20_000))
        .expect("recorded");
    let bare = run(dir.path(), &["alarms", "show", "4"]).out;
    assert!(bare.contains("d_GMM 0.012100, U_th 0.002000:"), "{bare}");
}
