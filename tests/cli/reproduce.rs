//! `reproduce`: its JSON, the same for any number of threads and for a scene run alone; its figures.

use crate::harness::program::patrold;
use crate::harness::schema;
use serde_json::Value;

/// The report without times.
fn without_times(mut report: Value) -> Value {
    report["seconds"] = Value::Null;
    for row in report["rows"].as_array_mut().into_iter().flatten() {
        row["chain_ms"] = Value::Null;
        row["reference_ms"] = Value::Null;
    }
    report
}

fn reproduce(args: &[&str]) -> Value {
    let dir = tempfile::tempdir().expect("temp dir");
    let ran = patrold(dir.path(), &[&["reproduce"], args, &["--json"]].concat());
    assert_eq!(ran.code, 0, "{ran:?}");
    let report = ran.json();
    schema::check("reproduce", &report);
    report
}

fn row<'a>(report: &'a Value, set: &str, way: &str, of: &str) -> &'a Value {
    let rows = report["rows"].as_array().expect("rows");
    let found = rows
        .iter()
        .find(|r| r["set"] == set && r["way"] == way && r["of"] == of);
    found.unwrap_or_else(|| panic!("no row {set} {way} {of}"))
}

#[test]
fn table1_fits_its_schema_and_does_not_depend_on_threads() {
    let with = |threads| reproduce(&["table1", "--scenes", "1", "--threads", threads]);
    let report = with("1");
    let all = row(&report, "printed", "feature", "all");
    assert_eq!((&all["objects"], &all["empty"]), (&3.into(), &1.into()));
    assert_eq!(report["paper"].as_array().map(Vec::len), Some(2));
    // The rotation of a cylinder about its axis has no error; four sets of five columns were run.
    let cylinder = row(&report, "fine", "feature", "cylinder");
    assert_eq!(cylinder["rotation_deg"][2], Value::Null);
    let columns = report["rows"].as_array().into_iter().flatten();
    assert_eq!(columns.filter(|r| r["of"] == "all").count(), 4 * 5);
    assert_eq!(without_times(report), without_times(with("2")));
}

#[test]
fn a_scene_gives_the_same_result_when_run_alone() {
    let some = ["table1", "--set", "printed", "--way", "feature"];
    let many = reproduce(&[&some[..], &["--scenes", "2"]].concat());
    let alone = reproduce(&[&some[..], &["--scenes", "2", "--scene", "plane-1"]].concat());
    let of = |report: &Value, key: &str| row(report, "printed", "feature", "plane")[key].clone();
    assert_eq!(of(&alone, "objects"), 1);
    let miss = |report: &Value| {
        let misses = report["misses"].as_array().cloned().unwrap_or_default();
        misses.into_iter().find(|m| m["scene"] == "plane-1")
    };
    assert_eq!(miss(&alone), miss(&many));
}

#[test]
fn the_ellipsoids_of_method_a_are_as_long_as_asked_for() {
    let some = [
        "table1",
        "--set",
        "printed",
        "--scenes",
        "2",
        "--way",
        "euclidean-samples",
    ];
    let of = |more: &[&str]| {
        let report = reproduce(&[&some[..], more].concat());
        let sphere = row(&report, "printed", "euclidean-samples", "sphere");
        let bias_cm = sphere["size_bias_cm"][0]
            .as_f64()
            .expect("a sphere was found");
        (
            report["ellipsoid_sigmas"].as_f64().expect("a number"),
            bias_cm,
        )
    };
    let ((default, unbiased_cm), (one, short_cm)) = (of(&[]), of(&["--ellipsoid-sigmas", "1"]));
    assert_eq!((default, one), (3f64.sqrt(), 1.0));
    // A ball of 30 to 60 cm loses 1 - 1 / sqrt 3 of its diameter.
    assert!(
        unbiased_cm.abs() < 8.0 && short_cm < -10.0,
        "{unbiased_cm} {short_cm}"
    );
}

#[test]
fn table2_has_every_site_with_mixtures_smaller_than_clouds() {
    let report = reproduce(&["table2", "--scenes", "1", "--way", "feature"]);
    for site in ["door-opened", "person", "door-closed"] {
        let [mixture, cloud] =
            [0, 1].map(|k| row(&report, "sites", "feature", site)["bytes"][k].as_f64());
        // As stored: ten numbers of eight bytes a Gaussian, three a beam. Many beams are one Gaussian.
        let ratio = cloud.expect("bytes") / mixture.expect("bytes");
        assert!(ratio > 20.0, "{site}: {ratio}");
    }
}

