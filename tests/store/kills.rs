//! The writer is killed at a random call of the system while the disk fails at another: what it reported is there afterwards.

use super::call_faults::{
    FAILING, FULL, Injection, QUOTA, READ_ONLY, SHORT, TOO_MANY_OPEN, copy_of, count_calls,
    run_child,
};
use super::failing_calls::visit_template;
use super::kit::{accept, changed_visit, stamp};
use patrold::store::{Ledger, Store, VisitRecord};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Visits of the yard at these places, metres.
const PLACES: [f64; 3] = [3.0, 6.0, 9.0];

/// Changes at the yard, an acknowledgement and an accept at the hall, each reported when it is done.
pub(crate) fn night(dir: &Path, report: impl Fn(&str)) {
    let Ok(store) = Store::open(dir) else {
        return report("not opened");
    };
    let mut ledger = Ledger::new(store);
    ledger.start();
    let Ok(reference) = ledger.store.reference("yard").map(|r| r.id) else {
        return report("no reference");
    };
    for (nth, x) in PLACES.into_iter().enumerate() {
        let at = stamp(20 + nth as i64);
        let recorded = changed_visit("yard", reference, x, |new| ledger.record_visit(new, &at));
        match recorded.expect("stored or held") {
            VisitRecord::Stored(outcome) => report(&format!("stored {} {x}", outcome.visit_id)),
            VisitRecord::Held(_) => report("held"),
            VisitRecord::Dropped(why) => panic!("three can be held: {why}"),
        }
        if nth == 0
            && ledger
                .store
                .acknowledge(1, "guard", None, &stamp(30))
                .is_ok()
        {
            report("acknowledged");
        }
        if nth == 1 && accept(&mut ledger.store, 1, 40).is_ok() {
            report("accepted");
        }
        for (waypoint, _, outcome) in ledger.retry().stored {
            assert_eq!(waypoint, "yard");
            report(&format!("stored later {}", outcome.visit_id));
        }
    }
}

/// What `report` says is in the store, after a start.
fn check(dir: &Path, report: &str, what: &str) {
    let mut ledger = Ledger::new(Store::open(dir).unwrap_or_else(|e| panic!("{what}: {e}")));
    let start = ledger.start();
    assert!(
        start.failures.is_empty() && start.lost_files.is_none(),
        "{what}: {start:?}"
    );
    let store = &ledger.store;
    let alarm = store.alarm(1).expect("kept");
    let reference = store.reference("hall").expect("whole").version;
    assert_eq!(
        alarm.state == "cleared",
        reference == 2,
        "{what}: both or none"
    );
    if report.contains("acknowledged") {
        assert_eq!(alarm.acknowledged_by.as_deref(), Some("guard"), "{what}");
    }
    if report.contains("accepted") {
        assert_eq!(reference, 2, "{what}");
    }
    let mut stored = 0;
    for line in report.lines().filter(|line| line.starts_with("stored")) {
        stored += 1;
        let words: Vec<&str> = line.split(' ').collect();
        let (id, x): (i64, Option<f64>) = match words[..] {
            ["stored", "later", id] => (id.parse().expect("an id"), None),
            ["stored", id, x] => (id.parse().expect("an id"), x.parse().ok()),
            _ => panic!("{line}"),
        };
        let alarms = store.alarms(&Default::default()).expect("alarms");
        let alarm = alarms.iter().find(|alarm| alarm.visit_id == id);
        let alarm = alarm.unwrap_or_else(|| panic!("{what}: no alarm of visit {id}"));
        assert_eq!(alarm.waypoint, "yard", "{what}");
        let place = alarm.novelties[0].centre[0];
        assert!(
            x.is_none_or(|x| x == place) && PLACES.contains(&place),
            "{what}: {place}"
        );
    }
    let alarms = store.alarms(&Default::default()).expect("alarms").len();
    assert!(alarms > stored, "{what}: {alarms} alarms");
    let check = store.check(|_, _| ()).expect("checked");
    assert!(check.database_errors.is_empty(), "{what}: {check:?}");
    // And it works again.
    drop(ledger);
    let after = std::cell::RefCell::new(Vec::new());
    night(dir, |line| after.borrow_mut().push(line.to_owned()));
    let again = after
        .borrow()
        .iter()
        .filter(|line| line.starts_with("stored "))
        .count();
    assert_eq!(again, PLACES.len(), "{what}: {:?}", after.borrow());
}

/// This many kills, at calls and with faults that follow from the seed.
fn kill(times: usize, seed: u64) {
    let template = visit_template();
    let calls = count_calls("night", template.path());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let faults = [FULL, SHORT, QUOTA, FAILING, TOO_MANY_OPEN, READ_ONLY];
    let mut killed = 0;
    while killed < times {
        let injection = Injection {
            fault: faults[rng.random_range(0..faults.len())],
            at: rng.random_range(0..calls),
            lasting: rng.random(),
            kill_at: rng.random_range(0..calls),
        };
        let (_dir, root) = copy_of(template.path());
        let run = run_child("night", &root, injection);
        // With a fault there may be fewer calls than that.
        killed += usize::from(run.calls.is_none());
        let what = format!("seed {seed}, kill {killed}: {injection:?}: {}", run.report);
        check(&root.join("live"), &run.report, &what);
    }
}

#[test]
fn kills_under_faults_lose_nothing_that_was_reported() {
    kill(60, 1);
}

#[test]
#[ignore = "a minute; further kills like those above"]
fn a_thousand_kills_under_faults_lose_nothing_that_was_reported() {
    kill(1000, 2);
}
