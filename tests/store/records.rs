//! What is stored is read back: references by version, visits, raw data, events.

use super::kit::{MODEL, mixture, novelty_at, raised, stamp, teach, view, visit};
use patrold::patrol::severity::Severity;
use patrold::store::{
    AlarmFilter, NewReference, NewVisit, ReferenceFrame, Store, StoreError, StoredMixture,
    SweepRecord,
};
use patrold_engine::novelty::Verdict;

#[test]
fn teaching_again_adds_a_version_and_clears_the_alarms() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    assert_eq!(teach(&mut store, "hall", 0), 1);
    let id = raised(&visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10))[0];
    assert_eq!(teach(&mut store, "hall", 20), 2);
    let alarm = store.alarm(id).expect("alarm");
    assert_eq!(
        alarm.cleared_because.as_deref(),
        Some("accepted with reference hall/2")
    );
    let reference = store.reference("hall").expect("newest");
    assert_eq!(reference.version, 2);
    assert_eq!(reference.view, view(20.0));
    let intact = StoredMixture::Intact {
        gamma: mixture(),
        model: MODEL.to_owned(),
    };
    assert_eq!(reference.mixture, intact);
    assert_eq!((reference.components, reference.in_use), (1, true));
    let first = store.reference_version("hall", 1).expect("kept");
    assert_eq!((first.version, first.in_use), (1, false));
    let detail = store.waypoint("hall").expect("waypoint");
    assert_eq!(detail.references.len(), 2);

    store
        .forget_waypoint("hall", &stamp(30))
        .expect("forgotten");
    let unknown = store.reference("hall").expect_err("unknown now");
    assert!(
        unknown
            .to_string()
            .contains("unknown waypoint \"hall\"; known: none yet"),
        "{unknown}"
    );
    assert_eq!(store.alarms(&AlarmFilter::default()).expect("log").len(), 1);
}

#[test]
fn a_stored_visit_is_read_back_as_it_was_judged() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let recorded = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    let back = store.visit(recorded.visit_id).expect("visit");
    assert_eq!(back.view, Some(view(1010.0)));
    assert_eq!((back.verdict.as_str(), back.seed), ("changed", 7));
    assert_eq!((back.engine.as_str(), back.quality.as_str()), ("{}", "{}"));
    let reference = store
        .reference_by_id(back.reference_id.expect("compared"))
        .expect("its reference");
    assert_eq!(reference.view, view(0.0));
    assert_eq!(
        (reference.engine.as_str(), reference.seed),
        (r#"{"ground": "w2"}"#, 7)
    );
    assert!(matches!(
        store.visit(999),
        Err(StoreError::UnknownVisit(999))
    ));
}

#[test]
fn events_are_kept_in_order() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    store
        .note_event(Severity::Warning, "laser", "gone", &stamp(1))
        .expect("noted");
    store
        .note_event(Severity::Info, "laser", "back", &stamp(2))
        .expect("noted");
    let events = store.events(10).expect("read");
    assert_eq!(events[0].text, "back");
    assert_eq!(events[1].level, "warning");
}

#[test]
fn raw_data_that_could_not_be_assembled_is_kept() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let reference = store.reference("hall").expect("reference").id;
    let broken = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference),
        sweep: Some(SweepRecord {
            dialogue: None,
            view: None,
            raw: Some(b"odd scans"),
            quality: "null",
        }),
        verdict: Verdict::NotObserved,
        reason: "cannot be assembled",
        d_gmm: None,
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: &[],
        places: &[],
        same_place_m: 0.5,
    };
    let id = store
        .record_visit(&broken, &stamp(10))
        .expect("recorded")
        .visit_id;
    let back = store.visit(id).expect("kept");
    assert_eq!(
        (back.view, back.raw.as_deref()),
        (None, Some(&b"odd scans"[..]))
    );

    let no_sweep = NewVisit {
        sweep: None,
        ..broken
    };
    let id = store
        .record_visit(&no_sweep, &stamp(20))
        .expect("recorded")
        .visit_id;
    let none = store.visit(id).expect_err("nothing to judge");
    assert!(none.to_string().contains("none was taken"), "{none}");

    let reference = NewReference {
        waypoint: "dock",
        sweep: SweepRecord {
            dialogue: None,
            view: None,
            raw: None,
            quality: "null",
        },
        mixture: &mixture(),
        model: "{}",
        engine: "{}",
        seed: 7,
        accepted: &[],
        frame: ReferenceFrame::Own,
    };
    assert!(store.teach(&reference, &stamp(30)).is_err());
}

