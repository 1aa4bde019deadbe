//! Pairs as files that `compare --manifest` reads, with their truth beside.

use super::pair::Pair;
use super::truth::Label;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::RollPitchYaw;
use serde::Serialize;

/// One pair of a manifest; keys after `current_origin` are truth, which `compare` ignores.
#[derive(Debug, Serialize)]
pub struct Entry {
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
    told: String,
    changed: bool,
    reference_labels: String,
    current_labels: String,
    current_from_reference: TruePose,
}

/// The true pose correction, as `compare` tells its own.
#[derive(Debug, Serialize)]
struct TruePose {
    translation: [f64; 3],
    rotation_deg: [f64; 3],
}

/// A file to write: its name and its bytes.
pub type NamedFile = (String, Vec<u8>);

/// The entry of a pair, and its four files: both clouds, and for each a line per point: 0 on nothing that changed, 1 on a
/// thing that came, went or moved, 2 the same where the other visit could not look for sure, 3 on a changed thing's part
/// that is where it was.
pub fn dump(pair: &Pair) -> (Entry, [NamedFile; 4]) {
    let name = pair.planned.name();
    let file = |kind: &str| format!("{name}-{kind}");
    let [reference, current] = [file("reference.ply"), file("current.ply")];
    let [reference_labels, current_labels] =
        [file("reference-labels.txt"), file("current-labels.txt")];
    let views = [&pair.sweeps[0].view, &pair.sweeps[1].view];
    let pose = &pair.current_from_reference;
    let angles = RollPitchYaw::of(pose);
    let files = [
        (reference.clone(), write_ply(&views[0].points)),
        (current.clone(), write_ply(&views[1].points)),
        (reference_labels.clone(), lines(&pair.labels[0])),
        (current_labels.clone(), lines(&pair.labels[1])),
    ];
    let entry = Entry {
        name,
        reference,
        current,
        reference_origin: views[0].origin.coords.into(),
        current_origin: views[1].origin.coords.into(),
        set: pair.planned.set.word(),
        place: pair.planned.place.word(),
        sensor: pair.planned.sensor.word(),
        pose_error: pair.planned.pose.word(),
        change: pair.planned.change.word(),
        told: pair.told.clone(),
        changed: pair.labels.iter().flatten().any(|l| *l != Label::Other),
        reference_labels,
        current_labels,
        current_from_reference: TruePose {
            translation: pose.translation.vector.into(),
            rotation_deg: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad].map(f64::to_degrees),
        },
    };
    (entry, files)
}

fn lines(labels: &[Label]) -> Vec<u8> {
    let digit = |l: &Label| match l {
        Label::Other => "0\n",
        Label::Seen => "1\n",
        Label::Hidden | Label::Beyond => "2\n",
        Label::Same => "3\n",
    };
    labels.iter().map(digit).collect::<String>().into_bytes()
}
