//! Simulated sweeps of shipped scenes and of a recorded cloud.

use super::{SimulatedSweep, SweepRows, simulate_sweep};
use crate::world::{MountGeometry, NoiseOptions, Scene, SimulatedRobot, World};
use nalgebra::Point3;
use patrold_test_support::data;
use std::time::Duration;

fn shipped(name: &str) -> (Scene, World, SimulatedRobot) {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(|e| e.to_string());
    let scene = Scene::resolve(name, &load).expect("a shipped scene");
    let world = scene.build(None).expect("no cloud");
    let robot = SimulatedRobot {
        map_from_base: scene.map_from_base,
        mount: MountGeometry::default(),
    };
    (scene, world, robot)
}

fn rows() -> SweepRows {
    SweepRows::evenly(-40.0, 30.0, 71)
}

fn points_on(sampled: &SimulatedSweep, world: &World, name: &str) -> usize {
    let object = world.object_named(name);
    sampled
        .objects
        .iter()
        .filter(|o| Some(**o) == object)
        .count()
}

#[test]
fn shipped_scenes_fill_the_view() {
    for name in ["corridor.toml", "office.toml", "storeroom.toml"] {
        let (scene, world, robot) = shipped(name);
        let sampled = simulate_sweep(&world, &robot, &rows(), &NoiseOptions::ideal());
        let beams = 682 * 71;
        assert!(
            sampled.view.points.len() > beams * 9 / 10,
            "{name}: {}",
            sampled.view.points.len()
        );
        assert_eq!(
            sampled.view.points.len() + sampled.view.no_return.len(),
            beams
        );
        let seen = world
            .objects()
            .iter()
            .filter(|o| points_on(&sampled, &world, &o.name) > 30)
            .count();
        let counts: Vec<_> = world
            .objects()
            .iter()
            .map(|o| (&o.name, points_on(&sampled, &world, &o.name)))
            .collect();
        assert!(
            seen >= 10,
            "{name}: only {seen} objects are visible: {counts:?}"
        );
        // The floor is z = 0 of the map.
        let low = sampled
            .view
            .points
            .iter()
            .map(|p| (scene.map_from_base * p).z)
            .fold(f64::INFINITY, f64::min);
        assert!(low.abs() < 0.01, "{name}: {low}");
    }
}

#[test]
fn changed_scenes_change_the_named_object_alone() {
    let cases = [
        ("corridor.toml", "corridor-person.toml", "intruder", 1),
        ("office.toml", "office-door.toml", "door", 0),
        ("storeroom.toml", "storeroom-box-left.toml", "left box", 1),
        ("storeroom.toml", "storeroom-taken.toml", "upper crate", -1),
    ];
    for (quiet, changed, name, sign) in cases {
        let (before, world_before, robot) = shipped(quiet);
        let (after, world_after, _) = shipped(changed);
        let changes = after.changes_since(&before);
        assert_eq!(
            changes.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
            [name]
        );
        let count = |world: &World| {
            points_on(
                &simulate_sweep(world, &robot, &rows(), &NoiseOptions::ideal()),
                world,
                name,
            )
        };
        let (before, after) = (count(&world_before), count(&world_after));
        match sign {
            1 => assert!(before == 0 && after > 150, "{changed}: {before} to {after}"),
            -1 => assert!(before > 150 && after == 0, "{changed}: {before} to {after}"),
            _ => assert!(
                before > 100 && after > 100,
                "{changed}: {before} to {after}"
            ),
        }
    }
}

#[test]
fn points_lie_on_their_labelled_object() {
    let (scene, world, robot) = shipped("storeroom.toml");
    let noise = NoiseOptions {
        mixed_scale: 0.0,
        ..NoiseOptions::seeded(3)
    };
    let sampled = simulate_sweep(&world, &robot, &rows(), &noise);
    let fender = world
        .object_named("fender")
        .expect("an object of the scene");
    let centre = scene.map_from_base.inverse() * Point3::new(2.2, -1.6, 1.15);
    let mut seen = 0;
    for (point, object) in sampled.view.points.iter().zip(&sampled.objects) {
        if *object == fender {
            seen += 1;
            assert!(((point - centre).norm() - 0.25).abs() < 0.08, "{point}");
        }
    }
    assert!(seen > 50, "{seen}");
    assert_eq!(sampled.view.points.len(), sampled.objects.len());
}

#[test]
fn the_same_seed_gives_the_same_sweep_on_any_number_of_threads() {
    let (_, world, robot) = shipped("office.toml");
    let rows = SweepRows::evenly(-20.0, 20.0, 9);
    let sample =
        |rows: &SweepRows, seed| simulate_sweep(&world, &robot, rows, &NoiseOptions::seeded(seed));
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    let first = sample(&rows, 1);
    assert_eq!(one.install(|| sample(&rows, 1)), first);
    assert_ne!(sample(&rows, 2), first);
    assert_ne!(
        sample(&rows.clone().starting_at(Duration::from_secs(60)), 1),
        first
    );
}

#[test]
fn a_laser_measures_a_recorded_cloud_again() {
    let Some(path) = data("semisynthetic/dev/dev12_nochange_ref.ply") else {
        return;
    };
    let bytes = std::fs::read(path).expect("readable");
    let cloud = patrold_engine::formats::read_cloud(&bytes, Some("ply")).expect("a recorded cloud");
    let scene =
        Scene::parse("[robot]\nheight_m = 0\n[cloud]\nfile = 'room.ply'\n").expect("a scene");
    let world = scene.build(Some(&cloud.points)).expect("points");
    // A laser where the cloud was recorded measures the recorded ranges.
    let mut errors_m = Vec::new();
    for point in cloud
        .points
        .iter()
        .filter(|p| p.coords.norm() < 5.0)
        .step_by(50)
    {
        let ray = crate::world::Ray {
            origin: Point3::origin(),
            direction: nalgebra::Unit::new_normalize(point.coords),
        };
        let hit = world.cast(&ray, 10.0).map_or(f64::INFINITY, |h| h.range_m);
        errors_m.push((hit - point.coords.norm()).abs());
    }
    errors_m.sort_by(f64::total_cmp);
    assert!(errors_m.len() > 100);
    assert!(
        errors_m[errors_m.len() / 2] < 0.01,
        "median {}",
        errors_m[errors_m.len() / 2]
    );
    assert!(
        errors_m[errors_m.len() * 9 / 10] < 0.1,
        "90 % {}",
        errors_m[errors_m.len() * 9 / 10]
    );
}
