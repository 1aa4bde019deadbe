//! The service as its clients see it: over its socket, with a scripted robot in simulated rooms.

mod emulated;
mod house;
mod process;

use house::{Act, House, Scripted, configure, plan, points};
use patrold::service::replies::VisitReply;
use patrold::service::{Control, ServiceError, serve};
use patrold::store::{AlarmFilter, Store};
use std::time::Duration;
use tokio::sync::mpsc;

const BEFORE: Act = Act::See("storeroom.toml");
const AFTER: Act = Act::See("storeroom-box-left.toml");

fn events(house: &House) -> Vec<String> {
    let store = Store::open_for_reading(&house.dir.join("store")).expect("readable meanwhile");
    let events = store.events(100).expect("events");
    events.into_iter().map(|e| e.text).collect()
}

#[test]
fn a_round_from_teaching_to_an_alarm_and_back() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));

    let none = house.at("/visit", "hall");
    assert_eq!(
        (none.status, none.error().contains("patrold teach hall")),
        (404, true)
    );
    assert_eq!(house.robot.script().sweeps, 0, "nothing was swept for it");

    let taught = house.at("/teach", "hall");
    assert_eq!(taught.status, 200, "{}", taught.json());
    assert_eq!(taught.json()["version"], 1);
    assert!(taught.json()["components"].as_u64() > Some(20));

    let quiet = house.visit(BEFORE);
    assert_eq!(quiet["verdict"], "quiet", "{quiet}");
    assert!(quiet["alarm"].is_null());

    let changed = house.visit(AFTER);
    assert_eq!(changed["verdict"], "changed", "{changed}");
    assert_eq!(changed["alarm"]["raised"], true);
    assert_eq!(changed["frame"], "hall/1");
    assert!(changed["d_gmm"].as_f64() >= changed["u_th"].as_f64());
    assert_eq!(changed["novelties"][0]["kind"], "appeared");
    let store = Store::open_for_reading(&house.dir.join("store")).expect("readable meanwhile");
    let alarms = store.alarms(&AlarmFilter::default()).expect("alarms");
    assert_eq!(alarms.len(), 1, "on disk before it was told");
    assert_eq!(Some(alarms[0].id), changed["alarm"]["id"].as_i64());

    let again = house.visit(AFTER);
    assert_eq!(again["alarm"]["raised"], false, "{again}");
    assert_eq!(again["alarm"]["id"], changed["alarm"]["id"]);

    let json = process::patrold(dir.path(), &["visit", "hall", "--json"])
        .output()
        .expect("runs");
    assert_eq!(json.status.code(), Some(10), "{json:?}");
    let told: VisitReply = serde_json::from_slice(&json.stdout).expect("the service's own JSON");
    assert_eq!(told.verdict, "changed");
    let text = process::patrold(dir.path(), &["visit", "hall"])
        .output()
        .expect("runs");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.starts_with("hall: changed ("), "{text}");
    assert!(text.contains("belongs to alarm 1"), "{text}");

    let gone = house.visit(BEFORE);
    assert_eq!(
        (&gone["verdict"], &gone["cleared"][0]),
        (&"quiet".into(), &changed["alarm"]["id"])
    );

    let swept = house.ask("POST", "/sweep", "");
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

    let status = house.status();
    assert_eq!(
        (&status["phase"], &status["devices"]["state"]),
        (&"idle".into(), &"ready".into())
    );
    assert_eq!(status["devices"]["identity"]["laser"]["serial"], "H0000000");
    assert!(events(&house).iter().any(|e| e == "scripted laser answers"));

    let robot = house.robot.clone();
    house.stop();
    assert_eq!(robot.script().parked, 1);
}

