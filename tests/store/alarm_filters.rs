//! Filters of alarms, each alone and with each other, against the plain definition, beside rows that they must not touch.

use super::kit::{changed_visit, novelty_at, stamp, teach};
use patrold::alarm::AlarmState;
use patrold::store::{AlarmFilter, AlarmRow, FloorPlace, NearFilter, NewVisit, Store, ThingFilter};
use patrold_engine::novelty::NoveltyKind;
use patrold_engine::report::NoveltyRecord;
use rusqlite::{Connection, params};
use std::path::Path;

/// Kind, place, and shape where it has one: class and size.
type Thing = (NoveltyKind, [f64; 2], Option<(&'static str, [f64; 3])>);

/// The thing of each alarm, hall and yard in turn. Sizes are of the shape's first, second or third
/// side.
const THINGS: [Thing; 8] = [
    (
        NoveltyKind::Appeared,
        [3.0, 4.0],
        Some(("box", [0.4, 0.3, 0.2])),
    ),
    (
        NoveltyKind::Appeared,
        [3.0, 4.0],
        Some(("box", [0.2, 0.9, 0.1])),
    ),
    (
        NoveltyKind::Disappeared,
        [-3.0, 4.0],
        Some(("cone", [0.1, 0.2, 1.5])),
    ),
    (NoveltyKind::Disappeared, [3.0, -4.0], None),
    (
        NoveltyKind::Appeared,
        [9.0, 1.0],
        Some(("cone", [0.5, 0.5, 0.5])),
    ),
    (
        NoveltyKind::Appeared,
        [-9.0, -1.0],
        Some(("sphere", [0.4, 0.4, 0.4])),
    ),
    (
        NoveltyKind::Disappeared,
        [20.0, 4.0],
        Some(("box", [0.9, 0.1, 0.1])),
    ),
    (NoveltyKind::Appeared, [20.0, 30.0], None),
];

fn thing(kind: NoveltyKind, [x, y]: [f64; 2]) -> NoveltyRecord {
    NoveltyRecord {
        kind: kind.as_str().to_owned(),
        centre: [x, y, 0.0],
        ..novelty_at(x)
    }
}

fn waypoint(at: usize) -> &'static str {
    ["hall", "yard"][at % 2]
}

fn record(store: &mut Store, waypoint: &str, second: i64, novelties: &[NoveltyRecord]) {
    let reference = store.reference(waypoint).expect("taught").id;
    changed_visit(waypoint, reference, 1.0, |new| {
        let visit = NewVisit {
            sweep: None,
            novelties,
            ..new.clone()
        };
        store
            .record_visit(&visit, &stamp(second))
            .expect("recorded");
    });
}

/// One alarm for each of [`THINGS`]; the first is seen again last, elsewhere.
fn log(dir: &Path) -> Store {
    let mut store = Store::open(dir).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "yard", 1);
    for (at, (kind, place, _)) in THINGS.iter().enumerate() {
        record(
            &mut store,
            waypoint(at),
            100 + at as i64,
            &[thing(*kind, *place)],
        );
    }
    store
        .acknowledge(2, "guard", None, &stamp(300))
        .expect("acknowledged");
    store
        .acknowledge(3, "guard", None, &stamp(301))
        .expect("acknowledged");
    record(
        &mut store,
        "hall",
        400,
        &[thing(NoveltyKind::Appeared, [3.1, 4.0])],
    );
    // A log from before it had shapes has none; the tests need theirs by hand.
    let db = Connection::open(dir.join("patrold.db")).expect("opens");
    for (at, (_, _, shape)) in THINGS.iter().enumerate() {
        let novelties = if at == 0 {
            vec![1, 9]
        } else {
            vec![at as i64 + 1]
        };
        for (novelty, (class, sides)) in novelties
            .iter()
            .flat_map(|n| shape.iter().map(move |s| (n, s)))
        {
            db.execute(
                "INSERT INTO shape (novelty_id, class, method, probability, size_x_m, size_y_m, size_z_m)
                 VALUES (?1, ?2, 'covariance', 0.9, ?3, ?4, ?5)",
                params![novelty, class, sides[0], sides[1], sides[2]],
            )
            .expect("a shape");
        }
    }
    store
}

/// Number of each of [`THINGS`] that is meant, by its alarm as it is listed without a filter.
fn plain(all: &[AlarmRow], filter: &AlarmFilter) -> Vec<i64> {
    let thing = &filter.thing;
    let is_meant = |alarm: &&AlarmRow| {
        let (_, place, shape) = THINGS[alarm.id as usize - 1];
        let place = if alarm.id == 1 { [3.1, 4.0] } else { place };
        let last = alarm.last_sighting.as_ref().expect("seen");
        let kind = last.novelties[0].kind.as_str();
        let longest = shape.map(|(_, [x, y, z])| x.max(y).max(z));
        let near = |near: &NearFilter| {
            near.places.iter().any(|at| {
                let off_m = (at.x_m - place[0]).hypot(at.y_m - place[1]);
                at.waypoint == alarm.waypoint && off_m <= near.within_m
            })
        };
        filter
            .waypoint
            .as_ref()
            .is_none_or(|name| *name == alarm.waypoint)
            && filter
                .state
                .is_none_or(|state| state.as_str() == alarm.state)
            && filter.before.is_none_or(|before| alarm.id < before)
            && filter
                .since
                .is_none_or(|since| alarm.last_seen_at >= format!("{since:.3}"))
            && filter
                .until
                .is_none_or(|until| alarm.raised_at <= format!("{until:.3}"))
            && thing.kind.is_none_or(|of| of.as_str() == kind)
            && thing
                .class
                .as_ref()
                .is_none_or(|class| shape.is_some_and(|s| s.0 == class))
            && thing
                .min_size_m
                .is_none_or(|min| longest.is_some_and(|size| size >= min))
            && thing
                .max_size_m
                .is_none_or(|max| longest.is_some_and(|size| size <= max))
            && thing.near.as_ref().is_none_or(near)
    };
    let ids = all.iter().filter(is_meant).map(|alarm| alarm.id);
    ids.take(filter.limit.map_or(usize::MAX, |limit| limit as usize))
        .collect()
}

