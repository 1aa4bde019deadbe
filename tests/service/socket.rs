//! The control socket against hostile and hasty clients: half requests, wrong bodies and names, requests that nobody waits for.

use super::harness::{ScriptedScanner, ScriptedSweep, TestService, configure};
use super::{BEFORE, process, schema};
use patrold::service::ServiceCommand;
use patrold::store::{Store, TimeRange};
use rustix::process::{Resource, getrlimit, setrlimit};
use serde_json::{Value, json};
use std::io::Write as _;
use std::os::unix::net::UnixStream;

fn started(dir: &std::path::Path) -> TestService {
    configure(dir, "");
    let service = TestService::start(dir, &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    service
}

fn visits(service: &TestService) -> usize {
    let store = Store::open_for_reading(&service.dir.join("store")).expect("readable");
    let count = store.count_visits(&TimeRange::default(), Some("hall"));
    usize::try_from(count.expect("counted")).expect("few")
}

#[test]
fn a_visit_beside_half_requests_is_answered_as_usual() {
    const CLIENTS: usize = 1300;
    let limit = getrlimit(Resource::Nofile);
    let wanted = 2 * CLIENTS as u64;
    if limit.maximum.is_some_and(|most| most < wanted) {
        eprintln!(
            "skipped: this user may have {:?} descriptors only",
            limit.maximum
        );
        return;
    }
    let raised = rustix::process::Rlimit {
        current: Some(limit.current.unwrap_or(wanted).max(wanted)),
        ..limit
    };
    setrlimit(Resource::Nofile, raised).expect("the soft limit is ours");
    let dir = tempfile::tempdir().expect("temp dir");
    let service = started(dir.path());
    let halves = [
        "",
        "POST /visit HTTP/1.1\r\nhost: x\r\n",
        "POST /visit HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\ncontent-length: 20\r\n\r\n{",
    ];
    let mut clients = Vec::new();
    for number in 0..CLIENTS {
        let mut client = UnixStream::connect(service.socket()).expect("the socket listens");
        // It may have been closed for a later one already.
        let _ = client.write_all(halves[number % halves.len()].as_bytes());
        clients.push(client);
    }
    let visit = service.visit(BEFORE);
    assert_eq!(visit["verdict"], "quiet", "{visit}");
    assert_eq!(service.status()["phase"], "idle");
    // None of them has more than its descriptor here, and most not even one there.
    let open = std::fs::read_dir("/proc/self/fd").expect("Linux").count();
    assert!(open < CLIENTS + 200, "{open}");
    drop(clients);
    service.stop();
}

#[test]
fn a_wrong_body_or_name_starts_nothing() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = started(dir.path());
    let sweeps = service.scanner.script().sweeps;
    let named = |name: &str| json!({"waypoint": name}).to_string();
    let mut wrong: Vec<(&str, String)> = [
        "..",
        ".",
        "-rf",
        "",
        "/",
        "a/b",
        "a\nb",
        "a\u{0}b",
        "two words",
    ]
    .into_iter()
    .flat_map(|name| [("/visit", named(name)), ("/teach", named(name))])
    .collect();
    for body in [
        "",
        "{",
        "null",
        "7",
        "\"hall\"",
        "[\"hall\"]",
        "[\"a\"]",
        "{}",
        "{\"waypoint\": null}",
        "{\"waypoint\": 7}",
        "{\"waypoint\": [\"hall\"]}",
        "{\"waypoint\": \"hall\", \"speed\": 1}",
        "{\"waypoint\": \"hall\"} x",
        "{\"waypoint\": \"hall\", \"wait\": \"no\"}",
    ] {
        wrong.push(("/visit", body.to_owned()));
        wrong.push(("/teach", body.to_owned()));
    }
    let others = [
        ("/teach", "{\"waypoint\": \"hall\", \"accept\": \"all\"}"),
        ("/teach", "{\"waypoint\": \"hall\", \"new\": 1}"),
        ("/ack", "[1]"),
        ("/ack", "{\"id\": \"1\"}"),
        ("/ack", "{\"id\": 1, \"answer\": \"maybe\"}"),
        ("/ack", "{\"id\": 1, \"because\": \"x\"}"),
        ("/restore", "[\"/tmp\"]"),
        ("/restore", "{\"dir\": \"here\"}"),
        ("/sweep", "{\"waypoint\": \"hall\"}"),
        ("/reload", "now"),
    ];
    wrong.extend(others.map(|(path, body)| (path, body.to_owned())));
    for (path, body) in &wrong {
        let answer = service.request("POST", path, body);
        assert_eq!(answer.status, 400, "{path} {body}");
        assert!(!answer.error().is_empty(), "{path} {body}");
    }
    assert_eq!(service.scanner.script().sweeps, sweeps, "nothing moved");
    assert_eq!(visits(&service), 0);
    for name in ["..", "-rf", "a/b", ""] {
        for command in ["visit", "teach"] {
            let ran = process::patrold(dir.path(), &[command])
                .args(["--", name])
                .output()
                .expect("runs");
            assert_eq!(ran.status.code(), Some(2), "{command} {name}: {ran:?}");
        }
    }
    service.stop();
}

/// The request, once it is in one of `states`.
fn awaited(service: &TestService, id: &Value, states: &[&str]) -> Value {
    let path = format!("/requests/{}", id.as_str().expect("a text"));
    let get = || {
        let answer = service.request("GET", &path, "");
        assert_eq!(answer.status, 200, "{}", answer.json());
        let request = answer.json();
        schema::check("request", &request);
        request
    };
    let is_there = |request: &Value| states.iter().any(|state| request["state"] == *state);
    service.until(&format!("{states:?}"), |_| is_there(&get()));
    get()
}

