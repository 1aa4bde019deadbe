//! The service as its clients see it: over its socket, with a scripted scanner in simulated scenes.

mod emulated;
#[path = "../harness/faulty_disk.rs"]
mod faulty_disk;
mod harness;
mod health;
mod process;
mod references;
mod reload;
mod restoring;
#[path = "../harness/schema.rs"]
mod schema;
mod socket;
mod storage;
#[path = "../harness/stored_mixture.rs"]
mod stored_mixture;
mod teaching;
mod wall_time;

use harness::{ScriptedScanner, ScriptedSweep, TestService, configure, parts, points};
use patrold::service::replies::VisitReply;
use patrold::service::{ServiceCommand, ServiceError, serve};
use patrold::store::{AlarmFilter, Store};
use std::time::Duration;
use tokio::sync::mpsc;

const BEFORE: ScriptedSweep = ScriptedSweep::Scene("storeroom.toml");
const AFTER: ScriptedSweep = ScriptedSweep::Scene("storeroom-box-left.toml");

fn events(service: &TestService) -> Vec<String> {
    let store = Store::open_for_reading(&service.dir.join("store"))
        .expect("readable while the service runs");
    let events = store.events(100).expect("events");
    events.into_iter().map(|e| e.text).collect()
}

#[test]
fn a_round_from_teaching_to_an_alarm_and_its_clearing() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));

    let unknown = service.post("/visit", "hall");
    assert_eq!(
        (
            unknown.status,
            unknown.error().contains("patrold teach hall")
        ),
        (404, true)
    );
    assert_eq!(service.scanner.script().sweeps, 0, "no sweep for it");

    let taught = service.post("/teach", "hall");
    assert_eq!(taught.status, 200, "{}", taught.json());
    assert_eq!(taught.json()["version"], 1);
    assert!(taught.json()["components"].as_u64() > Some(20));

    let quiet = service.visit(BEFORE);
    assert_eq!(quiet["verdict"], "quiet", "{quiet}");
    assert!(quiet["alarm"].is_null());

    let changed = service.visit(AFTER);
    assert_eq!(changed["verdict"], "changed", "{changed}");
    assert_eq!(changed["alarm"]["raised"], true);
    assert_eq!(changed["frame"], "hall/1");
    assert!(changed["d_gmm"].as_f64() >= changed["u_th"].as_f64());
    assert_eq!(changed["novelties"][0]["kind"], "appeared");
    let store = Store::open_for_reading(&service.dir.join("store"))
        .expect("readable while the service runs");
    let alarms = store.alarms(&AlarmFilter::default()).expect("alarms");
    assert_eq!(alarms.len(), 1, "on disk before the reply");
    assert_eq!(Some(alarms[0].id), changed["alarm"]["id"].as_i64());

    let again = service.visit(AFTER);
    assert_eq!(again["alarm"]["raised"], false, "{again}");
    assert_eq!(again["alarm"]["id"], changed["alarm"]["id"]);

    let json = process::patrold(dir.path(), &["visit", "hall", "--json"])
        .output()
        .expect("runs");
    assert_eq!(json.status.code(), Some(10), "{json:?}");
    let reply: VisitReply = serde_json::from_slice(&json.stdout).expect("the JSON of a visit");
    assert_eq!(reply.verdict, "changed");
    let text = process::patrold(dir.path(), &["visit", "hall"])
        .output()
        .expect("runs");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.starts_with("hall: changed ("), "{text}");
    assert!(text.contains("alarm 1 seen again"), "{text}");

    let gone = service.visit(BEFORE);
    assert_eq!(
        (&gone["verdict"], &gone["cleared"][0]),
        (&"quiet".into(), &changed["alarm"]["id"])
    );

    let swept = service.request("POST", "/sweep", "");
    assert_eq!(swept.status, 200);
    assert!(points(&swept.body).len() > 20_000);
    assert!(
        swept.head.contains("x-patrold-sweep: {\"points\":"),
        "{}",
        swept.head
    );

    let cloud = dir.path().join("cloud.ply");
    let out = process::patrold(dir.path(), &["sweep", "--out", &cloud.to_string_lossy()])
        .output()
        .expect("runs");
    assert_eq!(out.status.code(), Some(0), "{out:?}");
    assert!(points(&std::fs::read(&cloud).expect("written")).len() > 20_000);

    let status = service.status();
    assert_eq!(
        (&status["phase"], &status["devices"]["state"]),
        (&"idle".into(), &"ready".into())
    );
    assert_eq!(status["devices"]["identity"]["laser"]["serial"], "H0000000");
    assert!(
        events(&service)
            .iter()
            .any(|e| e == "scripted laser answers")
    );

    let scanner = service.scanner.clone();
    service.stop();
    assert_eq!(scanner.script().released, 1);
}

