//! Every call of the system that opens, writes, syncs or renames a file of the store fails once and from then on, those of
//! SQLite too: in a process of its own, whose calls fail_calls.c counts and makes fail.

use super::faults::{copy_store, fast_dir, store_with_an_alarm};
use super::kit::{changed_visit, novelty_at, stamp, teach, visit};
use super::rebuild::{files, remove_database, rows};
use patrold::store::{Ledger, Store, StoreError, VisitRecord};
use patrold_engine::novelty::Verdict;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What the C file calls them.
const OPEN: u32 = 1;
const WRITE: u32 = 2;
const SYNC: u32 = 4;
const RENAME: u32 = 8;

#[derive(Debug, Clone, Copy)]
struct CallFault {
    /// errno(3) of Linux.
    errno: i32,
    kinds: u32,
    /// Half is written first.
    short: bool,
}

const FULL: CallFault = CallFault {
    errno: 28,
    kinds: WRITE | SYNC | RENAME,
    short: false,
};
const SHORT: CallFault = CallFault {
    errno: 28,
    kinds: WRITE,
    short: true,
};
const QUOTA: CallFault = CallFault {
    errno: 122,
    kinds: WRITE | RENAME,
    short: false,
};
const FAILING: CallFault = CallFault {
    errno: 5,
    kinds: OPEN | WRITE | SYNC | RENAME,
    short: false,
};
const TOO_MANY_OPEN: CallFault = CallFault {
    errno: 24,
    kinds: OPEN,
    short: false,
};
const READ_ONLY: CallFault = CallFault {
    errno: 30,
    kinds: OPEN | WRITE | RENAME,
    short: false,
};
/// Once each, and a disk that stays full.
const EACH: [(CallFault, bool); 7] = [
    (FULL, false),
    (FULL, true),
    (SHORT, false),
    (QUOTA, false),
    (FAILING, false),
    (TOO_MANY_OPEN, false),
    (READ_ONLY, false),
];

/// More calls than there are.
const NEVER: usize = 1_000_000;

/// The library that makes calls fail, compiled once.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = LIBRARY.get_or_init(|| {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("fail_calls.so");
        let source = patrold_test_support::workspace_root().join("tests/store/fail_calls.c");
        let compiled = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([&path, &source])
            .arg("-ldl")
            .status();
        assert!(compiled.expect("cc, as for SQLite").success());
        (dir, path)
    });
    path
}

/// Runs an operation below `root` in a process whose `at`th call fails. Returns its report and the number of calls.
fn run_child(
    operation: &str,
    root: &Path,
    fault: CallFault,
    at: usize,
    lasting: bool,
) -> (String, usize) {
    let number = |n: u32| n.to_string();
    let ran = Command::new(std::env::current_exe().expect("this program"))
        .args([
            "failing_calls::child",
            "--exact",
            "--ignored",
            "--nocapture",
        ])
        .env("LD_PRELOAD", library())
        .env("FAIL_ROOT", root)
        .env("FAIL_AT", at.to_string())
        .env("FAIL_LASTING", number(lasting.into()))
        .env("FAIL_ERRNO", fault.errno.to_string())
        .env("FAIL_KINDS", number(fault.kinds))
        .env("FAIL_SHORT", number(fault.short.into()))
        .env("PATROLD_OPERATION", operation)
        .output()
        .expect("runs");
    let report = fs::read_to_string(root.with_extension("report"));
    let calls = fs::read_to_string(root.with_extension("calls"));
    let err = String::from_utf8_lossy(&ran.stderr);
    let report =
        report.unwrap_or_else(|_| panic!("{operation} {fault:?} at {at}: no report; {err}"));
    (report, calls.expect("counted").parse().expect("a number"))
}

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
    let report = match operation.as_str() {
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
    fs::write(root.with_extension("report"), report).expect("reported");
    // As a kill: nothing is closed.
    std::process::exit(0);
}

fn outcome(error: Option<StoreError>) -> String {
    error.map_or_else(|| "done".to_owned(), |error| format!("failed: {error}"))
}

/// `check` after a fault at every call: once, or from then on.
fn fail_each_call(
    operation: &str,
    template: &Path,
    faults: &[(CallFault, bool)],
    check: impl Fn(&Path, &str, &str),
) {
    let try_at = |fault: CallFault, at: usize, lasting: bool| {
        let dir = fast_dir();
        let root = dir.path().join("root");
        copy_store(template, &root);
        let (report, calls) = run_child(operation, &root, fault, at, lasting);
        let what = format!("{operation}: {fault:?} at {at}, lasting {lasting}: {report}");
        check(&root, &report, &what);
        calls
    };
    let calls = try_at(FULL, NEVER, false);
    assert!(calls > 20, "{operation}: {calls} calls are counted");
    for (fault, lasting) in faults {
        for at in 0..calls {
            try_at(*fault, at, *lasting);
        }
    }
}

