//! What retention deletes, and what it never does.

use super::kit::{EVERYTHING, novelty_at, stamp, teach, view, visit};
use patrold::store::{Ledger, NewVisit, Retention, Store, SweepRecord};
use patrold_engine::novelty::Verdict;
use std::path::Path;

#[test]
fn retention_keeps_evidence_and_references() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let quiet = visit(&mut store, Verdict::Quiet, &[], 10);
    let changed = visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 20);
    let everything = Retention {
        older_than: Some(stamp(1000).at),
        max_bytes: Some(0),
        unnamed_older_than: None,
    };
    let deleted = store.apply_retention(&everything).expect("retention");
    assert_eq!(deleted.sweeps, 1);
    assert!(store.visit(quiet.visit_id).is_err());
    assert!(store.visit(changed.visit_id).is_ok());
    assert!(store.reference("hall").is_ok());
}

#[test]
fn all_visits_of_an_alarm_are_evidence() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let ids: Vec<i64> = [10, 20, 30]
        .into_iter()
        .map(|second| visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], second).visit_id)
        .collect();
    store.apply_retention(&EVERYTHING).expect("retention");
    assert!(ids.iter().all(|id| store.visit(*id).is_ok()));
}

/// Size of the largest file; all views of these tests have the same number of points.
fn bytes_of_a_sweep(dir: &Path) -> u64 {
    let entries = std::fs::read_dir(dir.join("blobs")).expect("blobs");
    let sizes = entries.map(|entry| {
        let entry = entry.expect("a file");
        let is_evidence = entry.file_name().len() == 64;
        entry
            .metadata()
            .map_or(0, |file| if is_evidence { file.len() } else { 0 })
    });
    sizes.max().expect("a sweep")
}

#[test]
fn evidence_does_not_count_against_the_size_limit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    for second in 10..20 {
        visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], second);
    }
    let quiet = [
        visit(&mut store, Verdict::Quiet, &[], 30).visit_id,
        visit(&mut store, Verdict::Quiet, &[], 40).visit_id,
        visit(&mut store, Verdict::Quiet, &[], 50).visit_id,
    ];
    let one_sweep = bytes_of_a_sweep(dir.path());
    let limit = |max| Retention {
        older_than: None,
        max_bytes: Some(max),
        unnamed_older_than: None,
    };
    assert_eq!(
        store
            .apply_retention(&limit(3 * one_sweep))
            .expect("all fit")
            .sweeps,
        0
    );
    assert_eq!(
        store
            .apply_retention(&limit(2 * one_sweep))
            .expect("one goes")
            .sweeps,
        1
    );
    let kept: Vec<bool> = quiet.iter().map(|id| store.visit(*id).is_ok()).collect();
    assert_eq!(kept, [false, true, true], "the oldest");
}

#[test]
fn shared_files_count_once() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    // The same second, the same points, the same file.
    visit(&mut store, Verdict::Quiet, &[], 10);
    visit(&mut store, Verdict::Quiet, &[], 10);
    let one_sweep = bytes_of_a_sweep(dir.path());
    let limit = Retention {
        older_than: None,
        max_bytes: Some(one_sweep),
        unnamed_older_than: None,
    };
    assert_eq!(store.apply_retention(&limit).expect("fits").sweeps, 0);
}

#[test]
fn references_of_a_forgotten_waypoint_are_deleted_by_age_unless_they_are_evidence() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let spare = store.reference("hall").expect("reference").id;
    teach(&mut store, "hall", 10);
    let evidence = store.reference("hall").expect("reference").id;
    visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 20);
    assert_eq!(store.apply_retention(&EVERYTHING).expect("known").sweeps, 0);
    store
        .forget_waypoint("hall", &stamp(30))
        .expect("forgotten");
    let by_size = Retention {
        older_than: None,
        ..EVERYTHING
    };
    assert_eq!(
        store
            .apply_retention(&by_size)
            .expect("by age alone")
            .sweeps,
        0
    );
    assert_eq!(store.apply_retention(&EVERYTHING).expect("old").sweeps, 1);
    let gone = store.reference_by_id(spare).expect_err("gone");
    assert!(gone.to_string().contains("retention"), "{gone}");
    assert!(store.reference_by_id(evidence).is_ok());
}

