//! Visits that are held: in which order they are written, and which wait for which.

use super::faults::{ledger_with_an_alarm, record};
use super::faulty_disk::{Fault, FaultyDisk};
use super::kit::{first_raised, stamp};
use patrold::store::{Ledger, RetryResult, VisitRecord};

/// A ledger that holds changes of these waypoints, in this order.
fn holding(dir: &std::path::Path, waypoints: &[&str]) -> (Ledger, FaultyDisk) {
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir);
    disk.fail(Fault::Busy, 0, true);
    for (nth, waypoint) in waypoints.iter().enumerate() {
        let x = 3.0 + 2.0 * nth as f64;
        let recorded = record(&mut ledger, waypoint, x, &stamp(20 + nth as i64));
        assert!(matches!(recorded, VisitRecord::Held(_)), "{recorded:?}");
    }
    disk.heal();
    (ledger, disk)
}

fn stored(retry: &RetryResult) -> Vec<(&str, i64)> {
    let second = |at: &patrold::store::RecordTime| at.at.as_second() - stamp(0).at.as_second();
    retry
        .stored
        .iter()
        .map(|(waypoint, at, _)| (waypoint.as_str(), second(at)))
        .collect()
}

#[test]
fn what_is_held_is_written_in_its_order() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, _) = holding(dir.path(), &["hall", "yard", "hall"]);
    let retry = ledger.retry();
    assert_eq!(stored(&retry), [("hall", 20), ("yard", 21), ("hall", 22)]);
    assert_eq!((retry.held, retry.refused.len()), (0, 0));
    let ids: Vec<_> = retry.stored.iter().map(|(.., o)| first_raised(o)).collect();
    assert_eq!(ids, [Some(2), Some(3), Some(4)]);
    assert!(ledger.retry().stored.is_empty(), "each is reported once");
}

#[test]
fn no_visit_overtakes_another_of_its_waypoint() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk) = holding(dir.path(), &["hall", "hall", "yard"]);
    // No room for the first; the waypoint that has nothing to do with it goes on.
    disk.fail(Fault::Full, 0, false);
    let retry = ledger.retry();
    assert_eq!((stored(&retry), retry.held), (vec![("yard", 22)], 2));
    disk.heal();
    let retry = ledger.retry();
    assert_eq!(stored(&retry), [("hall", 20), ("hall", 21)]);
}

#[test]
fn a_database_that_takes_nothing_is_not_asked_again_for_each_visit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk) = holding(dir.path(), &["hall", "yard", "hall"]);
    disk.fail(Fault::Busy, 0, false);
    let retry = ledger.retry();
    assert_eq!((stored(&retry), retry.held), (vec![], 3));
    assert_eq!(disk.steps().done, ["Begin"], "asked once");
    assert!(retry.why.is_some());
    disk.heal();
    // One that comes is stored after all that are held.
    let next = record(&mut ledger, "yard", 11.0, &stamp(30));
    let VisitRecord::Stored(next) = next else {
        panic!("{next:?}");
    };
    assert_eq!(first_raised(&next), Some(5));
    assert_eq!(ledger.retry().stored.len(), 3);
}
