//! The rule that decides what a visit is to each incident of its waypoint.

use super::assignment::assign;
use super::incident::{AlarmState, Incident, Relation};
use super::likeness::{Likeness, likeness};
use super::sighting::Sighting;
use patrold_engine::novelty::{NoveltyKind, PlaceView, Verdict};

/// What a visit saw.
#[derive(Debug, Clone, Copy)]
pub struct VisitFacts<'a> {
    /// Its verdict.
    pub verdict: Verdict,
    /// Its novelties.
    pub seen: &'a [Sighting],
    /// How it saw the places of incidents, by number; one that is not named was hidden.
    pub places: &'a [(i64, PlaceView)],
    /// A thing that is further from where it was has moved, however uncertain the places, metres.
    pub same_place_m: f64,
}

/// A change of the alarm log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlarmDecision {
    /// A new incident for this sighting.
    Raise {
        /// Its position among the visit's novelties.
        sighting: usize,
    },
    /// This incident is that sighting: seen, moved, changed or back.
    Continue {
        /// Number of the alarm.
        incident: i64,
        /// Position of the sighting among the visit's novelties.
        sighting: usize,
        /// What became of the thing.
        relation: Relation,
        /// How far it is from where it was, metres.
        distance_m: f64,
    },
    /// Its place was seen without it.
    Clear {
        /// Number of the alarm.
        incident: i64,
    },
    /// Its place could not be seen: neither seen nor cleared.
    NotObserved {
        /// Number of the alarm.
        incident: i64,
    },
}

/// Decides from a visit and the incidents of its waypoint.
///
/// Every sighting is at most one incident, and every incident at most one sighting: the pairs that are most likely as a whole.
/// A sighting of none of them is raised if the visit's verdict is `changed`. An incident without a sighting is cleared if its
/// place was seen as in the reference, or with another thing in it. A visit that did not observe the place decides nothing.
pub fn decide(visit: &VisitFacts<'_>, incidents: &[Incident]) -> Vec<AlarmDecision> {
    let is_standing = |incident: &Incident| incident.state != AlarmState::Cleared;
    if visit.verdict == Verdict::NotObserved {
        let standing = incidents.iter().filter(|i| is_standing(i));
        return standing
            .map(|incident| AlarmDecision::NotObserved {
                incident: incident.id,
            })
            .collect();
    }
    let place = |incident: &Incident| {
        let named = visit.places.iter().find(|(id, _)| *id == incident.id);
        named.map_or(PlaceView::Hidden, |(_, view)| *view)
    };
    let is_taken = |incident: &Incident, but: Option<usize>| {
        let others = visit.seen.iter().enumerate();
        let mut others = others.filter(|(k, _)| Some(*k) != but);
        others.any(|(_, seen)| fills_its_place(seen, incident))
    };
    let pairs: Vec<Vec<Option<Likeness>>> = visit
        .seen
        .iter()
        .enumerate()
        .map(|(k, seen)| {
            let of = |incident| {
                // Another thing hides its place by standing in it.
                let view = match place(incident) {
                    PlaceView::Hidden if is_taken(incident, Some(k)) => PlaceView::Otherwise,
                    view => view,
                };
                likeness(incident, view, seen, visit.same_place_m)
            };
            // Below the threshold nothing is raised, nor raised again.
            let raises = |l: &Likeness| l.relation == Relation::Back;
            let allowed = |l: &Likeness| visit.verdict == Verdict::Changed || !raises(l);
            incidents.iter().map(|i| of(i).filter(allowed)).collect()
        })
        .collect();
    let gains: Vec<Vec<f64>> = pairs
        .iter()
        .map(|row| row.iter().map(|l| l.map_or(0.0, |l| l.gain)).collect())
        .collect();
    let assigned = assign(&gains, incidents.len());

    let mut decisions = Vec::new();
    for sighting in 0..visit.seen.len() {
        let partner = assigned.iter().find(|(row, _)| *row == sighting);
        let likeness = partner.and_then(|(row, column)| pairs[*row][*column].map(|l| (*column, l)));
        match likeness {
            Some((column, likeness)) => decisions.push(AlarmDecision::Continue {
                incident: incidents[column].id,
                sighting,
                relation: likeness.relation,
                distance_m: likeness.distance_m,
            }),
            None if visit.verdict == Verdict::Changed => {
                decisions.push(AlarmDecision::Raise { sighting });
            }
            None => {}
        }
    }
    for (column, incident) in incidents.iter().enumerate() {
        if !is_standing(incident) || assigned.iter().any(|(_, taken)| *taken == column) {
            continue;
        }
        let incident_id = incident.id;
        let is_replaced = || {
            visit
                .seen
                .iter()
                .any(|seen| is_in_its_place(seen, incident))
        };
        match place(incident) {
            PlaceView::Hidden if !is_taken(incident, None) => {
                decisions.push(AlarmDecision::NotObserved {
                    incident: incident_id,
                });
            }
            PlaceView::Otherwise if !is_replaced() => {}
            PlaceView::AsTaught | PlaceView::Otherwise | PlaceView::Hidden => {
                decisions.push(AlarmDecision::Clear {
                    incident: incident_id,
                });
            }
        }
    }
    decisions
}

/// Whether a sighting that is not the incident's thing stands so closely in its place that both cannot be there; what merely
/// stands before it is further off.
fn fills_its_place(seen: &Sighting, incident: &Incident) -> bool {
    let anchor = &incident.anchor;
    let reach_m = 0.5 * seen.widths.m[1].min(anchor.widths.m[1]);
    seen.kind == NoveltyKind::Appeared
        && anchor.kind == NoveltyKind::Appeared
        && (seen.centre - anchor.centre).xy().norm() <= reach_m
}

/// Whether a sighting that is not the incident's thing overlaps its place, so that the thing cannot be there.
fn is_in_its_place(seen: &Sighting, incident: &Incident) -> bool {
    let anchor = &incident.anchor;
    let reach_m = 0.5 * (seen.widths.m[1] + anchor.widths.m[1]);
    seen.kind == NoveltyKind::Appeared
        && anchor.kind == NoveltyKind::Appeared
        && (seen.centre - anchor.centre).xy().norm() <= reach_m
}

#[cfg(test)]
mod tests;
