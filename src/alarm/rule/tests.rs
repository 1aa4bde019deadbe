//! The rule on single visits: each limit on both sides.

use super::{AlarmDecision, VisitFacts, decide, fills_its_place, is_in_its_place};
use crate::alarm::{AlarmState, Incident, Lengths, Relation, Sighting};
use nalgebra::{Matrix3, Point3};
use patrold_engine::novelty::{NoveltyKind, PlaceView, Verdict};

const SD_M: f64 = 0.02;

fn lengths(m: [f64; 3]) -> Lengths {
    let sd_m = [SD_M; 3];
    Lengths { m, sd_m }
}

/// A box of 0.5 x 0.4 x 0.3 m.
fn thing(x: f64) -> Sighting {
    sized(x, [0.5, 0.4, 0.3])
}

fn sized(x: f64, m: [f64; 3]) -> Sighting {
    let mut classes = [0.0; 6];
    classes[3] = 1.0;
    Sighting {
        kind: NoveltyKind::Appeared,
        centre: Point3::new(x, 0.0, 0.0),
        centre_sd_m: [SD_M; 3],
        spread: Matrix3::from_diagonal(&m.map(|w| w * w / 12.0).into()),
        widths: lengths(m),
        body: Some(lengths(m)),
        classes,
    }
}

fn incident(id: i64, state: AlarmState, anchor: Sighting) -> Incident {
    Incident { id, state, anchor }
}

fn decisions(
    verdict: Verdict,
    seen: &[Sighting],
    places: &[(i64, PlaceView)],
    incidents: &[Incident],
) -> Vec<AlarmDecision> {
    let facts = VisitFacts {
        verdict,
        seen,
        places,
        same_place_m: 0.5,
    };
    decide(&facts, incidents)
}

/// What a changed visit that sees only `seen` is to one incident, whose place it sees as `place`: the relation, and whether it
/// raised and cleared.
fn relation(
    state: AlarmState,
    anchor: Sighting,
    seen: Sighting,
    place: PlaceView,
) -> (Option<Relation>, bool, bool) {
    let decided = decisions(
        Verdict::Changed,
        &[seen],
        &[(3, place)],
        &[incident(3, state, anchor)],
    );
    let relation = decided.iter().find_map(|d| match d {
        AlarmDecision::Continue { relation, .. } => Some(*relation),
        _ => None,
    });
    let raised = decided.contains(&AlarmDecision::Raise { sighting: 0 });
    let cleared = decided.contains(&AlarmDecision::Clear { incident: 3 });
    (relation, raised, cleared)
}

use AlarmState::{Acknowledged, Cleared, Open};
use PlaceView::{AsTaught, Hidden, Otherwise};

#[test]
fn a_thing_is_seen_again_up_to_its_uncertainty_and_moved_beyond() {
    // Chi-square 16.27 of one axis: 4.03 standard deviations of both.
    let limit = 16.27_f64.sqrt() * SD_M * 2.0_f64.sqrt();
    for (off, expected) in [
        (0.0, Relation::Seen),
        (0.99 * limit, Relation::Seen),
        (1.01 * limit, Relation::Moved),
        (3.0, Relation::Moved),
    ] {
        let got = relation(Open, thing(1.0), thing(1.0 + off), AsTaught);
        assert_eq!(got, (Some(expected), false, false), "{off}");
    }
}

#[test]
fn a_thing_is_not_in_its_place_beyond_same_place_m_however_uncertain() {
    let uncertain = |x| Sighting {
        centre_sd_m: [1.0; 3],
        ..thing(x)
    };
    for (off, expected) in [(0.49, Relation::Seen), (0.51, Relation::Moved)] {
        let got = relation(Open, uncertain(0.0), uncertain(off), Otherwise).0;
        assert_eq!(got, Some(expected), "{off}");
    }
}

#[test]
fn another_thing_in_its_place_is_raised_and_the_first_is_gone() {
    let crouching = sized(1.02, [0.97, 0.3, 0.25]);
    for state in [Open, Acknowledged] {
        let got = relation(state, thing(1.0), crouching, Otherwise);
        assert_eq!(got, (None, true, true), "{state}");
    }
}

