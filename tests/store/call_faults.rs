//! Calls of the system that open, write, sync or rename a file of the store fail, those of SQLite too: in a process of its
//! own, whose calls fail_calls.c counts, makes fail and ends.

use super::faults::{copy_store, fast_dir};
use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What the C file calls them.
const OPEN: u32 = 1;
const WRITE: u32 = 2;
const SYNC: u32 = 4;
const RENAME: u32 = 8;
/// SIGKILL, signal(7).
const KILLED: i32 = 9;

#[derive(Debug, Clone, Copy)]
pub(crate) struct CallFault {
    /// errno(3) of Linux.
    errno: i32,
    kinds: u32,
    /// Half is written first.
    short: bool,
}

pub(crate) const FULL: CallFault = CallFault {
    errno: 28,
    kinds: WRITE | SYNC | RENAME,
    short: false,
};
pub(crate) const SHORT: CallFault = CallFault {
    errno: 28,
    kinds: WRITE,
    short: true,
};
pub(crate) const QUOTA: CallFault = CallFault {
    errno: 122,
    kinds: WRITE | RENAME,
    short: false,
};
pub(crate) const FAILING: CallFault = CallFault {
    errno: 5,
    kinds: OPEN | WRITE | SYNC | RENAME,
    short: false,
};
pub(crate) const TOO_MANY_OPEN: CallFault = CallFault {
    errno: 24,
    kinds: OPEN,
    short: false,
};
pub(crate) const READ_ONLY: CallFault = CallFault {
    errno: 30,
    kinds: OPEN | WRITE | RENAME,
    short: false,
};
pub(crate) const UNSYNCED: CallFault = CallFault {
    errno: 5,
    kinds: SYNC,
    short: false,
};

/// More calls than there are.
pub(crate) const NEVER: usize = 1_000_000;

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

/// What happens to the calls of an operation, which are counted from 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Injection {
    pub(crate) fault: CallFault,
    /// This one fails.
    pub(crate) at: usize,
    /// All after it too.
    pub(crate) lasting: bool,
    /// The process is killed before this one, or in the middle of it where it is a write.
    pub(crate) kill_at: usize,
}

impl Injection {
    /// Nothing fails.
    pub(crate) const NONE: Self = Self {
        fault: FULL,
        at: NEVER,
        lasting: false,
        kill_at: NEVER,
    };

    pub(crate) fn of(fault: CallFault, at: usize, lasting: bool) -> Self {
        Self {
            fault,
            at,
            lasting,
            kill_at: NEVER,
        }
    }
}

/// What is left of a process.
#[derive(Debug)]
pub(crate) struct ChildRun {
    /// What it reported, line by line.
    pub(crate) report: String,
    /// Calls counted; `None`: it was killed.
    pub(crate) calls: Option<usize>,
}

/// Runs an operation below `root` in a process of its own.
pub(crate) fn run_child(operation: &str, root: &Path, injection: Injection) -> ChildRun {
    let number = |n: u32| n.to_string();
    let fault = injection.fault;
    let ran = Command::new(std::env::current_exe().expect("this program"))
        .args([
            "failing_calls::child",
            "--exact",
            "--ignored",
            "--nocapture",
        ])
        .env("LD_PRELOAD", library())
        .env("FAIL_ROOT", root)
        .env("FAIL_AT", injection.at.to_string())
        .env("FAIL_LASTING", number(injection.lasting.into()))
        .env("FAIL_ERRNO", fault.errno.to_string())
        .env("FAIL_KINDS", number(fault.kinds))
        .env("FAIL_SHORT", number(fault.short.into()))
        .env("KILL_AT", injection.kill_at.to_string())
        .env("PATROLD_OPERATION", operation)
        .output()
        .expect("runs");
    let report = fs::read_to_string(root.with_extension("report")).unwrap_or_default();
    if ran.status.signal() == Some(KILLED) {
        let calls = None;
        return ChildRun { report, calls };
    }
    let err = String::from_utf8_lossy(&ran.stderr);
    assert!(
        ran.status.success(),
        "{operation} {injection:?}: {report}; {err}"
    );
    let calls = fs::read_to_string(root.with_extension("calls")).expect("counted");
    ChildRun {
        report,
        calls: Some(calls.parse().expect("a number")),
    }
}

/// Calls of an operation on a copy of `template`, without a fault.
pub(crate) fn count_calls(operation: &str, template: &Path) -> usize {
    let (_dir, root) = copy_of(template);
    let calls = run_child(operation, &root, Injection::NONE).calls;
    let calls = calls.expect("not killed");
    assert!(calls > 20, "{operation}: {calls} calls are counted");
    calls
}

pub(crate) fn copy_of(template: &Path) -> (tempfile::TempDir, PathBuf) {
    let dir = fast_dir();
    let root = dir.path().join("root");
    copy_store(template, &root);
    (dir, root)
}

/// `check` after a fault at every call: once, or from then on.
pub(crate) fn fail_each_call(
    operation: &str,
    template: &Path,
    faults: &[(CallFault, bool)],
    check: impl Fn(&Path, &str, &str),
) {
    let calls = count_calls(operation, template);
    for (fault, lasting) in faults {
        for at in 0..calls {
            let (_dir, root) = copy_of(template);
            let injection = Injection::of(*fault, at, *lasting);
            let report = run_child(operation, &root, injection).report;
            check(
                &root,
                &report,
                &format!("{operation}: {injection:?}: {report}"),
            );
        }
    }
}

/// Each fault once, and from then on.
pub(crate) fn once_and_lasting(faults: &[CallFault]) -> Vec<(CallFault, bool)> {
    let both = |fault: &CallFault| [(*fault, false), (*fault, true)];
    faults.iter().flat_map(both).collect()
}
