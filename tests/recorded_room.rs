//! A recorded cloud as the simulated world, swept by the simulated laser, without and with a box in it. Needs the recorded
//! data (`PATROLD_DATA`).
#![allow(clippy::print_stdout, reason = "it prints a table")]

use patrold_engine::inspect::{EngineSettings, Inspection, inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_sim::world::{
    MountGeometry, NoiseOptions, Pose2d, Scene, SimulatedRobot, SweepRows, simulate_sweep,
};
use std::time::Duration;

/// The recorded corridor. Its sensor is at the origin of the cloud, 0.38 m above the floor.
const CORRIDOR_SCENE: &str = r#"
[robot]
at = [0.0, 0.0]
height_m = 0.2

[cloud]
file = "room.ply"
at = [0.0, 0.0, 0.3814]
"#;

/// As in the pair `dev04`.
const BOX_OBJECT: &str = r#"
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
    cloud: &[nalgebra::Point3<f64>],
) -> Inspection {
    let settings = EngineSettings::standard();
    let sweep = |scene: &Scene, error: [f64; 3], seed: u64| {
        let world = scene.build(Some(cloud)).expect("builds");
        let mut robot = SimulatedRobot {
            map_from_base: scene.map_from_base,
            mount: MountGeometry::default(),
        };
        robot.drive_to(Pose2d {
            x_m: error[0],
            y_m: error[1],
            yaw_rad: error[2].to_radians(),
        });
        let rows = SweepRows::evenly(-35.0, 25.0, 120).starting_at(Duration::from_secs(100 * seed));
        simulate_sweep(&world, &robot, &rows, &NoiseOptions::seeded(seed)).view
    };
    let reference = prepare(&sweep(before, [0.0; 3], 2 * seed), &settings, 7).expect("prepares");
    let current = sweep(after, error, 2 * seed + 1);
    inspect(&reference, &current, &settings, 7, &mut |_| {}).expect("inspects")
}

#[test]
fn a_recorded_corridor_gives_the_right_verdicts() {
    let Some(folder) = patrold_test_support::data("semisynthetic/dev") else {
        return;
    };
    let bytes = std::fs::read(folder.join("dev04_box_ref.ply")).expect("a reference cloud");
    let cloud = patrold_engine::formats::read_cloud(&bytes, Some("ply")).expect("reads");
    let before = Scene::parse(CORRIDOR_SCENE).expect("a scene");
    let after = Scene::parse(&format!("{CORRIDOR_SCENE}{BOX_OBJECT}")).expect("a scene");
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