#[test]
fn a_bad_sweep_is_not_observed_and_never_becomes_a_reference() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);

    let blocked = service.visit(ScriptedSweep::Fail("pan-tilt stalled", true));
    assert_eq!(blocked["verdict"], "not_observed");
    assert_eq!(blocked["reason"], "pan-tilt stalled");
    assert!(blocked["d_gmm"].is_null() && blocked["alarm"].is_null());
    service.until("the devices are opened again", |s| {
        s.scanner.script().connections == 2
    });

    let frozen = service.visit(ScriptedSweep::Frozen);
    assert_eq!(frozen["verdict"], "not_observed");
    assert!(
        frozen["reason"]
            .as_str()
            .is_some_and(|r| r.contains("frozen")),
        "{frozen}"
    );
    assert_eq!(frozen["sweep"]["frozen"], true);

    let refused = service.post("/teach", "hall");
    assert_eq!(
        (refused.status, refused.error().contains("frozen")),
        (422, true)
    );
    service.scanner.script().sweep = ScriptedSweep::Fail("no laser", false);
    assert_eq!(service.post("/teach", "hall").status, 503);

    let store = Store::open_for_reading(&service.dir.join("store"))
        .expect("readable while the service runs");
    let hall = store.waypoint("hall").expect("known");
    assert_eq!(hall.references.len(), 1, "the old reference stays");
    assert_eq!(hall.row.last_verdict.as_deref(), Some("not_observed"));
    service.stop();
}

#[test]
fn without_devices_visits_are_not_observed() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let scanner = ScriptedScanner::new(BEFORE);
    let service = TestService::start(dir.path(), &scanner);
    assert_eq!(service.post("/teach", "hall").status, 200);
    service.stop();

    scanner.script().absent = Some("laser (laser.port): nothing there");
    let service = TestService::start(dir.path(), &scanner);
    service.until("they are lost", |s| {
        s.status()["devices"]["state"] == "lost"
    });
    let visit = service.visit(BEFORE);
    assert_eq!(visit["verdict"], "not_observed");
    assert_eq!(
        visit["reason"],
        "no devices: laser (laser.port): nothing there"
    );
    assert_eq!(service.request("POST", "/sweep", "").status, 503);
    scanner.script().absent = None;
    service.until("they are tried again", |s| {
        s.status()["devices"]["state"] == "ready"
    });
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    service.stop();
}

#[test]
fn a_reload_applies_if_valid_and_is_logged_either_way() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);

    configure(dir.path(), "novelty.u_th_m = 5.0\n");
    service.command(ServiceCommand::Reload);
    service.until("it is in force", |s| {
        events(s).iter().any(|e| e == "configuration reloaded")
    });
    let visit = service.visit(AFTER);
    assert_eq!(
        (&visit["verdict"], &visit["u_th"]),
        (&"quiet".into(), &5.0.into())
    );
    assert!(
        visit["novelties"].as_array().is_some_and(|n| !n.is_empty()),
        "still listed"
    );

    configure(dir.path(), "novelty.uth_m = 5.0\nlaser.baud = \"fast\"\n");
    service.command(ServiceCommand::Reload);
    service.until("it is refused", |s| {
        events(s).iter().any(|e| {
            let both = e.contains("novelty.u_th_m?") && e.contains("laser.baud");
            e.contains("the old one stays") && both
        })
    });
    assert_eq!(service.visit(AFTER)["u_th"], 5.0);
    service.stop();
}

