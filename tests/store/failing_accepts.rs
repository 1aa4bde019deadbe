//! Whatever fails under an accept: the alarm and the reference are as before or as reported, and it can be done again.

use super::call_faults::{
    FAILING, FULL, QUOTA, READ_ONLY, SHORT, TOO_MANY_OPEN, fail_each_call, once_and_lasting,
};
use super::failing_calls::visit_template;
use super::faults::{advice_words, copy_store, fast_dir, ledger_of};
use super::faulty_disk::Fault;
use super::kit::{accept, stamp};
use patrold::store::{Ledger, Store};
use std::path::Path;

/// `accepted`: as it was reported. An accept that is not reported may be there whole, or not at all.
fn check(dir: &Path, accepted: bool, what: &str) {
    let mut ledger = Ledger::new(Store::open(dir).expect("opens"));
    let start = ledger.start();
    assert!(
        start.failures.is_empty() && start.lost_files.is_none(),
        "{what}: {start:?}"
    );
    let store = &mut ledger.store;
    let state = |store: &Store| {
        let alarm = store.alarm(1).expect("kept");
        let reference = store.reference("hall").expect("whole");
        (alarm.state, reference.version, reference.frame_version)
    };
    let (before, after) = (("open".to_owned(), 1, 1), ("cleared".to_owned(), 2, 1));
    let now = state(store);
    assert!(
        now == after || !accepted && now == before,
        "{what}: {now:?}"
    );
    let yard = store.reference("yard").expect("untouched");
    assert_eq!(yard.version, 1, "{what}");
    if now == before {
        let again = accept(store, 1, 60).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(again, 2, "{what}");
        assert_eq!(state(store), after, "{what}");
    }
    let check = store.check(|_, _| ()).expect("checked");
    assert!(
        check.database_errors.is_empty() && check.missing.is_empty(),
        "{what}: {check:?}"
    );
}

fn check_calls(faults: &[super::call_faults::CallFault]) {
    let template = visit_template();
    fail_each_call(
        "accept",
        template.path(),
        &once_and_lasting(faults),
        |root, report, what| {
            check(&root.join("live"), report.starts_with("accepted 2"), what);
        },
    );
}

#[test]
fn an_accept_on_a_full_disk_or_over_its_quota() {
    check_calls(&[FULL, SHORT, QUOTA]);
}

#[test]
fn an_accept_on_a_failing_or_read_only_disk_or_without_descriptors() {
    check_calls(&[FAILING, TOO_MANY_OPEN, READ_ONLY]);
}

/// The steps of an accept, without a fault.
fn steps(template: &Path) -> Vec<String> {
    let dir = fast_dir();
    copy_store(template, dir.path());
    let (mut ledger, disk) = ledger_of(dir.path());
    disk.heal();
    accept(&mut ledger.store, 1, 40).expect("accepted");
    disk.steps().done.clone()
}

#[test]
fn an_accept_syncs_its_view_before_its_row() {
    let template = visit_template();
    let file = [
        "open to create",
        "write",
        "sync",
        "rename",
        "open a folder",
        "sync of a folder",
    ];
    let journal = ["Begin", "open to append", "write", "sync", "Commit"];
    let expected = [&file[..], &["Begin", "Commit"], &journal].concat();
    assert_eq!(steps(&template.path().join("live")), expected);
}

#[test]
fn each_step_of_an_accept_fails_once_and_from_then_on() {
    let template = visit_template();
    let template = template.path().join("live");
    let steps = steps(&template).len();
    let faults = [
        Fault::Full,
        Fault::Quota,
        Fault::Failing,
        Fault::TooManyOpen,
        Fault::ReadOnly,
        Fault::ShortWrite,
        Fault::Busy,
    ];
    for fault in faults {
        for (at, lasting) in (0..steps).flat_map(|at| [(at, false), (at, true)]) {
            let what = format!("{fault:?} at step {at}, lasting {lasting}");
            let dir = fast_dir();
            let (running, killed) = (dir.path().join("running"), dir.path().join("killed"));
            copy_store(&template, &running);
            let (mut ledger, disk) = ledger_of(&running);
            disk.fail(fault, at, lasting);
            let accepted = accept(&mut ledger.store, 1, 40);
            if let Err(why) = &accepted {
                let text = why.to_string();
                assert!(text.contains(advice_words(fault)), "{what}: {text}");
            }
            copy_store(&running, &killed);
            check(&killed, accepted.is_ok(), &format!("{what}, killed"));
            disk.heal();
            ledger
                .store
                .acknowledge(1, "guard", None, &stamp(50))
                .expect("the disk works");
            drop(ledger);
            let state = Store::open(&running)
                .expect("opens")
                .alarm(1)
                .expect("kept")
                .state;
            let expected = if accepted.is_ok() {
                "cleared"
            } else {
                "acknowledged"
            };
            assert_eq!(state, expected, "{what}");
        }
    }
}
