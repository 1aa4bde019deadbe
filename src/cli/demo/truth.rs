//! What truly came and went at a place, and whether a visit told exactly that.

use super::building::{Place, world};
use crate::cli::failure::Failure;
use nalgebra::{Point3, Vector3};
use patrold_engine::report::NoveltyRecord;
use patrold_sim::world::{MountGeometry, NoiseOptions, Robot, Scene, SweepRows, sample_view};
use serde::Serialize;

/// Tilts of the demo's sweeps, degrees, and rows enough to see every thing.
const TILTS_DEG: (f64, f64, usize) = (-35.0, 25.0, 121);
/// A true change is told if a novelty of its kind lies so near, metres.
const SAME_PLACE_M: f64 = 0.2;
/// A shape is sane if its largest side is that of the thing seen, within this factor either way.
const SANE_FACTOR: f64 = 1.6;

/// One thing that truly came or went.
#[derive(Debug, Clone, Serialize)]
pub struct Truth {
    /// Its name in the scene.
    pub name: String,
    /// appeared or disappeared.
    pub kind: &'static str,
    /// Middle of what can be seen of it from the waypoint, metres, in the waypoint's reference frame.
    pub place: [f64; 3],
    /// Extent of what can be seen of it, metres.
    pub extent: [f64; 3],
}

/// A truth and what was told of it.
#[derive(Debug, Clone, Serialize)]
pub struct Told {
    /// The truth.
    pub truth: Truth,
    /// What was told, if anything near enough was.
    pub novelty: Option<NoveltyRecord>,
    /// How far off it was, metres.
    pub off_m: Option<f64>,
    /// Whether its shape is about as large as the thing.
    pub sane_shape: bool,
}

/// Everything that truly changed at a place and can be seen.
///
/// # Errors
/// A scene does not build.
pub fn of(place: &Place) -> Result<Vec<Truth>, Failure> {
    let mut truths = Vec::new();
    for change in place.after.changes_since(&place.before) {
        for (there, scene, kind) in [
            (change.before, &place.before, "disappeared"),
            (change.after, &place.after, "appeared"),
        ] {
            if there.is_some() {
                truths.extend(seen(scene, &change.name, kind)?);
            }
        }
    }
    Ok(truths)
}

/// The thing as an ideal laser sees it from the waypoint.
fn seen(scene: &Scene, name: &str, kind: &'static str) -> Result<Option<Truth>, Failure> {
    let world = world(scene)?;
    let robot = Robot {
        pose: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    let (from_deg, to_deg, rows) = TILTS_DEG;
    let rows = SweepRows::evenly(from_deg, to_deg, rows);
    let sampled = sample_view(&world, &robot, &rows, &NoiseOptions::ideal());
    let Some(object) = world.object_named(name) else {
        return Ok(None);
    };
    let points: Vec<Point3<f64>> = sampled
        .view
        .points
        .iter()
        .zip(&sampled.objects)
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
    Ok(Some(Truth {
        name: name.to_owned(),
        kind,
        place: (sum / points.len() as f64).into(),
        extent: (bounds.1 - bounds.0).into(),
    }))
}

/// Holds what was told against the truth: each truth with its novelty, and the novelties that tell of none.
pub fn judge(truths: Vec<Truth>, told: &[NoveltyRecord]) -> (Vec<Told>, Vec<NoveltyRecord>) {
    let mut left: Vec<NoveltyRecord> = told.to_vec();
    let judged = truths
        .into_iter()
        .map(|truth| tell(truth, &mut left))
        .collect();
    (judged, left)
}

fn tell(truth: Truth, left: &mut Vec<NoveltyRecord>) -> Told {
    let off_m = |n: &NoveltyRecord| (Point3::from(n.centre) - Point3::from(truth.place)).norm();
    let nearest = (0..left.len())
        .filter(|i| left[*i].kind == truth.kind && off_m(&left[*i]) <= SAME_PLACE_M)
        .min_by(|a, b| off_m(&left[*a]).total_cmp(&off_m(&left[*b])));
    let novelty = nearest.map(|i| left.remove(i));
    let largest = |sides: [f64; 3]| sides.into_iter().fold(0.0, f64::max);
    let sane_shape = novelty
        .as_ref()
        .and_then(|n| n.shape.as_ref())
        .is_some_and(|shape| {
            let ratio = largest(shape.size) / largest(truth.extent);
            (1.0 / SANE_FACTOR..=SANE_FACTOR).contains(&ratio)
        });
    Told {
        off_m: novelty.as_ref().map(off_m),
        novelty,
        sane_shape,
        truth,
    }
}

#[cfg(test)]
mod tests {
    use super::{judge, of};
    use crate::cli::demo::building::places;

    #[test]
    fn the_building_has_a_visible_change_at_every_place() {
        let mut kinds = Vec::new();
        for place in places().expect("the shipped scenes") {
            let truths = of(&place).expect("builds");
            assert!(!truths.is_empty(), "{}", place.waypoint);
            kinds.extend(truths.iter().map(|t| t.kind));
            let (told, stray) = judge(truths, &[]);
            assert!(told.iter().all(|t| t.novelty.is_none()) && stray.is_empty());
        }
        assert!(kinds.contains(&"appeared") && kinds.contains(&"disappeared"));
    }
}