fn near(places: &[(&str, f64, f64)], within_m: f64) -> Option<NearFilter> {
    let place = |(name, x_m, y_m): &(&str, f64, f64)| FloorPlace {
        waypoint: (*name).to_owned(),
        x_m: *x_m,
        y_m: *y_m,
    };
    Some(NearFilter {
        places: places.iter().map(place).collect(),
        within_m,
    })
}

#[test]
fn every_filter_alone_and_each_pair_lists_what_it_says() {
    let dir = tempfile::tempdir().expect("temp dir");
    let store = log(dir.path());
    let all = store.alarms(&AlarmFilter::default()).expect("all");
    assert_eq!(all.len(), THINGS.len());
    assert_eq!(all[7].id, 1, "the newest first");
    type Set = fn(&mut AlarmFilter);
    let filters: [Set; 22] = [
        |_| (),
        |f| f.waypoint = Some("hall".to_owned()),
        |f| f.waypoint = Some("yard".to_owned()),
        |f| f.state = Some(AlarmState::Open),
        |f| f.state = Some(AlarmState::Acknowledged),
        |f| f.before = Some(3),
        |f| f.limit = Some(2),
        |f| f.since = Some(stamp(104).at),
        |f| f.until = Some(stamp(104).at),
        |f| f.thing.kind = Some(NoveltyKind::Appeared),
        |f| f.thing.kind = Some(NoveltyKind::Disappeared),
        |f| f.thing.class = Some("box".to_owned()),
        |f| f.thing.class = Some("cone".to_owned()),
        |f| f.thing.min_size_m = Some(0.9),
        |f| f.thing.min_size_m = Some(0.4),
        |f| f.thing.max_size_m = Some(0.4),
        |f| f.thing.max_size_m = Some(0.9),
        |f| f.thing.near = near(&[("hall", 3.0, 4.0)], 0.11),
        |f| f.thing.near = near(&[("yard", 3.0, 4.0)], 0.0),
        |f| f.thing.near = near(&[("hall", 0.0, 0.0), ("yard", 0.0, 0.0)], 5.0),
        |f| {
            f.thing.near = near(
                &[
                    ("hall", -3.0, 4.0),
                    ("hall", 9.0, 1.0),
                    ("yard", 20.0, 30.0),
                ],
                0.5,
            )
        },
        |f| f.thing.near = near(&[], 100.0),
    ];
    let mut selective = 0;
    for first in filters {
        for second in filters {
            let mut filter = AlarmFilter::default();
            first(&mut filter);
            second(&mut filter);
            let listed = store.alarms(&filter).expect("listed");
            let ids: Vec<i64> = listed.iter().map(|alarm| alarm.id).collect();
            assert_eq!(ids, plain(&all, &filter), "{filter:?}");
            selective += usize::from(!ids.is_empty() && ids.len() < all.len());
        }
    }
    assert!(selective > 200, "{selective} of them list some");
    let unknown = ThingFilter::default();
    assert_eq!(unknown, AlarmFilter::default().thing);
}

#[test]
fn a_place_is_within_its_distance_on_both_sides_of_the_limit() {
    let dir = tempfile::tempdir().expect("temp dir");
    let store = log(dir.path());
    let found = |x_m: f64, y_m: f64, within_m: f64| {
        let filter = AlarmFilter {
            thing: ThingFilter {
                near: near(&[("yard", x_m, y_m)], within_m),
                ..ThingFilter::default()
            },
            ..AlarmFilter::default()
        };
        let listed = store.alarms(&filter).expect("listed");
        listed.iter().map(|alarm| alarm.id).collect::<Vec<_>>()
    };
    // Alarm 2 is at (3, 4), alarm 4 at (3, -4).
    assert_eq!(found(6.0, 8.0, 5.0), [2]);
    assert_eq!(found(6.0, 8.0, 4.99), [0i64; 0]);
    assert_eq!(found(3.0, 0.0, 4.0), [4, 2]);
    assert_eq!(found(3.0, -1.0, 4.0), [4]);
}

#[test]
fn a_name_that_was_taught_again_is_both_waypoints() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = log(dir.path());
    store
        .forget_waypoint("yard", &stamp(500))
        .expect("forgotten");
    teach(&mut store, "yard", 510);
    record(
        &mut store,
        "yard",
        520,
        &[thing(NoveltyKind::Appeared, [3.0, 4.0])],
    );
    let filter = AlarmFilter {
        thing: ThingFilter {
            near: near(&[("yard", 3.0, 4.0)], 0.1),
            ..ThingFilter::default()
        },
        ..AlarmFilter::default()
    };
    let listed = store.alarms(&filter).expect("listed");
    let ids: Vec<i64> = listed.iter().map(|alarm| alarm.id).collect();
    assert_eq!(ids, [9, 2]);
    // Where there are several of a name, all are asked for.
    let by_name = AlarmFilter {
        waypoint: Some("yard".to_owned()),
        ..AlarmFilter::default()
    };
    let ids: Vec<i64> = store
        .alarms(&by_name)
        .expect("listed")
        .iter()
        .map(|a| a.id)
        .collect();
    assert_eq!(ids, [9, 8, 6, 4, 2]);
}
