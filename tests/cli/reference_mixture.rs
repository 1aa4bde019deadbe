//! The stored mixture decides: `rejudge` with the mixture in the database replaced, damaged or outdated, and
//! `waypoints rebuild`.

use crate::harness::clouds::CRATE;
use crate::harness::program::patrold;
use crate::harness::{schema, stored_mixture};
use crate::rejudge::{rejudge, store_folder_with};
use patrold::store::{Store, StoredMixture};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// The report of `rejudge --json` on a visit, held to its schema.
fn judged(dir: &Path, visit: &str) -> (i32, Value) {
    let ran = rejudge(dir, &[visit, "--json"]);
    assert_eq!(ran.err, "", "visit {visit}");
    let json = ran.json();
    schema::check("rejudge", &json);
    (ran.code, json)
}

/// Visits 1 and 2 get the verdict and the distance in the log.
fn assert_judged_as_before(dir: &Path) {
    for visit in ["1", "2"] {
        let (_, json) = judged(dir, visit);
        for key in ["verdict", "d_gmm"] {
            assert_eq!(json["judged"][key], json["stored"][key], "visit {visit}");
        }
    }
}

#[test]
fn a_mixture_without_its_checksum_is_refused_until_it_is_made_anew() {
    let dir = store_folder_with(&[]);
    let store = dir.path().join("store");
    let (mut gamma, _) = stored_mixture::read(&store);
    let components = gamma.mixture.len();
    gamma.mixture.weights[0] *= 1.5;
    stored_mixture::write(&store, &gamma, false);
    for visit in ["1", "2"] {
        let (code, json) = judged(dir.path(), visit);
        let reason = json["judged"]["reason"].as_str().expect("a reason");
        assert_eq!((code, &json["judged"]["d_gmm"]), (11, &Value::Null));
        for part in [
            "reference hall/1: its mixture is damaged",
            "patrold waypoints rebuild hall",
        ] {
            assert!(reason.contains(part), "{reason}");
        }
        assert!(!reason.contains("--reference-version"), "{reason}");
        assert!(json["reference_made_anew"].is_null());
    }

    let args = [
        "waypoints",
        "rebuild",
        "hall",
        "--config",
        "c.toml",
        "--json",
    ];
    let ran = patrold(dir.path(), &args);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check("waypoint-rebuilt", &json);
    assert_eq!(
        (&json["waypoint"], &json["version"], &json["was"]),
        (&json!("hall"), &json!(1), &json!("damaged"))
    );
    let counts = (&json["components_before"], &json["components"]);
    assert_eq!(counts, (&json!(components), &json!(components)));
    assert_judged_as_before(dir.path());
    let events = Store::open_for_reading(&store)
        .expect("reader")
        .events(1)
        .expect("events");
    let text = &events[0].text;
    assert!(
        text.contains("hall/1: mixture made anew") && text.contains("it was damaged"),
        "{text}"
    );

    let again = patrold(dir.path(), &args[..5]);
    assert!(again.out.contains("(intact)"), "{again:?}");
    let unknown = patrold(
        dir.path(),
        &["waypoints", "rebuild", "hal", "--config", "c.toml"],
    );
    assert_eq!((unknown.code, unknown.out.as_str()), (1, ""));
    assert!(unknown.err.contains("unknown waypoint"), "{}", unknown.err);
}

#[test]
fn an_older_version_is_made_anew_by_its_number() {
    let dir = store_folder_with(&[]);
    let store = dir.path().join("store");
    // A second version with the same view and mixture.
    stored_mixture::execute(
        &store,
        "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture,
                                mixture_sha256, model)
         SELECT waypoint_id, 2, sweep_id, taken_at, boot_id, components, seed, engine, mixture, mixture_sha256, model
         FROM reference",
    );
    stored_mixture::execute(
        &store,
        "UPDATE reference SET mixture = x'02' WHERE version = 1",
    );
    let (code, json) = judged(dir.path(), "1");
    let reason = json["judged"]["reason"].as_str().expect("a reason");
    let command = "patrold waypoints rebuild hall --reference-version 1";
    assert!(code == 11 && reason.ends_with(command), "{reason}");
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    let ran = patrold(dir.path(), &[&words[..], &["--config", "c.toml"]].concat());
    assert_eq!(ran.code, 0, "{ran:?}");
    assert_judged_as_before(dir.path());
    let words = ["waypoints", "rebuild", "hall", "--reference-version", "3"];
    let ran = patrold(dir.path(), &[&words[..], &["--config", "c.toml"]].concat());
    assert!(ran.code == 1 && ran.err.contains("hall/3"), "{ran:?}");
}

