//! The engine on the recorded pairs: changes are found, unchanged pairs stay quiet. Prints a table (`--nocapture`).

use nalgebra::Point3;
use patrold_engine::formats::read_cloud;
use patrold_engine::geometry::{Pose, RollPitchYaw, View};
use patrold_engine::novelty::{
    Detection, NoveltyKind, NoveltySettings, Reference, Verdict, detect,
};
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

fn planar_pose(x: f64, y: f64, yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation([x, y, 0.0])
}

/// Precision and recall of the labels.
struct DetectionScore {
    detection: Detection,
    precision: f64,
    recall: f64,
}

/// `is_novel` is the truth of a current point; `None` where it is not scored.
fn compare(
    name: &str,
    reference: &View,
    current: &View,
    is_novel: impl Fn(usize) -> Option<bool>,
) -> DetectionScore {
    let settings = NoveltySettings::default();
    let prepared = Reference::prepare(reference, &settings, 1).expect("a reference");
    let detection = detect(&prepared, current, &settings, 1, &mut |_| {}).expect("a detection");
    let (mut hits, mut false_hits, mut missed) = (0, 0, 0);
    for (i, hit) in detection.labels.iter().enumerate() {
        match (is_novel(i), hit) {
            (Some(true), true) => hits += 1,
            (Some(false), true) => false_hits += 1,
            (Some(true), false) => missed += 1,
            _ => {}
        }
    }
    let ratio = |part: i32, whole: i32| f64::from(part) / f64::from(whole.max(1));
    let score = DetectionScore {
        precision: ratio(hits, hits + false_hits),
        recall: ratio(hits, hits + missed),
        detection,
    };
    let pose = &score.detection.registration.current_from_reference;
    let count = |k: NoveltyKind| {
        score
            .detection
            .novelties
            .iter()
            .filter(|n| n.kind == k)
            .count()
    };
    eprintln!(
        "{name:28} {:11} d {:.5} rest {:.5} work {:6.3} came {:2} went {:2} precision {:.3} recall {:.3} | {:.4} m {:.3} deg | {}",
        format!("{:?}", score.detection.verdict),
        score.detection.d_gmm,
        score.detection.unexplained,
        score.detection.work_m3,
        count(NoveltyKind::Appeared),
        count(NoveltyKind::Disappeared),
        score.precision,
        score.recall,
        pose.translation.vector.norm(),
        pose.rotation.angle().to_degrees(),
        score.detection.reason,
    );
    score
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a manifest")).expect("json")
}

fn entry_path(root: &Path, entry: &serde_json::Value, key: &str) -> PathBuf {
    root.join(entry[key].as_str().expect("a path"))
}

fn origin(entry: &serde_json::Value, key: &str) -> Point3<f64> {
    let at = |i: usize| entry[key][i].as_f64().expect("a coordinate");
    Point3::new(at(0), at(1), at(2))
}

#[test]
fn inserted_objects_are_found_at_any_pose_and_quiet_pairs_stay_quiet() {
    let Some(root) = patrold_test_support::data("semisynthetic") else {
        return;
    };
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let reference =
            View::from_points(ply(&entry_path(&root, pair, "reference")), Point3::origin());
        let points = ply(&entry_path(&root, pair, "current"));
        let truth = labels(&entry_path(&root, pair, "labels"));
        let name = pair["name"].as_str().expect("a name");
        for (x, y, yaw_deg) in [(0.0, 0.0, 0.0), (0.02, -0.022, 1.0), (-0.08, 0.06, -5.0)] {
            let pose = planar_pose(x, y, yaw_deg);
            let current = View::from_points(
                points.iter().map(|p| pose * p).collect(),
                pose * Point3::origin(),
            );
            let score = compare(name, &reference, &current, |i| Some(truth[i] > 0));
            let pose_error = score.detection.registration.current_from_reference * pose.inverse();
            assert!(
                pose_error.translation.vector.norm() < 0.01,
                "{name}: {pose_error}"
            );
            assert!(pose_error.rotation.angle() < 0.004, "{name}: {pose_error}");
            if pair["nochange"].as_bool() == Some(true) {
                assert_eq!(score.detection.verdict, Verdict::Quiet, "{name}");
                assert!(score.detection.d_gmm < 2e-4 && score.detection.novelties.is_empty());
            } else if pair["novel_points"].as_u64() >= Some(136) {
                assert_eq!(score.detection.verdict, Verdict::Changed, "{name}");
                assert!(score.precision >= 0.95 && score.recall >= 0.90, "{name}");
            }
        }
    }
}

#[test]
fn the_ball_is_found_in_every_pair_of_a_spinning_laser() {
    let Some(root) = patrold_test_support::data("spherecalib/dev") else {
        return;
    };
    let meta = json(&root.join("meta.json"));
    for pair in meta["pairs"].as_array().expect("pairs") {
        let reference =
            View::from_points(ply(&entry_path(&root, pair, "reference")), Point3::origin());
        let current_name = pair["current"].as_str().expect("a name");
        let current = View::from_points(ply(&root.join(current_name)), Point3::origin());
        let from = pair["reference"].as_str().expect("a name");
        let name = format!("{current_name} {from}");
        if !pair["labels"].is_string() {
            let score = compare(&name, &reference, &current, |_| Some(false));
            assert_eq!(score.detection.verdict, Verdict::Quiet, "{name}");
            assert!(score.detection.d_gmm < 2e-4 && score.detection.novelties.is_empty());
            continue;
        }
        let truth = labels(&entry_path(&root, pair, "labels"));
        let score = compare(&name, &reference, &current, |i| match truth[i] {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        });
        assert_eq!(score.detection.verdict, Verdict::Changed, "{name}");
        assert!(score.precision >= 0.85 && score.recall >= 0.75, "{name}");
        let ball = labels(&root.join(current_name.replace(".ply", ".sphere.txt")));
        let on_ball: Vec<usize> = (0..ball.len())
            .filter(|i| ball[*i] == 1 && truth[*i] == 1)
            .collect();
        let found = on_ball
            .iter()
            .filter(|i| score.detection.labels[**i])
            .count();
        eprintln!("    ball: {found} of {}", on_ball.len());
        assert!(2 * found >= on_ball.len(), "{name}");
    }
}

#[test]
fn another_viewpoint_is_never_a_change() {
    let Some(root) = patrold_test_support::data("viewpoint_nochange") else {
        return;
    };
    let manifest = json(&root.join("manifest_dev.json"));
    for pair in manifest["pairs"].as_array().expect("pairs") {
        let view = |key: &str, at: &str| {
            View::from_points(ply(&entry_path(&root, pair, key)), origin(pair, at))
        };
        let name = pair["name"].as_str().expect("a name");
        let score = compare(
            name,
            &view("reference", "ref_sensor"),
            &view("current", "cur_sensor"),
            |_| Some(false),
        );
        assert_ne!(score.detection.verdict, Verdict::Changed, "{name}");
    }
}
