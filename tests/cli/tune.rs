//! `patrold tune`: what thresholds would have done to a known past, labels, and one of them put into force.

use crate::harness::program::CommandOutput;
use crate::harness::schema;
use crate::log::{novelty, record_time, run, teach};
use patrold::store::{NewVisit, Store};
use patrold_engine::novelty::Verdict;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Stores a visit with this distance; its verdict is that of the threshold 0.001.
fn visit(store: &mut Store, waypoint: &str, d_gmm: f64, x: Option<f64>, ground: &str, second: i64) {
    let seen: Vec<_> = x.map(novelty).into_iter().collect();
    let changed = d_gmm >= 0.001 && !seen.is_empty();
    let engine = json!({"ground": ground}).to_string();
    let new = NewVisit {
        waypoint,
        reference_id: Some(store.reference(waypoint).expect("reference").id),
        sweep: None,
        verdict: if changed {
            Verdict::Changed
        } else {
            Verdict::Quiet
        },
        reason: "test",
        d_gmm: Some(d_gmm),
        u_th: 0.001,
        seed: 7,
        engine: &engine,
        report: "{}",
        novelties: &seen,
        places: &[],
        same_place_m: 0.5,
    };
    store
        .record_visit(&new, &record_time(second))
        .expect("recorded");
}

/// The hall has quiet visits 1 (nothing), 2 (0.0004, a thing) and 8 (0.0008, nothing listed), alarms 1 (0.004 and again 0.006,
/// confirmed) and 2 (0.0015, false); the dock one alarm (3, of 0.05) and one in another unit.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 1);
    visit(&mut store, "hall", 0.0, None, "w2", 100);
    visit(&mut store, "hall", 0.0004, Some(9.0), "w2", 200);
    visit(&mut store, "hall", 0.004, Some(1.0), "w2", 300);
    visit(&mut store, "hall", 0.006, Some(1.1), "w2", 400);
    visit(&mut store, "hall", 0.0015, Some(5.0), "w2", 500);
    visit(&mut store, "dock", 0.05, Some(2.0), "w2", 600);
    visit(&mut store, "dock", 0.9, Some(7.0), "fm", 700);
    visit(&mut store, "hall", 0.0008, None, "w2", 800);
    fs::write(
        dir.path().join("c.toml"),
        "store.dir = \"store\"\napi.socket = \"none.sock\"\nnovelty.u_th_m = 0.001\n",
    )
    .expect("written");
    for (id, answer) in [("1", "--confirmed"), ("2", "--false-alarm")] {
        assert_eq!(run(dir.path(), &["alarms", "ack", id, answer]).code, 0);
    }
    dir
}

fn tuned(dir: &Path, args: &[&str]) -> Value {
    let ran = run(dir, &[&["tune", "--json"], args].concat());
    assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{ran:?}");
    let json = ran.json();
    schema::check("tune", &json);
    json
}

fn effect(study: &Value, u_th: f64) -> Value {
    let candidates = study["candidates"].as_array().expect("candidates");
    let one = candidates.iter().find(|c| {
        c["u_th"]
            .as_f64()
            .is_some_and(|u| (u / u_th - 1.0).abs() < 1e-9)
    });
    one.unwrap_or_else(|| panic!("{u_th}: {study}")).clone()
}

#[test]
fn each_threshold_does_to_the_past_what_it_would_have_done() {
    let dir = folder();
    let json = tuned(dir.path(), &[]);
    let names: Vec<_> = json["waypoints"]
        .as_array()
        .expect("two")
        .iter()
        .map(|w| &w["waypoint"])
        .collect();
    assert_eq!(names, ["dock", "hall"]);
    let (dock, hall) = (&json["waypoints"][0], &json["waypoints"][1]);
    assert_eq!((&hall["quiet"], &hall["changed"]), (&json!(3), &json!(3)));
    assert_eq!(
        hall["alarms"],
        json!({"all": 2, "confirmed": 1, "false_alarms": 1})
    );
    assert_eq!(
        (&dock["changed"], &dock["alarms"]["all"]),
        (&json!(1), &json!(1)),
        "fm is left out"
    );

    let in_force = effect(hall, 0.001);
    assert_eq!(
        (&in_force["gone"]["all"], &in_force["alarming"]),
        (&json!(0), &json!(0))
    );
    let low = effect(hall, 2e-4);
    assert_eq!(
        (&low["alarming_ids"], &low["unexplained"]),
        (&json!([2]), &json!(1))
    );
    let higher = effect(hall, 0.002);
    assert_eq!(
        higher["gone"],
        json!({"all": 1, "confirmed": 0, "false_alarms": 1})
    );
    assert_eq!(higher["gone_ids"], json!([2]));
    // The second visit of alarm 1 reaches it.
    assert_eq!(effect(hall, 0.005)["gone_ids"], json!([2]));
    assert_eq!(effect(hall, 0.01)["gone_ids"], json!([1, 2]));
    assert_eq!(effect(dock, 0.05)["gone"]["all"], 0);

    // All unchanged visits: 0, 0.0004, 0.0008 and the false alarm of 0.0015.
    let suggested = hall["suggestion"]["u_th"].as_f64().expect("a threshold");
    assert!((0.0015..0.00155).contains(&suggested), "{suggested}");
    assert_eq!(hall["gone"][0]["id"], 2);
    assert_eq!(
        hall["gone"][0]["things"][0],
        "appeared at 5.00, 0.00, 0.00: sphere 0.30 x 0.30 x 0.30"
    );
    let loose = tuned(
        dir.path(),
        &["--waypoint", "hall", "--false-alarm-rate", "0.5"],
    );
    let suggested = loose["waypoints"][0]["suggestion"]["u_th"]
        .as_f64()
        .expect("a threshold");
    assert!((0.0008..0.0009).contains(&suggested), "{suggested}");

    let since = tuned(
        dir.path(),
        &["--waypoint", "hall", "--since", "2027-01-15T08:08:00Z"],
    );
    assert_eq!(since["waypoints"][0]["alarms"]["all"], 1);
    assert_eq!(since["waypoints"][0]["quiet"], 1);
}

