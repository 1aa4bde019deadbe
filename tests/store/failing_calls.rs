//! Every call of the system under a visit and its acknowledgement fails once, and from then on.

use super::call_faults::{
    FAILING, FULL, QUOTA, READ_ONLY, SHORT, TOO_MANY_OPEN, UNSYNCED, fail_each_call,
    once_and_lasting,
};
use super::faults::store_with_an_alarm;
use super::kit::{accept, changed_visit, stamp};
use patrold::store::{Ledger, Store, StoreError, VisitRecord};
use std::fs;
use std::io::Write as _;
use std::path::Path;

/// Not a test of its own: what [`run_child`] runs.
#[test]
#[ignore = "run by the other tests of this file"]
fn child() {
    let (Ok(root), Ok(operation)) = (
        std::env::var("FAIL_ROOT"),
        std::env::var("PATROLD_OPERATION"),
    ) else {
        return;
    };
    let root = Path::new(&root);
    let (live, copy) = (root.join("live"), root.join("copy"));
    let arm = |name: &str| drop(fs::File::open(root.join(name)));
    let report_file = root.with_extension("report");
    let report = match operation.as_str() {
        "accept" => {
            let mut store = Store::open(&live).expect("opens");
            arm("ARM");
            let accepted = accept(&mut store, 1, 40);
            arm("DISARM");
            match accepted {
                Ok(version) => format!("accepted {version}"),
                Err(why) => {
                    assert!(why.to_string().contains("; "), "advice: {why}");
                    "refused".to_owned()
                }
            }
        }
        "night" => {
            arm("ARM");
            super::kills::night(&live, |line| note(&report_file, line));
            arm("DISARM");
            String::new()
        }
        "visit" => {
            let mut ledger = Ledger::new(Store::open(&live).expect("opens"));
            let reference = ledger.store.reference("yard").expect("taught").id;
            arm("ARM");
            let recorded = changed_visit("yard", reference, 3.0, |new| {
                ledger.record_visit(new, &stamp(20))
            });
            let acknowledged = ledger.store.acknowledge(1, "guard", None, &stamp(30));
            arm("DISARM");
            let visit = match recorded.expect("stored or held") {
                VisitRecord::Stored(outcome) if outcome.evidence_missing.is_none() => {
                    "stored whole"
                }
                VisitRecord::Stored(_) => "stored",
                VisitRecord::Held(why) => {
                    assert!(why.to_string().contains("; "), "advice: {why}");
                    "held"
                }
                VisitRecord::Dropped(why) => panic!("one visit can be held: {why}"),
            };
            format!(
                "{visit}, {}",
                if acknowledged.is_ok() {
                    "acknowledged"
                } else {
                    "refused"
                }
            )
        }
        "rebuild" => {
            arm("ARM");
            let done = Store::rebuild(&live, &stamp(100));
            arm("DISARM");
            outcome(done.err())
        }
        "backup" => {
            let store = Store::open_for_reading(&live).expect("opens");
            arm("ARM");
            let done = store.back_up(&copy, |_, _| ());
            arm("DISARM");
            outcome(done.err())
        }
        "restore" => {
            arm("ARM");
            let done = Store::restore(&live, &copy, &stamp(100), |_, _| ());
            arm("DISARM");
            outcome(done.err())
        }
        other => panic!("{other}"),
    };
    note(&report_file, &report);
    // As a kill: nothing is closed.
    std::process::exit(0);
}

/// A line that outlives a kill.
fn note(file: &Path, line: &str) {
    let mut file = fs::File::options()
        .append(true)
        .create(true)
        .open(file)
        .expect("opens");
    file.write_all(format!("{line}\n").as_bytes())
        .expect("reported");
}

fn outcome(error: Option<StoreError>) -> String {
    error.map_or_else(|| "done".to_owned(), |error| format!("failed: {error}"))
}

pub(crate) fn visit_template() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    let standing = store_with_an_alarm(&live);
    assert_eq!(standing, 1);
    dir
}

fn check_visit(root: &Path, report: &str, what: &str) {
    let mut ledger = Ledger::new(Store::open(&root.join("live")).expect("opens"));
    let start = ledger.start();
    assert!(
        start.failures.is_empty() && start.lost_files.is_none(),
        "{what}: {start:?}"
    );
    let store = &ledger.store;
    let raised = store.alarm(2);
    if report.starts_with("stored") {
        let alarm = raised.unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(alarm.novelties[0].centre[0], 3.0, "{what}");
        if report.starts_with("stored whole") {
            assert!(store.visit(alarm.visit_id).is_ok(), "{what}");
        }
    }
    let state = store.alarm(1).expect("kept").state;
    if report.trim_end().ends_with("acknowledged") {
        assert_eq!(state, "acknowledged", "{what}");
    }
    let check = store.check(|_, _| ()).expect("checked");
    assert!(check.database_errors.is_empty(), "{what}: {check:?}");
}

#[test]
fn a_visit_on_a_full_disk_or_over_its_quota() {
    let faults = once_and_lasting(&[FULL, SHORT, QUOTA]);
    fail_each_call("visit", visit_template().path(), &faults, check_visit);
}

#[test]
fn a_visit_on_a_failing_or_read_only_disk_or_without_descriptors() {
    let faults = once_and_lasting(&[FAILING, TOO_MANY_OPEN, READ_ONLY]);
    fail_each_call("visit", visit_template().path(), &faults, check_visit);
}

#[test]
fn each_file_and_each_folder_is_synced_by_the_system() {
    let reports = std::cell::RefCell::new(Vec::new());
    fail_each_call(
        "visit",
        visit_template().path(),
        &[(UNSYNCED, false)],
        |_, report, _| {
            reports.borrow_mut().push(report.trim_end().to_owned());
        },
    );
    let count = |report: &str| reports.borrow().iter().filter(|r| *r == report).count();
    assert_eq!(
        count("held, acknowledged"),
        2,
        "the rows of the visit: head and pages of the log"
    );
    // View, raw data, their folder after each, and the mark that they are there.
    assert_eq!(count("stored, acknowledged"), 5);
    assert_eq!(count("stored whole, refused"), 1, "the acknowledgement");
}
