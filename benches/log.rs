//! How long the log takes to answer when it is long: a million visits and 10,000 alarms at 40 waypoints, on disk. Prints a table of
//! CPU time per query (opening included), and the growth of memory while everything is exported.
//!
//! `cargo bench --bench log [-- VISITS]`

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

use patrold::alarm::{AlarmState, ThresholdStudy};
use patrold::patrol::severity::Severity;
use patrold::store::{
    AlarmFilter, EventFilter, FloorPlace, NearFilter, Store, StoreError, ThingFilter, TimeRange,
    VisitFilter,
};
use patrold_engine::novelty::{NoveltyKind, Verdict};
use rusqlite::{Connection, params};
use std::fs;
use std::path::Path;
use std::time::Instant;

const VISITS: i64 = 1_000_000;
const WAYPOINTS: i64 = 40;
/// One visit of so many raises an alarm: 10,000 of a million.
const VISITS_PER_ALARM: i64 = 100;
/// Events: one for so many visits.
const VISITS_PER_EVENT: i64 = 10;
/// 2026-03-01T00:00:00Z, and a visit every half minute.
const FIRST_S: i64 = 1_772_323_200;
const SECONDS_PER_VISIT: i64 = 30;
/// The figure that a query has to keep, milliseconds.
const LIMIT_MS: f64 = 10.0;
const RUNS: usize = 40;

fn main() {
    let visits = std::env::args()
        .filter_map(|arg| arg.parse().ok())
        .next()
        .unwrap_or(VISITS);
    let dir = tempfile::tempdir().expect("a temporary folder");
    let started = Instant::now();
    build(dir.path(), visits);
    let bytes = fs::metadata(dir.path().join("patrold.db")).map_or(0, |file| file.len());
    println!(
        "{visits} visits, {} alarms, {WAYPOINTS} waypoints: {:.1} GB, built in {:.0} s",
        visits / VISITS_PER_ALARM,
        bytes as f64 / 1e9,
        started.elapsed().as_secs_f64()
    );
    println!(
        "{:<58} {:>6} {:>9} {:>9}",
        "query", "rows", "CPU ms", "wall ms"
    );
    queries(dir.path(), visits);
    export(dir.path());
}

fn stamp(visit: i64) -> String {
    format!("{:.3}", time(visit))
}

fn time(visit: i64) -> jiff::Timestamp {
    jiff::Timestamp::from_second(FIRST_S + SECONDS_PER_VISIT * visit).expect("a time")
}

/// Rows as the service writes them, without its syncs.
fn build(dir: &Path, visits: i64) {
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
                "INSERT INTO visit (id, waypoint_id, reference_id, at, boot_id, verdict, reason, d_gmm, u_th, seed, engine, report)
                 VALUES (?1, ?2, ?2, ?3, ?4, ?5, ?6, ?7, 0.0005, 7, ?8, ?9)",
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
                    report
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
    change.commit().expect("committed");
    db.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)")
        .expect("checkpoint");
}

fn name(id: i64) -> String {
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

/// Runs a query several times, each on a store opened anew; prints the mean, because the kernel counts CPU time in coarse steps.
fn measure(dir: &Path, what: &str, query: impl Fn(&Store) -> Result<usize, StoreError>) {
    let mut rows = 0;
    let (cpu, wall) = (cpu_ms(), Instant::now());
    for _ in 0..RUNS {
        let store = Store::open_for_reading(dir).expect("opens");
        rows = query(&store).expect("answers");
    }
    let cpu = (cpu_ms() - cpu) / RUNS as f64;
    let wall = wall.elapsed().as_secs_f64() * 1e3 / RUNS as f64;
    let mark = if cpu > LIMIT_MS {
        "  above the limit"
    } else {
        ""
    };
    println!("{what:<58} {rows:>6} {cpu:>9.2} {wall:>9.2}{mark}");
}

/// Rows as JSON, as the command prints them; how many.
fn json<T: serde::Serialize>(rows: &[T]) -> usize {
    let text = serde_json::to_string(rows).expect("JSON");
    std::hint::black_box(text);
    rows.len()
}

/// CPU time of this thread (proc_pid_schedstat(5)).
fn cpu_ms() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ns = text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
    ns.unwrap_or(f64::NAN) / 1e6
}