fn visit_template() -> tempfile::TempDir {
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
    if report.ends_with("acknowledged") {
        assert_eq!(state, "acknowledged", "{what}");
    }
    let check = store.check(|_, _| ()).expect("checked");
    assert!(check.database_errors.is_empty(), "{what}: {check:?}");
}

#[test]
fn a_visit_on_a_full_disk_or_over_its_quota() {
    let both = |fault| [(fault, false), (fault, true)];
    let faults = [FULL, SHORT, QUOTA].map(both).concat();
    fail_each_call("visit", visit_template().path(), &faults, check_visit);
}

#[test]
fn a_visit_on_a_failing_or_read_only_disk_or_without_descriptors() {
    let both = |fault| [(fault, false), (fault, true)];
    let faults = [FAILING, TOO_MANY_OPEN, READ_ONLY].map(both).concat();
    fail_each_call("visit", visit_template().path(), &faults, check_visit);
}

#[test]
fn each_file_and_each_folder_is_synced_by_the_system() {
    let only_syncs = CallFault {
        errno: 5,
        kinds: SYNC,
        short: false,
    };
    let reports = std::cell::RefCell::new(Vec::new());
    fail_each_call(
        "visit",
        visit_template().path(),
        &[(only_syncs, false)],
        |_, report, _| {
            reports.borrow_mut().push(report.to_owned());
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

#[test]
fn a_rebuild_that_fails_can_be_run_again() {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    store_with_an_alarm(&live);
    let (before, evidence) = (rows(&live), files(&live).len());
    remove_database(&live);
    fail_each_call("rebuild", dir.path(), &EACH, |root, report, what| {
        let live = root.join("live");
        if report != "done" {
            assert_eq!(files(&live).len(), evidence, "{what}");
            Store::rebuild(&live, &stamp(200)).unwrap_or_else(|error| panic!("{what}: {error}"));
        }
        assert_eq!(rows(&live), before, "{what}");
        assert_eq!(files(&live).len(), evidence, "{what}");
    });
}

#[test]
fn a_backup_that_fails_can_be_run_again() {
    let dir = tempfile::tempdir().expect("temp dir");
    let live = dir.path().join("live");
    store_with_an_alarm(&live);
    let before = rows(&live);
    fail_each_call("backup", dir.path(), &EACH, |root, report, what| {
        let (live, copy) = (root.join("live"), root.join("copy"));
        if report != "done" {
            let store = Store::open_for_reading(&live).expect("opens");
            let again = store.back_up(&copy, |_, _| ());
            let again = again.unwrap_or_else(|error| panic!("{what}: {error}"));
            assert!(again.check.is_sound(), "{what}: {again:?}");
        }
        assert_eq!(
            (rows(&copy), rows(&live)),
            (before.clone(), before.clone()),
            "{what}"
        );
    });
}

#[test]
fn a_restore_that_fails_leaves_one_of_both_and_can_be_run_again() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (live, copy) = (dir.path().join("live"), dir.path().join("copy"));
    store_with_an_alarm(&live);
    let backed_up = rows(&live);
    let reader = Store::open_for_reading(&live).expect("opens");
    reader.back_up(&copy, |_, _| ()).expect("backed up");
    drop(reader);
    let mut store = Store::open(&live).expect("opens");
    visit(&mut store, Verdict::Changed, &[novelty_at(7.0)], 50);
    teach(&mut store, "dock", 60);
    store.close();
    let (later, evidence) = (rows(&live), files(&live).len());
    fail_each_call("restore", dir.path(), &EACH, |root, report, what| {
        let (live, copy) = (root.join("live"), root.join("copy"));
        assert!(files(&live).len() >= evidence, "{what}: nothing is deleted");
        if report != "done" {
            let store = Store::open(&live).unwrap_or_else(|error| panic!("{what}: {error}"));
            store.close();
            let now = rows(&live);
            assert!(now == later || now == backed_up, "{what}");
            Store::restore(&live, &copy, &stamp(200), |_, _| ())
                .unwrap_or_else(|error| panic!("{what}: {error}"));
        }
        assert_eq!(rows(&live), backed_up, "{what}");
        let store = Store::open(&live).expect("opens");
        assert_eq!(store.changes_lost().expect("asked"), 0, "{what}");
    });
}
