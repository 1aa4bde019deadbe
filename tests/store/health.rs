//! Health incidents: begun once, cleared when over, each by itself.

use super::kit::{stamp, teach, visit};
use patrold::store::Store;
use patrold_engine::novelty::Verdict;

fn standing(store: &Store) -> Vec<(String, String, String)> {
    let mut rows = store.health(true, 100).expect("health");
    rows.reverse();
    let texts = rows.into_iter().map(|r| (r.subject, r.reason, r.since));
    texts.collect()
}

fn row(subject: &str, reason: &str, second: i64) -> (String, String, String) {
    let since = stamp(second).to_rfc3339();
    (subject.to_owned(), reason.to_owned(), since)
}

#[test]
fn what_stands_keeps_its_beginning_and_each_subject_is_its_own() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    let mut note = |subject, reason, second| {
        store
            .note_health(subject, reason, &stamp(second))
            .expect("noted");
    };
    note("devices", None, 1);
    note("devices", Some("laser absent"), 10);
    note("sweep", Some("covered"), 20);
    note("devices", Some("head absent"), 30);
    let expected = [
        row("devices", "head absent", 10),
        row("sweep", "covered", 20),
    ];
    assert_eq!(standing(&store), expected);
    store
        .note_health("devices", None, &stamp(40))
        .expect("over");
    assert_eq!(standing(&store), [row("sweep", "covered", 20)]);
    store
        .note_health("devices", Some("again"), &stamp(50))
        .expect("noted");
    store
        .note_health("devices", None, &stamp(60))
        .expect("over");
    store
        .note_health("devices", Some("again"), &stamp(70))
        .expect("noted");
    let all = store.health(false, 100).expect("health");
    let over: Vec<_> = all.iter().map(|r| (r.id, r.cleared_at.clone())).collect();
    let cleared = |second| Some(stamp(second).to_rfc3339());
    let expected = [(4, None), (3, cleared(60)), (2, None), (1, cleared(40))];
    assert_eq!(over, expected, "what was over stays as it was");
    let events = store.events(100).expect("events");
    let texts: Vec<_> = events.iter().rev().map(|e| e.text.as_str()).collect();
    let expected = [
        "devices: laser absent",
        "sweep: covered",
        "devices: over",
        "devices: again",
        "devices: over",
        "devices: again",
    ];
    assert_eq!(texts, expected, "each beginning and end once");
    assert!(events.iter().all(|event| event.device == "health"));
}

#[test]
fn a_beginning_and_an_end_are_returned_as_the_event_log_has_them() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "dock", 0);
    teach(&mut store, "hall", 1);
    let mut returned = Vec::new();
    for (second, reason) in [
        (10, None),
        (11, Some("absent")),
        (12, Some("silent")),
        (13, None),
    ] {
        let noted = store.note_health("devices", reason, &stamp(second));
        returned.extend(noted.expect("noted"));
    }
    for (second, before) in [(20, Some(1)), (21, Some(2)), (22, None)] {
        let before = before.map(|s| stamp(s).at);
        let noted = store.note_unseen(before, &stamp(second));
        returned.extend(noted.expect("noted"));
    }
    let returned = returned.into_iter().map(|e| (e.severity, e.text));
    let returned: Vec<_> = returned
        .map(|(s, text)| (s.as_str().to_owned(), text))
        .collect();
    let mut logged = store.events(100).expect("events");
    logged.reverse();
    let logged: Vec<_> = logged.into_iter().map(|e| (e.level, e.text)).collect();
    assert_eq!((logged.len(), &returned), (6, &logged));
}

#[test]
fn a_waypoint_that_nobody_visits_is_noted_until_somebody_does() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "dock", 0);
    teach(&mut store, "hall", 100);
    let at = |store: &mut Store, before: Option<i64>, second| {
        let before = before.map(|s| stamp(s).at);
        store.note_unseen(before, &stamp(second)).expect("noted");
        standing(store)
    };
    let since = |second| format!("not visited since {}", stamp(second).to_rfc3339());
    assert_eq!(
        at(&mut store, Some(0), 110),
        [],
        "exactly as long ago as allowed"
    );
    let dock = row("waypoint dock", &since(0), 120);
    assert_eq!(at(&mut store, Some(1), 120), std::slice::from_ref(&dock));
    assert_eq!(
        at(&mut store, Some(2), 130),
        std::slice::from_ref(&dock),
        "since then"
    );
    let hall = row("waypoint hall", &since(100), 140);
    assert_eq!(at(&mut store, Some(101), 140), [dock.clone(), hall]);
    visit(&mut store, Verdict::Quiet, &[], 150);
    store
        .note_health("devices", Some("absent"), &stamp(151))
        .expect("noted");
    let devices = row("devices", "absent", 151);
    assert_eq!(at(&mut store, Some(150), 160), [dock, devices.clone()]);
    store
        .forget_waypoint("dock", &stamp(165))
        .expect("forgotten");
    assert_eq!(
        at(&mut store, Some(150), 170),
        std::slice::from_ref(&devices)
    );
    assert_eq!(at(&mut store, None, 180), [devices], "off");
}
