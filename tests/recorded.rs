//! `compare --manifest` on the recorded pairs: quiet stays quiet, large objects are found. Prints precision and recall.
#![allow(clippy::print_stdout, reason = "it prints a table")]

mod harness;

use harness::program::patrold;
use harness::schema;
use patrold_test_support::data;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Objects with fewer points may be missed.
const LARGE_POINTS: usize = 300;

/// With its truth.
struct RecordedPair {
    name: String,
    reference: PathBuf,
    current: PathBuf,
    origin: Value,
    /// By point; `None` where it is not scored.
    novel: Vec<Option<bool>>,
    /// Whether a large object appeared; `None` where only small ones did.
    expected_change: Option<bool>,
}

/// Numbers of points.
struct LabelScore {
    hits: usize,
    listed: usize,
    novel: usize,
}

impl LabelScore {
    fn new(truth: &[Option<bool>], labels: &str) -> Self {
        let listed: Vec<bool> = labels.lines().map(|line| line == "1").collect();
        assert_eq!(listed.len(), truth.len(), "a label for every point");
        let scored = || {
            truth
                .iter()
                .zip(&listed)
                .filter_map(|(t, l)| Some(((*t)?, *l)))
        };
        Self {
            hits: scored().filter(|(t, l)| *t && *l).count(),
            listed: scored().filter(|(_, l)| *l).count(),
            novel: scored().filter(|(t, _)| *t).count(),
        }
    }

    fn ratio(part: usize, whole: usize) -> String {
        if whole == 0 {
            return "    -".to_owned();
        }
        format!("{:.3}", part as f64 / whole as f64)
    }
}

/// Compares all pairs in one process and prints the table; gives the rows with a wrong verdict.
fn compare(pairs: &[RecordedPair]) -> Vec<String> {
    let dir = tempfile::tempdir().expect("temp dir");
    let listed: Vec<Value> = pairs
        .iter()
        .map(|pair| {
            json!({
                "name": pair.name, "reference": pair.reference, "current": pair.current,
                "sensor_origin": pair.origin, "labels_out": format!("{}.labels", pair.name),
            })
        })
        .collect();
    let manifest = dir.path().join("pairs.json");
    fs::write(&manifest, json!({"pairs": listed}).to_string()).expect("written");
    let ran = patrold(
        dir.path(),
        &["compare", "--manifest", "pairs.json", "--json"],
    );
    assert!([0, 10, 11].contains(&ran.code), "{ran:?}");
    let lines = ran.json_lines();
    assert_eq!(lines.len(), pairs.len(), "{}", ran.err);

    let mut table = String::new();
    let mut wrong = Vec::new();
    for (pair, line) in pairs.iter().zip(&lines) {
        schema::check("compare", line);
        assert_eq!(line["name"], pair.name);
        let labels =
            fs::read_to_string(dir.path().join(format!("{}.labels", pair.name))).expect("labels");
        let score = LabelScore::new(&pair.novel, &labels);
        let verdict = line["verdict"].as_str().unwrap_or_default();
        let d = line["d_gmm"].as_f64().unwrap_or(f64::NAN);
        let row = format!(
            "{:24} {verdict:12} d_gmm {d:.6} m  novel {:5}  precision {}  recall {}",
            pair.name,
            score.novel,
            LabelScore::ratio(score.hits, score.listed),
            LabelScore::ratio(score.hits, score.novel),
        );
        let expected = pair
            .expected_change
            .map(|large| if large { "changed" } else { "quiet" });
        if expected.is_some_and(|expected| expected != verdict) {
            wrong.push(format!("{row}  ({})", line["reason"]));
        }
        writeln!(table, "{row}").expect("text");
    }
    println!("{table}");
    wrong
}

fn read_json(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("readable");
    serde_json::from_str(&text).expect("JSON")
}

fn labels(path: &Path, truth: impl Fn(i64) -> Option<bool>) -> Vec<Option<bool>> {
    let text = fs::read_to_string(path).expect("labels");
    text.split_whitespace()
        .map(|label| truth(label.parse().expect("a label")))
        .collect()
}

fn assert_verdicts(pairs: &[RecordedPair]) {
    let wrong = compare(pairs);
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn semisynthetic_corridor_pairs() {
    let Some(root) = data("semisynthetic") else {
        return;
    };
    let manifest = read_json(&root.join("manifest_dev.json"));
    let path = |pair: &Value, key: &str| root.join(pair[key].as_str().expect("a path"));
    let pair = |pair: &Value| {
        let objects = pair["objects"].as_array().expect("objects");
        let large = objects.iter().any(|o| {
            o["beams_hit"]
                .as_u64()
                .is_some_and(|n| n as usize >= LARGE_POINTS)
        });
        RecordedPair {
            name: pair["name"].as_str().expect("a name").to_owned(),
            reference: path(pair, "reference"),
            current: path(pair, "current"),
            origin: pair["sensor_origin"].clone(),
            novel: labels(&path(pair, "labels"), |label| Some(label > 0)),
            expected_change: match (objects.is_empty(), large) {
                (true, _) => Some(false),
                (false, true) => Some(true),
                (false, false) => None,
            },
        }
    };
    let pairs: Vec<RecordedPair> = manifest["pairs"]
        .as_array()
        .expect("pairs")
        .iter()
        .map(pair)
        .collect();
    assert_verdicts(&pairs);
}

#[test]
fn sphere_calibration_pairs() {
    let Some(root) = data("spherecalib") else {
        return;
    };
    let root = root.join("dev");
    let meta = read_json(&root.join("meta.json"));
    let path = |pair: &Value, key: &str| root.join(pair[key].as_str().expect("a path"));
    let origin = meta["sensor_origin"].clone();
    let labelled = meta["pairs"]
        .as_array()
        .expect("pairs")
        .iter()
        .filter(|p| p["labels"].is_string());
    let moved = labelled.map(|pair| {
        let novel = labels(&path(pair, "labels"), |label| match label {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        });
        let count = novel.iter().filter(|n| **n == Some(true)).count();
        RecordedPair {
            name: pair["labels"]
                .as_str()
                .expect("a name")
                .replace(".labels.txt", ""),
            reference: path(pair, "reference"),
            current: path(pair, "current"),
            origin: origin.clone(),
            expected_change: (count >= LARGE_POINTS).then_some(true),
            novel,
        }
    });
    let unchanged = (0..2).map(|i| {
        let current = root.join(format!("nochange{i}_cur.ply"));
        let points = patrold_engine::formats::read_cloud(
            &fs::read(&current).expect("readable"),
            Some("ply"),
        )
        .expect("a cloud")
        .points
        .len();
        RecordedPair {
            name: format!("nochange{i}"),
            reference: root.join(format!("nochange{i}_ref.ply")),
            current,
            origin: origin.clone(),
            novel: vec![Some(false); points],
            expected_change: Some(false),
        }
    });
    let pairs: Vec<RecordedPair> = moved.chain(unchanged).collect();
    assert_verdicts(&pairs);
}
