//! Robots that err, heads that lose steps: how soon the history says so, and how often for nothing.

use super::{HomingReason, SeenTurn, TurnHistory};
use crate::patrol::constants::{MAX_ERRORS, MAX_VIEWS_SINCE_HOMING, MIN_HOMING_INTERVAL};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::time::Duration;

/// As shipped.
fn fresh() -> TurnHistory {
    TurnHistory::new(3_f64.to_radians(), 0.4_f64.to_radians())
}

fn seen(waypoint: &str, pan_deg: f64, tilt_deg: f64) -> SeenTurn {
    SeenTurn {
        waypoint: waypoint.to_owned(),
        frame_version: 1,
        pan_rad: pan_deg.to_radians(),
        tilt_rad: Some(tilt_deg.to_radians()),
    }
}

/// Before a round is over for long enough.
const EARLY: Duration = Duration::from_secs(1);

fn suspects(history: &TurnHistory) -> bool {
    matches!(
        history.reason_to_home(EARLY),
        Some(HomingReason::LostSteps(_))
    )
}

struct Robot {
    history: TurnHistory,
    errors: Normal<f64>,
    /// Of each waypoint's teaching.
    taught_deg: Vec<f64>,
    rng: ChaCha8Rng,
}

impl Robot {
    fn new(sd_deg: f64, waypoints: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let errors = Normal::new(0.0, sd_deg).expect("a spread");
        let mut history = fresh();
        history.homed(Duration::ZERO);
        Self {
            taught_deg: (0..waypoints).map(|_| errors.sample(&mut rng)).collect(),
            history,
            errors,
            rng,
        }
    }

    /// A visit with `lost_deg` of pan lost; whether the head would be homed for it.
    fn visit(&mut self, waypoint: usize, lost_deg: f64) -> bool {
        let turn_deg = self.errors.sample(&mut self.rng) + lost_deg - self.taught_deg[waypoint];
        let tilt_deg = self.rng.random_range(-0.03..0.03);
        self.history
            .observe(&seen(&format!("w{waypoint}"), turn_deg, tilt_deg));
        suspects(&self.history)
    }

    /// A round without losses, homed at its end; how often it was homed for nothing.
    fn round(&mut self) -> usize {
        let mut for_nothing = 0;
        for waypoint in 0..self.taught_deg.len() {
            if self.visit(waypoint, 0.0) {
                self.history.homed(Duration::ZERO);
                for_nothing += 1;
            }
        }
        self.history.homed(Duration::ZERO);
        for_nothing
    }
}

#[test]
fn a_loss_of_three_standard_deviations_is_found_within_three_visits() {
    for (sd_deg, waypoints) in [(0.6, 6), (2.0, 3), (2.0, 12)] {
        let (mut found, mut for_nothing) = (0, 0);
        for seed in 0..200 {
            let mut robot = Robot::new(sd_deg, waypoints, seed);
            for round in 0..40 {
                let homed = robot.round();
                // The first rounds are there to learn from.
                for_nothing += if round < 10 { 0 } else { homed };
            }
            let first = robot.rng.random_range(0..waypoints);
            let lost_deg = 3.0 * sd_deg;
            let at_once = (0..3).any(|i| robot.visit((first + i) % waypoints, lost_deg));
            found += usize::from(at_once);
        }
        let per_visit = for_nothing as f64 / (200 * 30 * waypoints) as f64;
        eprintln!(
            "sd {sd_deg} deg, {waypoints} waypoints: {found} of 200 found, {per_visit:.4} of visits homed for nothing"
        );
        assert!(found >= 190, "sd {sd_deg}, {waypoints}: {found}");
        assert!(per_visit < 0.02, "sd {sd_deg}, {waypoints}: {per_visit}");
    }
}

#[test]
fn the_spread_of_the_robot_is_learned_whatever_was_expected() {
    for sd_deg in [0.2, 1.0, 5.0] {
        let mut robot = Robot::new(sd_deg, 5, 3);
        for _ in 0..MAX_ERRORS {
            robot.round();
        }
        let learned_deg = robot.history.pan.variance().sqrt().to_degrees();
        assert!(
            (learned_deg / sd_deg - 1.0).abs() < 0.2,
            "{sd_deg}: {learned_deg}"
        );
    }
}