#[test]
fn in_doubt_an_open_incident_goes_on_and_an_acknowledged_one_does_not() {
    // Chi-square of six sizes: 0.07 m are 2.5 standard deviations of each, 36.8 of the widths and bodies.
    let grown = sized(1.0, [0.57, 0.47, 0.37]);
    let got = relation(Open, thing(1.0), grown, Otherwise);
    assert_eq!(got, (Some(Relation::Changed), false, false));
    let got = relation(Acknowledged, thing(1.0), grown, Otherwise);
    assert_eq!(got, (None, true, true));
    let got = relation(Cleared, thing(1.0), grown, Otherwise);
    assert_eq!(got, (None, true, false));
    // Within the limit of nine figures, 27.88.
    let alike = sized(1.0, [0.555, 0.455, 0.355]);
    let got = relation(Acknowledged, thing(1.0), alike, Otherwise);
    assert_eq!(got, (Some(Relation::Seen), false, false));
}

#[test]
fn another_class_counts_against_it() {
    let mut ball = sized(1.0, [0.558, 0.458, 0.358]);
    let got = relation(Acknowledged, thing(1.0), ball, Otherwise).0;
    assert_eq!(got, Some(Relation::Seen));
    ball.classes = [0.0; 6];
    ball.classes[0] = 1.0;
    let got = relation(Acknowledged, thing(1.0), ball, Otherwise);
    assert_eq!(got, (None, true, true));
}

#[test]
fn appeared_is_never_disappeared() {
    let missing = Sighting {
        kind: NoveltyKind::Disappeared,
        ..thing(1.0)
    };
    assert_eq!(
        relation(Open, thing(1.0), missing, Hidden),
        (None, true, false)
    );
}

#[test]
fn what_may_still_stand_where_nobody_could_look_has_not_moved() {
    let got = relation(Open, thing(1.0), thing(3.0), Hidden);
    assert_eq!(got, (None, true, false));
    let got = relation(Open, thing(1.0), thing(3.0), AsTaught);
    assert_eq!(got, (Some(Relation::Moved), false, false));
}

#[test]
fn what_was_gone_is_back_in_its_place_alone_and_not_below_the_threshold() {
    let got = relation(Cleared, thing(1.0), thing(1.03), Otherwise);
    assert_eq!(got, (Some(Relation::Back), false, false));
    let got = relation(Cleared, thing(1.0), thing(3.0), AsTaught);
    assert_eq!(got, (None, true, false));
    let gone = [incident(3, Cleared, thing(1.0))];
    let quiet = decisions(Verdict::Quiet, &[thing(1.0)], &[(3, Otherwise)], &gone);
    assert_eq!(quiet, []);
}

