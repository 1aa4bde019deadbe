//! Things that give nothing back are never quiet, and gaps of a sensor are no things (`docs/novelty.md section 5`).

#[path = "harness/analytic.rs"]
mod analytic;

use analytic::{
    AnalyticSolid, ScanPattern, URG_NOISE, at_origin, compare, furnished_room, planar_pose,
};
use nalgebra::Point3;
use patrold_engine::geometry::{Pose, View};
use patrold_engine::novelty::Verdict;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A visit to the furnished room with an upright thing in it that gives nothing back; how many beams met it.
fn visit_with_absorber(
    pattern: ScanPattern,
    low: [f64; 3],
    high: [f64; 3],
    pose: &Pose,
    seed: u64,
) -> (View, usize) {
    let room = furnished_room().with(AnalyticSolid::Block(low, high));
    let mut view = room.scan(pattern, pose, URG_NOISE, f64::INFINITY, seed);
    let before = view.points.len();
    let is_on = |p: &Point3<f64>| {
        let placed = pose * p;
        (0..3).all(|i| (low[i] - 0.03..high[i] + 0.03).contains(&placed[i]) && placed.z > -0.47)
    };
    view.points.retain(|p| !is_on(p));
    let lost = before - view.points.len();
    (view, lost)
}

/// Its middle and half width in front, metres; half a metre below the sensor it stands on the floor.
fn upright(at: [f64; 2], half_m: f64, height_m: f64) -> ([f64; 3], [f64; 3]) {
    let [x, y] = at;
    let low = [x - 0.12, y - half_m, -0.5];
    (low, [x + 0.12, y + half_m, height_m - 0.5])
}

#[test]
fn who_gives_nothing_back_is_never_quiet_and_is_seen_where_he_stands() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut persons = 0;
    for seed in 0..30 {
        // Of rings 30 deg high a person fills a sector from edge to edge.
        let pattern = ScanPattern::Tilted(rng.random_range(0.5..2.0));
        let at = [rng.random_range(1.2..2.2), rng.random_range(-0.6..0.9)];
        let (low, high) = upright(at, 0.25, rng.random_range(1.2..1.9));
        let pose = planar_pose(
            rng.random_range(-0.05..0.05),
            rng.random_range(-0.05..0.05),
            rng.random_range(-3.0..3.0),
        );
        let reference = furnished_room().scan(pattern, &at_origin(), URG_NOISE, 1e3, 3000 + seed);
        let (visit, lost) = visit_with_absorber(pattern, low, high, &pose, 4000 + seed);
        if lost < 250 {
            continue;
        }
        persons += 1;
        let found = compare(&reference, &visit);
        let told = format!(
            "seed {seed} {pattern:?} {at:?} {lost} beams: {}",
            found.reason
        );
        assert_eq!(found.verdict, Verdict::NotObserved, "{told}");
        assert!(found.reason.contains("gives nothing back"), "{told}");
        let largest = found.absorbing.iter().max_by_key(|thing| thing.beams);
        let thing = largest.expect("in the reason");
        let middle = pose.inverse() * Point3::new(at[0], at[1], 0.0);
        let [right, left] = thing.bearings_rad;
        let off_rad = 0.5 * (right + left) - middle.y.atan2(middle.x);
        assert!(off_rad.abs() < 3.0_f64.to_radians(), "{told}");
        assert!(thing.far_m > at[0] - 0.2 && thing.far_m < 4.5, "{told}");
    }
    assert!(persons >= 20, "{persons}");
}

/// A visit that saw nothing within these bearings and elevations, degrees.
fn visit_without(bearings: [f64; 2], elevations: [f64; 2]) -> View {
    let (pattern, pose) = (ScanPattern::Tilted(1.0), at_origin());
    let mut view = furnished_room().scan(pattern, &pose, URG_NOISE, f64::INFINITY, 51);
    view.points.retain(|p| {
        let bearing_deg = p.y.atan2(p.x).to_degrees();
        let elevation_deg = p.z.atan2(p.x.hypot(p.y)).to_degrees();
        !((bearings[0]..bearings[1]).contains(&bearing_deg)
            && (elevations[0]..elevations[1]).contains(&elevation_deg))
    });
    view
}

#[test]
fn a_thing_ends_at_both_sides_and_above_or_below_and_what_a_sensor_lacks_does_not() {
    let all = 200.0;
    let pattern = ScanPattern::Tilted(1.0);
    let reference = furnished_room().scan(pattern, &at_origin(), URG_NOISE, f64::INFINITY, 50);
    for (name, bearings, elevations, things) in [
        ("an outline within the field", [10.0, 24.0], [-10.0, 8.0], 1),
        ("cut off above", [10.0, 24.0], [-10.0, all], 1),
        ("cut off below", [10.0, 24.0], [-all, 8.0], 1),
        ("a sector", [10.0, 24.0], [-all, all], 0),
        ("a band", [-all, all], [-10.0, 8.0], 0),
        ("open to the left", [10.0, all], [-10.0, 8.0], 0),
        ("open to the right", [-all, 24.0], [-10.0, 8.0], 0),
        ("too small", [10.0, 13.0], [-3.0, 0.0], 0),
        ("two rows high", [10.0, 60.0], [-3.0, -1.0], 0),
        ("two columns wide", [10.0, 12.0], [-10.0, 8.0], 0),
    ] {
        let found = compare(&reference, &visit_without(bearings, elevations));
        assert_eq!(
            found.absorbing.len(),
            things,
            "{name}: {:?}",
            found.absorbing
        );
        let is_told = found.reason.contains("gives nothing back");
        assert_eq!(is_told, things > 0, "{name}: {}", found.reason);
        if things > 0 {
            assert_eq!(found.verdict, Verdict::NotObserved, "{name}");
        }
    }
}
