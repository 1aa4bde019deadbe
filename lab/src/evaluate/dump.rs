//! Pairs as files that `compare --manifest` reads, with their truth.

use super::pair::SimulatedPair;
use super::point_labels::PointLabel;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::RollPitchYaw;
use serde::Serialize;

/// A pair in a manifest; the keys after `current_origin` are truth, which `compare` ignores.
#[derive(Debug, Serialize)]
pub struct ManifestEntry {
    name: String,
    reference: String,
    current: String,
    reference_origin: [f64; 3],
    current_origin: [f64; 3],
    set: &'static str,
    place: &'static str,
    sensor: &'static str,
    pose_error: &'static str,
    change: &'static str,
    #[serde(rename = "told")]
    change_description: String,
    changed: bool,
    reference_labels: String,
    current_labels: String,
    current_from_reference: TruePose,
}

/// The true pose correction, in the form in which `compare` reports its own.
#[derive(Debug, Serialize)]
struct TruePose {
    translation: [f64; 3],
    rotation_deg: [f64; 3],
}

/// A file to write: its name and bytes.
pub type NamedFile = (String, Vec<u8>);

/// The manifest entry of a pair, and its four files: both clouds, and for each a line per point: 0 unchanged, 1 on an
/// object that appeared, disappeared or moved, 2 the same where the other visit could not see for sure, 3 on a part of a
/// changed object that is where it was.
pub fn dump(pair: &SimulatedPair) -> (ManifestEntry, [NamedFile; 4]) {
    let name = pair.plan.name();
    let file = |kind: &str| format!("{name}-{kind}");
    let [reference, current] = [file("reference.ply"), file("current.ply")];
    let [reference_labels, current_labels] =
        [file("reference-labels.txt"), file("current-labels.txt")];
    let views = [&pair.sweeps[0].view, &pair.sweeps[1].view];
    let pose = &pair.current_from_reference;
    let angles = RollPitchYaw::from_pose(pose);
    let files = [
        (reference.clone(), write_ply(&views[0].points)),
        (current.clone(), write_ply(&views[1].points)),
        (reference_labels.clone(), label_lines(&pair.labels[0])),
        (current_labels.clone(), label_lines(&pair.labels[1])),
    ];
    let entry = ManifestEntry {
        name,
        reference,
        current,
        reference_origin: views[0].origin.coords.into(),
        current_origin: views[1].origin.coords.into(),
        set: pair.plan.set.as_str(),
        place: pair.plan.place.as_str(),
        sensor: pair.plan.sensor.as_str(),
        pose_error: pair.plan.pose_error.as_str(),
        change: pair.plan.change.as_str(),
        change_description: pair.change_description.clone(),
        changed: pair
            .labels
            .iter()
            .flatten()
            .any(|l| *l != PointLabel::Unchanged),
        reference_labels,
        current_labels,
        current_from_reference: TruePose {
            translation: pose.translation.vector.into(),
            rotation_deg: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad].map(f64::to_degrees),
        },
    };
    (entry, files)
}

fn label_lines(labels: &[PointLabel]) -> Vec<u8> {
    let digit = |l: &PointLabel| match l {
        PointLabel::Unchanged => "0\n",
        PointLabel::FreeSpace => "1\n",
        PointLabel::NotVisible | PointLabel::BeyondFreeRange => "2\n",
        PointLabel::OnSurface => "3\n",
    };
    labels.iter().map(digit).collect::<String>().into_bytes()
}