/// A visit of the hall whose sweep gave no view, or shares both files with others.
fn visit_with(
    store: &mut Store,
    verdict: Verdict,
    view_x: Option<f64>,
    raw: &[u8],
    second: i64,
) -> i64 {
    let reference = store.reference("hall").expect("reference").id;
    let view = view_x.map(view);
    let novelties = [novelty_at(1.0)];
    let visit = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference),
        sweep: Some(SweepRecord {
            dialogue: None,
            view: view.as_ref(),
            raw: Some(raw),
            quality: "null",
        }),
        verdict,
        reason: "test",
        d_gmm: None,
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: if verdict == Verdict::Changed {
            &novelties
        } else {
            &[]
        },
        places: &[],
        same_place_m: 0.5,
    };
    let recorded = store
        .record_visit(&visit, &stamp(second))
        .expect("recorded");
    recorded.visit_id
}

#[test]
fn a_file_that_another_row_names_stays() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let old = visit_with(&mut store, Verdict::Quiet, Some(7.0), b"shared", 10);
    let new = visit_with(&mut store, Verdict::Quiet, Some(7.0), b"shared", 30);
    let evidence = visit_with(&mut store, Verdict::Changed, Some(8.0), b"evidence", 40);
    let like_evidence = visit_with(&mut store, Verdict::NotObserved, Some(8.0), b"evidence", 11);
    let limit = Retention {
        older_than: Some(stamp(20).at),
        max_bytes: None,
        unnamed_older_than: None,
    };
    let deleted = store.apply_retention(&limit).expect("applied");
    assert_eq!((deleted.sweeps, deleted.bytes), (2, 0));
    assert!(store.visit(old).is_err() && store.visit(like_evidence).is_err());
    for kept in [new, evidence] {
        let visit = store.visit(kept).expect("its files");
        assert!(visit.view.is_some() && visit.raw.is_some());
    }
    store.apply_retention(&EVERYTHING).expect("applied");
    assert!(store.visit(new).is_err() && store.visit(evidence).is_ok());
    assert!(store.check(|_, _| ()).expect("checked").unnamed.is_empty());
}

#[test]
fn a_sweep_without_a_view_is_kept_and_deleted_as_any_other() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let spare = visit_with(&mut store, Verdict::NotObserved, None, b"spare", 10);
    let evidence = visit_with(&mut store, Verdict::Changed, None, b"evidence", 20);
    store.close();
    let mut ledger = Ledger::new(Store::open(dir.path()).expect("store"));
    assert!(ledger.start().failures.is_empty());
    let store = &mut ledger.store;
    assert!(
        store.visit(spare).is_ok() && store.visit(evidence).is_ok(),
        "after a start"
    );
    assert_eq!(
        store.apply_retention(&EVERYTHING).expect("applied").sweeps,
        1
    );
    assert!(store.visit(spare).is_err());
    let kept = store.visit(evidence).expect("evidence");
    assert_eq!(
        (kept.view, kept.raw.as_deref()),
        (None, Some(&b"evidence"[..]))
    );
}

#[test]
fn files_that_no_row_names_have_a_retention_of_their_own() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    let stray = dir.path().join("blobs").join("a".repeat(64));
    let limit = |unnamed_older_than| Retention {
        unnamed_older_than,
        ..EVERYTHING
    };
    std::fs::write(&stray, b"stray").expect("written");
    let everything = limit(Some(jiff::Timestamp::MAX));
    store.apply_retention(&everything).expect("applied");
    assert!(
        stray.is_file(),
        "there is no reference: the database may be lost"
    );
    teach(&mut store, "hall", 0);
    visit(&mut store, Verdict::Changed, &[novelty_at(1.0)], 10);
    for keeps in [None, Some(jiff::Timestamp::UNIX_EPOCH)] {
        store.apply_retention(&limit(keeps)).expect("applied");
        assert!(stray.is_file(), "{keeps:?}");
    }
    assert_eq!(
        store.apply_retention(&everything).expect("applied").bytes,
        5
    );
    assert!(!stray.exists());
    assert!(
        store.check(|_, _| ()).expect("checked").is_sound(),
        "and no other"
    );
}

#[test]
fn half_written_files_are_deleted_and_nothing_else() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    teach(&mut store, "hall", 0);
    let blobs = dir.path().join("blobs");
    let hash = "a".repeat(64);
    let half = format!("{hash}.tmp");
    for name in [&hash, &half, "notes.txt"] {
        std::fs::write(blobs.join(name), b"left").expect("written");
    }
    let deleted = store.delete_half_written().expect("deleted");
    assert_eq!((deleted.sweeps, deleted.bytes), (1, 4));
    assert!(!blobs.join(half).exists());
    assert!(blobs.join("notes.txt").is_file(), "not ours");
    assert!(blobs.join(&hash).is_file(), "whole, though no row names it");
    assert_eq!(store.unnamed_files().expect("listed"), [hash]);
    assert!(store.reference("hall").is_ok());
    assert_eq!(store.delete_half_written().expect("again").sweeps, 0);
}