#[test]
fn two_writers_wait_for_each_other() {
    let dir = tempfile::tempdir().expect("temp dir");
    drop(Store::open(dir.path()).expect("store"));
    let writer = |name: &'static str| {
        let dir = dir.path().to_owned();
        std::thread::spawn(move || {
            let mut store = Store::open_existing(&dir).expect("store");
            for second in 0..20 {
                teach(&mut store, name, second);
            }
        })
    };
    let both = [writer("hall"), writer("hall")];
    for one in both {
        one.join().expect("no write was refused");
    }
    let store = Store::open_for_reading(dir.path()).expect("reader");
    assert_eq!(store.reference("hall").expect("newest").version, 40);
}

#[test]
fn versions_continue_after_a_waypoint_was_forgotten() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    assert_eq!(teach(&mut store, "hall", 0), 1);
    store
        .forget_waypoint("hall", &stamp(10))
        .expect("forgotten");
    assert_eq!(teach(&mut store, "hall", 20), 2);
    assert_eq!(teach(&mut store, "dock", 30), 1);
}

#[test]
fn figures_that_are_not_finite_are_stored_as_null() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let mut odd = novelty_at(1.0);
    odd.centre[2] = f64::NAN;
    odd.mass = f64::NAN;
    odd.covariance[0][0] = f64::INFINITY;
    let reference = store.reference("hall").expect("reference").id;
    let visit_with = |store: &mut Store, d_gmm, u_th, second| {
        let view = view(second as f64);
        let visit = NewVisit {
            waypoint: "hall",
            reference_id: Some(reference),
            sweep: Some(SweepRecord {
                dialogue: None,
                view: Some(&view),
                raw: None,
                quality: "{}",
            }),
            verdict: Verdict::Changed,
            reason: "test",
            d_gmm,
            u_th,
            seed: 7,
            engine: "{}",
            report: "{}",
            novelties: std::slice::from_ref(&odd),
            places: &[],
            same_place_m: 0.5,
        };
        store
            .record_visit(&visit, &stamp(second))
            .expect("recorded")
    };
    visit_with(&mut store, Some(f64::NAN), 0.001, 10);
    visit_with(&mut store, None, f64::NAN, 20);
    visit(&mut store, Verdict::Changed, &[novelty_at(5.0)], 30);
    let log = store
        .alarms(&AlarmFilter::default())
        .expect("the whole log");
    assert_eq!(log.len(), 3);
    assert_eq!((log[2].d_gmm, log[1].u_th), (None, None));
    assert!(log[2].novelties[0].centre[2].is_nan());
    assert_eq!(log[0].d_gmm, Some(0.005));
}

#[test]
fn the_log_is_read_where_nothing_can_be_written() {
    let dir = tempfile::tempdir().expect("temp dir");
    // What a URI has another meaning for.
    let folder = dir.path().join("a ö?b#c%20d");
    let mut store = Store::open(&folder).expect("store");
    teach(&mut store, "hall", 0);
    let outcome = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    store.close();
    // As on a read-only file system: the file that readers share cannot be made.
    std::fs::create_dir(folder.join("patrold.db-shm")).expect("in its place");
    let reader = Store::open_for_reading(&folder).expect("readable");
    let alarms = reader.alarms(&AlarmFilter::default()).expect("alarms");
    let ids: Vec<i64> = alarms.iter().map(|alarm| alarm.id).collect();
    assert_eq!(ids, raised(&outcome));
}

#[test]
fn damage_is_found_and_named() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    let evidence = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    assert_eq!(store.find_damage().expect("looked"), [""; 0]);
    let check = |store: &Store| store.check(|_, _| ()).expect("checked");
    assert_eq!(
        check(&store).evidence_files,
        5,
        "two views, their raw data twice, a visit"
    );
    let blobs = dir.path().join("blobs");
    let before = check(&store);
    assert!(before.missing.is_empty());
    // Flip one bit of every evidence file in turn: each is noticed, and no other.
    let entries = std::fs::read_dir(&blobs).expect("blobs");
    let files = entries.map(|entry| entry.expect("an entry").path());
    let files: Vec<_> = files
        .filter(|file| !file.ends_with("journal.txt"))
        .collect();
    let mut of_references = 0;
    for file in files {
        let mut bytes = std::fs::read(&file).expect("read");
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        std::fs::write(&file, &bytes).expect("flipped");
        let missing = check(&store).missing;
        assert!(!missing.is_empty() && missing.iter().all(|m| file.ends_with(&m.file)));
        let damage = store.find_damage().expect("looked");
        of_references += damage.len();
        for text in damage {
            assert!(
                text.starts_with("the reference of ") && text.contains("teach the waypoint again"),
                "{text}"
            );
        }
        bytes[last] ^= 1;
        std::fs::write(&file, &bytes).expect("mended");
    }
    assert_eq!(of_references, 2, "one view each");
    assert!(store.visit(evidence.visit_id).is_ok());
}