#[test]
fn half_a_degree_of_tilt_is_found_within_three_visits_of_a_new_robot() {
    for waypoints in [1, 3] {
        let mut history = fresh();
        history.homed(Duration::ZERO);
        let first = (1..=3).find(|visit| {
            history.observe(&seen(&format!("w{}", visit % waypoints), 0.0, 0.5));
            suspects(&history)
        });
        assert!(first.is_some(), "{waypoints} waypoints");
    }
    let mut history = fresh();
    history.observe(&seen("hall", 0.0, 0.5));
    assert!(!suspects(&history), "one view alone may be the floor");
}

#[test]
fn several_pans_say_nothing_of_tilt() {
    let mut history = fresh();
    for _ in 0..8 {
        history.observe(&SeenTurn {
            tilt_rad: None,
            ..seen("hall", 0.0, 0.0)
        });
    }
    assert_eq!(history.tilt.open.len(), 0);
    assert_eq!(history.pan.open.len(), 8);
}

/// A turned reference, a door that leans, a map that was drawn again: the robot stops there turned from now on.
#[test]
fn a_turn_that_stays_after_homing_is_the_robots() {
    let mut robot = Robot::new(0.5, 4, 5);
    for _ in 0..20 {
        robot.round();
    }
    robot.taught_deg[2] -= 6.0;
    let homed: usize = (0..30).map(|_| robot.round()).sum();
    let later: usize = (0..30).map(|_| robot.round()).sum();
    assert!((1..=15).contains(&homed), "{homed}");
    assert!(later <= 2, "{later}");
}

#[test]
fn a_loss_is_not_learned_as_the_robots() {
    let mut robot = Robot::new(0.5, 4, 6);
    for _ in 0..20 {
        robot.round();
    }
    let before = robot.history.pan.variance();
    for _ in 0..40 {
        while !robot.visit(1, 4.0) {}
        robot.history.homed(Duration::ZERO);
        robot.round();
    }
    let after = robot.history.pan.variance();
    assert!(after < 1.5 * before, "{before} {after}");
}

#[test]
fn a_new_reference_begins_anew() {
    let mut history = fresh();
    for _ in 0..4 {
        history.observe(&seen("hall", 2.0, 0.0));
        history.observe(&seen("store", 0.1, 0.0));
    }
    history.observe(&SeenTurn {
        frame_version: 2,
        ..seen("hall", 0.2, 0.0)
    });
    let of_hall = |(name, _): &&(String, f64)| name == "hall";
    assert_eq!(history.pan.open.iter().filter(of_hall).count(), 1);
    assert_eq!(history.pan.open.len(), 5, "the other waypoint's stay");
}

#[test]
fn a_round_is_over_where_a_waypoint_comes_again() {
    let later = MIN_HOMING_INTERVAL;
    let mut history = fresh();
    history.observe(&seen("hall", 0.0, 0.0));
    history.observe(&seen("hall", 0.0, 0.0));
    assert_eq!(history.reason_to_home(later), None, "used as it was found");
    history.homed(Duration::ZERO);
    history.observe(&seen("hall", 0.0, 0.0));
    history.observe(&seen("store", 0.0, 0.0));
    assert_eq!(history.reason_to_home(later), None);
    history.observe(&seen("hall", 0.0, 0.0));
    assert_eq!(history.reason_to_home(later), Some(HomingReason::RoundOver));
    let just_before = later - Duration::from_millis(1);
    assert_eq!(history.reason_to_home(just_before), None);
    history.homed(later);
    assert_eq!(history.reason_to_home(2 * later), None);
    history.observe(&seen("hall", 0.0, 0.0));
    assert_eq!(history.reason_to_home(2 * later), None);
}

#[test]
fn memory_does_not_grow() {
    let mut history = fresh();
    for i in 0..3000 {
        history.observe(&seen(["hall", "store"][i % 2], 0.01 * (i % 7) as f64, 0.0));
    }
    assert_eq!(history.pan.open.len(), MAX_VIEWS_SINCE_HOMING);
    assert_eq!(history.pan.squares.len(), MAX_ERRORS);
}

#[test]
fn what_is_suspect_can_be_changed() {
    let mut history = fresh();
    history.observe(&seen("hall", 3.0, 0.0));
    assert!(!suspects(&history));
    history.suspect(1_f64.to_radians(), 0.4_f64.to_radians());
    assert!(suspects(&history));
}