#[test]
fn a_bad_sweep_is_not_observed_and_never_a_reference() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));
    assert_eq!(house.at("/teach", "hall").status, 200);

    let blocked = house.visit(Act::Fail("pan-tilt stalled", true));
    assert_eq!(blocked["verdict"], "not_observed");
    assert_eq!(blocked["reason"], "pan-tilt stalled");
    assert!(blocked["d_gmm"].is_null() && blocked["alarm"].is_null());
    house.until("the devices are opened anew", |h| {
        h.robot.script().connections == 2
    });

    let frozen = house.visit(Act::Freeze);
    assert_eq!(frozen["verdict"], "not_observed");
    assert!(
        frozen["reason"]
            .as_str()
            .is_some_and(|r| r.contains("frozen")),
        "{frozen}"
    );
    assert_eq!(frozen["sweep"]["frozen"], true);

    let refused = house.at("/teach", "hall");
    assert_eq!(
        (refused.status, refused.error().contains("frozen")),
        (422, true)
    );
    house.robot.script().act = Act::Fail("no laser", false);
    assert_eq!(house.at("/teach", "hall").status, 503);

    let store = Store::open_for_reading(&house.dir.join("store")).expect("readable meanwhile");
    let hall = store.waypoint("hall").expect("known");
    assert_eq!(hall.references.len(), 1, "the old reference stays");
    assert_eq!(hall.row.last_verdict.as_deref(), Some("not_observed"));
    house.stop();
}

#[test]
fn without_devices_it_runs_and_says_so() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let robot = Scripted::new(BEFORE);
    let house = House::start(dir.path(), &robot);
    assert_eq!(house.at("/teach", "hall").status, 200);
    house.stop();

    robot.script().absent = Some("laser (laser.port): nothing there");
    let house = House::start(dir.path(), &robot);
    house.until("they are lost", |h| {
        h.status()["devices"]["state"] == "lost"
    });
    let visit = house.visit(BEFORE);
    assert_eq!(visit["verdict"], "not_observed");
    assert_eq!(
        visit["reason"],
        "no devices: laser (laser.port): nothing there"
    );
    assert_eq!(house.ask("POST", "/sweep", "").status, 503);
    robot.script().absent = None;
    house.until("they are tried again", |h| {
        h.status()["devices"]["state"] == "ready"
    });
    assert_eq!(house.visit(BEFORE)["verdict"], "quiet");
    house.stop();
}

#[test]
fn a_reload_counts_if_valid_and_is_told_either_way() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));
    assert_eq!(house.at("/teach", "hall").status, 200);

    configure(dir.path(), "novelty.u_th_m = 5.0\n");
    house.control(Control::Reload);
    house.until("it is in force", |h| {
        events(h).iter().any(|e| e.contains("put in force"))
    });
    let deaf = house.visit(AFTER);
    assert_eq!(
        (&deaf["verdict"], &deaf["u_th"]),
        (&"quiet".into(), &5.0.into())
    );
    assert!(
        deaf["novelties"].as_array().is_some_and(|n| !n.is_empty()),
        "still listed"
    );

    configure(dir.path(), "novelty.uth_m = 5.0\nlaser.baud = \"fast\"\n");
    house.control(Control::Reload);
    house.until("it is refused", |h| {
        events(h).iter().any(|e| {
            let both = e.contains("novelty.u_th_m?") && e.contains("laser.baud");
            e.contains("the old one stays") && both
        })
    });
    assert_eq!(house.visit(AFTER)["u_th"], 5.0);
    house.stop();
}

#[test]
fn a_second_service_on_the_same_store_is_refused() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let robot = Scripted::new(BEFORE);
    let house = House::start(dir.path(), &robot);
    let (_controls, receiver) = mpsc::channel(1);
    let runtime = tokio::runtime::Runtime::new().expect("runtime");
    let second = runtime.block_on(serve(plan(dir.path(), &robot), receiver));
    let error = second.expect_err("refused");
    assert!(matches!(error, ServiceError::Taken { .. }), "{error}");
    house.stop();
    assert!(!dir.path().join("patrold.sock").exists());
}