#[test]
fn components_taken_out_of_the_mixture_appear() {
    let dir = store_folder_with(&[CRATE]);
    let store = dir.path().join("store");
    let verdicts = || ["1", "2"].map(|visit| judged(dir.path(), visit).1["judged"].clone());
    let [with, without] = verdicts();
    assert_eq!(
        (&with["verdict"], &without["verdict"]),
        (&json!("quiet"), &json!("changed"))
    );
    assert_eq!(without["novelties"][0]["kind"], "disappeared");

    let (mut gamma, _) = stored_mixture::read(&store);
    let (centre, size) = CRATE;
    let taken = stored_mixture::take_out(&mut gamma, centre, size.map(|s| s + 0.04));
    assert!(taken > 2, "{taken}");
    stored_mixture::write(&store, &gamma, true);
    let [with, without] = verdicts();
    assert_eq!(with["verdict"], "changed", "{with}");
    // What stood behind the crate is in neither, so that it may appear; the crate cannot disappear.
    let novelties = without["novelties"].as_array().expect("a list");
    assert!(
        novelties.iter().all(|n| n["kind"] == "appeared"),
        "{without}"
    );
    let novelty = &with["novelties"][0];
    assert_eq!(novelty["kind"], "appeared");
    for axis in 0..3 {
        let at = novelty["centre"][axis].as_f64().expect("a number");
        let half = 0.5 * size[axis];
        assert!((at - centre[axis]).abs() < half + 0.05, "{novelty}");
    }
}

#[test]
fn a_mixture_that_no_fit_gives_is_compared_to_the_bit() {
    let dir = store_folder_with(&[]);
    let store = dir.path().join("store");
    let (mut gamma, _) = stored_mixture::read(&store);
    // Each component twice, a millimetre apart: a fit has neither their number nor their means.
    let fitted = gamma.mixture.len();
    for k in 0..fitted {
        let mut twin = gamma.mixture.components[k];
        twin.mean.x += 0.001;
        gamma.mixture.components.push(twin);
        gamma.beams.push(gamma.beams[k]);
        let half = 0.5 * gamma.mixture.weights[k];
        gamma.mixture.weights[k] = half;
        gamma.mixture.weights.push(half);
    }
    stored_mixture::write(&store, &gamma, true);
    let ran = rejudge(dir.path(), &["2", "--json", "--mixtures-out", "m"]);
    assert_eq!(ran.code, 0, "{ran:?}");
    assert!(ran.json()["reference_made_anew"].is_null());
    let text = fs::read_to_string(dir.path().join("m/gamma.json")).expect("written");
    let compared: Value = serde_json::from_str(&text).expect("JSON");
    let means = compared["means"].as_array().expect("means");
    assert!(means.len() > fitted, "{} of {fitted}", means.len());
    let stored: Vec<Value> = gamma
        .mixture
        .components
        .iter()
        .map(|g| json!([g.mean.x, g.mean.y, g.mean.z]))
        .collect();
    assert!(means.iter().all(|mean| stored.contains(mean)));
}

#[test]
fn an_outdated_mixture_is_made_anew_and_reported_and_nothing_is_written() {
    let dir = store_folder_with(&[]);
    let store = dir.path().join("store");
    stored_mixture::execute(
        &store,
        "UPDATE reference SET mixture = x'01', mixture_sha256 = NULL, model = NULL",
    );
    assert_judged_as_before(dir.path());
    let (_, json) = judged(dir.path(), "1");
    let why = json["reference_made_anew"].as_str().expect("why");
    assert!(why.contains("an earlier version"), "{why}");
    let text = rejudge(dir.path(), &["1"]).out;
    assert!(
        text.contains(&format!("made anew from its view: {why}")),
        "{text}"
    );
    let reader = Store::open_for_reading(&store).expect("reader");
    let reference = reader.reference("hall").expect("reference");
    assert_eq!(reference.mixture, StoredMixture::Outdated);
    assert!(reader.events(10).expect("events").is_empty());
}

#[test]
fn a_mixture_of_other_settings_is_made_anew() {
    let dir = store_folder_with(&[]);
    let write = |more: &str| {
        let text = format!("store.dir = \"store\"\n{more}");
        fs::write(dir.path().join("c.toml"), text).expect("written");
    };
    write("novelty.max_range_m = 3.5\n");
    let (_, json) = judged(dir.path(), "1");
    let why = json["reference_made_anew"].as_str().expect("why");
    let [now, stored] = ["3.5", "null"].map(|range| {
        let at = why.find(&format!("\"max_range_m\":{range}"));
        at.unwrap_or_else(|| panic!("{why}"))
    });
    assert!(why.starts_with("other settings: ") && now < stored, "{why}");
    assert!(why[now..stored].contains(" instead of "), "{why}");
    // The threshold is none of them.
    write("novelty.u_th_m = 0.9\n");
    assert!(judged(dir.path(), "1").1["reference_made_anew"].is_null());
}
