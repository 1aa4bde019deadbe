//! The rule: what a visit does to the alarms of its waypoint.

use super::incident::{Incident, Sighting};
use patrold_engine::novelty::Verdict;

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// A change that no standing alarm knows: raise a new one.
    Raise,
    /// Everything seen belongs to this alarm: note the visit under it.
    Fold(i64),
    /// The change of this alarm is gone.
    Clear(i64),
}

/// Decides from one visit's verdict, the things it saw and the alarms that stand at the waypoint.
///
/// A changed place folds into a standing alarm only if that alarm knows every single thing seen (same
/// kind, centre within `same_place_m` metres), so a second intruder is never hidden by the first.
/// A quiet place clears each standing alarm of which it shows nothing any more; one whose thing is still
/// there (found, but too small to reach the threshold) stands. A place that was not observed changes nothing.
pub fn decide(
    verdict: Verdict,
    seen: &[Sighting],
    standing: &[Incident],
    same_place_m: f64,
) -> Vec<Decision> {
    match verdict {
        Verdict::NotObserved => Vec::new(),
        Verdict::Quiet => standing
            .iter()
            .filter(|incident| {
                !seen
                    .iter()
                    .any(|thing| knows(incident, thing, same_place_m))
            })
            .map(|incident| Decision::Clear(incident.id))
            .collect(),
        Verdict::Changed => {
            let knows_all = |incident: &&Incident| {
                seen.iter()
                    .all(|thing| knows(incident, thing, same_place_m))
            };
            let decision = standing
                .iter()
                .filter(knows_all)
                .max_by_key(|incident| incident.id)
                .map_or(Decision::Raise, |incident| Decision::Fold(incident.id));
            vec![decision]
        }
    }
}

fn knows(incident: &Incident, thing: &Sighting, same_place_m: f64) -> bool {
    incident.sightings.iter().any(|known| {
        known.kind == thing.kind && (known.centre - thing.centre).norm() <= same_place_m
    })
}

#[cfg(test)]
mod tests {
    use super::{Decision, Incident, Sighting, decide};
    use nalgebra::Point3;
    use patrold_engine::novelty::{Kind, Verdict};

    fn at(x: f64, kind: Kind) -> Sighting {
        let centre = Point3::new(x, 0.0, 0.0);
        Sighting { kind, centre }
    }

    fn incident(id: i64, sightings: &[Sighting]) -> Incident {
        let sightings = sightings.to_vec();
        Incident { id, sightings }
    }

    #[test]
    fn the_same_thing_seen_again_is_one_alarm() {
        let standing = [incident(3, &[at(1.0, Kind::Appeared)])];
        let seen = [at(1.2, Kind::Appeared)];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [Decision::Fold(3)]);
    }

    #[test]
    fn a_second_thing_is_a_second_alarm() {
        let standing = [incident(3, &[at(1.0, Kind::Appeared)])];
        let seen = [at(1.2, Kind::Appeared), at(4.0, Kind::Appeared)];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [Decision::Raise]);
    }

    #[test]
    fn a_thing_gone_is_not_the_thing_that_came() {
        let standing = [incident(3, &[at(1.0, Kind::Appeared)])];
        let seen = [at(1.0, Kind::Disappeared)];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [Decision::Raise]);
    }

    #[test]
    fn quiet_keeps_an_alarm_whose_thing_is_still_there() {
        let standing = [
            incident(3, &[at(1.0, Kind::Appeared), at(2.0, Kind::Appeared)]),
            incident(5, &[at(4.0, Kind::Appeared)]),
        ];
        let still_there = [at(2.1, Kind::Appeared)];
        let decisions = decide(Verdict::Quiet, &still_there, &standing, 0.5);
        assert_eq!(decisions, [Decision::Clear(5)]);
    }

    #[test]
    fn quiet_clears_all_and_not_observed_none() {
        let standing = [
            incident(3, &[at(1.0, Kind::Appeared)]),
            incident(5, &[at(4.0, Kind::Appeared)]),
        ];
        let cleared = decide(Verdict::Quiet, &[], &standing, 0.5);
        assert_eq!(cleared, [Decision::Clear(3), Decision::Clear(5)]);
        assert!(decide(Verdict::NotObserved, &[], &standing, 0.5).is_empty());
    }
}