#[test]
fn a_stop_in_the_middle_of_a_sweep_is_quick_and_leaves_a_trace() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));
    assert_eq!(house.at("/teach", "hall").status, 200);
    house.robot.script().act = Act::Dawdle;
    let (robot, socket) = (house.robot.clone(), house.socket());
    let asker = std::thread::spawn({
        let socket = socket.clone();
        move || {
            let body = "{\"waypoint\": \"hall\"}";
            ask(&socket, body)
        }
    });
    house.until("it sweeps", |h| h.status()["phase"] == "sweeping");
    let took = house.stop();
    assert!(took < Duration::from_secs(3), "{took:?}");
    assert_eq!(robot.script().parked, 1);
    let told = asker.join().expect("no panic");
    assert!(told.contains("not_observed"), "{told}");
    let store = Store::open_for_reading(&dir.path().join("store")).expect("store");
    let hall = store.waypoint("hall").expect("known").row;
    assert_eq!(hall.last_verdict.as_deref(), Some("not_observed"));
}

fn ask(socket: &std::path::Path, body: &str) -> String {
    use std::io::{Read as _, Write as _};
    let mut stream = std::os::unix::net::UnixStream::connect(socket).expect("it listens");
    write!(
        stream,
        "POST /visit HTTP/1.1\r\nhost: x\r\nconnection: close\r\ncontent-type: application/json\r\n\
         content-length: {}\r\n\r\n{body}",
        body.len()
    )
    .expect("asked");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("answered");
    text
}

#[test]
fn wrong_requests_get_one_line_each() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));
    for (method, path, body, status) in [
        ("POST", "/visit", "{\"waypoint\": \"two words\"}", 400),
        ("POST", "/visit", "{\"waypoint\": \"", 400),
        ("POST", "/visit", "{\"way\": \"hall\"}", 422),
        ("GET", "/visit", "", 405),
        ("POST", "/nowhere", "", 404),
    ] {
        let answer = house.ask(method, path, body);
        assert_eq!(answer.status, status, "{method} {path} {body}");
        assert!(!answer.error().is_empty());
    }
    house.stop();
}

#[test]
fn a_teach_whose_asker_went_away_leaves_no_reference() {
    use std::io::Write as _;
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(Act::Dawdle));
    let teach = |waypoint: &str| {
        let mut stream =
            std::os::unix::net::UnixStream::connect(house.socket()).expect("it listens");
        let body = format!("{{\"waypoint\": {waypoint:?}}}");
        write!(
            stream,
            "POST /teach HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n\
             content-length: {}\r\n\r\n{body}",
            body.len()
        )
        .expect("asked");
        stream
    };
    let first = teach("a");
    house.until("it sweeps", |h| h.status()["phase"] == "sweeping");
    let second = teach("b");
    house.until("the second waits", |h| h.status()["waiting"] == 1);
    drop(second);
    house.until("the second is dropped", |h| h.status()["waiting"] == 0);
    drop(first);
    house.until("the first is called off", |h| h.status()["phase"] == "idle");
    assert_eq!(house.robot.script().sweeps, 1, "nothing was swept for b");
    house.robot.script().act = BEFORE;
    assert_eq!(house.at("/teach", "c").status, 200);
    let noted = events(&house);
    for text in ["teach a dropped: whoever", "teach b dropped: whoever"] {
        assert!(noted.iter().any(|e| e.starts_with(text)), "{noted:?}");
    }
    let store = Store::open_for_reading(&house.dir.join("store")).expect("readable meanwhile");
    let names = store.waypoints().expect("waypoints");
    assert_eq!(names.len(), 1, "only c");
    house.stop();
}

#[test]
fn idle_devices_that_go_away_are_told_and_opened_anew() {
    let dir = tempfile::tempdir().expect("temp dir");
    configure(dir.path(), "");
    let house = House::start(dir.path(), &Scripted::new(BEFORE));
    let state = |h: &House| h.status()["devices"]["state"].clone();
    house.until("they are ready", |h| state(h) == "ready");
    {
        let mut script = house.robot.script();
        (script.unplugged, script.absent) = (Some("laser unplugged"), Some("laser away"));
    }
    house.until("they are lost", |h| state(h) == "lost");
    // The status does not wait for the disk.
    house.until("the log has it", |h| {
        events(h).iter().any(|e| e == "laser unplugged")
    });
    {
        let mut script = house.robot.script();
        (script.unplugged, script.absent) = (None, None);
    }
    // At once, whenever the next attempt is due.
    assert_eq!(house.ask("POST", "/sweep", "").status, 200);
    assert_eq!(state(&house), "ready");
    house.stop();
}
