//! Teaching over standing alarms: refused, or accepted, and what it leaves.

use super::incidents::{changed, relations, states, thing, two_waypoints, unchanged};
use super::kit::stamp;
use patrold::alarm::Relation;
use patrold::store::{NewReference, ReferenceFrame, Store, StoreError, SweepRecord};

#[test]
fn a_teach_over_standing_alarms_or_by_a_slip_of_the_pen_is_refused() {
    let (_dir, store) = two_waypoints();
    let refused = |name, accept: &[i64], new| {
        let refused = store.check_teach(name, accept, new);
        refused.expect_err("refused").to_string()
    };
    let standing = refused("hall", &[1], false);
    assert!(
        standing.starts_with("hall: alarm 2 is not cleared") && standing.contains("--accept 2"),
        "{standing}"
    );
    let other = refused("hall", &[1, 2, 3], true);
    assert!(
        other.starts_with("alarm 3 cannot be accepted: it does not stand at hall"),
        "{other}"
    );
    store.check_teach("hall", &[2, 1], false).expect("accepted");
    store.check_teach("dock", &[3], false).expect("its own");
    for (name, like) in [
        ("hal", "hall"),
        ("halle", "hall"),
        ("Hall2", "hall"),
        ("doc", "dock"),
    ] {
        let text = refused(name, &[], false);
        assert!(text.contains(&format!("but \"{like}\"")), "{text}");
        store.check_teach(name, &[], true).expect("new");
    }
    store
        .check_teach("ballon", &[], false)
        .expect("three letters");
}

#[test]
fn an_accepted_alarm_leaves_the_others_and_their_frame() {
    let (_dir, mut store) = two_waypoints();
    let dock = store.alarm(3).expect("alarm");
    let version = teach_with(&mut store, &[1], ReferenceFrame::Version(1)).expect("accepted");
    assert_eq!(version, 2);
    let states = states(&store);
    assert_eq!(states[0], (1, "cleared".to_owned()));
    assert_eq!(states[1], (2, "open".to_owned()));
    let reference = store.reference("hall").expect("reference");
    assert_eq!((reference.version, reference.frame_version), (2, 1));
    let again = changed(&mut store, "hall", &[thing(4.0, 0.9)], 70);
    assert_eq!(
        relations(&again),
        [(2, Relation::Seen, 0)],
        "in the same frame"
    );
    unchanged(&store, 3, &dock);
    let refused = teach_with(&mut store, &[], ReferenceFrame::Own).expect_err("alarm 2 stands");
    assert!(
        matches!(refused, StoreError::StandingAlarms { .. }),
        "{refused}"
    );
    let refused = teach_with(&mut store, &[3], ReferenceFrame::Version(1)).expect_err("elsewhere");
    assert!(
        matches!(refused, StoreError::NotAcceptable { id: 3, .. }),
        "{refused}"
    );
    assert_eq!(store.reference("hall").expect("reference").version, 2);
}

fn teach_with(
    store: &mut Store,
    accepted: &[i64],
    frame: ReferenceFrame,
) -> Result<i64, StoreError> {
    let view = super::kit::view(1.0);
    let new = NewReference {
        waypoint: "hall",
        sweep: SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: None,
            quality: "{}",
        },
        mixture: &super::kit::mixture(),
        model: super::kit::MODEL,
        engine: "{}",
        seed: 7,
        accepted,
        frame,
    };
    store.teach(&new, &stamp(60))
}
