//! Taking a reference: what refuses it, and what `alarms accept` makes normal without one.

use super::faulty_disk::{Fault, FaultyDisk};
use super::harness::{ScriptedScanner, ScriptedSweep, TestService, configure, parts};
use super::{AFTER, BEFORE, events, process, schema};
use patrold::store::Store;
use std::process::Output;
use std::sync::Arc;

#[test]
fn a_teach_whose_client_disconnected_leaves_no_reference() {
    use std::io::Write as _;
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(ScriptedSweep::Endless));
    let teach = |waypoint: &str| {
        let mut stream =
            std::os::unix::net::UnixStream::connect(service.socket()).expect("the socket listens");
        let body = format!("{{\"waypoint\": {waypoint:?}}}");
        write!(
            stream,
            "POST /teach HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n\
             content-length: {}\r\n\r\n{body}",
            body.len()
        )
        .expect("sent");
        stream
    };
    let first = teach("a");
    service.until("it is sweeping", |s| s.status()["phase"] == "sweeping");
    let second = teach("b");
    service.until("the second waits", |s| s.status()["waiting"] == 1);
    drop(second);
    service.until("the second is dropped", |s| s.status()["waiting"] == 0);
    drop(first);
    service.until("the first is cancelled", |s| s.status()["phase"] == "idle");
    assert_eq!(service.scanner.script().sweeps, 1, "no sweep for b");
    service.scanner.script().sweep = BEFORE;
    assert_eq!(service.post("/teach", "c").status, 200);
    let logged = events(&service);
    for text in ["teach a dropped: the client", "teach b dropped: the client"] {
        assert!(logged.iter().any(|e| e.starts_with(text)), "{logged:?}");
    }
    let store = Store::open_for_reading(&service.dir.join("store"))
        .expect("readable while the service runs");
    let names = store.waypoints().expect("waypoints");
    assert_eq!(names.len(), 1, "only c");
    service.stop();
}

