//! A log of many visits, as the service would have written it, without its syncs.

use patrold::store::Store;
use rusqlite::{Connection, params};
use std::path::Path;

pub(crate) const WAYPOINTS: i64 = 40;
/// One visit of so many raises an alarm: 10,000 of a million.
pub(crate) const VISITS_PER_ALARM: i64 = 100;
/// Events: one for so many visits.
const VISITS_PER_EVENT: i64 = 10;
/// Sweeps whose files are still there: of the last two days.
pub(crate) const KEPT_SWEEPS: i64 = 5760;
/// 2026-03-01T00:00:00Z, and a visit every half minute.
const FIRST_S: i64 = 1_772_323_200;
const SECONDS_PER_VISIT: i64 = 30;

fn stamp(visit: i64) -> String {
    format!("{:.3}", time(visit))
}

pub(crate) fn time(visit: i64) -> jiff::Timestamp {
    jiff::Timestamp::from_second(FIRST_S + SECONDS_PER_VISIT * visit).expect("a time")
}

/// Rows as the service writes them, without its syncs.
pub(crate) fn build(dir: &Path, visits: i64) {
    drop(Store::open(dir).expect("a store"));
    let mut db = Connection::open(dir.join("patrold.db")).expect("the database");
    db.pragma_update(None, "synchronous", "OFF").expect("set");
    let change = db.transaction().expect("begins");
    for id in 1..=WAYPOINTS {
        change
            .execute(
                "INSERT INTO waypoint (name, created_at) VALUES (?1, '')",
                [name(id)],
            )
            .expect("a waypoint");
        change
            .execute(
                "INSERT INTO sweep (waypoint_id, taken_at, boot_id, points, quality) VALUES (?1, '', '', 1, '{}')",
                [id],
            )
            .expect("a sweep");
        change
            .execute(
                "INSERT INTO reference (waypoint_id, version, sweep_id, taken_at, boot_id, components, seed, engine, mixture)
                 VALUES (?1, 1, ?1, '', '', 1, 7, '{}', x'00')",
                [id],
            )
            .expect("a reference");
    }
    let boot = "7d3b8c1e-5f0a-4c7e-9d2a-1b6f3e8a4c5d";
    let report = format!("{{\"text\":\"{}\"}}", "x".repeat(1500));
    let engine = r#"{"version":"0.1.0","engine":"standard","ground":"w2","max_range_m":null,"shape":"auto"}"#;
    let reason = "d_GMM 0.0021 m reaches U_th 0.0005 m; one thing listed";
    {
        let mut visit = change
            .prepare(
                "INSERT INTO visit (id, waypoint_id, reference_id, at, boot_id, verdict, reason, d_gmm, u_th, seed, engine, report, sweep_id)
                 VALUES (?1, ?2, ?2, ?3, ?4, ?5, ?6, ?7, 0.0005, 7, ?8, ?9, ?10)",
            )
            .expect("a statement");
        let mut sweep = change
            .prepare(
                "INSERT INTO sweep (id, waypoint_id, taken_at, boot_id, points, quality, view_file)
                 VALUES (?1, ?2, ?3, ?4, 80000, '{}', ?5)",
            )
            .expect("a statement");
        let mut event = change
            .prepare("INSERT INTO event (at, boot_id, level, device, text) VALUES (?1, ?2, ?3, ?4, 'laser lost')")
            .expect("a statement");
        for id in 1..=visits {
            let alarms = id % VISITS_PER_ALARM == 0;
            let verdict = match (alarms, id % 977 == 0) {
                (true, _) => "changed",
                (false, true) => "not_observed",
                (false, false) => "quiet",
            };
            let d_gmm = if alarms {
                0.0021
            } else {
                1e-7 * (id % 1000) as f64
            };
            let file = (id > visits - KEPT_SWEEPS).then(|| file_of(id));
            if let Some(file) = &file {
                std::fs::write(dir.join("blobs").join(file), b"view").expect("written");
            }
            let sweep_id = WAYPOINTS + id;
            sweep
                .execute(params![sweep_id, waypoint(id), stamp(id), boot, file])
                .expect("a sweep");
            visit
                .execute(params![
                    id,
                    waypoint(id),
                    stamp(id),
                    boot,
                    verdict,
                    reason,
                    d_gmm,
                    engine,
                    report,
                    sweep_id
                ])
                .expect("a visit");
            if alarms {
                insert_alarm(&change, id, boot);
            }
            if id % VISITS_PER_EVENT == 0 {
                let level = if id % 9970 == 0 { "error" } else { "info" };
                let device = if id % 3 == 0 { "laser" } else { "ptu" };
                event
                    .execute(params![stamp(id), boot, level, device])
                    .expect("an event");
            }
        }
    }
    // As if the journal had them: it would be as long as the database.
    change
        .execute("DELETE FROM unjournaled", [])
        .expect("cleared");
    change.commit().expect("committed");
    db.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)")
        .expect("checkpoint");
}

