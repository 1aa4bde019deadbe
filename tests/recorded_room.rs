//! A place that somebody really scanned, as the world: its cloud is the room, swept by the simulated laser, and an
//! object of the same recordings is placed in it. Needs the recorded data (`PATROLD_DATA`).
#![allow(
    clippy::print_stdout,
    reason = "the table that it prints is its report"
)]

use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Robot, Scene, Stand, SweepRows, sample_view,
};
use std::time::Duration;

/// The recorded corridor: sensor at the origin of the cloud, floor 0.38 m below it, so the base of the pan-tilt
/// stands where the cloud's floor would be.
const ROOM: &str = r#"
[robot]
at = [0.0, 0.0]
height_m = 0.2

[cloud]
file = "room.ply"
at = [0.0, 0.0, 0.3814]
"#;

/// The box of the pair `dev04`.
const BOX: &str = r#"
[[box]]
name = "box"
centre = [2.9, 0.3, 0.25]
size = [0.4, 0.3, 0.5]
yaw_deg = 26
"#;

fn inspection(
    before: &Scene,
    after: &Scene,
    error: [f64; 3],
    seed: u64,
    room: &[nalgebra::Point3<f64>],
) -> Inspection {
    let settings = EngineSettings::standard();
    let sweep = |scene: &Scene, error: [f64; 3], seed: u64| {
        let world = scene.build(Some(room)).expect("builds");
        let mut robot = Robot {
            pose: scene.map_from_base,
            mount: MountGeometry::default(),
        };
        robot.drive_to(Stand {
            x_m: error[0],
            y_m: error[1],
            yaw_rad: error[2].to_radians(),
        });
        let rows = SweepRows::evenly(-35.0, 25.0, 120).starting_at(Duration::from_secs(100 * seed));
        sample_view(&world, &robot, &rows, &NoiseOptions::seeded(seed)).view
    };
    let reference = prepare(&sweep(before, [0.0; 3], 2 * seed), &settings, 7).expect("prepares");
    let current = sweep(after, error, 2 * seed + 1);
    inspect(&reference, &current, &settings, 7, &mut |_| {}).expect("inspects")
}

#[test]
fn a_recorded_corridor_is_patrolled() {
    let Some(folder) = patrold_test_support::data("semisynthetic/dev") else {
        return;
    };
    let bytes = std::fs::read(folder.join("dev04_box_ref.ply")).expect("a reference cloud");
    let cloud = patrold_engine::formats::read_cloud(&bytes, Some("ply")).expect("reads");
    let before = Scene::parse(ROOM).expect("a scene");
    let after = Scene::parse(&format!("{ROOM}{BOX}")).expect("a scene");
    for (i, error) in [[0.0, 0.0, 0.0], [0.03, -0.03, 1.0], [-0.05, 0.04, -2.0]]
        .into_iter()
        .enumerate()
    {
        let seed = 40 + i as u64;
        let quiet = inspection(&before, &before, error, seed, &cloud.points).detection;
        println!(
            "quiet {error:?}: {:?} d {:.5} {}",
            quiet.verdict, quiet.d_gmm, quiet.reason
        );
        assert_eq!(quiet.verdict, Verdict::Quiet, "{}", quiet.reason);

        let changed = inspection(&before, &after, error, seed + 10, &cloud.points).detection;
        println!(
            "changed {error:?}: {:?} d {:.5} {}",
            changed.verdict, changed.d_gmm, changed.reason
        );
        for n in &changed.novelties {
            println!(
                "    {:?} {} points at {:?}",
                n.kind,
                n.points.len(),
                n.moments.mean
            );
        }
        assert_eq!(changed.verdict, Verdict::Changed, "{}", changed.reason);
        assert_eq!(changed.novelties.len(), 1);
    }
}
