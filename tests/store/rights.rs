//! The service's user and a member of its group use one store, in every order of start, stop, kill, read and write. Needs root.

use super::kit::{changed_visit, raised, stamp, teach};
use patrold::store::{Store, VisitOutcome};
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, chown};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Numbers that no user of the machine has: user and group of the service, a member of that group, a stranger.
const SERVICE: u32 = 61_001;
const GROUP: u32 = 61_000;
const MEMBER: u32 = 61_002;
const STRANGER: u32 = 61_003;

struct House {
    dir: tempfile::TempDir,
    program: PathBuf,
    service: Option<Child>,
    alarm: i64,
}

impl House {
    /// `None` with the reason printed where this test cannot run.
    fn new() -> Option<Self> {
        let can = rustix::process::geteuid().is_root()
            && Command::new("setpriv").arg("--version").output().is_ok();
        if !can {
            eprintln!("skipped: needs root and setpriv, to be two users");
            return None;
        }
        let dir = tempfile::tempdir().expect("temp dir");
        set_mode(dir.path(), 0o755);
        let store = dir.path().join("store");
        fs::create_dir(&store).expect("made");
        let alarm = {
            let mut store = Store::open(&store).expect("new");
            teach(&mut store, "hall", 1);
            let reference = store.reference("hall").expect("taught").id;
            let outcome: VisitOutcome = changed_visit("hall", reference, 3.0, |visit| {
                store.record_visit(visit, &stamp(2)).expect("recorded")
            });
            store.close();
            raised(&outcome)[0]
        };
        // The program where both users may run it.
        let program = dir.path().join("patrold");
        fs::copy(env!("CARGO_BIN_EXE_patrold"), &program).expect("copied");
        set_mode(&program, 0o755);
        let run = dir.path().join("run");
        fs::create_dir(&run).expect("made");
        chown(&run, Some(SERVICE), Some(GROUP)).expect("root may");
        set_mode(&run, 0o750);
        give(&store);
        set_mode(&store, 0o2770);
        set_mode(&store.join("blobs"), 0o2770);
        let text = format!(
            "store.dir = {store:?}\napi.socket = {:?}\nlaser.port = \"/nowhere/laser\"\nptu.port = \"/nowhere/ptu\"\n",
            run.join("patrold.sock")
        );
        fs::write(dir.path().join("patrold.toml"), text).expect("written");
        Some(Self {
            dir,
            program,
            service: None,
            alarm,
        })
    }

    fn store(&self) -> PathBuf {
        self.dir.path().join("store")
    }

    fn socket(&self) -> PathBuf {
        self.dir.path().join("run/patrold.sock")
    }

    fn command(&self, user: u32, umask: &str, arguments: &[&str]) -> Command {
        let (own, groups) = match user {
            SERVICE => (GROUP, GROUP.to_string()),
            MEMBER => (MEMBER, GROUP.to_string()),
            other => (other, other.to_string()),
        };
        let mut command = Command::new("sh");
        command
            .arg("-c")
            .arg(format!(
                "umask {umask}; exec setpriv --reuid {user} --regid {own} --groups {groups} \"$@\""
            ))
            .arg("sh")
            .arg(&self.program)
            .args(arguments)
            .arg("--config")
            .arg(self.dir.path().join("patrold.toml"))
            .env_remove("JOURNAL_STREAM")
            .env_remove("NOTIFY_SOCKET");
        command
    }

    fn run(&self, user: u32, umask: &str, arguments: &[&str]) -> Output {
        let output = self.command(user, umask, arguments).output();
        output.expect("the program starts")
    }

    fn start(&mut self) {
        if self.service.is_some() {
            return;
        }
        let _ = fs::remove_file(self.socket());
        let mut child = self
            .command(SERVICE, "007", &["run"])
            .stderr(Stdio::null())
            .spawn()
            .expect("starts");
        let limit = Instant::now() + Duration::from_secs(60);
        while !self.socket().exists() {
            let ended = child.try_wait().expect("asked");
            assert!(ended.is_none(), "the service does not start: {ended:?}");
            assert!(Instant::now() < limit, "the service does not listen");
            std::thread::sleep(Duration::from_millis(5));
        }
        self.service = Some(child);
    }

    fn end(&mut self, signal: &str) {
        if let Some(mut child) = self.service.take() {
            let sent = Command::new("kill")
                .args([signal, &child.id().to_string()])
                .status();
            assert!(sent.expect("kill runs").success());
            child.wait().expect("ends");
        }
    }

