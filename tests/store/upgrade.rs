//! A store of an earlier version is upgraded without a loss, and its journal gives it back.

use super::kit::{changed_visit, stamp};
use super::rebuild::rows;
use patrold::store::{Ledger, NewVisit, Store, SweepRecord};
use patrold_engine::blob::encode_view;
use rusqlite::Connection;
use std::fs;
use std::path::Path;

/// Rows of every table as the second schema had them: two waypoints, references, visits and alarms.
fn second_version(dir: &Path) {
    let blobs = dir.join("blobs");
    fs::create_dir_all(&blobs).expect("folder");
    let view = |x: f64| {
        let bytes = encode_view(&super::kit::view(x));
        let name = sha256(&bytes);
        fs::write(blobs.join(&name), bytes).expect("written");
        name
    };
    let [a, b, c] = [1.0, 2.0, 3.0].map(view);
    let db = Connection::open(dir.join("patrold.db")).expect("database");
    db.pragma_update(None, "journal_mode", "WAL").expect("log");
    let migrations = patrold_test_support::workspace_root().join("migrations");
    for name in ["0001_patrol.sql", "0002_reference_mixture.sql"] {
        let sql = fs::read_to_string(migrations.join(name)).expect("a migration");
        db.execute_batch(&sql).expect("applied");
    }
    db.execute_batch(&format!(
        "PRAGMA user_version = 2;
         INSERT INTO waypoint (name, created_at) VALUES ('hall', 't1'), ('yard', 't2');
         INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, view_file, quality)
         VALUES (1, 't1', 'b', 4, '{a}', '{{}}'), (2, 't2', 'b', 4, '{b}', '{{}}'), (1, 't3', 'b', 4, '{c}', '{{}}'),
                (2, 't4', 'b', 4, NULL, '{{}}');
         INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture)
         VALUES (1, 1, 1, 't1', 'b', 30, 7, '{{}}', x'0101'), (2, 1, 2, 't2', 'b', 31, 7, '{{}}', x'01ff');
         INSERT INTO visit (waypoint_id, reference_id, sweep_id, at, boot_id, verdict, reason, d_gmm, u_th, seed, engine, report)
         VALUES (1, 1, 3, 't3', 'b', 'changed', 'r', 0.1, 0.002, 7, '{{}}', '{{}}'),
                (2, 2, 4, 't4', 'b', 'changed', 'r', 0.30000000000000004, 0.002, 7, '{{}}', '{{}}');
         INSERT INTO alarm (waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, state,
                            acknowledged_at, acknowledged_by, note)
         VALUES (1, 't3', 'b', 1, 1, 't3', 'acknowledged', 't5', 'guard', 'ours'), (2, 't4', 'b', 2, 2, 't4', 'open', NULL, NULL, NULL);
         UPDATE visit SET alarm_id = id;
         INSERT INTO novelty (visit_id, position, kind, x_m, points, record)
         VALUES (1, 0, 'appeared', 1.5, 9, '{{}}'), (2, 0, 'disappeared', NULL, 9, '{{}}');
         INSERT INTO shape (novelty_id, class, method) VALUES (1, 'box', 'm'), (2, 'sphere', 'm');
         INSERT INTO event (at, boot_id, level, device, text) VALUES ('t', 'b', 'info', 'service', 'old');"
    ))
    .expect("rows");
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::{Digest as _, Sha256};
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn nothing_is_lost_by_an_upgrade_and_a_rebuild_after_it() {
    let dir = tempfile::tempdir().expect("temp dir");
    second_version(dir.path());
    let before = rows(dir.path());
    let mut ledger = Ledger::new(Store::open(dir.path()).expect("upgraded"));
    let start = ledger.start();
    assert!(
        start.failures.is_empty() && start.lost_files.is_none(),
        "{start:?}"
    );
    ledger.maintain();
    assert!(ledger.store.check(|_, _| ()).expect("checked").is_sound());
    let events = ledger.store.events(9).expect("events");
    assert_eq!(events[0].text, "old");
    // Visits of then have no bytes of the devices, and one of now has.
    let before_upgrade = ledger.store.visit(1).expect("an old visit");
    let why = before_upgrade.dialogue.expect_err("none");
    assert!(why.contains("before patrold kept the bytes"), "{why}");
    let upgraded = rows(dir.path());
    for (table, old) in &before {
        assert_eq!(old.len(), upgraded[table].len(), "{table}");
    }
    let bytes = b"of both devices";
    let recorded = changed_visit("hall", 1, 9.0, |new| {
        let sweep = new.sweep.clone().map(|sweep| SweepRecord {
            dialogue: Some(bytes),
            ..sweep
        });
        let new = NewVisit {
            sweep,
            ..new.clone()
        };
        ledger.store.record_visit(&new, &stamp(50))
    });
    let visit_id = recorded.expect("recorded").visit_id;
    let visit = ledger.store.visit(visit_id).expect("stored");
    assert_eq!(visit.dialogue.as_deref(), Ok(&bytes[..]));
    ledger.close();
    let after = rows(dir.path());
    for (table, old) in &before {
        for (old, new) in old.iter().zip(&after[table]) {
            assert!(
                old.iter().all(|value| new.contains(value)),
                "{table}: {old:?}, now {new:?}"
            );
        }
    }
    for name in ["patrold.db", "patrold.db-wal", "patrold.db-shm"] {
        let _ = fs::remove_file(dir.path().join(name));
    }
    Store::rebuild(dir.path(), &stamp(100)).expect("rebuilt");
    assert_eq!(rows(dir.path()), after);
    let rebuilt = Store::open_for_reading(dir.path()).expect("reader");
    let again = rebuilt.visit(visit_id).expect("stored");
    assert_eq!(again.dialogue.as_deref(), Ok(&bytes[..]));
}