#[test]
fn teaching_over_an_alarm_is_a_decision_and_accepting_it_needs_no_drive() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let (scanner, disk) = (ScriptedScanner::new(BEFORE), FaultyDisk::default());
    let mut parts = parts(dir.path(), &scanner);
    parts.disk = Arc::new(disk.clone());
    let service = TestService::start_with(dir.path(), &scanner, parts);
    assert_eq!(service.post("/teach", "hall").status, 200);
    let sweeps = service.scanner.script().sweeps;
    let slip = service.post("/teach", "halls");
    assert_eq!(slip.status, 409, "{}", slip.error());
    assert!(
        slip.error()
            .contains("but \"hall\"; for a new one give --new")
    );
    assert_eq!(service.visit(AFTER)["alarm"]["id"], 1);
    let refused = service.post("/teach", "hall");
    assert_eq!(refused.status, 409);
    assert!(
        refused.error().contains("hall: alarm 1 is not cleared"),
        "{}",
        refused.error()
    );
    assert_eq!(
        service.scanner.script().sweeps,
        sweeps + 1,
        "no sweep for these"
    );

    let accept = |id: &str| {
        let run = process::patrold(dir.path(), &["alarms", "accept", id, "--by", "ana"]).output();
        run.expect("runs")
    };
    let normal = |accepted: &Output, alarm: i64, version: i64| {
        let text = String::from_utf8_lossy(&accepted.stdout).into_owned();
        let expected = format!("alarm {alarm}: normal from reference hall/{version} on");
        assert_eq!(text.trim(), expected, "{accepted:?}");
    };
    disk.fail(Fault::Full, 0, true);
    assert_eq!(accept("1").status.code(), Some(1), "no room for the view");
    disk.heal();
    assert_eq!(alarm_state(&service), "open", "nobody has seen to it");
    normal(&accept("1"), 1, 2);
    assert_eq!(accept("1").status.code(), Some(1), "once");
    for (body, status) in [
        (r#"{"id": 1}"#, 409),
        (r#"{"id": 99}"#, 404),
        (r#"{"id": "1"}"#, 400),
    ] {
        let answer = service.request("POST", "/accept", body);
        assert_eq!(answer.status, status, "{body}: {}", answer.error());
    }
    // The box is normal, and so is what it hides; without it, the place has changed.
    let with = service.visit(AFTER);
    assert_eq!(
        (&with["verdict"], &with["frame"]),
        (&"quiet".into(), &"hall/1".into()),
        "{with}"
    );
    assert_eq!(
        with["novelties"].as_array().map(Vec::len),
        Some(0),
        "{with}"
    );
    let without = service.visit(BEFORE);
    assert_eq!(without["verdict"], "changed", "{without}");
    assert_eq!(without["novelties"][0]["kind"], "disappeared");

    let other = service.request("POST", "/teach", r#"{"waypoint": "hall", "accept": [1]}"#);
    assert_eq!(other.status, 409, "alarm 1 is over, 2 stands");
    let taught = service.request("POST", "/teach", r#"{"waypoint": "hall", "accept": [2]}"#);
    assert_eq!(taught.status, 200, "{}", taught.json());
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    let is_accepted = |text: &String| {
        text.starts_with("alarm 1 accepted by ana (user ") && text.ends_with(": reference hall/2")
    };
    assert!(events(&service).iter().any(is_accepted));

    // The user is the one that the socket sees, and without a service the one that runs the command.
    assert_eq!(service.visit(AFTER)["alarm"]["id"], 3);
    let reply = service.request("POST", "/accept", r#"{"id": 3, "by": "bo"}"#);
    assert_eq!(reply.status, 200, "{}", reply.json());
    schema::check("accept", &reply.json());
    assert_eq!(reply.json()["version"], 4);
    let signed = |by: &str| by.starts_with("bo (user ");
    assert!(
        reply.json()["by"].as_str().is_some_and(signed),
        "{}",
        reply.json()
    );
    assert_eq!(service.visit(BEFORE)["alarm"]["id"], 4);
    service.stop();
    let report = process::patrold(
        dir.path(),
        &["alarms", "accept", "4", "--by", "bo", "--json"],
    );
    let report = { report }.output().expect("runs");
    let report: serde_json::Value = serde_json::from_slice(&report.stdout).expect("JSON");
    schema::check("alarms-accepted", &report);
    assert_eq!(report["accepted"][0]["version"], 5);
    assert!(
        report["accepted"][0]["by"].as_str().is_some_and(signed),
        "{report}"
    );
}

#[test]
fn a_name_that_is_nearly_known_is_asked_about_on_a_terminal_and_refused_off_it() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    let slip = service.post("/teach", "halls").json();
    assert_eq!(slip["nearly"], "hall", "{slip}");
    let known = || {
        let store = Store::open_for_reading(&dir.path().join("store")).expect("readable");
        store.waypoints().expect("waypoints").len()
    };
    let teach = |name: &str, answer: Option<&str>| {
        let mut terminal = link::PseudoTerminal::open(None).expect("a terminal");
        let mut command = process::patrold(dir.path(), &["teach", name]);
        if let Some(answer) = answer {
            let slave = std::fs::File::open(terminal.slave_path()).expect("opens");
            command.stdin(slave);
            // It waits in the terminal until it is read.
            terminal.write(answer.as_bytes()).expect("typed");
        } else {
            command.stdin(std::process::Stdio::null());
        }
        let run = command.output().expect("runs");
        (run.status.code(), process::stderr(&run))
    };
    let sweeps = service.scanner.script().sweeps;
    let (code, text) = teach("halls", None);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("for a new one give --new"), "{text}");
    for answer in ["n\n", "\n"] {
        let (code, text) = teach("halls", Some(answer));
        assert_eq!(code, Some(1), "{text}");
        assert!(
            text.contains("there is no waypoint halls, but hall; is halls a new one? [y/N]"),
            "{text}"
        );
        assert!(text.contains("halls: not taught"), "{text}");
    }
    assert_eq!(
        (known(), service.scanner.script().sweeps),
        (1, sweeps),
        "nothing was done"
    );
    let (code, text) = teach("halls", Some("y\n"));
    assert_eq!((code, known()), (Some(0), 2), "{text}");
    // Known, and far from all: nobody is asked.
    for name in ["halls", "warehouse"] {
        let (code, text) = teach(name, None);
        assert_eq!(code, Some(0), "{text}");
    }
    service.stop();
}

fn alarm_state(service: &TestService) -> String {
    let store = Store::open_for_reading(&service.dir.join("store")).expect("readable");
    store.alarm(1).expect("raised").state
}
