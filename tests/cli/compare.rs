//! `compare` on one pair: its verdicts and what it writes.

use crate::harness::clouds::{self, CRATE};
use crate::harness::program::patrold;
use crate::harness::schema;
use nalgebra::{Point3, Vector3};
use patrold_engine::formats::read_cloud;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;

#[test]
fn the_same_cloud_is_quiet_with_no_novelty() {
    let dir = clouds::folder();
    let ran = patrold(dir.path(), &["compare", "then.ply", "then.ply", "--json"]);
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!((ran.code, &json["verdict"]), (0, &"quiet".into()), "{json}");
    assert_eq!(json["novelties"], Value::Array(Vec::new()));
    assert_eq!(json["name"], "then");
    assert_eq!(json["seed"], 7);
    assert_eq!(json["engine"], "standard");
}

#[test]
fn noise_alone_is_quiet() {
    let dir = clouds::folder();
    let ran = patrold(dir.path(), &["compare", "then.ply", "again.ply", "--json"]);
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!((ran.code, &json["verdict"]), (0, &"quiet".into()), "{json}");
}

#[test]
fn an_appeared_crate_is_changed_and_labelled() {
    let dir = clouds::folder();
    let args = [
        "compare",
        "then.ply",
        "now.ply",
        "--json",
        "--labels-out",
        "l.txt",
        "--novelty-out",
        "n.ply",
    ];
    let ran = patrold(dir.path(), &args);
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!(
        (ran.code, &json["verdict"]),
        (10, &"changed".into()),
        "{json}"
    );
    assert_eq!(json["alarm"], true);
    assert_eq!(ran.err, "");
    let d = json["d_gmm"].as_f64().expect("d_gmm");
    assert!(d >= json["u_th"].as_f64().expect("u_th"));

    let novelties = json["novelties"].as_array().expect("novelties");
    assert_eq!(novelties.len(), 1, "{json}");
    assert_eq!(novelties[0]["kind"], "appeared");
    let centre: [f64; 3] = serde_json::from_value(novelties[0]["centre"].clone()).expect("centre");
    assert!(clouds::is_on(&CRATE, &Point3::from(centre)), "{centre:?}");

    let points = clouds::room_points(&[CRATE], 3);
    let text = fs::read_to_string(dir.path().join("l.txt")).expect("labels");
    let labels: Vec<&str> = text.lines().collect();
    assert_eq!(labels.len(), points.len());
    assert!(labels.iter().all(|l| ["0", "1"].contains(l)));
    let (mut hits, mut listed, mut crate_points) = (0, 0, 0);
    for (point, label) in points.iter().zip(&labels) {
        let (is_crate, is_listed) = (clouds::is_on(&CRATE, point), *label == "1");
        hits += usize::from(is_crate && is_listed);
        listed += usize::from(is_listed);
        crate_points += usize::from(is_crate);
    }
    assert!(hits * 10 >= crate_points * 9, "{hits} of {crate_points}");
    assert!(hits * 10 >= listed * 9, "{hits} of {listed} listed");

    let written = fs::read(dir.path().join("n.ply")).expect("novelty");
    let cloud = read_cloud(&written, Some("ply")).expect("a cloud");
    assert_eq!(
        cloud.points.len(),
        novelties[0]["points"].as_u64().expect("points") as usize
    );
}

#[test]
fn a_removed_crate_is_reported_as_disappeared() {
    let dir = clouds::folder();
    let ran = patrold(dir.path(), &["compare", "now.ply", "again.ply", "--json"]);
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!(
        (ran.code, &json["novelties"][0]["kind"]),
        (10, &"disappeared".into()),
        "{json}"
    );
}

#[test]
fn the_verdict_is_changed_from_u_th_on() {
    let dir = clouds::folder();
    let with = |u_th: &str| {
        let ran = patrold(
            dir.path(),
            &["compare", "then.ply", "now.ply", "--json", "--u-th", u_th],
        );
        (ran.code, ran.json())
    };
    let (_, first) = with("0.0005");
    let d = first["d_gmm"].as_f64().expect("d_gmm");
    for (u_th, code) in [(d * (1.0 - 1e-9), 10), (d, 10), (d * (1.0 + 1e-9), 0)] {
        let (got, json) = with(&format!("{u_th}"));
        schema::check("compare", &json);
        assert_eq!(
            json["d_gmm"].as_f64(),
            Some(d),
            "the threshold is not part of the distance"
        );
        assert_eq!(json["u_th"].as_f64(), Some(u_th));
        assert_eq!(got, code, "u_th {u_th}, d {d}");
        assert_eq!(
            json["novelties"].as_array().map(Vec::len),
            Some(1),
            "listed under {}",
            json["verdict"]
        );
    }
}

