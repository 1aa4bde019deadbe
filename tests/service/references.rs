//! A visit uses the stored mixture: made anew where it is outdated, refused where it is damaged, read again where another
//! program replaced it.

use super::harness::{ScriptedScanner, TestService, configure};
use super::{AFTER, BEFORE, events, process, stored_mixture};
use patrold::store::{Store, StoredMixture};
use std::path::PathBuf;

fn taught(dir: &std::path::Path) -> (TestService, PathBuf) {
    configure(dir, "");
    let service = TestService::start(dir, &ScriptedScanner::new(BEFORE));
    assert_eq!(service.post("/teach", "hall").status, 200);
    let store = dir.join("store");
    (service, store)
}

fn made_anew(service: &TestService) -> Vec<String> {
    let is_it = |e: &String| e.starts_with("reference hall/1: mixture made anew from its view");
    events(service).into_iter().filter(is_it).collect()
}

#[test]
fn an_outdated_mixture_is_made_anew_once_and_noted() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, store) = taught(dir.path());
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    assert_eq!(made_anew(&service), [""; 0]);
    let (taught, checksum) = stored_mixture::read(&store);

    for (nth, (sql, why)) in [
        (
            "UPDATE reference SET mixture = x'0102', mixture_sha256 = NULL, model = NULL",
            "an earlier version of patrold made it",
        ),
        (
            "UPDATE reference SET model = '{\"version\":0}'",
            "instead of {\"version\":0}",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        stored_mixture::execute(&store, sql);
        assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
        let noted = made_anew(&service);
        assert_eq!(noted.len(), nth + 1, "{noted:?}");
        assert!(noted[0].contains(why), "{noted:?}");
        assert_eq!(
            stored_mixture::read(&store),
            (taught.clone(), checksum.clone())
        );
        let reader = Store::open_for_reading(&store).expect("reader");
        let mixture = reader.reference("hall").expect("stored").mixture;
        assert!(
            matches!(mixture, StoredMixture::Intact { .. }),
            "{mixture:?}"
        );

        assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
        assert_eq!(made_anew(&service).len(), nth + 1, "once");
    }
    service.stop();
}

#[test]
fn a_damaged_mixture_is_not_observed_until_it_is_made_anew_beside_the_service() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, store) = taught(dir.path());
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    let (mut gamma, _) = stored_mixture::read(&store);
    stored_mixture::shift(&mut gamma, 0.5);
    stored_mixture::write(&store, &gamma, false);

    let refused = service.visit(AFTER);
    assert_eq!(refused["verdict"], "not_observed", "{refused}");
    let reason = refused["reason"].as_str().expect("a reason");
    assert!(reason.contains("reference hall/1"), "{reason}");
    assert!(
        reason.ends_with("patrold waypoints rebuild hall"),
        "{reason}"
    );

    let rebuilt = process::patrold(dir.path(), &["waypoints", "rebuild", "hall"])
        .output()
        .expect("runs");
    assert_eq!(rebuilt.status.code(), Some(0), "{rebuilt:?}");
    assert_eq!(service.visit(BEFORE)["verdict"], "quiet");
    assert_eq!(service.visit(AFTER)["verdict"], "changed");
    // The sweep of the refused visit was kept.
    let visit = refused["visit_id"].to_string();
    let judged = process::patrold(dir.path(), &["rejudge", &visit])
        .output()
        .expect("runs");
    assert_eq!(judged.status.code(), Some(10), "{judged:?}");
    service.stop();
}

#[test]
fn a_mixture_that_another_program_stored_decides_the_next_visit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let (service, store) = taught(dir.path());
    let boxed = service.visit(AFTER)["novelties"][0].clone();
    let centre = [0, 1, 2].map(|axis| boxed["centre"][axis].as_f64().expect("a number"));

    service.scanner.script().sweep = AFTER;
    let accepting = r#"{"waypoint": "hall", "accept": [1]}"#;
    assert_eq!(service.request("POST", "/teach", accepting).status, 200);
    assert_eq!(service.visit(AFTER)["verdict"], "quiet");
    let (mut gamma, _) = stored_mixture::read(&store);
    // The box of the scene from the robot, turned by 20 degrees; the floor is at -0.4.
    let taken = stored_mixture::take_out(&mut gamma, [1.7, -0.5, -0.19], [0.57, 0.51, 0.4]);
    assert!(taken > 2, "{taken}");
    stored_mixture::write(&store, &gamma, true);

    let changed = service.visit(AFTER);
    assert_eq!(changed["verdict"], "changed", "{changed}");
    let novelty = &changed["novelties"][0];
    assert_eq!(novelty["kind"], "appeared");
    // The box is where it is.
    for axis in 0..3 {
        let at = novelty["centre"][axis].as_f64().expect("a number");
        assert!((at - centre[axis]).abs() < 0.05, "{novelty} at {centre:?}");
    }
    let noted = events(&service);
    assert!(!noted.iter().any(|e| e.contains("made anew")), "{noted:?}");
    service.stop();
}
