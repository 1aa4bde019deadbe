//! What truly changed at a waypoint, and which novelties match it.

use super::building::{DemoWaypoint, build_world};
use crate::cli::failure::Failure;
use nalgebra::{Point3, Vector3};
use patrold_engine::report::NoveltyRecord;
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Scene, SimulatedRobot, SweepRows, simulate_sweep,
};
use serde::Serialize;

/// Tilt range of the demo's sweeps, degrees, and a number of rows that sees every object.
const TILT_ROWS: (f64, f64, usize) = (-35.0, 25.0, 121);
/// A novelty matches a true change of its kind up to this distance of the centres, metres.
const MAX_MATCH_DISTANCE_M: f64 = 0.2;
/// A shape is sane if its largest side is that of the visible object within this factor.
const MAX_SIZE_RATIO: f64 = 1.6;

/// An object that appeared or disappeared.
#[derive(Debug, Clone, Serialize)]
pub(super) struct TrueChange {
    /// Name of the object in the scene.
    pub name: String,
    /// `appeared` or `disappeared`.
    pub kind: &'static str,
    /// Mean of its visible points, metres, in the frame of the waypoint's reference.
    #[serde(rename = "place")]
    pub centre: [f64; 3],
    /// Extent of its visible points along x, y and z, metres.
    pub extent: [f64; 3],
}

/// A true change and the novelty that matches it.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ChangeMatch {
    pub truth: TrueChange,
    pub novelty: Option<NoveltyRecord>,
    /// Distance of the centres, metres.
    pub off_m: Option<f64>,
    /// Whether the shape is about as large as the object.
    pub sane_shape: bool,
}

/// The changes at a waypoint that are visible from it.
pub(super) fn true_changes(waypoint: &DemoWaypoint) -> Result<Vec<TrueChange>, Failure> {
    let mut changes = Vec::new();
    for change in waypoint.after.changes_since(&waypoint.before) {
        for (object, scene, kind) in [
            (change.before, &waypoint.before, "disappeared"),
            (change.after, &waypoint.after, "appeared"),
        ] {
            if object.is_some() {
                changes.extend(visible_change(scene, &change.name, kind)?);
            }
        }
    }
    Ok(changes)
}

/// The object as an ideal laser sees it from the waypoint; `None` where it does not.
fn visible_change(
    scene: &Scene,
    name: &str,
    kind: &'static str,
) -> Result<Option<TrueChange>, Failure> {
    let world = build_world(scene)?;
    let robot = SimulatedRobot {
        map_from_base: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    let (from_deg, to_deg, rows) = TILT_ROWS;
    let rows = SweepRows::evenly(from_deg, to_deg, rows);
    let sweep = simulate_sweep(&world, &robot, &rows, &NoiseOptions::ideal());
    let Some(object) = world.object_named(name) else {
        return Ok(None);
    };
    let points: Vec<Point3<f64>> = sweep
        .view
        .points
        .iter()
        .zip(&sweep.objects)
        .filter(|(_, hit)| **hit == object)
        .map(|(point, _)| *point)
        .collect();
    let Some(first) = points.first() else {
        return Ok(None);
    };
    let bounds = points
        .iter()
        .fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let sum = points
        .iter()
        .fold(Vector3::zeros(), |sum, p| sum + p.coords);
    Ok(Some(TrueChange {
        name: name.to_owned(),
        kind,
        centre: (sum / points.len() as f64).into(),
        extent: (bounds.1 - bounds.0).into(),
    }))
}

/// Each change with the novelty that matches it, and the novelties that match none.
pub(super) fn match_novelties(
    changes: Vec<TrueChange>,
    novelties: &[NoveltyRecord],
) -> (Vec<ChangeMatch>, Vec<NoveltyRecord>) {
    let mut unmatched: Vec<NoveltyRecord> = novelties.to_vec();
    let matches = changes
        .into_iter()
        .map(|truth| take_match(truth, &mut unmatched))
        .collect();
    (matches, unmatched)
}

/// Takes the nearest novelty of the same kind out of `unmatched`.
fn take_match(truth: TrueChange, unmatched: &mut Vec<NoveltyRecord>) -> ChangeMatch {
    let off_m = |n: &NoveltyRecord| (Point3::from(n.centre) - Point3::from(truth.centre)).norm();
    let is_candidate = |n: &NoveltyRecord| n.kind == truth.kind && off_m(n) <= MAX_MATCH_DISTANCE_M;
    let nearest = (0..unmatched.len())
        .filter(|i| is_candidate(&unmatched[*i]))
        .min_by(|a, b| off_m(&unmatched[*a]).total_cmp(&off_m(&unmatched[*b])));
    let novelty = nearest.map(|i| unmatched.remove(i));
    let largest = |sides: [f64; 3]| sides.into_iter().fold(0.0, f64::max);
    let sane_shape = novelty
        .as_ref()
        .and_then(|n| n.shape.as_ref())
        .is_some_and(|shape| {
            let ratio = largest(shape.size) / largest(truth.extent);
            (1.0 / MAX_SIZE_RATIO..=MAX_SIZE_RATIO).contains(&ratio)
        });
    ChangeMatch {
        off_m: novelty.as_ref().map(off_m),
        novelty,
        sane_shape,
        truth,
    }
}

#[cfg(test)]
mod tests {
    use super::{match_novelties, true_changes};
    use crate::cli::demo::building::demo_waypoints;

    #[test]
    fn every_waypoint_has_a_visible_change() {
        let mut kinds = Vec::new();
        for waypoint in demo_waypoints().expect("the shipped scenes") {
            let changes = true_changes(&waypoint).expect("builds");
            assert!(!changes.is_empty(), "{}", waypoint.name);
            kinds.extend(changes.iter().map(|c| c.kind));
            let (matches, stray) = match_novelties(changes, &[]);
            assert!(matches.iter().all(|m| m.novelty.is_none()) && stray.is_empty());
        }
        assert!(kinds.contains(&"appeared") && kinds.contains(&"disappeared"));
    }
}
