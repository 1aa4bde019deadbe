//! Rounds of a robot that stops askew, whose head loses steps now and then, beside the same rounds of a head that loses none.

use super::virtual_patrol::{TaughtReference, VirtualPatrol, displaced_pose, settings, world};
use patrold_engine::novelty::Verdict;
use patrold_sim::emulator::EmulationOptions;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::time::Duration;

/// Stands in the storeroom: metres forward and left, degrees to the left.
const WAYPOINTS: [(&str, (f64, f64, f64)); 3] = [
    ("door", (0.0, 0.0, 0.0)),
    ("shelf", (0.25, 0.2, 15.0)),
    ("corner", (0.1, -0.2, -20.0)),
];

/// Standard deviation of the robot's heading where it stops, degrees, and of its place, metres.
const HEADING_SD_DEG: f64 = 2.0;
const PLACE_SD_M: f64 = 0.02;

/// Share of visits before which steps are lost.
const LOSSES: f64 = 0.1;

#[derive(Debug, Default)]
struct Figures {
    visits: usize,
    losses: usize,
    extra_sweeps: usize,
    homings: u64,
    /// Not observed, unlike the same place without lost steps: the head ran into its limit.
    not_observed: usize,
    /// Alarms and quiets that the same place without lost steps did not give.
    differing: Vec<String>,
    /// Of the rounds without losses: false alarms, changes missed.
    wrong_without_losses: usize,
}

fn taught(waypoint: &str, stand: (f64, f64, f64)) -> TaughtReference {
    let options = EmulationOptions::seeded(1);
    let mut patrol = VirtualPatrol::new(settings(), options, "storeroom.toml");
    patrol.stand_at(waypoint);
    patrol
        .devices
        .with_emulation(|e| e.drive_to(displaced_pose("storeroom.toml", stand)));
    patrol.teach();
    patrol.reference().expect("taught")
}

fn run_rounds(rounds: usize, seed: u64, figures: &mut Figures) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let heading = Normal::new(0.0, HEADING_SD_DEG).expect("a spread");
    let place = Normal::new(0.0, PLACE_SD_M).expect("a spread");
    let references = WAYPOINTS.map(|(name, stand)| (name, taught(name, stand)));
    // One whose head loses steps, and one whose does not.
    let mut patrols = [0, 1].map(|_| {
        let mut patrol = VirtualPatrol::with_reference(&references[0].1, 50 + seed);
        for (name, taught) in &references {
            patrol.know(name, taught);
        }
        patrol
    });
    let homings = patrols[0].homings;
    for _ in 0..rounds {
        for (name, (x_m, y_m, yaw_deg)) in WAYPOINTS {
            let scene =
                ["storeroom.toml", "storeroom-box-left.toml"][usize::from(rng.random_bool(0.2))];
            let off = [
                place.sample(&mut rng),
                place.sample(&mut rng),
                heading.sample(&mut rng),
            ];
            let pose = displaced_pose(
                "storeroom.toml",
                (x_m + off[0], y_m + off[1], yaw_deg + off[2]),
            );
            let loss = rng.random_bool(LOSSES).then(|| {
                let axis = ["pan", "tilt"][usize::from(rng.random_bool(0.5))];
                let sign = [-1, 1][usize::from(rng.random_bool(0.5))];
                // A quarter of a degree to eight, in counts of 0.0514 deg.
                (axis, sign * rng.random_range(5..=156))
            });
            if let Some((axis, steps)) = loss {
                patrols[0].inject(&format!("ptu.lost-steps:axis={axis},steps={steps}"));
                figures.losses += 1;
            }
            let verdicts = [0, 1].map(|i| {
                let patrol = &mut patrols[i];
                patrol.stand_at(name);
                patrol.devices.with_emulation(|e| {
                    e.set_world(world(scene));
                    e.drive_to(pose);
                });
                let before = patrol.sweep_count;
                let result = patrol.visit();
                if i == 0 {
                    figures.extra_sweeps += patrol.sweep_count - before - 1;
                }
                // The way to the next waypoint.
                patrol.idle(Duration::from_secs(40));
                result
            });
            figures.visits += 1;
            let expected = if scene == "storeroom.toml" {
                Verdict::Quiet
            } else {
                Verdict::Changed
            };
            figures.wrong_without_losses += usize::from(verdicts[1].verdict != expected);
            if verdicts[0].verdict == verdicts[1].verdict {
                continue;
            }
            if verdicts[0].verdict == Verdict::NotObserved {
                figures.not_observed += 1;
            } else {
                figures
                    .differing
                    .push(format!("{name} {scene} {off:?} {loss:?}: {verdicts:?}"));
            }
        }
    }
    figures.homings += patrols[0].homings - homings;
}

fn check(rounds: usize, seeds: std::ops::Range<u64>) {
    let mut figures = Figures::default();
    for seed in seeds {
        run_rounds(rounds, seed, &mut figures);
    }
    eprintln!("{figures:#?}");
    assert!(50 * figures.extra_sweeps <= figures.visits, "more than 2 %");
    assert!(figures.differing.is_empty());
}

#[test]
fn a_robot_that_stops_askew_needs_no_second_sweep() {
    check(6, 1..2);
}

#[test]
#[ignore = "an hour; as above"]
fn a_robot_that_stops_askew_needs_no_second_sweep_in_1_000_rounds() {
    check(100, 1..11);
}
