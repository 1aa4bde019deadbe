//! The commands on recorded files, and what all commands share.

use crate::harness::clouds::{self, CRATE};
use crate::harness::program::{command, patrold};
use crate::harness::schema;
use std::fs;
use std::io::Read as _;
use std::process::Stdio;

#[test]
fn fit_writes_a_mixture_that_fit_and_distance_read() {
    let dir = clouds::folder();
    let ran = patrold(
        dir.path(),
        &[
            "fit",
            "now.ply",
            "--components",
            "12",
            "--seed",
            "3",
            "--json",
        ],
    );
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let fitted = ran.json();
    schema::check("fit", &fitted);
    schema::check("mixture", &fitted);
    assert_eq!(fitted["weights"].as_array().map(Vec::len), Some(12));
    fs::write(dir.path().join("a.json"), &ran.out).expect("written");

    let ran = patrold(
        dir.path(),
        &[
            "fit",
            "now.ply",
            "--init",
            "a.json",
            "--iterations",
            "3",
            "--json",
        ],
    );
    let again = ran.json();
    schema::check("fit", &again);
    assert_eq!(again["iterations"], 3);
    fs::write(dir.path().join("b.json"), &ran.out).expect("written");

    for ground in ["w2", "euclid", "fm"] {
        let ran = patrold(
            dir.path(),
            &[
                "distance", "a.json", "b.json", "--ground", ground, "--repeat", "3", "--json",
            ],
        );
        assert_eq!(ran.code, 0, "{ran:?}");
        let json = ran.json();
        schema::check("distance", &json);
        let plan = json["plan"].as_array().expect("a plan");
        let mass: f64 = plan.iter().filter_map(|flow| flow[2].as_f64()).sum();
        assert!((mass - 1.0).abs() < 1e-9, "{mass}");
        let same = patrold(
            dir.path(),
            &["distance", "a.json", "a.json", "--ground", ground, "--json"],
        )
        .json();
        schema::check("distance", &same);
        assert!(same["d"].as_f64().is_some_and(|d| d < 1e-6), "{same}");
    }
}

#[test]
fn fuse_gives_a_mixture_that_fuse_fit_and_distance_read() {
    let dir = clouds::folder();
    for (cloud, name) in [("then.ply", "a.json"), ("again.ply", "b.json")] {
        let ran = patrold(dir.path(), &["fit", cloud, "--components", "20", "--json"]);
        fs::write(dir.path().join(name), &ran.out).expect("written");
    }
    let ran = patrold(dir.path(), &["fuse", "a.json", "b.json", "--json"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check("fuse", &json);
    schema::check("mixture", &json);
    let beams = |json: &serde_json::Value| -> f64 {
        let beams = json["beams"].as_array().expect("beams");
        beams.iter().filter_map(serde_json::Value::as_f64).sum()
    };
    // Beams of a fit are its points.
    let points = clouds::room_points(&[], 1).len() + clouds::room_points(&[], 2).len();
    assert!((beams(&json) - points as f64).abs() < 1e-6);
    fs::write(dir.path().join("c.json"), &ran.out).expect("written");

    // With itself it is itself, with twice the beams.
    let args = ["fuse", "c.json", "c.json", "--json"];
    let twice = patrold(dir.path(), &args).json();
    schema::check("fuse", &twice);
    assert!((beams(&twice) / beams(&json) - 2.0).abs() < 1e-9);
    assert_eq!(
        twice["merges"],
        json["weights"].as_array().map_or(0, Vec::len)
    );
    fs::write(dir.path().join("d.json"), twice.to_string()).expect("written");
    let args = ["distance", "c.json", "d.json", "--json"];
    let d = patrold(dir.path(), &args).json();
    assert!(d["d"].as_f64().is_some_and(|d| d < 1e-6), "{d}");

    let args = [
        "fuse",
        "a.json",
        "b.json",
        "--max-components",
        "7",
        "--json",
    ];
    let few = patrold(dir.path(), &args).json();
    schema::check("fuse", &few);
    assert_eq!(few["weights"].as_array().map(Vec::len), Some(7));
    let ran = patrold(dir.path(), &["fuse", "a.json", "b.json"]);
    assert_eq!(ran.code, 0);
    assert!(
        ran.out.contains("fused") && ran.out.contains("pairs merged"),
        "{}",
        ran.out
    );
}

#[test]
fn distance_of_unequal_masses_moves_the_smaller_one() {
    let dir = tempfile::tempdir().expect("temp dir");
    let put = |name: &str, weights: &str, xs: [f64; 2]| {
        let means: Vec<[f64; 3]> = xs.iter().map(|x| [*x, 0.0, 0.0]).collect();
        let text = format!(
            r#"{{"weights": {weights}, "means": {means:?}, "covs": [[1,0,0,1,0,1],[1,0,0,1,0,1]]}}"#
        );
        fs::write(dir.path().join(name), text).expect("written");
    };
    put("a.json", "[2, 1]", [0.0, 10.0]);
    put("b.json", "[1, 1]", [1.0, 4.0]);
    let args = ["distance", "a.json", "b.json", "--partial"];
    let ran = patrold(dir.path(), &[&args[..], &["--json"]].concat());
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check("distance", &json);
    // Two of three units move, from 0 to 1 and to 4 m.
    assert!(json["d"].as_f64().is_some_and(|d| (d - 2.5).abs() < 1e-12));
    assert_eq!(json["totals"], serde_json::json!([3.0, 2.0]));
    assert_eq!(json["plan"], serde_json::json!([[0, 0, 1.0], [0, 1, 1.0]]));
    let text = patrold(dir.path(), &args).out;
    assert!(
        text.contains("2.000000 of 3.000000 and 2.000000 moved"),
        "{text}"
    );
    // Without --partial the weights have to sum to one.
    let refused = patrold(dir.path(), &args[..3]);
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("weights sum to 3"), "{}", refused.err);
}

#[test]
fn fit_reports_how_it_chose_components_and_start() {
    let dir = clouds::folder();
    for (count, start) in [("mml", "k_means"), ("bic", "k_means"), ("flat", "flat")] {
        let args = [
            "fit",
            "now.ply",
            "--components",
            count,
            "--max-components",
            "4",
            "--restarts",
            "2",
            "--json",
        ];
        let ran = patrold(dir.path(), &args);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""));
        let fitted = ran.json();
        schema::check("fit", &fitted);
        assert_eq!(
            (&fitted["components_by"], &fitted["start"]["kind"]),
            (&count.into(), &start.into())
        );
        let k = fitted["weights"].as_array().map_or(0, Vec::len);
        assert!(k >= 1 && (k <= 4 || count == "flat"), "{k}");
        assert!(fitted["runs"].as_u64() >= Some(if count == "flat" { 1 } else { 2 }));
    }
}

