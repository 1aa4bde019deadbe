//! The whole engine on simulated sweeps of the shipped scenes: quiet stays quiet, exactly the true changes are told.
#![allow(
    clippy::print_stdout,
    reason = "the table that it prints is its report"
)]

use nalgebra::Point3;
use patrold_engine::geometry::Pose;
use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_engine::report::NoveltyRecord;
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Robot, SampledView, Scene, SceneChange, Stand, SweepRows,
    sample_view,
};
use std::time::Duration;

fn scene(name: &str) -> Scene {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    Scene::resolve(name, &load).expect("a shipped scene")
}

/// Where the robot stands off its waypoint on a revisit: metres and degrees.
const POSE_ERRORS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.03, -0.02, 1.0],
    [-0.06, 0.05, -2.0],
    [0.08, 0.06, 4.0],
];

fn stands(at: &Pose, error: [f64; 3]) -> Stand {
    let yaw_rad = at.rotation.euler_angles().2 + error[2].to_radians();
    let t = at.translation.vector;
    Stand {
        x_m: t.x + error[0],
        y_m: t.y + error[1],
        yaw_rad,
    }
}

fn swept(scene: &Scene, error: [f64; 3], seed: u64) -> (SampledView, Pose) {
    let world = scene.build(None).expect("builds");
    let mut robot = Robot {
        pose: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    robot.drive_to(stands(&scene.map_from_base, error));
    let rows = SweepRows::evenly(-35.0, 25.0, 120).starting_at(Duration::from_secs(100 * seed));
    let view = sample_view(&world, &robot, &rows, &NoiseOptions::seeded(seed));
    (view, robot.pose)
}

struct Visit {
    inspection: Inspection,
    /// Novelties in the map's frame.
    told: Vec<NoveltyRecord>,
}

fn visit(before: &Scene, after: &Scene, error: [f64; 3], seed: u64) -> Visit {
    let settings = EngineSettings::standard();
    let (reference, _) = swept(before, [0.0; 3], 2 * seed);
    let (current, map_from_base) = swept(after, error, 2 * seed + 1);
    let prepared = prepare(&reference.view, &settings, 7).expect("prepares");
    let inspection =
        inspect(&prepared, &current.view, &settings, 7, &mut |_| {}).expect("inspects");
    let told = inspection
        .detection
        .novelties
        .iter()
        .zip(&inspection.retrievals)
        .map(|(n, r)| NoveltyRecord::new(n, r.as_ref()).in_frame(&map_from_base))
        .collect();
    Visit { inspection, told }
}

fn print(name: &str, error: [f64; 3], seed: u64, visit: &Visit) {
    let detection = &visit.inspection.detection;
    println!(
        "{name} {error:?} seed {seed}: {:?} d {:.5} unexplained {:.5} ({})",
        detection.verdict, detection.d_gmm, detection.unexplained, detection.reason
    );
    for n in &visit.told {
        let shape = n
            .shape
            .as_ref()
            .map(|s| (s.class.clone(), s.size, s.centre));
        println!(
            "    {} {:?} {} points, support {:.0}, {shape:?}",
            n.kind, n.centre, n.points, n.support
        );
    }
}

#[test]
fn an_unchanged_place_is_quiet_wherever_the_robot_stands() {
    let mut loud = Vec::new();
    for name in ["corridor.toml", "office.toml", "storeroom.toml"] {
        let before = scene(name);
        for (i, error) in POSE_ERRORS.into_iter().enumerate() {
            let seed = 10 + i as u64;
            let seen = visit(&before, &before, error, seed);
            print(name, error, seed, &seen);
            if seen.inspection.detection.verdict != Verdict::Quiet || !seen.told.is_empty() {
                loud.push((name, error));
            }
        }
    }
    assert!(loud.is_empty(), "{loud:?}");
}

#[test]
fn exactly_the_true_changes_are_told() {
    let mut wrong = Vec::new();
    for (before, after) in [
        ("corridor.toml", "corridor-person.toml"),
        ("office.toml", "office-door.toml"),
        ("storeroom.toml", "storeroom-box-left.toml"),
        ("storeroom.toml", "storeroom-taken.toml"),
    ] {
        let changes = scene(after).changes_since(&scene(before));
        for (i, error) in POSE_ERRORS.into_iter().enumerate() {
            let seed = 20 + i as u64;
            let seen = visit(&scene(before), &scene(after), error, seed);
            print(after, error, seed, &seen);
            let complete = changes.iter().all(|change| is_told(change, &seen.told));
            let true_only = seen
                .told
                .iter()
                .all(|n| changes.iter().any(|c| tells(n, c)));
            if seen.inspection.detection.verdict != Verdict::Changed || !complete || !true_only {
                wrong.push((after, error, complete, true_only));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn is_told(change: &SceneChange, told: &[NoveltyRecord]) -> bool {
    told.iter().any(|n| tells(n, change))
}

/// Within half a metre in plan: a thing's middle is not the middle of the side that is seen.
fn tells(n: &NoveltyRecord, change: &SceneChange) -> bool {
    let place = if n.kind == "appeared" {
        change.after
    } else {
        change.before
    };
    place.is_some_and(|p| {
        let centre = Point3::from(n.centre);
        (centre.xy() - p.xy()).norm() < 0.5
    })
}
