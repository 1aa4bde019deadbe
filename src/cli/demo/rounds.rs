//! The three rounds: teach, quiet, changed.

use super::building::{DemoWaypoint, build_world, robot_pose};
use super::system::DemoSystem;
use crate::cli::failure::Failure;
use crate::service::replies::{TeachReply, VisitReply};
use serde_json::json;

/// Attempts at a waypoint while the answer is `not_observed` or the reference is refused; time runs slower after each, as a slow
/// machine is the usual reason.
const MAX_ATTEMPTS: usize = 4;

/// Runs all rounds. Returns the visits of the quiet round, which the alarm log does not have.
pub(super) fn run_rounds(
    system: &mut DemoSystem,
    waypoints: &[DemoWaypoint],
    seed: u64,
    print: &dyn Fn(&str) -> Result<(), Failure>,
) -> Result<Vec<VisitReply>, Failure> {
    print("\nteaching")?;
    for waypoint in waypoints {
        let reply = teach(system, waypoint)?;
        print(&format!(
            "  {}: reference of {} points, {} components",
            reply.waypoint, reply.points, reply.components
        ))?;
    }
    print("\nquiet round")?;
    let quiet_visits = visit_all(system, waypoints, VisitRound::Quiet, seed, print)?;
    print("\nchanged round")?;
    visit_all(system, waypoints, VisitRound::Changed, seed, print)?;
    Ok(quiet_visits)
}

#[derive(Clone, Copy, PartialEq)]
enum VisitRound {
    Quiet,
    Changed,
}

fn teach(system: &mut DemoSystem, waypoint: &DemoWaypoint) -> Result<TeachReply, Failure> {
    let world = build_world(&waypoint.before)?;
    system.set_scene(world, robot_pose(&waypoint.before, None))?;
    let mut reply = system.request("/teach", waypoint.name, json!({"new": true}));
    for attempt in 2..=MAX_ATTEMPTS {
        let Err(why) = &reply else {
            break;
        };
        system.slow_down(&again(waypoint.name, &why.to_string(), attempt));
        reply = system.request("/teach", waypoint.name, json!({"new": true}));
    }
    reply
}

fn visit_all(
    system: &mut DemoSystem,
    waypoints: &[DemoWaypoint],
    round: VisitRound,
    seed: u64,
    print: &dyn Fn(&str) -> Result<(), Failure>,
) -> Result<Vec<VisitReply>, Failure> {
    let mut visits = Vec::new();
    for (index, waypoint) in waypoints.iter().enumerate() {
        let (scene, change) = match round {
            VisitRound::Quiet => (&waypoint.before, ""),
            VisitRound::Changed => (&waypoint.after, waypoint.change),
        };
        let visit_seed =
            seed.wrapping_mul(1000) + 10 * index as u64 + u64::from(round == VisitRound::Changed);
        system.set_scene(build_world(scene)?, robot_pose(scene, Some(visit_seed)))?;
        let visit = visit(system, waypoint.name)?;
        let d_gmm = visit
            .d_gmm
            .map_or_else(|| "-".to_owned(), |d| format!("{d:.5} m"));
        let note = if visit.verdict == "not_observed" {
            visit.reason.as_str()
        } else {
            change
        };
        print(&format!(
            "  {:<12} {:<12} d_GMM {d_gmm:<11} {note}",
            visit.waypoint, visit.verdict
        ))?;
        visits.push(visit);
    }
    Ok(visits)
}

fn again(waypoint: &str, why: &str, attempt: usize) -> String {
    format!("{waypoint}: {why}; attempt {attempt} of {MAX_ATTEMPTS}")
}

fn visit(system: &mut DemoSystem, waypoint: &str) -> Result<VisitReply, Failure> {
    let mut visit: VisitReply = system.request("/visit", waypoint, json!({}))?;
    for attempt in 2..=MAX_ATTEMPTS {
        if visit.verdict != "not_observed" {
            break;
        }
        let why = format!("not observed: {}", visit.reason);
        system.slow_down(&again(waypoint, &why, attempt));
        visit = system.request("/visit", waypoint, json!({}))?;
    }
    Ok(visit)
}