#[test]
fn fit_splits_until_flat_where_no_number_is_given() {
    let dir = clouds::folder();
    let ran = patrold(dir.path(), &["fit", "then.ply", "--json", "--threads", "2"]);
    schema::check("fit", &ran.json());
    assert_eq!(ran.code, 0);
}

#[test]
fn shapes_reports_the_points_of_each_shape_and_the_remainder() {
    let dir = clouds::folder();
    let crate_points: Vec<_> = clouds::room_points(&[CRATE], 3)
        .into_iter()
        .filter(|p| clouds::is_on(&CRATE, p))
        .collect();
    clouds::write(&dir.path().join("crate.ply"), &crate_points);
    for extra in [
        &[][..],
        &["--method", "ransac"],
        &["--method", "covariance"],
        &["--points", "--epsilon", "0.02"],
    ] {
        let ran = patrold(
            dir.path(),
            &[&["shapes", "crate.ply", "--json"], extra].concat(),
        );
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{extra:?}");
        let json = ran.json();
        schema::check("shapes", &json);
        assert_eq!(json["points"], crate_points.len());
        // With --points no point is on two shapes; `remainder` counts the others.
        let inliers = |s: &serde_json::Value| s["inliers"].as_u64().expect("a count");
        let on_shapes: u64 = json["shapes"]
            .as_array()
            .expect("shapes")
            .iter()
            .map(inliers)
            .sum();
        let whole = json["remainder"].as_u64().map(|left| left + on_shapes);
        let expected = extra
            .contains(&"--points")
            .then_some(crate_points.len() as u64);
        assert_eq!(whole, expected, "{extra:?}");
    }
}

#[test]
fn help_and_version_are_printed() {
    let dir = tempfile::tempdir().expect("temp dir");
    let version = patrold(dir.path(), &["--version"]);
    assert_eq!(
        (version.code, version.out),
        (0, format!("patrold {}\n", env!("CARGO_PKG_VERSION")))
    );
    for args in [
        &["--help"][..],
        &["-h"],
        &["compare", "--help"],
        &["alarms", "list", "-h"],
    ] {
        let help = patrold(dir.path(), args);
        assert_eq!(help.code, 0, "{args:?}");
        assert!(help.out.contains("Usage: patrold"), "{}", help.out);
    }
}

#[test]
fn a_closed_standard_output_is_no_failure() {
    let dir = clouds::folder();
    for args in [
        &["compare", "then.ply", "now.ply", "--json"][..],
        &["config", "show"],
        &["fit", "then.ply", "--json"],
    ] {
        let mut child = command(dir.path(), args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        drop(child.stdout.take());
        let mut stderr = String::new();
        child
            .stderr
            .take()
            .expect("piped")
            .read_to_string(&mut stderr)
            .expect("UTF-8");
        let status = child.wait().expect("ends");
        assert_eq!(stderr, "", "{args:?}");
        let expected = if args[0] == "compare" { 10 } else { 0 };
        assert_eq!(status.code(), Some(expected), "{args:?}");
    }
}