#[test]
fn a_second_service_on_the_same_store_is_refused() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let scanner = ScriptedScanner::new(BEFORE);
    let service = TestService::start(dir.path(), &scanner);
    let (_controls, receiver) = mpsc::channel(1);
    let runtime = tokio::runtime::Runtime::new().expect("runtime");
    let second = runtime.block_on(serve(parts(dir.path(), &scanner), receiver));
    let error = second.expect_err("refused");
    assert!(matches!(error, ServiceError::StoreInUse { .. }), "{error}");
    service.stop();
    assert!(!dir.path().join("patrold.sock").exists());
}

#[test]
fn a_stop_during_a_sweep_is_quick_and_recorded() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    service.scanner.script().sweep = ScriptedSweep::Endless;
    let (scanner, socket) = (service.scanner.clone(), service.socket());
    let client = std::thread::spawn({
        let socket = socket.clone();
        move || {
            let body = "{\"waypoint\": \"hall\"}";
            post_visit(&socket, body)
        }
    });
    service.until("it is sweeping", |s| s.status()["phase"] == "sweeping");
    let took = service.stop();
    assert!(took < Duration::from_secs(3), "{took:?}");
    assert_eq!(scanner.script().released, 1);
    let reply = client.join().expect("no panic");
    assert!(reply.contains("not_observed"), "{reply}");
    let store = Store::open_for_reading(&dir.path().join("store")).expect("store");
    let hall = store.waypoint("hall").expect("known").row;
    assert_eq!(hall.last_verdict.as_deref(), Some("not_observed"));
}

fn post_visit(socket: &std::path::Path, body: &str) -> String {
    use std::io::{Read as _, Write as _};
    let mut stream = std::os::unix::net::UnixStream::connect(socket).expect("the socket listens");
    write!(
        stream,
        "POST /visit HTTP/1.1\r\nhost: x\r\nconnection: close\r\ncontent-type: application/json\r\n\
         content-length: {}\r\n\r\n{body}",
        body.len()
    )
    .expect("sent");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("a reply");
    text
}

#[test]
fn wrong_requests_get_one_line_each() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    for (method, path, body, status) in [
        ("POST", "/visit", "{\"waypoint\": \"two words\"}", 400),
        ("POST", "/visit", "{\"waypoint\": \"", 400),
        ("POST", "/visit", "{\"way\": \"hall\"}", 400),
        ("GET", "/visit", "", 405),
        ("POST", "/nowhere", "", 404),
    ] {
        let answer = service.request(method, path, body);
        assert_eq!(answer.status, status, "{method} {path} {body}");
        assert!(!answer.error().is_empty());
    }
    service.stop();
}

#[test]
fn unplugged_idle_devices_are_logged_and_opened_again() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let service = TestService::start(dir.path(), &ScriptedScanner::new(BEFORE));
    let state = |s: &TestService| s.status()["devices"]["state"].clone();
    service.until("they are ready", |s| state(s) == "ready");
    {
        let mut script = service.scanner.script();
        (script.unplugged, script.absent) = (Some("laser unplugged"), Some("laser absent"));
    }
    service.until("they are lost", |s| state(s) == "lost");
    // The status does not wait for the disk.
    service.until("it is in the event log", |s| {
        events(s).iter().any(|e| e == "laser unplugged")
    });
    {
        let mut script = service.scanner.script();
        (script.unplugged, script.absent) = (None, None);
    }
    // A request does not wait for the next attempt.
    assert_eq!(service.request("POST", "/sweep", "").status, 200);
    assert_eq!(state(&service), "ready");
    service.stop();
}