#[test]
fn non_finite_points_are_dropped_counted_and_labelled_0() {
    let dir = clouds::folder();
    let mut points = clouds::room_points(&[CRATE], 3);
    let n = points.len();
    for at in [0, 100, n] {
        points.insert(at, Point3::new(f64::NAN, 0.0, f64::INFINITY));
    }
    clouds::write(&dir.path().join("holes.ply"), &points);
    let ran = patrold(
        dir.path(),
        &[
            "compare",
            "then.ply",
            "holes.ply",
            "--json",
            "--labels-out",
            "l.txt",
        ],
    );
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!(ran.code, 10);
    assert_eq!(json["dropped"], serde_json::json!([0, 3]));
    assert_eq!(json["current"]["points"], serde_json::json!(n));
    let text = fs::read_to_string(dir.path().join("l.txt")).expect("labels");
    let labels: Vec<&str> = text.lines().collect();
    assert_eq!(labels.len(), n + 3);
    for at in [0, 100, n] {
        assert_eq!(labels[at], "0");
    }

    let whole = patrold(dir.path(), &["compare", "then.ply", "now.ply", "--json"]).json();
    assert_eq!(
        json["d_gmm"], whole["d_gmm"],
        "dropped points leave no trace"
    );
}

#[test]
fn a_quiet_pair_has_a_label_for_every_point() {
    let dir = clouds::folder();
    patrold(
        dir.path(),
        &["compare", "then.ply", "again.ply", "--labels-out", "l.txt"],
    );
    let text = fs::read_to_string(dir.path().join("l.txt")).expect("labels");
    assert_eq!(text, "0\n".repeat(clouds::room_points(&[], 2).len()));
}

#[test]
fn the_same_input_gives_the_same_answer() {
    let dir = clouds::folder();
    let once = || {
        let ran = patrold(
            dir.path(),
            &["compare", "then.ply", "now.ply", "--json", "--seed", "11"],
        );
        let mut json = ran.json();
        json.as_object_mut().expect("an object").remove("timing_ms");
        json
    };
    let first = once();
    assert_eq!(first["seed"], 11);
    assert_eq!(first, once());
}

#[test]
fn the_paper_engine_runs() {
    let dir = clouds::folder();
    let ran = patrold(
        dir.path(),
        &[
            "compare", "then.ply", "now.ply", "--json", "--engine", "paper",
        ],
    );
    let json = ran.json();
    schema::check("compare", &json);
    assert_eq!(json["engine"], "paper");
    assert!([0, 10, 11].contains(&ran.code), "{ran:?}");
}

#[test]
fn the_sensor_may_be_anywhere_in_the_clouds() {
    let dir = clouds::folder();
    let shift = Vector3::new(-10.0, 5.0, 1.5);
    for (name, crates, seed) in [("then", &[][..], 1), ("now", &[CRATE][..], 3)] {
        let moved: Vec<_> = clouds::room_points(crates, seed)
            .iter()
            .map(|p| p + shift)
            .collect();
        clouds::write(&dir.path().join(format!("{name}-moved.ply")), &moved);
    }
    let at = "-10,5,1.5";
    let args = [
        "compare",
        "then-moved.ply",
        "now-moved.ply",
        "--json",
        "--sensor-origin",
        at,
    ];
    let both = patrold(dir.path(), &args);
    assert_eq!(both.code, 10, "{both:?}");
    let args = [
        "compare",
        "then-moved.ply",
        "now-moved.ply",
        "--json",
        "--reference-origin",
        at,
        "--current-origin",
        at,
    ];
    let each = patrold(dir.path(), &args);
    assert_eq!(each.json()["d_gmm"], both.json()["d_gmm"]);
}

#[test]
fn text_clouds_are_read_too() {
    let dir = clouds::folder();
    for (name, crates, seed) in [("then.xyz", &[][..], 1), ("now.pcd", &[CRATE][..], 3)] {
        let points = clouds::room_points(crates, seed);
        let mut text = String::new();
        if name.ends_with("pcd") {
            let n = points.len();
            writeln!(
                text,
                "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {n}\nHEIGHT 1\n\
                 VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA ascii"
            )
            .expect("text");
        }
        for p in points {
            writeln!(text, "{} {} {}", p.x, p.y, p.z).expect("text");
        }
        fs::write(dir.path().join(name), text).expect("written");
    }
    let ran = patrold(dir.path(), &["compare", "then.xyz", "now.pcd", "--json"]);
    schema::check("compare", &ran.json());
    assert_eq!(ran.code, 10);
}

#[test]
fn without_json_the_report_is_text() {
    let dir = clouds::folder();
    let ran = patrold(dir.path(), &["compare", "then.ply", "now.ply"]);
    assert_eq!(ran.code, 10);
    assert!(ran.out.starts_with("changed: "), "{}", ran.out);
    assert!(ran.out.contains("appeared at "), "{}", ran.out);
}
