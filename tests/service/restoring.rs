//! `patrold restore` and `patrold alarms ack` while the service runs: through its socket, as a shell has them.

use super::harness::{ScriptedScanner, ScriptedSweep, TestService, configure};
use super::{AFTER, BEFORE, events, process, schema};
use patrold::store::{AlarmFilter, Store, TimeRange};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Output;

fn run(dir: &Path, arguments: &[&str]) -> Output {
    process::patrold(dir, arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json_of(output: &Output) -> Value {
    let error = text(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {error}"))
}

fn reader(service: &TestService) -> Store {
    Store::open_for_reading(&service.dir.join("store")).expect("readable while the service runs")
}

fn alarms(service: &TestService) -> usize {
    let alarms = reader(service).alarms(&AlarmFilter::default());
    alarms.expect("alarms").len()
}

fn visits(service: &TestService) -> u64 {
    let all = reader(service).count_visits(&TimeRange::default(), None);
    all.expect("visits")
}

/// A reference and a quiet visit, backed up to `backup`; then a changed visit.
fn service_with_a_backup(dir: &Path) -> TestService {
    configure(dir, "");
    let service = TestService::start(dir, &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    let backup = dir.join("backup");
    let backed_up = run(dir, &["backup", backup.to_str().expect("a path")]);
    assert!(backed_up.status.success(), "{}", text(&backed_up.stderr));
    assert_eq!(service.visit(AFTER)["verdict"], "changed");
    assert_eq!((alarms(&service), visits(&service)), (1, 2));
    service
}

#[test]
fn the_running_service_restores_its_store_between_two_visits_and_goes_on() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = service_with_a_backup(dir.path());
    // A visit is under way, and another one waits.
    service.scanner.script().sweep = ScriptedSweep::Endless;
    let post = |service: &TestService| {
        let socket = service.socket();
        let body = json!({"waypoint": "hall"}).to_string();
        std::thread::spawn(move || super::post_visit(&socket, &body))
    };
    let first = post(&service);
    service.until("it is sweeping", |s| s.status()["phase"] == "sweeping");
    let second = post(&service);
    service.until("the second waits", |s| s.status()["waiting"] == 1);
    let place = dir.path().to_owned();
    // From another folder: the service has its own.
    let restore = std::thread::spawn(move || {
        let mut command = process::patrold(&place, &["restore", "backup", "--json"]);
        command
            .current_dir(&place)
            .output()
            .expect("the program starts")
    });
    let copied = dir.path().join("store/journal.restore");
    service.until("the backup waits for the visit", |_| copied.exists());
    // A second restore is refused meanwhile, and the old store is still the one.
    let again = service.request("POST", "/restore", r#"{"dir": "/nowhere"}"#);
    assert_eq!(again.status, 500);
    assert!(again.error().contains("under way"), "{}", again.error());
    assert_eq!((alarms(&service), visits(&service)), (1, 2));
    // The first sweep ends without a result; it is recorded in the store that it began with.
    service.scanner.script().sweep = BEFORE;
    let first = first.join().expect("no panic");
    assert!(first.contains("not_observed"), "{first}");
    let restored = restore.join().expect("no panic");
    assert!(restored.status.success(), "{}", text(&restored.stderr));
    let report = json_of(&restored);
    schema::check("backup", &report);
    let second = second.join().expect("no panic");
    assert!(second.contains("\"verdict\":\"quiet\""), "{second}");
    // The quiet visit of the backup, and the second, compared with the reference of the backup.
    assert_eq!((alarms(&service), visits(&service)), (0, 2));
    let old = report["old_database"].as_str().expect("kept");
    let old = rusqlite::Connection::open(old).expect("opens");
    let count = |sql: &str| -> i64 { old.query_row(sql, [], |row| row.get(0)).expect("a count") };
    let of_then = ["SELECT count(*) FROM visit", "SELECT count(*) FROM alarm"].map(count);
    assert_eq!(of_then, [3, 1]);
    assert!(
        events(&service)
            .iter()
            .any(|text| text.contains("restored from "))
    );
    // Alarms are raised in the new one, and it is whole.
    let changed = service.visit(AFTER);
    assert_eq!(
        (&changed["verdict"], &changed["alarm"]["id"]),
        (&json!("changed"), &json!(1))
    );
    let check = reader(&service).check(|_, _| ()).expect("checked");
    assert!(check.is_sound(), "{check:?}");
    service.stop();
}

#[test]
fn a_restore_that_fails_leaves_the_store_as_it_was_and_says_so() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = service_with_a_backup(dir.path());
    let backup = dir.path().join("backup");
    let database = backup.join("patrold.db");
    let mut bytes = std::fs::read(&database).expect("read");
    bytes[4096..].fill(0xff);
    std::fs::write(&database, bytes).expect("damaged");
    for from in [backup, dir.path().join("none"), dir.path().join("store")] {
        let failed = run(dir.path(), &["restore", from.to_str().expect("a path")]);
        let why = text(&failed.stderr);
        assert_eq!(failed.status.code(), Some(1), "{why}");
        let says_so = why.contains("the store is as it was") || why.contains("none");
        assert!(says_so && why.trim().lines().count() == 1, "{why}");
        assert_eq!((alarms(&service), visits(&service)), (1, 2));
    }
    let relative = service.request("POST", "/restore", r#"{"dir": "backup"}"#);
    assert_eq!(relative.status, 400, "{}", relative.error());
    assert_eq!(
        service.visit(AFTER)["alarm"]["raised"],
        false,
        "alarm 1 goes on"
    );
    service.stop();
}

#[test]
fn an_acknowledgement_goes_through_the_service_and_else_to_the_database() {
    let dir = tempfile::tempdir().expect("temp dir");
    let service = service_with_a_backup(dir.path());
    let ack = |more: &[&str]| run(dir.path(), &[&["alarms", "ack", "1"], more].concat());
    let first = ack(&["--by", "ana", "--confirmed", "--note", "a box", "--json"]);
    let alarm = json_of(&first);
    let by = alarm["acknowledged_by"]
        .as_str()
        .expect("acknowledged")
        .to_owned();
    assert!(by.starts_with("ana (user "), "{by}");
    let [state, answer, note] = ["state", "answer", "note"].map(|key| alarm[key].clone());
    assert_eq!(
        [state, answer, note],
        ["acknowledged", "confirmed", "a box"]
    );
    for (body, status) in [
        (json!({"id": 99, "answer": "confirmed"}), 404),
        (json!({"id": 1, "answer": "maybe"}), 400),
        (json!({"id": "1"}), 400),
    ] {
        let answer = service.request("POST", "/ack", &body.to_string());
        assert_eq!(answer.status, status, "{body}: {}", answer.error());
    }
    let said = service.request(
        "POST",
        "/ack",
        r#"{"id": 1, "by": "bo", "answer": "false_alarm"}"#,
    );
    let reply = said.json();
    schema::check("ack", &reply);
    assert!(
        reply["by"]
            .as_str()
            .is_some_and(|by| by.starts_with("bo (user ")),
        "{reply}"
    );
    let alarm = reader(&service).alarm(1).expect("raised");
    assert_eq!(alarm.answer.as_deref(), Some("false_alarm"));
    assert_eq!(alarm.acknowledged_by, Some(by), "the first one stays");
    service.stop();
    let last = ack(&["--confirmed"]);
    assert!(last.status.success(), "{}", text(&last.stderr));
    let store = Store::open_for_reading(&dir.path().join("store")).expect("reader");
    assert_eq!(
        store.alarm(1).expect("raised").answer.as_deref(),
        Some("confirmed")
    );
}
