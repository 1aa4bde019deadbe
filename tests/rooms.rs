//! The whole engine on simulated sweeps of the shipped scenes: quiet stays quiet, exactly the true changes are reported.
#![allow(clippy::print_stdout, reason = "it prints a table")]

use nalgebra::Point3;
use patrold_engine::geometry::Pose;
use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_engine::report::NoveltyRecord;
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Pose2d, Scene, SceneChange, SimulatedRobot, SimulatedSweep,
    SweepRows, simulate_sweep,
};
use std::time::Duration;

fn scene(name: &str) -> Scene {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    Scene::resolve(name, &load).expect("a shipped scene")
}

/// Of the revisits: x and y in metres, yaw in degrees.
const POSE_ERRORS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.03, -0.02, 1.0],
    [-0.06, 0.05, -2.0],
    [0.08, 0.06, 4.0],
];

fn displaced(pose: &Pose, error: [f64; 3]) -> Pose2d {
    let yaw_rad = pose.rotation.euler_angles().2 + error[2].to_radians();
    let t = pose.translation.vector;
    Pose2d {
        x_m: t.x + error[0],
        y_m: t.y + error[1],
        yaw_rad,
    }
}

fn simulate(scene: &Scene, error: [f64; 3], seed: u64) -> (SimulatedSweep, Pose) {
    let world = scene.build(None).expect("builds");
    let mut robot = SimulatedRobot {
        map_from_base: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    robot.drive_to(displaced(&scene.map_from_base, error));
    let rows = SweepRows::evenly(-35.0, 25.0, 120).starting_at(Duration::from_secs(100 * seed));
    let sweep = simulate_sweep(&world, &robot, &rows, &NoiseOptions::seeded(seed));
    (sweep, robot.map_from_base)
}

struct Visit {
    inspection: Inspection,
    /// In the map's frame.
    novelties: Vec<NoveltyRecord>,
}

fn visit(before: &Scene, after: &Scene, error: [f64; 3], seed: u64) -> Visit {
    let settings = EngineSettings::standard();
    let (reference, _) = simulate(before, [0.0; 3], 2 * seed);
    let (current, map_from_base) = simulate(after, error, 2 * seed + 1);
    let prepared = prepare(&reference.view, &settings, 7).expect("prepares");
    let inspection =
        inspect(&prepared, &current.view, &settings, 7, &mut |_| {}).expect("inspects");
    let novelties = inspection
        .detection
        .novelties
        .iter()
        .zip(&inspection.retrievals)
        .map(|(n, r)| NoveltyRecord::new(n, r.as_ref()).in_frame(&map_from_base))
        .collect();
    Visit {
        inspection,
        novelties,
    }
}

fn print(name: &str, error: [f64; 3], seed: u64, visit: &Visit) {
    let detection = &visit.inspection.detection;
    println!(
        "{name} {error:?} seed {seed}: {:?} d {:.5} unexplained {:.5} ({})",
        detection.verdict, detection.d_gmm, detection.unexplained, detection.reason
    );
    for n in &visit.novelties {
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
fn an_unchanged_place_is_quiet_at_any_pose_error() {
    let mut loud = Vec::new();
    for name in ["corridor.toml", "office.toml", "storeroom.toml"] {
        let before = scene(name);
        for (i, error) in POSE_ERRORS.into_iter().enumerate() {
            let seed = 10 + i as u64;
            let result = visit(&before, &before, error, seed);
            print(name, error, seed, &result);
            if result.inspection.detection.verdict != Verdict::Quiet || !result.novelties.is_empty()
            {
                loud.push((name, error));
            }
        }
    }
    assert!(loud.is_empty(), "{loud:?}");
}

#[test]
fn exactly_the_true_changes_are_reported() {
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
            let result = visit(&scene(before), &scene(after), error, seed);
            print(after, error, seed, &result);
            let complete = changes
                .iter()
                .all(|change| is_reported(change, &result.novelties));
            let true_only = result
                .novelties
                .iter()
                .all(|n| changes.iter().any(|c| matches(n, c)));
            if result.inspection.detection.verdict != Verdict::Changed || !complete || !true_only {
                wrong.push((after, error, complete, true_only));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn is_reported(change: &SceneChange, novelties: &[NoveltyRecord]) -> bool {
    novelties.iter().any(|n| matches(n, change))
}

/// Within half a metre in plan: the centre of an object is not that of its visible side.
fn matches(n: &NoveltyRecord, change: &SceneChange) -> bool {
    let position = if n.kind == "appeared" {
        change.after
    } else {
        change.before
    };
    position.is_some_and(|p| {
        let centre = Point3::from(n.centre);
        (centre.xy() - p.xy()).norm() < 0.5
    })
}
