//! The three rounds: teach, quiet, changed.

use super::building::{Place, stand, world};
use super::stage::Stage;
use crate::cli::failure::Failure;
use crate::service::replies::{TeachReply, VisitReply};

/// A visit that was not observed is made again so often, as a patrol would; the clock runs slower each time.
const TRIES: usize = 4;

/// What the rounds saw that the log does not tell, in the order of the places.
pub struct Rounds {
    /// Nothing had changed.
    pub quiet: Vec<VisitReply>,
}

/// Makes all rounds.
///
/// # Errors
/// The service refuses something.
pub fn all(
    stage: &mut Stage,
    places: &[Place],
    seed: u64,
    say: &dyn Fn(&str) -> Result<(), Failure>,
) -> Result<Rounds, Failure> {
    say("\nteaching")?;
    for place in places {
        let taught = teach(stage, place)?;
        say(&format!(
            "  {}: reference of {} points, {} components",
            taught.waypoint, taught.points, taught.components
        ))?;
    }
    say("\nquiet round")?;
    let quiet = round(stage, places, Round::Quiet, seed, say)?;
    say("\nchanged round")?;
    round(stage, places, Round::Changed, seed, say)?;
    Ok(Rounds { quiet })
}

#[derive(Clone, Copy, PartialEq)]
enum Round {
    Quiet,
    Changed,
}

fn teach(stage: &mut Stage, place: &Place) -> Result<TeachReply, Failure> {
    stage.arrange(world(&place.before)?, stand(&place.before, None))?;
    let mut tried = stage.ask("/teach", place.waypoint);
    for _ in 1..TRIES {
        if tried.is_ok() {
            break;
        }
        stage.slow_down();
        tried = stage.ask("/teach", place.waypoint);
    }
    tried
}

fn round(
    stage: &mut Stage,
    places: &[Place],
    round: Round,
    seed: u64,
    say: &dyn Fn(&str) -> Result<(), Failure>,
) -> Result<Vec<VisitReply>, Failure> {
    let mut visits = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let (scene, story) = match round {
            Round::Quiet => (&place.before, ""),
            Round::Changed => (&place.after, place.story),
        };
        let visit_seed =
            seed.wrapping_mul(1000) + 10 * index as u64 + u64::from(round == Round::Changed);
        stage.arrange(world(scene)?, stand(scene, Some(visit_seed)))?;
        let visit = visit(stage, place.waypoint)?;
        let d_gmm = visit
            .d_gmm
            .map_or_else(|| "-".to_owned(), |d| format!("{d:.5} m"));
        let because = if visit.verdict == "not_observed" {
            visit.reason.as_str()
        } else {
            story
        };
        say(&format!(
            "  {:<12} {:<12} d_GMM {d_gmm:<11} {because}",
            visit.waypoint, visit.verdict
        ))?;
        visits.push(visit);
    }
    Ok(visits)
}

fn visit(stage: &mut Stage, waypoint: &str) -> Result<VisitReply, Failure> {
    let mut visit: VisitReply = stage.ask("/visit", waypoint)?;
    for _ in 1..TRIES {
        if visit.verdict != "not_observed" {
            break;
        }
        stage.slow_down();
        visit = stage.ask("/visit", waypoint)?;
    }
    Ok(visit)
}
