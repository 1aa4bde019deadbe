//! The built program as systemd and a shell see it, without devices.

use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// The program with the configuration in `dir`, not yet started.
pub(crate) fn patrold(dir: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patrold"));
    command
        .args(arguments)
        .arg("--config")
        .arg(dir.join("patrold.toml"))
        .env_remove("JOURNAL_STREAM")
        .env_remove("NOTIFY_SOCKET");
    command
}

pub(crate) fn configure(dir: &Path, more: &str) {
    let text = format!(
        "store.dir = {:?}\napi.socket = {:?}\nlaser.port = {:?}\nptu.port = {:?}\n{more}",
        dir.join("store"),
        dir.join("patrold.sock"),
        dir.join("no-laser"),
        dir.join("no-ptu"),
    );
    std::fs::write(dir.join("patrold.toml"), text).expect("configuration written");
}

/// Messages that are not waited for, in a row: one each 0.2 s by [`run_under_systemd`]'s watchdog.
const MAX_OTHER_MESSAGES: usize = 300;

/// The socket that systemd gives a service for its notifications.
pub(crate) struct NotifySocket(UnixDatagram);

impl NotifySocket {
    pub(crate) fn listen(dir: &Path) -> Self {
        let socket = UnixDatagram::bind(dir.join("notify")).expect("bound");
        let timeout = Some(Duration::from_secs(20));
        socket.set_read_timeout(timeout).expect("set");
        Self(socket)
    }

    /// Until nothing comes for a while.
    pub(crate) fn read_all(&self) {
        let mut buffer = [0; 4096];
        while self.0.recv(&mut buffer).is_ok() {}
    }

    /// The next message that contains `wanted`.
    pub(crate) fn wait_for(&self, wanted: &str) -> String {
        let mut buffer = [0; 4096];
        let mut others = Vec::new();
        // A service that lives sends WATCHDOG=1 for ever.
        while others.len() < MAX_OTHER_MESSAGES {
            let received = self.0.recv(&mut buffer);
            let count = received.unwrap_or_else(|e| panic!("waiting for {wanted}: {e}"));
            let text = String::from_utf8_lossy(&buffer[..count]).into_owned();
            if text.contains(wanted) {
                return text;
            }
            others.push(text);
        }
        others.dedup();
        panic!("waiting for {wanted}, got {others:?}");
    }
}

/// Starts the service as systemd does, with a notification socket and a watchdog time-out of 0.4 s.
pub(crate) fn run_under_systemd(dir: &Path) -> (NotifySocket, Child) {
    let notify = NotifySocket::listen(dir);
    let child = patrold(dir, &["run"])
        .env("NOTIFY_SOCKET", dir.join("notify"))
        .env("WATCHDOG_USEC", "400000")
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    (notify, child)
}

/// Ends the service; what it has logged.
pub(crate) fn terminate(mut child: Child) -> String {
    signal(&child, "-TERM");
    let mut log = String::new();
    let mut pipe = child.stderr.take().expect("piped");
    std::io::Read::read_to_string(&mut pipe, &mut log).expect("a log");
    assert_eq!(child.wait().expect("ends").code(), Some(0));
    log
}

pub(crate) fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([name, &child.id().to_string()])
        .status();
    assert!(sent.expect("kill runs").success());
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn systemd_is_notified_and_the_shell_gets_exit_codes() {
    let dir = tempfile::tempdir().expect("temp dir");
    let dir = dir.path();
    configure(dir, "");
    let (notify, child) = run_under_systemd(dir);

    notify.wait_for("READY=1");
    notify.wait_for("STATUS=devices lost: ");
    notify.wait_for("WATCHDOG=1");

    signal(&child, "-HUP");
    assert!(notify.wait_for("RELOADING=1").contains("MONOTONIC_USEC="));
    notify.wait_for("READY=1");
    configure(dir, "laser.prot = \"x\"\n");
    signal(&child, "-HUP");
    notify.wait_for("RELOADING=1");
    notify.wait_for("READY=1");
    configure(dir, "");

    let second = patrold(dir, &["run"]).output().expect("runs");
    let error = stderr(&second);
    let pid = child.id();
    let expected = format!("patrold: another patrold (pid {pid}) already uses ");
    assert_eq!(second.status.code(), Some(1));
    assert!(
        error.starts_with(&expected) && error.lines().count() == 1,
        "{error}"
    );

    let visit = patrold(dir, &["visit", "hall"]).output().expect("runs");
    assert_eq!(visit.status.code(), Some(1));
    assert!(
        stderr(&visit).starts_with("patrold: unknown waypoint \"hall\""),
        "{}",
        stderr(&visit)
    );
    let teach = patrold(dir, &["teach", "hall"]).output().expect("runs");
    assert_eq!(teach.status.code(), Some(1));
    assert!(
        stderr(&teach).starts_with("patrold: teach refused: no devices: "),
        "{}",
        stderr(&teach)
    );

    let log = terminate(child);
    notify.wait_for("STOPPING=1");
    assert!(log.contains("laser.port?"), "the error is logged: {log}");
    assert!(!log.contains('\u{1b}'), "no colour in a file");

    let stopped = patrold(dir, &["visit", "hall"]).output().expect("runs");
    assert_eq!(stopped.status.code(), Some(1));
    assert!(
        stderr(&stopped).ends_with("start it: systemctl start patrold\n"),
        "{}",
        stderr(&stopped)
    );
}

#[test]
fn all_configuration_errors_are_reported_at_once() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "laser.prot = \"x\"\nnovelty.u_th_m = nan\n");
    let run = patrold(dir.path(), &["run"]).output().expect("runs");
    assert_eq!(run.status.code(), Some(2));
    assert_eq!(stderr(&run).lines().count(), 2, "{}", stderr(&run));
}

#[test]
fn a_missing_device_is_logged_once() {
    let dir = tempfile::tempdir().expect("temp dir");
    let dir = dir.path();
    configure(dir, "");
    let (notify, child) = run_under_systemd(dir);
    // Found missing, tried again, found missing again.
    notify.wait_for("STATUS=devices lost: ");
    notify.wait_for("STATUS=starting");
    notify.wait_for("STATUS=devices lost: ");
    let log = terminate(child);
    // The first one that is found missing; the other one where it was found so by then.
    let times = |of_health: bool| {
        ["no-laser", "no-ptu"].map(|missing| {
            let named = log.lines().filter(|line| line.contains(missing));
            named
                .filter(|line| line.contains(" health: ") == of_health)
                .count()
        })
    };
    let of_ports = times(false);
    assert!(
        of_ports.contains(&1) && of_ports.iter().all(|n| *n <= 1),
        "{log}"
    );
    // The incident of the watch that cannot see, beside them.
    assert!(times(true).iter().all(|n| *n <= 1), "{log}");
}
