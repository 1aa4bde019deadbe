//! The rule that decides the effect of a visit on the alarms of its waypoint.

use super::incident::{Incident, Sighting};
use patrold_engine::novelty::Verdict;

/// A change of the alarm log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlarmDecision {
    /// Raise a new alarm: no standing alarm has this change.
    Raise,
    /// Add the visit to this alarm: it has all novelties of the visit.
    Extend(i64),
    /// Clear this alarm: its change is gone.
    Clear(i64),
}

/// Decides from the verdict of a visit, its novelties and the standing alarms of the waypoint.
///
/// A changed visit extends a standing alarm only if every novelty matches one of the alarm's (same kind, centres within
/// `same_place_m` metres), so that a second intruder is not hidden by the first. A quiet visit clears each standing alarm
/// of which it saw no novelty; a novelty too small to reach the threshold keeps its alarm. A visit that did not observe the
/// place changes nothing.
pub fn decide(
    verdict: Verdict,
    seen: &[Sighting],
    standing: &[Incident],
    same_place_m: f64,
) -> Vec<AlarmDecision> {
    match verdict {
        Verdict::NotObserved => Vec::new(),
        Verdict::Quiet => standing
            .iter()
            .filter(|incident| {
                !seen
                    .iter()
                    .any(|sighting| matches(incident, sighting, same_place_m))
            })
            .map(|incident| AlarmDecision::Clear(incident.id))
            .collect(),
        Verdict::Changed => {
            let matches_all = |incident: &&Incident| {
                seen.iter()
                    .all(|sighting| matches(incident, sighting, same_place_m))
            };
            let decision = standing
                .iter()
                .filter(matches_all)
                .max_by_key(|incident| incident.id)
                .map_or(AlarmDecision::Raise, |incident| {
                    AlarmDecision::Extend(incident.id)
                });
            vec![decision]
        }
    }
}

fn matches(incident: &Incident, sighting: &Sighting, same_place_m: f64) -> bool {
    incident.sightings.iter().any(|known| {
        known.kind == sighting.kind && (known.centre - sighting.centre).norm() <= same_place_m
    })
}

#[cfg(test)]
mod tests {
    use super::{AlarmDecision, Incident, Sighting, decide};
    use nalgebra::Point3;
    use patrold_engine::novelty::{NoveltyKind, Verdict};

    fn at(x: f64, kind: NoveltyKind) -> Sighting {
        let centre = Point3::new(x, 0.0, 0.0);
        Sighting { kind, centre }
    }

    fn incident(id: i64, sightings: &[Sighting]) -> Incident {
        let sightings = sightings.to_vec();
        Incident { id, sightings }
    }

    #[test]
    fn the_same_novelty_seen_again_is_one_alarm() {
        let standing = [incident(3, &[at(1.0, NoveltyKind::Appeared)])];
        let seen = [at(1.2, NoveltyKind::Appeared)];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [AlarmDecision::Extend(3)]);
    }

    #[test]
    fn a_second_novelty_is_a_second_alarm() {
        let standing = [incident(3, &[at(1.0, NoveltyKind::Appeared)])];
        let seen = [
            at(1.2, NoveltyKind::Appeared),
            at(4.0, NoveltyKind::Appeared),
        ];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [AlarmDecision::Raise]);
    }

    #[test]
    fn disappeared_does_not_match_appeared() {
        let standing = [incident(3, &[at(1.0, NoveltyKind::Appeared)])];
        let seen = [at(1.0, NoveltyKind::Disappeared)];
        let decisions = decide(Verdict::Changed, &seen, &standing, 0.5);
        assert_eq!(decisions, [AlarmDecision::Raise]);
    }

    #[test]
    fn quiet_keeps_an_alarm_whose_novelty_is_still_there() {
        let standing = [
            incident(
                3,
                &[
                    at(1.0, NoveltyKind::Appeared),
                    at(2.0, NoveltyKind::Appeared),
                ],
            ),
            incident(5, &[at(4.0, NoveltyKind::Appeared)]),
        ];
        let still_there = [at(2.1, NoveltyKind::Appeared)];
        let decisions = decide(Verdict::Quiet, &still_there, &standing, 0.5);
        assert_eq!(decisions, [AlarmDecision::Clear(5)]);
    }

    #[test]
    fn quiet_clears_all_and_not_observed_none() {
        let standing = [
            incident(3, &[at(1.0, NoveltyKind::Appeared)]),
            incident(5, &[at(4.0, NoveltyKind::Appeared)]),
        ];
        let cleared = decide(Verdict::Quiet, &[], &standing, 0.5);
        assert_eq!(cleared, [AlarmDecision::Clear(3), AlarmDecision::Clear(5)]);
        assert!(decide(Verdict::NotObserved, &[], &standing, 0.5).is_empty());
    }
}
