//! The engine against recorded pairs: what changed is found, what did not stays quiet. The table that
//! it prints (`--nocapture`) is the engine's report on them.

use nalgebra::Point3;
use patrold_engine::formats::read_cloud;
use patrold_engine::geometry::{Pose, RollPitchYaw, View};
use patrold_engine::novelty::{Detection, Kind, Reference, Settings, Verdict, detect};
use std::path::{Path, PathBuf};

fn ply(path: &Path) -> Vec<Point3<f64>> {
    let bytes = std::fs::read(path).expect("a readable file");
    read_cloud(&bytes, Some("ply")).expect("a cloud").points
}

fn labels(path: &Path) -> Vec<u8> {
    std::fs::read_to_string(path)
        .expect("a readable file")
        .lines()
        .map(|l| l.trim().parse().expect("a label"))
        .collect()
}

fn moved(x: f64, y: f64, yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation([x, y, 0.0])
}

/// Precision and recall of the labels against truth.
struct Score {
    found: Detection,
    precision: f64,
    recall: f64,
}

/// Compares a pair; `novel` tells the truth of a current point, `None` where it is not to be scored.
fn compare(
    name: &str,
    reference: &View,
    current: &View,
    novel: impl Fn(usize) -> Option<bool>,
) -> Score {
    let settings = Settings::default();
    let prepared = Reference::prepare(reference, &settings, 1).expect("a reference");
    let found = detect(&prepared, current, &settings, 1, &mut |_| {}).expect("a detection");
    let (mut hits, mut false_hits, mut missed) = (0, 0, 0);
    for (i, hit) in found.labels.iter().enumerate() {
        match (novel(i), hit) {
            (Some(true), true) => hits += 1,
            (Some(false), true) => false_hits += 1,
            (Some(true), false) => missed += 1,
            _ => {}
        }
    }
    let share = |n: i32, of: i32| f64::from(n) / f64::from(of.max(1));
    let score = Score {
        precision: share(hits, hits + false_hits),
        recall: share(hits, hits + missed),
        found,
    };
    let pose = &score.found.registration.current_from_reference;
    let count = |k: Kind| score.found.novelties.iter().filter(|n| n.kind == k).count();
    eprintln!(
        "{name:28} {:11} d {:.5} rest {:.5} work {:6.3} came {:2} went {:2} precision {:.3} recall {:.3} | {:.4} m {:.3} deg | {}",
        format!("{:?}", score.found.verdict),
        score.found.d_gmm,
        score.found.unexplained,
        score.found.work_m3,
        count(Kind::Appeared),
        count(Kind::Disappeared),
        score.precision,
        score.recall,
        pose.translation.vector.norm(),
        pose.rotation.angle().to_degrees(),
        score.found.reason,
    );
    score
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a manifest")).expect("json")
}

/// A file that a manifest's entry names.
fn file(root: &Path, entry: &serde_json::Value, key: &str) -> PathBuf {
    root.join(entry[key].as_str().expect("a path"))
}

fn origin(entry: &serde_json::Value, key: &str) -> Point3<f64> {
    let at = |i: usize| entry[key][i].as_f64().expect("a coordinate");
    Point3::new(at(0), at(1), at(2))
}

#[test]
fn inserted_objects_are_found_whatever_the_pose_and_quiet_pairs_stay_quiet() {
    let Some(root) = patrold_test_support::data("semisynthetic") else {
        return;
    };
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let reference = View::bare(ply(&file(&root, pair, "reference")), Point3::origin());
        let points = ply(&file(&root, pair, "current"));
        let truth = labels(&file(&root, pair, "labels"));
        let name = pair["name"].as_str().expect("a name");
        for (x, y, yaw_deg) in [(0.0, 0.0, 0.0), (0.02, -0.022, 1.0), (-0.08, 0.06, -5.0)] {
            let pose = moved(x, y, yaw_deg);
            let current = View::bare(
                points.iter().map(|p| pose * p).collect(),
                pose * Point3::origin(),
            );
            let score = compare(name, &reference, &current, |i| Some(truth[i] > 0));
            let off = score.found.registration.current_from_reference * pose.inverse();
            assert!(off.translation.vector.norm() < 0.01, "{name}: {off}");
            assert!(off.rotation.angle() < 0.004, "{name}: {off}");
            if pair["nochange"].as_bool() == Some(true) {
                assert_eq!(score.found.verdict, Verdict::Quiet, "{name}");
                assert!(score.found.d_gmm < 2e-4 && score.found.novelties.is_empty());
            } else if pair["novel_points"].as_u64() >= Some(136) {
                assert_eq!(score.found.verdict, Verdict::Changed, "{name}");
                assert!(score.precision >= 0.95 && score.recall >= 0.90, "{name}");
            }
        }
    }
}

#[test]
fn the_ball_of_a_spinning_laser_is_found_in_every_pair() {
    let Some(root) = patrold_test_support::data("spherecalib/dev") else {
        return;
    };
    let meta = json(&root.join("meta.json"));
    for pair in meta["pairs"].as_array().expect("pairs") {
        let reference = View::bare(ply(&file(&root, pair, "reference")), Point3::origin());
        let current_name = pair["current"].as_str().expect("a name");
        let current = View::bare(ply(&root.join(current_name)), Point3::origin());
        let from = pair["reference"].as_str().expect("a name");
        let name = format!("{current_name} {from}");
        if !pair["labels"].is_string() {
            let score = compare(&name, &reference, &current, |_| Some(false));
            assert_eq!(score.found.verdict, Verdict::Quiet, "{name}");
            assert!(score.found.d_gmm < 2e-4 && score.found.novelties.is_empty());
            continue;
        }
        let truth = labels(&file(&root, pair, "labels"));
        let score = compare(&name, &reference, &current, |i| match truth[i] {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        });
        assert_eq!(score.found.verdict, Verdict::Changed, "{name}");
        assert!(score.precision >= 0.85 && score.recall >= 0.75, "{name}");
        let ball = labels(&root.join(current_name.replace(".ply", ".sphere.txt")));
        let on_ball: Vec<usize> = (0..ball.len())
            .filter(|i| ball[*i] == 1 && truth[*i] == 1)
            .collect();
        let got = on_ball.iter().filter(|i| score.found.labels[**i]).count();
        eprintln!("    ball: {got} of {}", on_ball.len());
        assert!(2 * got >= on_ball.len(), "{name}");
    }
}

#[test]
fn another_viewpoint_is_never_a_change() {
    let Some(root) = patrold_test_support::data("viewpoint_nochange") else {
        return;
    };
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let view = |key: &str, at: &str| View::bare(ply(&file(&root, pair, key)), origin(pair, at));
        let name = pair["name"].as_str().expect("a name");
        let score = compare(
            name,
            &view("reference", "ref_sensor"),
            &view("current", "cur_sensor"),
            |_| Some(false),
        );
        assert_ne!(score.found.verdict, Verdict::Changed, "{name}");
    }
}
