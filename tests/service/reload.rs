//! `patrold reload` and `patrold status` against a running service, and a start with a bad configuration.

use crate::process::{NotifySocket, configure, patrold, signal, stderr};
use crate::schema;
use patrold::store::Store;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

/// A service that does not outlive its test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(dir: &Path) -> Running {
    let notify = NotifySocket::listen(dir);
    let child = patrold(dir, &["run"])
        .env("NOTIFY_SOCKET", dir.join("notify"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    notify.wait_for("READY=1");
    // systemd reads every one: a service that is not read waits.
    std::thread::spawn(move || notify.read_all());
    Running(child)
}

/// Stops the service; its log.
fn stop(dir: &Path, mut running: Running) -> String {
    signal(&running.0, "-TERM");
    assert_eq!(running.0.wait().expect("ends").code(), Some(0));
    let mut log = String::new();
    let mut pipe = running.0.stderr.take().expect("piped");
    std::io::Read::read_to_string(&mut pipe, &mut log).expect("a log");
    std::fs::remove_file(dir.join("notify")).expect("removed");
    log
}

fn run(dir: &Path, args: &[&str]) -> Output {
    patrold(dir, args).output().expect("runs")
}

fn json(name: &str, output: &Output) -> Value {
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
    schema::check(name, &json);
    json
}

fn events(dir: &Path) -> Vec<String> {
    let store = Store::open_for_reading(&dir.join("store")).expect("a store");
    store
        .events(100)
        .expect("events")
        .into_iter()
        .map(|event| event.text)
        .collect()
}

#[test]
fn the_exit_code_of_reload_says_whether_the_file_was_taken() {
    let dir = tempfile::tempdir().expect("temp dir");
    let dir = dir.path();
    configure(dir, "");
    let none = run(dir, &["reload"]);
    assert_eq!(none.status.code(), Some(1), "{none:?}");
    assert!(stderr(&none).contains("no service at"), "{}", stderr(&none));
    let child = start(dir);

    let untouched = json("status-report", &run(dir, &["status", "--json"]));
    assert_eq!(untouched["service"]["running"], true);
    let status = &untouched["service"]["status"];
    schema::check("status", status);
    assert_eq!(status["config_read"]["taken"], true);

    configure(dir, "robot.name = \"new\"\nlog.to = \"stderr\"\n");
    let taken = run(dir, &["reload", "--json"]);
    assert_eq!(taken.status.code(), Some(0), "{taken:?}");
    let reply = json("reload", &taken);
    assert_eq!(
        (&reply["taken"], &reply["needs_restart"][0]),
        (&true.into(), &"log.to".into())
    );
    let text = run(dir, &["status"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.starts_with("service: up, new, patrold "), "{text}");

    configure(
        dir,
        "robot.name = \"bad\"\nlaser.prot = \"x\"\n[Novelty]\nu_th = 1\n",
    );
    let refused = run(dir, &["reload", "--json"]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    let reply = json("reload", &refused);
    assert_eq!(
        (&reply["taken"], reply["mistakes"].as_array().map(Vec::len)),
        (&false.into(), Some(2))
    );
    let error = stderr(&refused);
    assert!(
        error.contains("laser.port?") && error.contains("[novelty]?"),
        "{error}"
    );
    let report = json("status-report", &run(dir, &["status", "--json"]));
    let status = &report["service"]["status"];
    assert_eq!(
        (&status["robot"], &status["config_read"]["taken"]),
        (&"new".into(), &false.into())
    );
    assert_eq!(
        report["configuration"]["mistakes"].as_array().map(Vec::len),
        Some(2)
    );
    let text = run(dir, &["status"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains("NOT taken") && text.contains("laser.port?"),
        "{text}"
    );

    // A broken file stops no reader.
    for args in [
        &["alarms"][..],
        &["visits"],
        &["events"],
        &["waypoints"],
        &["status"],
    ] {
        let ran = run(dir, args);
        assert_eq!(ran.status.code(), Some(0), "{args:?} {ran:?}");
    }
    configure(dir, "robot.name = \"again\"\n");
    assert_eq!(run(dir, &["reload"]).status.code(), Some(0));
    stop(dir, child);
}

#[test]
fn a_start_with_a_bad_configuration_uses_the_last_good_one() {
    let dir = tempfile::tempdir().expect("temp dir");
    let dir = dir.path();
    configure(dir, "robot.name = \"rex\"\n");
    let child = start(dir);
    stop(dir, child);

    configure(dir, "robot.name = \"max\"\nlaser.prot = \"x\"\n");
    let child = start(dir);
    let report = json("status-report", &run(dir, &["status", "--json"]));
    let status = &report["service"]["status"];
    assert_eq!(status["robot"], "rex");
    assert_eq!(status["config_read"]["taken"], false);
    assert!(
        status["config_files"][0]
            .as_str()
            .is_some_and(|f| f.ends_with("last-good.toml"))
    );
    let loud = "the configuration has mistakes; the last good one is in force: ";
    let is_loud = |text: &String| text.starts_with(loud) && text.contains("laser.port?");
    // The writer may still be at it when the service is ready.
    let deadline = Instant::now() + Duration::from_secs(60);
    while !events(dir).iter().any(is_loud) {
        assert!(Instant::now() < deadline, "{:?}", events(dir));
        std::thread::yield_now();
    }
    // Mended, it is taken without a restart, and kept.
    configure(dir, "robot.name = \"max\"\n");
    assert_eq!(run(dir, &["reload"]).status.code(), Some(0));
    let log = stop(dir, child);
    assert!(log.contains(loud), "{log}");
    configure(dir, "[novelty\n");
    let child = start(dir);
    let report = json("status-report", &run(dir, &["status", "--json"]));
    assert_eq!(report["service"]["status"]["robot"], "max");
    stop(dir, child);

    let down = run(dir, &["status", "--json"]);
    assert_eq!(down.status.code(), Some(0));
    let report = json("status-report", &down);
    assert_eq!(
        (&report["service"]["running"], &report["store"]["error"]),
        (&false.into(), &Value::Null)
    );
    let text = run(dir, &["status"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.starts_with("service: down (no service at "), "{text}");
}
