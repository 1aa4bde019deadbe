//! A database filled through the library, for the tests of `alarms` and `waypoints`.

use crate::harness::program::{CommandOutput, patrold};
use crate::harness::schema;
use nalgebra::{Matrix3, Point3};
use patrold::store::{NewReference, NewVisit, RecordTime, ReferenceFrame, Store, SweepRecord};
use patrold_engine::geometry::View;
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::{ComponentBeams, PlaceView, ReferenceMixture, Verdict};
use patrold_engine::report::{MethodsRecord, NoveltyRecord, ShapeRecord};
use std::fs;
use std::path::Path;

/// Seconds after 2027-01-15T08:00:00Z.
pub(crate) fn record_time(second: i64) -> RecordTime {
    RecordTime {
        at: jiff::Timestamp::from_second(1_800_000_000 + second).expect("a time"),
        boot_id: "boot-1".to_owned(),
    }
}

pub(crate) fn mixture() -> ReferenceMixture {
    let component = Gaussian {
        mean: Point3::origin(),
        covariance: Matrix3::identity(),
    };
    let beams = ComponentBeams {
        count: 1.0,
        noise_m: 0.01,
        lost_share: 0.0,
    };
    ReferenceMixture {
        mixture: Mixture {
            weights: vec![1.0],
            components: vec![component],
        },
        beams: vec![beams],
    }
}

pub(crate) fn novelty(x: f64) -> NoveltyRecord {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let shape = ShapeRecord {
        class: "sphere".to_owned(),
        method: "covariance".to_owned(),
        probability: 0.9,
        alternatives: Vec::new(),
        centre: [x, 0.0, 0.0],
        centre_sd: [0.01; 3],
        rotation: unit,
        size: [0.3; 3],
        size_sd: [0.02; 3],
        exponents: None,
        residual_m: 0.004,
        inliers: 120,
    };
    NoveltyRecord {
        kind: "appeared".to_owned(),
        moved_from: None,
        centre: [x, 0.0, 0.0],
        covariance: unit.map(|row| row.map(|x| 0.01 * x)),
        pose_sd: None,
        extent: [0.3; 3],
        points: 120,
        mass: 0.01,
        contribution: 0.002,
        support: 400.0,
        components: vec![0],
        needed_for_alarm: true,
        shape: Some(shape.clone()),
        shapes: MethodsRecord {
            covariance: Some(shape),
            ransac: None,
        },
        parts: Vec::new(),
    }
}

pub(crate) fn teach(store: &mut Store, waypoint: &str, second: i64) {
    let view = View::from_points(vec![Point3::new(1.0, 2.0, second as f64)], Point3::origin());
    let sweep = SweepRecord {
        dialogue: None,
        view: Some(&view),
        raw: None,
        quality: "{}",
    };
    let new = NewReference {
        waypoint,
        sweep,
        mixture: &mixture(),
        model: "{}",
        engine: "{}",
        seed: 7,
        accepted: &[],
        frame: ReferenceFrame::Own,
    };
    store.teach(&new, &record_time(second)).expect("taught");
}

pub(crate) fn visit(
    store: &mut Store,
    waypoint: &str,
    verdict: Verdict,
    seen: &[NoveltyRecord],
    second: i64,
) {
    visit_at(store, waypoint, verdict, seen, &record_time(second));
}

pub(crate) fn visit_at(
    store: &mut Store,
    waypoint: &str,
    verdict: Verdict,
    seen: &[NoveltyRecord],
    stamp: &RecordTime,
) {
    let second = stamp.at.as_second() as f64;
    let view = View::from_points(vec![Point3::new(9.0, 2.0, second)], Point3::origin());
    // A quiet visit saw every place as it was taught, a changed one none of them.
    let places: Vec<(i64, PlaceView)> = match verdict {
        Verdict::Quiet => (1..=9).map(|id| (id, PlaceView::AsTaught)).collect(),
        _ => Vec::new(),
    };
    let visit = NewVisit {
        waypoint,
        reference_id: Some(store.reference(waypoint).expect("reference").id),
        sweep: Some(SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: None,
            quality: "{}",
        }),
        verdict,
        reason: "d_GMM reaches U_th",
        d_gmm: Some(0.0021),
        u_th: 0.0005,
        seed: 7,
        engine: r#"{"ground": "w2"}"#,
        report: "{}",
        novelties: seen,
        places: &places,
        same_place_m: 0.5,
    };
    store.record_visit(&visit, stamp).expect("recorded");
}

/// Alarms 1 (dock, cleared), 2 (hall, acknowledged), 3 and 4 (hall, open, of one visit), raised an hour apart.
pub(crate) fn store_folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    teach(&mut store, "hall", 0);
    teach(&mut store, "dock", 10);
    visit(&mut store, "dock", Verdict::Changed, &[novelty(1.0)], 3600);
    visit(&mut store, "dock", Verdict::Quiet, &[], 3700);
    visit(&mut store, "hall", Verdict::Changed, &[novelty(1.0)], 7200);
    store
        .acknowledge(2, "ana", Some("the \"red\" bin, again"), &record_time(7300))
        .expect("acknowledged");
    visit(
        &mut store,
        "hall",
        Verdict::Changed,
        &[novelty(3.0), novelty(5.0)],
        10_800,
    );
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    dir
}

pub(crate) fn run(dir: &Path, args: &[&str]) -> CommandOutput {
    patrold(dir, &[args, &["--config", "c.toml"]].concat())
}

pub(crate) fn ids(ran: &CommandOutput) -> Vec<i64> {
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let json = ran.json();
    schema::check("alarms-list", &json);
    let all = json["alarms"].as_array().expect("a list");
    all.iter().filter_map(|a| a["id"].as_i64()).collect()
}