fn queries(dir: &Path, visits: i64) {
    let middle = TimeRange {
        since: Some(time(visits / 2)),
        until: Some(time(visits / 2 + 2880)),
    };
    let early = TimeRange {
        since: None,
        until: Some(time(visits / 50)),
    };
    let all = TimeRange::default();
    for (range, when) in [
        (all, ""),
        (middle, " of a day"),
        (early, " of the beginning"),
    ] {
        for (waypoint, verdict) in [
            (None, None),
            (Some(7), None),
            (None, Some(Verdict::Changed)),
            (None, Some(Verdict::NotObserved)),
            (Some(7), Some(Verdict::Changed)),
        ] {
            let filter = VisitFilter {
                range,
                waypoint: waypoint.map(name),
                verdict,
                limit: 100,
            };
            let at = if waypoint.is_some() {
                " at a waypoint"
            } else {
                ""
            };
            let verdict = verdict.map_or("", Verdict::as_str);
            let what = format!("visits{when}{at} {verdict}");
            measure(dir, &what, |store| Ok(json(&store.visits(&filter)?)));
        }
        for (severity, device) in [
            (None, None),
            (Some(Severity::Error), None),
            (None, Some("laser")),
        ] {
            let filter = EventFilter {
                range,
                severity,
                device: device.map(str::to_owned),
                limit: 100,
            };
            let level = severity.map_or("", Severity::as_str);
            let what = format!("events{when} {level}{}", device.unwrap_or(""));
            measure(dir, &what, |store| Ok(json(&store.events(filter.clone())?)));
        }
        let filter = AlarmFilter {
            since: range.since,
            until: range.until,
            limit: Some(100),
            ..AlarmFilter::default()
        };
        measure(dir, &format!("alarms{when}"), |store| {
            Ok(json(&store.alarms(&filter)?))
        });
    }
    let near = NearFilter {
        places: vec![FloorPlace {
            waypoint: name(7),
            x_m: 5.0,
            y_m: 1.0,
        }],
        within_m: 0.01,
    };
    let on_map = NearFilter {
        places: (1..=WAYPOINTS)
            .map(|id| FloorPlace {
                waypoint: name(id),
                x_m: 5.0,
                y_m: 1.0,
            })
            .collect(),
        within_m: 0.01,
    };
    let thing = |thing| AlarmFilter {
        thing,
        limit: Some(100),
        ..AlarmFilter::default()
    };
    let any = ThingFilter::default;
    for (what, filter) in [
        (
            "alarms open",
            AlarmFilter {
                state: Some(AlarmState::Open),
                limit: Some(100),
                ..AlarmFilter::default()
            },
        ),
        (
            "alarms at a waypoint",
            AlarmFilter {
                waypoint: Some(name(7)),
                limit: Some(100),
                ..AlarmFilter::default()
            },
        ),
        (
            "alarms of a rare kind",
            thing(ThingFilter {
                kind: Some(NoveltyKind::Disappeared),
                ..any()
            }),
        ),
        (
            "alarms of a rare class",
            thing(ThingFilter {
                class: Some("cone".to_owned()),
                ..any()
            }),
        ),
        (
            "alarms of an absent class",
            thing(ThingFilter {
                class: Some("sphere".to_owned()),
                ..any()
            }),
        ),
        (
            "alarms of a rare size",
            thing(ThingFilter {
                min_size_m: Some(1.0),
                ..any()
            }),
        ),
        (
            "alarms near a place",
            thing(ThingFilter {
                near: Some(near),
                ..any()
            }),
        ),
        (
            "alarms near a place on the map",
            thing(ThingFilter {
                near: Some(on_map),
                ..any()
            }),
        ),
    ] {
        measure(dir, what, |store| Ok(json(&store.alarms(&filter)?)));
    }
    measure(dir, "waypoints", |store| Ok(json(&store.waypoints()?)));
    measure(dir, "last visit of each waypoint", |store| {
        for id in 1..=WAYPOINTS {
            let filter = VisitFilter {
                range: TimeRange::default(),
                waypoint: Some(name(id)),
                verdict: None,
                limit: 1,
            };
            store.visits(&filter)?;
        }
        Ok(WAYPOINTS as usize)
    });
    measure(dir, "one visit", |store| {
        store.visit_detail(visits / 2).map(|_| 1)
    });
    measure(dir, "one alarm", |store| store.alarm(1).map(|_| 1));
    println!("without a limit:");
    measure(dir, "distances of a waypoint, for tune", |store| {
        let mut study = ThresholdStudy::new([0.001]);
        store.each_past_distance(&name(7), &TimeRange::default(), "w2", &mut |past| {
            study.add(past)
        })?;
        Ok((study.quiet().total() + study.changed().total()) as usize)
    });
}

/// All alarms, page by page as `alarms export` reads them.
fn export(dir: &Path) {
    let store = Store::open_for_reading(dir).expect("opens");
    let (cpu, mut rows, mut bytes) = (cpu_ms(), 0, 0);
    let mut filter = AlarmFilter {
        limit: Some(200),
        ..AlarmFilter::default()
    };
    let mut resident = Vec::new();
    loop {
        let page = store.alarms(&filter).expect("a page");
        bytes += page
            .iter()
            .map(|alarm| serde_json::to_string(alarm).map_or(0, |text| text.len()))
            .sum::<usize>();
        rows += page.len();
        resident.push(resident_kb());
        let Some(last) = page.last() else { break };
        filter.before = Some(last.id);
    }
    // The first pages fill the cache of SQLite.
    let (early, late) = (resident[resident.len() / 4], resident[resident.len() - 1]);
    println!(
        "export: {rows} alarms, {:.1} MB of JSON, {:.0} ms of CPU; memory after a quarter {:.1} MB, at the end {:.1} MB",
        bytes as f64 / 1e6,
        cpu_ms() - cpu,
        early / 1e3,
        late / 1e3
    );
}

/// Resident memory (proc_pid_status(5)).
fn resident_kb() -> f64 {
    let text = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok())
        .unwrap_or(f64::NAN)
}