#[test]
fn rooms_have_objects_of_every_class() {
    let report = reproduce(&[
        "rooms",
        "--scenes",
        "2",
        "--way",
        "feature",
        "--threads",
        "2",
    ]);
    assert_eq!(
        (&report["table"], &report["paper"]),
        (&3.into(), &Value::Array(Vec::new()))
    );
    for class in ["sphere", "cylinder", "plane", "box", "cone", "superquadric"] {
        assert_eq!(
            row(&report, "rooms", "feature", class)["objects"],
            2,
            "{class}"
        );
    }
    let empty = row(&report, "rooms", "feature", "empty");
    assert_eq!((&empty["empty"], &empty["wrong"]), (&2.into(), &0.into()));
    // The sizes are those of the objects.
    let all = row(&report, "rooms", "feature", "all");
    assert!(all["size_share"].as_f64() < Some(0.1), "{all}");
}

/// The figures that a run writes, by name.
fn figures(args: &[&str], names: &[&str]) -> Vec<String> {
    let dir = tempfile::tempdir().expect("temp dir");
    let more = ["--scenes", "1", "--way", "feature", "--figures", "of/it"];
    let ran = patrold(dir.path(), &[&["reproduce"], args, &more].concat());
    assert_eq!(ran.code, 0, "{ran:?}");
    let read = |name: &&str| {
        let path = dir.path().join(format!("of/it/{name}.svg"));
        let svg = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        let whole = svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>");
        assert!(whole, "{name}");
        svg
    };
    names.iter().map(read).collect()
}

/// The texts in an SVG.
fn texts(svg: &str) -> Vec<&str> {
    let after = svg.split("<text").skip(1);
    let inner = after.filter_map(|t| t.split_once('>')?.1.split_once("</text>"));
    inner.map(|(text, _)| text.trim()).collect()
}

const BLUE: &str = "#0000FF";
const RED: &str = "#FF0000";

#[test]
fn table1_draws_figures_3_to_5() {
    let names = [
        "fig3",
        "fig4",
        "algorithm1",
        "fig5-fine-sphere-0",
        "fig5-fine-cylinder-0",
        "fig5-fine-plane-0",
    ];
    let drawn = figures(&["table1", "--set", "fine"], &names);
    // In Fig. 3 the novelty has its number; it has Gaussians of its own colour.
    assert!(texts(&drawn[0]).contains(&"1"), "{:?}", texts(&drawn[0]));
    assert!(drawn[0].contains(RED) && !drawn[0].contains(BLUE));
    let panels = |svg: &str| {
        let titled = |t: &&str| t.get(1..3) == Some(") ");
        let letters = texts(svg)
            .into_iter()
            .filter(titled)
            .map(|t| t[..1].to_owned());
        letters.collect::<Vec<_>>()
    };
    assert_eq!(panels(&drawn[0]), ["a", "b", "c", "d"]);
    assert_eq!(panels(&drawn[1]), ["a", "b", "c", "d"]);
    assert_eq!(panels(&drawn[3]), ["a", "d"]);
    assert_eq!(panels(&drawn[5]), ["c", "f"]);
    // Method A is blue, method B and the threshold red.
    for svg in &drawn[1..] {
        assert!(svg.contains(BLUE) && svg.contains(RED));
    }
}

#[test]
fn table2_draws_figure_6_a_to_l() {
    let names = ["door-opened", "person", "door-closed"].map(|s| format!("fig6-sites-{s}-0"));
    let drawn = figures(&["table2"], &names.each_ref().map(String::as_str));
    for (svg, letters) in drawn.iter().zip(["adgj", "behk", "cfil"]) {
        for letter in letters.chars() {
            let title = format!("{letter}) ");
            assert!(texts(svg).iter().any(|t| t.starts_with(&title)), "{title}");
        }
        assert!(svg.contains(BLUE) && svg.contains(RED), "{letters}");
    }
}

#[test]
fn an_unknown_scene_is_wrong_usage() {
    let dir = tempfile::tempdir().expect("temp dir");
    let ran = patrold(dir.path(), &["reproduce", "table1", "--scene", "cube-3"]);
    assert_eq!(ran.code, 2, "{ran:?}");
}
