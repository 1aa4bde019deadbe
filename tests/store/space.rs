//! A disk with little space: the reserve of alarms, what evidence leaves to them, what is held.

use super::faults::{fast_dir, ledger_with_an_alarm, record_of};
use super::faulty_disk::Fault;
use super::kit::{changed_visit, first_raised, stamp};
use patrold::store::{Ledger, StoreError, VisitRecord};
use patrold_engine::novelty::Verdict;

/// As many as are held at most (`src/store/held_visits.rs`).
const MAX_HELD: i64 = 240;

#[test]
fn a_full_disk_takes_an_alarm_out_of_the_reserve_and_nothing_else() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir.path());
    let hall = ledger.store.reference("hall").expect("taught").id;
    let yard = ledger.store.reference("yard").expect("taught").id;
    ledger.store.hold_reserve().expect("held");
    let reserve = dir.path().join("patrold.reserve");
    let held_bytes = std::fs::metadata(&reserve).expect("held").len();
    assert_eq!(held_bytes, 16 << 20);

    // The first attempt fails, the one after giving back the reserve does not.
    disk.fail(Fault::Full, 0, false);
    disk.steps().free_bytes = Some(held_bytes - 1);
    let recorded = record_of(&mut ledger, "yard", yard, 3.0, &stamp(20));
    let VisitRecord::Stored(outcome) = recorded else {
        panic!("{recorded:?}");
    };
    assert!(!reserve.exists());
    let why = outcome.evidence_missing.as_ref().expect("no room for it");
    assert!(why.contains("kept for alarms"), "{why}");
    let quiet = |ledger: &mut Ledger, waypoint: &str, reference, second| {
        changed_visit(waypoint, reference, 3.0, |new| {
            let mut quiet = new.clone();
            (quiet.verdict, quiet.novelties) = (Verdict::Quiet, &[]);
            ledger.record_visit(&quiet, &stamp(second)).expect("held")
        })
    };
    let at_hall = quiet(&mut ledger, "hall", hall, 30);
    assert!(
        matches!(at_hall, VisitRecord::Held(StoreError::LowSpace { .. })),
        "{at_hall:?}"
    );
    let at_yard = quiet(&mut ledger, "yard", yard, 40);
    assert!(matches!(at_yard, VisitRecord::Held(_)), "{at_yard:?}");
    // The change comes after the quiet visit of its waypoint; that of the other waypoint waits.
    let again = record_of(&mut ledger, "yard", yard, 5.0, &stamp(50));
    let VisitRecord::Stored(second) = again else {
        panic!("{again:?}");
    };
    assert_ne!(first_raised(&second), first_raised(&outcome));
    let first = ledger
        .store
        .alarm(first_raised(&outcome).expect("raised"))
        .expect("kept");
    assert_eq!(
        first.state, "open",
        "the quiet visit between did not look for it"
    );
    let waypoint = ledger.store.waypoint("hall").expect("known").row;
    assert_eq!(
        waypoint.last_verdict.as_deref(),
        Some("changed"),
        "its quiet visit is held"
    );

    disk.steps().free_bytes = None;
    let report = ledger.maintain();
    assert_eq!(
        (report.retry.held, report.retry.waiting),
        (0, 0),
        "{report:?}"
    );
    let waypoint = ledger.store.waypoint("hall").expect("known").row;
    assert_eq!(waypoint.last_verdict.as_deref(), Some("quiet"));
    assert!(
        ledger.store.visit(outcome.visit_id).is_ok(),
        "its evidence is there now"
    );
    assert_eq!(
        std::fs::metadata(&reserve).expect("held again").len(),
        held_bytes
    );
}

#[test]
fn the_reserve_is_taken_where_there_is_as_much_again() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir.path());
    let reserve = dir.path().join("patrold.reserve");
    for (free_bytes, expected) in [((32 << 20) - 1, false), (32 << 20, true)] {
        disk.steps().free_bytes = Some(free_bytes);
        ledger.store.hold_reserve().expect("asked");
        assert_eq!(reserve.exists(), expected, "{free_bytes}");
    }
    // One that is there is kept, whatever is free.
    disk.heal();
    disk.steps().free_bytes = Some(0);
    ledger.store.hold_reserve().expect("asked");
    assert_eq!(std::fs::metadata(&reserve).expect("kept").len(), 16 << 20);
    assert!(disk.steps().done.is_empty(), "and not written again");
    // A half of it is taken anew; what the disk does not take goes at once.
    std::fs::write(&reserve, b"half").expect("torn");
    disk.steps().free_bytes = Some(32 << 20);
    disk.fail(Fault::ShortWrite, 3, false);
    ledger.store.hold_reserve().expect_err("full");
    assert!(!reserve.exists());
    disk.heal();
    ledger.store.hold_reserve().expect("taken");
    let steps = disk.steps().done.clone();
    assert_eq!(steps.last().map(String::as_str), Some("sync"), "{steps:?}");
}

#[test]
fn evidence_leaves_the_last_bytes_to_alarms() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir.path());
    ledger.store.hold_reserve().expect("held");
    let reserve = std::fs::metadata(dir.path().join("patrold.reserve"))
        .expect("held")
        .len();
    let yard = ledger.store.reference("yard").expect("taught").id;
    disk.fail(Fault::Full, 0, false);
    // Room for the rows of a visit beside what is kept, and not for its files; then for both.
    for (more, x, fits) in [(10, 3.0, false), (1 << 20, 5.0, true)] {
        disk.steps().free_bytes = Some(reserve + more);
        let recorded = record_of(&mut ledger, "yard", yard, x, &stamp(20));
        let VisitRecord::Stored(outcome) = recorded else {
            panic!("{recorded:?}");
        };
        assert_eq!(outcome.evidence_missing.is_none(), fits, "{more}");
    }
}

#[test]
fn low_space_is_reported_before_it_is_an_error() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (ledger, disk, _) = ledger_with_an_alarm(dir.path());
    let per_visit = ledger.store.disk_space().expect("space").visit_bytes;
    let reserve = 16 << 20;
    for (visits, low, ample) in [(119, true, false), (120, false, false), (150, false, true)] {
        disk.steps().free_bytes = Some(reserve + visits * per_visit);
        let space = ledger.store.disk_space().expect("space");
        assert_eq!(space.visits(), visits);
        assert_eq!((space.is_low(), space.is_ample()), (low, ample), "{visits}");
    }
}

#[test]
fn a_change_after_as_many_as_can_be_held_is_stored_when_the_disk_is_well_again() {
    let dir = fast_dir();
    let (mut ledger, disk, _) = ledger_with_an_alarm(dir.path());
    let reference = ledger.store.reference("yard").expect("taught").id;
    disk.fail(Fault::Failing, 0, true);
    for second in 0..MAX_HELD {
        let recorded = record_of(&mut ledger, "yard", reference, 3.0, &stamp(20 + second));
        assert!(matches!(recorded, VisitRecord::Held(_)), "{recorded:?}");
    }
    let one_more = record_of(&mut ledger, "yard", reference, 3.0, &stamp(20 + MAX_HELD));
    assert!(matches!(one_more, VisitRecord::Dropped(_)), "{one_more:?}");
    disk.heal();
    let last = record_of(&mut ledger, "yard", reference, 3.0, &stamp(21 + MAX_HELD));
    assert!(matches!(last, VisitRecord::Stored(_)), "{last:?}");
    assert!(!ledger.is_behind());
    let reported = ledger.retry().stored;
    assert_eq!(reported.len() as i64, MAX_HELD, "each is reported");
    assert_eq!(reported[0].1, stamp(20));
}