fn ask_later(service: &TestService, path: &str, waypoint: &str) -> Value {
    let body = json!({"waypoint": waypoint, "wait": false}).to_string();
    let answer = service.request("POST", path, &body);
    assert_eq!(answer.status, 202, "{}", answer.json());
    let request = answer.json();
    schema::check("request", &request);
    let place = format!(
        "location: /requests/{}",
        request["id"].as_str().expect("a text")
    );
    assert!(
        answer.head.to_lowercase().contains(&place),
        "{}",
        answer.head
    );
    request
}

#[test]
fn a_client_that_does_not_wait_gets_its_outcome_later() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    let taught = ask_later(&service, "/teach", "hall");
    assert_eq!(
        (&taught["task"], &taught["waypoint"]),
        (&"teach".into(), &"hall".into())
    );
    // Each request is a connection of its own, which its client has closed.
    let taught = awaited(&service, &taught["id"], &["done"]);
    assert_eq!(taught["teach"]["version"], 1);
    assert!(taught["visit"].is_null() && taught["refusal"].is_null());

    let visit = ask_later(&service, "/visit", "hall");
    assert_ne!(visit["id"], taught["id"]);
    let visit = awaited(&service, &visit["id"], &["done"]);
    assert_eq!(visit["visit"]["verdict"], "quiet", "{visit}");
    assert_eq!(visits(&service), 1, "it is in the log");
    // Both can still be asked for, as often as one likes.
    assert_eq!(awaited(&service, &visit["id"], &["done"]), visit);
    assert_eq!(awaited(&service, &taught["id"], &["done"]), taught);

    let unknown = ask_later(&service, "/visit", "cellar");
    let unknown = awaited(&service, &unknown["id"], &["refused"]);
    assert_eq!(unknown["refusal"]["status"], 404);
    let near = ask_later(&service, "/teach", "halle");
    let near = awaited(&service, &near["id"], &["refused"]);
    assert_eq!(near["refusal"]["nearly"], "hall");
    for (method, path) in [("GET", "/requests/0-1"), ("DELETE", "/requests/0-1")] {
        assert_eq!(service.request(method, path, "").status, 404);
    }
    let id = visit["id"].as_str().expect("a text");
    let late = service.request("DELETE", &format!("/requests/{id}"), "");
    assert_eq!((late.status, late.error().contains("done")), (409, true));
    service.stop();
}

#[test]
fn progress_is_seen_and_a_request_is_ended_by_its_client() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = started(dir.path());
    service.scanner.script().sweep = ScriptedSweep::Endless;
    let first = ask_later(&service, "/visit", "hall");
    let second = ask_later(&service, "/visit", "hall");
    let sweeping = awaited(&service, &first["id"], &["sweeping"]);
    let share = sweeping["progress"]["share"].as_f64().expect("a share");
    assert!((0.0..1.0).contains(&share), "{sweeping}");
    assert!(
        sweeping["progress"]["seconds_left"].is_number(),
        "{sweeping}"
    );
    let mut status = service.status();
    // The scripted devices describe less of themselves than real ones.
    status["devices"]["identity"] = Value::Null;
    schema::check("status", &status);
    assert_eq!(status["current"]["waypoint"], "hall");
    assert_eq!(
        awaited(&service, &second["id"], &["waiting"])["progress"],
        Value::Null
    );

    let end = |request: &Value| {
        let path = format!("/requests/{}", request["id"].as_str().expect("a text"));
        let answer = service.request("DELETE", &path, "");
        assert_eq!(answer.status, 200, "{}", answer.json());
        schema::check("request", &answer.json());
        answer.json()
    };
    // One that waits is dropped and leaves nothing; one whose sweep is under way is a visit that saw nothing.
    assert_eq!(end(&second)["state"], "cancelled");
    let ended = end(&first);
    assert_eq!(ended["cancelled"], true);
    let first = awaited(&service, &first["id"], &["done"]);
    assert_eq!(first["visit"]["verdict"], "not_observed");
    assert_eq!(
        first["visit"]["reason"],
        "cancelled by its client during the sweep"
    );
    assert_eq!(first["cancelled"], true);
    // The devices are as they were.
    service.scanner.script().sweep = BEFORE;
    let third = ask_later(&service, "/teach", "hall");
    let third = awaited(&service, &third["id"], &["done"]);
    assert_eq!(third["teach"]["version"], 2);
    assert_eq!(visits(&service), 1);
    assert_eq!(
        awaited(&service, &second["id"], &["cancelled"])["visit"],
        Value::Null
    );
    service.stop();
}

#[test]
fn too_many_requests_are_refused_at_once_and_a_stop_records_the_one_under_way() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = started(dir.path());
    service.scanner.script().sweep = ScriptedSweep::Endless;
    for _ in 0..5 {
        ask_later(&service, "/visit", "hall");
    }
    service.until("it is sweeping", |s| s.status()["phase"] == "sweeping");
    service.until("four wait", |s| s.status()["waiting"] == 4);
    let body = json!({"waypoint": "hall", "wait": false}).to_string();
    let busy = service.request("POST", "/visit", &body);
    assert_eq!((busy.status, busy.error().contains("busy")), (503, true));
    service.command(ServiceCommand::Reload);
    let store = service.dir.join("store");
    service.stop();
    let store = Store::open_for_reading(&store).expect("readable");
    let hall = store.waypoint("hall").expect("known").row;
    assert_eq!(hall.last_verdict.as_deref(), Some("not_observed"));
}