/// As long as the name of an evidence file.
fn file_of(visit: i64) -> String {
    format!("{visit:064x}")
}

pub(crate) fn name(id: i64) -> String {
    format!("wp-{id}")
}

fn waypoint(visit: i64) -> i64 {
    // Not in step with the alarms.
    1 + (visit + visit / VISITS_PER_ALARM) % WAYPOINTS
}

fn insert_alarm(db: &Connection, visit: i64, boot: &str) {
    let number = visit / VISITS_PER_ALARM;
    let (class, size) = if number % 997 == 0 {
        ("cone", 1.5)
    } else {
        ("box", 0.4)
    };
    let kind = if number % 499 == 0 {
        "disappeared"
    } else {
        "appeared"
    };
    let state = if number % 501 == 0 { "open" } else { "cleared" };
    let x = (number % 100) as f64 * 0.1;
    let record = format!(
        r#"{{"kind":"{kind}","moved_from":null,"centre":[{x},1,0],"covariance":[[1,0,0],[0,1,0],[0,0,1]],"extent":[1,1,1],
        "points":100,"mass":0.01,"contribution":0.002,"support":300,"components":[],"needed_for_alarm":true,
        "shape":null,"shapes":{{"covariance":null,"ransac":null}},"parts":[],"text":"{}"}}"#,
        "x".repeat(1500)
    );
    db.prepare_cached(
        "INSERT INTO novelty (id, visit_id, position, kind, x_m, y_m, z_m, points, mass, contribution, record)
         VALUES (?1, ?2, 0, ?3, ?4, 1, 0, 100, 0.01, 0.002, ?5)",
    )
    .and_then(|mut insert| insert.execute(params![number, visit, kind, x, record]))
    .expect("a novelty");
    db.prepare_cached(
        "INSERT INTO shape (novelty_id, class, method, probability, size_x_m, size_y_m, size_z_m)
         VALUES (?1, ?2, 'covariance', 0.9, ?3, 0.3, 0.2)",
    )
    .and_then(|mut insert| insert.execute(params![number, class, size]))
    .expect("a shape");
    db.prepare_cached(
        "INSERT INTO alarm (id, waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, state)
         VALUES (?1, ?2, ?3, ?4, ?5, ?5, ?3, ?6)",
    )
    .and_then(|mut insert| {
        insert.execute(params![number, waypoint(visit), stamp(visit), boot, visit, state])
    })
    .expect("an alarm");
    db.prepare_cached(
        "INSERT INTO sighting (alarm_id, visit_id, position, relation) VALUES (?1, ?2, 0, 'raised')",
    )
    .and_then(|mut insert| insert.execute(params![number, visit]))
    .expect("a sighting");
    db.prepare_cached("UPDATE visit SET alarm_id = ?1 WHERE id = ?2")
        .and_then(|mut update| update.execute(params![number, visit]))
        .expect("linked");
}
