//! How long the log takes to answer when it is long: a million visits and 10,000 alarms at 40 waypoints, on disk. Prints a table of
//! CPU time per query (opening included), and the growth of memory while everything is exported.
//!
//! `cargo bench --bench log [-- VISITS]`

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

mod long_log;

use long_log::{KEPT_SWEEPS, VISITS_PER_ALARM, WAYPOINTS, build, name, time};
use patrold::alarm::{AlarmState, ThresholdStudy};
use patrold::patrol::severity::Severity;
use patrold::store::{
    AlarmFilter, EventFilter, FloorPlace, NearFilter, Retention, Store, StoreError, ThingFilter,
    TimeRange, VisitFilter,
};
use patrold_engine::novelty::{NoveltyKind, Verdict};
use std::fs;
use std::path::Path;
use std::time::Instant;

const VISITS: i64 = 1_000_000;
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
    beside(dir.path(), visits);
}

/// Some queries while another thread writes or copies.
fn beside(dir: &Path, visits: i64) {
    let copy = tempfile::tempdir().expect("a temporary folder");
    type Work<'a> = Box<dyn Fn() + Send + Sync + 'a>;
    let retention = || {
        let mut store = Store::open(dir).expect("opens");
        // A hundredth more goes each time.
        for hundredth in 1..=100 {
            let retention = Retention {
                older_than: Some(time(visits - KEPT_SWEEPS + KEPT_SWEEPS * hundredth / 100)),
                max_bytes: None,
                unnamed_older_than: None,
            };
            store.apply_retention(&retention).expect("applied");
        }
    };
    let backup = || {
        let store = Store::open_for_reading(dir).expect("opens");
        store.back_up(copy.path(), |_, _| ()).expect("backed up");
    };
    for (what, work) in [
        ("retention", Box::new(retention) as Work<'_>),
        ("backup", Box::new(backup)),
    ] {
        let started = Instant::now();
        std::thread::scope(|scope| {
            let other = scope.spawn(work);
            let mut rounds = 0;
            while !other.is_finished() && rounds < 3 {
                println!("while {what} runs:");
                some_queries(dir, visits);
                rounds += 1;
            }
        });
        println!("{what}: {:.1} s", started.elapsed().as_secs_f64());
    }
}

/// One of each kind.
fn some_queries(dir: &Path, visits: i64) {
    let visits_of = |verdict| VisitFilter {
        range: TimeRange::default(),
        waypoint: Some(name(7)),
        verdict,
        limit: 100,
    };
    let alarms = AlarmFilter {
        limit: Some(100),
        ..AlarmFilter::default()
    };
    let filter = visits_of(Some(Verdict::Changed));
    measure(dir, "visits at a waypoint changed", |store| {
        Ok(json(&store.visits(&filter)?))
    });
    measure(dir, "events", |store| Ok(json(&store.events(100)?)));
    measure(dir, "alarms", |store| Ok(json(&store.alarms(&alarms)?)));
    let on_map = on_map();
    measure(dir, "alarms near a place on the map", |store| {
        Ok(json(&store.alarms(&on_map)?))
    });
    measure(dir, "one visit", |store| {
        store.visit_detail(visits / 2).map(|_| 1)
    });
}

/// One alarm of a hundred is there.
fn on_map() -> AlarmFilter {
    let places = (1..=WAYPOINTS).map(|id| FloorPlace {
        waypoint: name(id),
        x_m: 5.0,
        y_m: 1.0,
    });
    let near = NearFilter {
        places: places.collect(),
        within_m: 0.01,
    };
    AlarmFilter {
        thing: ThingFilter {
            near: Some(near),
            ..ThingFilter::default()
        },
        limit: Some(100),
        ..AlarmFilter::default()
    }
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
        ("alarms near a place on the map", on_map()),
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