    fn step(&mut self, step: Step) {
        let alarm = self.alarm.to_string();
        let (user, umask, arguments) = match step {
            Step::Start => return self.start(),
            Step::Stop => return self.end("-TERM"),
            Step::Kill => return self.end("-KILL"),
            Step::Read => (MEMBER, "022", vec!["alarms", "--json"]),
            Step::Write => (MEMBER, "077", vec!["alarms", "ack", &alarm]),
            Step::OwnRead => (SERVICE, "022", vec!["visits", "--json"]),
        };
        let output = self.run(user, umask, &arguments);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{step:?}: {output:?}\n{}",
            listing(&self.store())
        );
    }
}

impl Drop for House {
    fn drop(&mut self) {
        self.end("-KILL");
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Start,
    Stop,
    Kill,
    /// The member of the group reads.
    Read,
    /// The member of the group acknowledges.
    Write,
    /// The service's own user reads.
    OwnRead,
}

const STEPS: [Step; 6] = [
    Step::Start,
    Step::Stop,
    Step::Kill,
    Step::Read,
    Step::Write,
    Step::OwnRead,
];

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("set");
}

fn give(path: &Path) {
    chown(path, Some(SERVICE), Some(GROUP)).expect("root may");
    if path.is_dir() {
        for entry in fs::read_dir(path).expect("listed") {
            give(&entry.expect("an entry").path());
        }
    }
}

fn listing(dir: &Path) -> String {
    let output = Command::new("ls").args(["-lan"]).arg(dir).output();
    String::from_utf8_lossy(&output.expect("ls runs").stdout).into_owned()
}

/// Every step after every pair of steps: a sequence in which each three of them stand in each order.
fn every_order() -> Vec<Step> {
    // De Bruijn's sequence by the greedy rule: the last step that gives a new triple.
    let count = STEPS.len();
    let mut seen = std::collections::BTreeSet::new();
    let mut steps = vec![0, 0];
    loop {
        let pair = [steps[steps.len() - 2], steps[steps.len() - 1]];
        let next = (0..count).rev().find(|next| !seen.contains(&(pair, *next)));
        let Some(next) = next else {
            break;
        };
        seen.insert((pair, next));
        steps.push(next);
    }
    assert_eq!(seen.len(), count.pow(3));
    steps.into_iter().map(|at| STEPS[at]).collect()
}

#[test]
fn every_order_of_both_users_works() {
    let Some(mut house) = House::new() else {
        return;
    };
    // As an earlier version left it.
    set_mode(&house.store().join("patrold.db"), 0o640);
    house.start();
    for (nth, step) in every_order().into_iter().enumerate() {
        if nth % 20 == 0 {
            eprintln!("step {nth}: {step:?}");
        }
        house.step(step);
    }
    house.end("-TERM");
    let store = Store::open_for_reading(&house.store()).expect("whole");
    let alarm = store.alarm(house.alarm).expect("kept");
    let by = alarm.acknowledged_by.expect("acknowledged");
    assert!(by.contains(&MEMBER.to_string()), "{by}");
    assert!(store.check(|_, _| ()).expect("checked").is_sound());
}

#[test]
fn a_stranger_is_told_that_it_is_the_rights() {
    let Some(mut house) = House::new() else {
        return;
    };
    let commands = [
        &["alarms"][..],
        &["alarms", "ack", "1"],
        &["visits"],
        &["waypoints"],
        &["store", "rebuild"],
        &["restore", "/nowhere"],
    ];
    for running in [false, true] {
        if running {
            house.start();
        }
        for command in commands {
            let output = house.run(STRANGER, "022", command);
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{command:?} {error}");
            assert!(!error.contains("no database here"), "{command:?} {error}");
            let remedy = error.contains("usermod -aG 61000");
            assert!(remedy && error.lines().count() == 1, "{command:?} {error}");
        }
    }
    house.end("-TERM");
    // A file that somebody else made unreadable is named.
    let db = house.store().join("patrold.db");
    set_mode(&db, 0o600);
    let output = house.run(MEMBER, "022", &["alarms"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    let remedy = format!("as its owner, chmod g+rw {}", db.display());
    assert!(
        error.contains("this user may not use it") && error.contains(&remedy),
        "{error}"
    );
    // What a reader of an earlier version left keeps the service from its own store, and is named.
    set_mode(&db, 0o660);
    let shm = house.store().join("patrold.db-shm");
    fs::write(&shm, b"").expect("written");
    chown(&shm, Some(MEMBER), Some(GROUP)).expect("root may");
    set_mode(&shm, 0o640);
    let output = house.run(SERVICE, "007", &["alarms", "ack", "1"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains(&format!("chmod g+rw {}", shm.display())),
        "{error}"
    );
    fs::remove_file(&shm).expect("removed");
    // Where there is none, that is what is said.
    fs::remove_file(&db).expect("removed");
    let output = house.run(MEMBER, "022", &["alarms"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(error.contains("no database here"), "{error}");
}