#[test]
fn people_see_a_histogram_the_candidates_and_examples() {
    let dir = folder();
    let text = run(
        dir.path(),
        &[
            "tune",
            "--waypoint",
            "hall",
            "--u-th",
            "0.002",
            "--svg",
            "h.svg",
        ],
    )
    .out;
    for part in [
        "hall: 3 quiet and 3 changed visits, 2 alarms (1 confirmed, 1 false); U_th in force 0.001 m",
        "in force",
        "asked for",
        "suggested",
        "never alarms",
        "alarms that U_th 0.002 would not have raised, the newest:",
        "appeared at 5.00, 0.00, 0.00",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(text.contains('#') && text.contains('.'), "bars: {text}");
    let picture = fs::read_to_string(dir.path().join("h.svg")).expect("written");
    assert!(picture.starts_with("<svg") && picture.contains("hall"));
    for wrong in [
        &["tune", "--apply", "0.002"][..],
        &["tune", "--svg", "x.svg"],
        &["tune", "--u-th", "0"],
        &["tune", "--false-alarm-rate", "1"],
    ] {
        let ran = run(dir.path(), wrong);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{wrong:?}");
    }
}

fn in_force(dir: &Path, key: &str) -> Option<Value> {
    let shown = run(dir, &["config", "show", "--json"]).json();
    let settings = shown["settings"].as_array().expect("settings").clone();
    settings
        .into_iter()
        .find(|s| s["key"] == key)
        .map(|s| s["value"].clone())
}

#[test]
fn apply_puts_a_threshold_into_force_or_leaves_everything_as_it_was() {
    let dir = folder();
    let key = "waypoint.hall.u_th_m";
    let apply = |u: &str| -> CommandOutput {
        run(
            dir.path(),
            &["tune", "--waypoint", "hall", "--apply", u, "--json"],
        )
    };
    let ran = apply("0.002");
    assert_eq!(ran.code, 0, "{ran:?}");
    schema::check("tune", &ran.json());
    assert_eq!(
        ran.json()["applied"],
        json!({"waypoint": "hall", "u_th": 0.002, "file": "c.d/90-u_th-hall.toml", "reloaded": null})
    );
    assert_eq!(in_force(dir.path(), key), Some(json!(0.002)));
    assert_eq!(apply("0.003").code, 0);
    assert_eq!(in_force(dir.path(), key), Some(json!(0.003)));

    // Nothing of the past reaches it: done all the same, with a warning here and in the check.
    let text = run(
        dir.path(),
        &["tune", "--waypoint", "hall", "--apply", "0.01"],
    )
    .out;
    let never = "hall: with U_th 0.01 none of its 2 alarms would have been raised";
    assert!(text.contains(never), "{text}");
    let check = run(dir.path(), &["config", "check"]);
    assert_eq!(check.code, 0);
    assert!(
        check.err.contains(never) && !check.err.contains("dock"),
        "{check:?}"
    );
    let json = run(dir.path(), &["config", "check", "--json"]).json();
    schema::check("config-check", &json);
    assert_eq!(json["warnings"].as_array().map(Vec::len), Some(1));

    // A later file wins: refused, and as before.
    fs::write(
        dir.path().join("c.d/95.toml"),
        "waypoint.hall.u_th_m = 0.004\n",
    )
    .expect("written");
    let ran = apply("0.005");
    assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{ran:?}");
    assert!(ran.err.contains("sets U_th 0.004 at hall"), "{ran:?}");
    fs::remove_file(dir.path().join("c.d/95.toml")).expect("removed");
    assert_eq!(in_force(dir.path(), key), Some(json!(0.01)));
    let files: Vec<_> = fs::read_dir(dir.path().join("c.d"))
        .expect("folder")
        .collect();
    assert_eq!(files.len(), 1, "nothing aside");
}