#[test]
fn two_new_things_are_two_and_two_known_ones_keep_their_numbers() {
    let seen = [thing(1.0), thing(4.0)];
    let raised = decisions(Verdict::Changed, &seen, &[], &[]);
    let expected = [0, 1].map(|sighting| AlarmDecision::Raise { sighting });
    assert_eq!(raised, expected);
    // Each a little towards the other: alone, the nearer would do for both.
    let known = [
        incident(7, Acknowledged, thing(1.06)),
        incident(9, Open, thing(1.12)),
    ];
    let seen = [thing(1.09), thing(1.03)];
    let decided = decisions(
        Verdict::Changed,
        &seen,
        &[(7, Otherwise), (9, Otherwise)],
        &known,
    );
    let pairs: Vec<(i64, usize)> = decided
        .iter()
        .map(|d| match d {
            AlarmDecision::Continue {
                incident, sighting, ..
            } => (*incident, *sighting),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(pairs, [(9, 0), (7, 1)]);
}

#[test]
fn each_is_cleared_by_its_own_place() {
    let known = [
        incident(3, Open, thing(1.0)),
        incident(5, Acknowledged, thing(3.0)),
        incident(7, Open, thing(5.0)),
        incident(9, Open, thing(7.0)),
        incident(11, Cleared, thing(9.0)),
    ];
    let places = [(3, AsTaught), (5, Otherwise), (7, Hidden), (11, AsTaught)];
    let expected = [
        AlarmDecision::Clear { incident: 3 },
        AlarmDecision::NotObserved { incident: 7 },
        // Not named.
        AlarmDecision::NotObserved { incident: 9 },
    ];
    assert_eq!(decisions(Verdict::Quiet, &[], &places, &known), expected);
    let missing = Sighting {
        kind: NoveltyKind::Disappeared,
        ..thing(20.0)
    };
    let changed = decisions(Verdict::Changed, &[missing], &places, &known);
    assert_eq!(changed[0], AlarmDecision::Raise { sighting: 0 });
    assert_eq!(changed[1..], expected, "in a changed visit too");
    let unseen = decisions(Verdict::NotObserved, &[], &places, &known);
    let standing = [3, 5, 7, 9].map(|incident| AlarmDecision::NotObserved { incident });
    assert_eq!(unseen, standing);
}

#[test]
fn a_quiet_visit_keeps_what_it_still_sees_and_raises_nothing() {
    let known = [incident(3, Open, thing(1.0))];
    let seen = [thing(1.0), thing(4.0)];
    let decided = decisions(Verdict::Quiet, &seen, &[(3, Otherwise)], &known);
    assert!(
        matches!(
            decided[..],
            [AlarmDecision::Continue {
                incident: 3,
                sighting: 0,
                relation: Relation::Seen,
                ..
            }]
        ),
        "{decided:?}"
    );
}

#[test]
fn a_moved_or_returned_thing_is_open_again() {
    assert_eq!(Relation::Moved.state_after(Acknowledged), Open);
    assert_eq!(Relation::Back.state_after(Cleared), Open);
    assert_eq!(Relation::Seen.state_after(Acknowledged), Acknowledged);
    assert_eq!(Relation::Changed.state_after(Open), Open);
    assert_eq!(Relation::Gone.state_after(Acknowledged), Cleared);
}

#[test]
fn a_thing_that_hides_a_place_by_standing_in_it_takes_it() {
    let drum = |x| sized(x, [0.9, 0.5, 0.3]);
    // Half the smaller of both second widths, 0.4 m.
    let got = relation(Acknowledged, thing(1.0), drum(1.19), Hidden);
    assert_eq!(got, (None, true, true));
    let got = relation(Acknowledged, thing(1.0), drum(1.21), Hidden);
    assert_eq!(got, (None, true, false));
    // Another in its place and the thing elsewhere: it has moved.
    let known = [incident(3, Open, thing(1.0))];
    let seen = [thing(4.0), drum(1.1)];
    let decided = decisions(Verdict::Changed, &seen, &[(3, Hidden)], &known);
    assert!(
        matches!(
            decided[..],
            [
                AlarmDecision::Continue {
                    incident: 3,
                    sighting: 0,
                    relation: Relation::Moved,
                    ..
                },
                AlarmDecision::Raise { sighting: 1 }
            ]
        ),
        "{decided:?}"
    );
}

/// Widths of 0.4 m and of 0.8 m: both have room beside each other from 0.6 m on, the smaller one fills a place within 0.2 m.
#[test]
fn a_place_is_filled_and_overlapped_on_both_sides_of_its_limits() {
    let (small, large) = ([0.5, 0.4, 0.3], [0.9, 0.8, 0.3]);
    for (x, fills, overlaps) in [
        (0.0, true, true),
        (0.199, true, true),
        (0.201, false, true),
        (0.599, false, true),
        (0.601, false, false),
    ] {
        for (seen, anchor) in [(small, large), (large, small)] {
            let incident = incident(1, AlarmState::Open, sized(0.0, anchor));
            let seen = sized(x, seen);
            assert_eq!(fills_its_place(&seen, &incident), fills, "{x}");
            assert_eq!(is_in_its_place(&seen, &incident), overlaps, "{x}");
            let mut gone = seen;
            gone.kind = NoveltyKind::Disappeared;
            assert!(!fills_its_place(&gone, &incident) && !is_in_its_place(&gone, &incident));
            let mut higher = seen;
            higher.centre.z += 1.0;
            assert_eq!(fills_its_place(&higher, &incident), fills, "above it");
        }
    }
}
