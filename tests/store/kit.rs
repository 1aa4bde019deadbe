//! Sweeps, mixtures and novelties to store, and short forms of the calls.

use nalgebra::{Matrix3, Point3};
use patrold::alarm::Relation;
use patrold::store::{
    AlarmFilter, NewReference, NewVisit, RecordTime, ReferenceFrame, Retention, Store, StoreError,
    SweepRecord, VisitOutcome,
};
use patrold_engine::geometry::View;
use patrold_engine::mixture::{Gaussian, Mixture};
use patrold_engine::novelty::{
    ComponentBeams, Novelty, NoveltyKind, PlaceView, ReferenceMixture, Surroundings, Verdict,
};
use patrold_engine::report::NoveltyRecord;
use std::path::Path;

pub(crate) const EVERYTHING: Retention = Retention {
    older_than: Some(jiff::Timestamp::MAX),
    max_bytes: Some(0),
    unnamed_older_than: None,
};

pub(crate) fn stamp(second: i64) -> RecordTime {
    RecordTime {
        at: jiff::Timestamp::from_second(1_800_000_000 + second).expect("a valid time"),
        boot_id: "boot".to_owned(),
    }
}

pub(crate) fn view(x: f64) -> View {
    View::from_points(vec![Point3::new(x, 0.0, 0.0); 4], Point3::origin())
}

/// What [`mixture`] is stored as made by.
pub(crate) const MODEL: &str = r#"{"version":1,"fit":"by hand"}"#;

pub(crate) fn mixture() -> ReferenceMixture {
    let beams = ComponentBeams {
        count: 4.0,
        noise_m: 0.01,
        lost_share: 0.0,
    };
    ReferenceMixture {
        mixture: Mixture {
            weights: vec![1.0],
            components: vec![gaussian(1.0)],
        },
        beams: vec![beams],
    }
}

pub(crate) fn gaussian(x: f64) -> Gaussian {
    Gaussian {
        mean: Point3::new(x, 0.0, 0.0),
        covariance: Matrix3::identity(),
    }
}

pub(crate) fn teach(store: &mut Store, name: &str, second: i64) -> i64 {
    let view = view(second as f64);
    let accepted = standing(store, name);
    let new = NewReference {
        waypoint: name,
        sweep: SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: Some(b"raw"),
            quality: "{}",
        },
        mixture: &mixture(),
        model: MODEL,
        engine: r#"{"ground": "w2"}"#,
        seed: 7,
        accepted: &accepted,
        frame: ReferenceFrame::Own,
    };
    store.teach(&new, &stamp(second)).expect("taught")
}

/// Makes what an alarm at the hall shows normal: the view with it as a new version, in the frame of the first.
pub(crate) fn accept(store: &mut Store, alarm: i64, second: i64) -> Result<i64, StoreError> {
    let view = view(3000.0 + second as f64);
    let new = NewReference {
        waypoint: "hall",
        sweep: SweepRecord {
            view: Some(&view),
            raw: None,
            dialogue: None,
            quality: "null",
        },
        mixture: &mixture(),
        model: MODEL,
        engine: "{}",
        seed: 7,
        accepted: &[alarm],
        frame: ReferenceFrame::Version(1),
    };
    store.teach(&new, &stamp(second))
}

/// The alarms of a waypoint that are not cleared.
pub(crate) fn standing(store: &Store, name: &str) -> Vec<i64> {
    let alarms = store.alarms(&AlarmFilter::default()).expect("alarms");
    let standing = alarms
        .iter()
        .filter(|a| a.waypoint == name && a.state != "cleared");
    standing.map(|a| a.id).collect()
}

pub(crate) fn novelty_at(x: f64) -> NoveltyRecord {
    let novelty = Novelty {
        kind: NoveltyKind::Appeared,
        moved_from: None,
        point_indices: vec![0, 1],
        points: Vec::new(),
        moments: gaussian(x),
        mixture: mixture().mixture,
        components: vec![0],
        needed_for_alarm: true,
        extent_m: [0.1, 0.1, 0.1],
        surroundings: Surroundings::default(),
        mass: 0.01,
        contribution: 0.005,
        support: 400.0,
    };
    NoveltyRecord::new(&novelty, None)
}

pub(crate) fn visit(
    store: &mut Store,
    verdict: Verdict,
    novelties: &[NoveltyRecord],
    second: i64,
) -> VisitOutcome {
    let reference = store.reference("hall").expect("reference");
    visit_of(store, reference.id, verdict, novelties, second)
}

pub(crate) fn visit_of(
    store: &mut Store,
    reference_id: i64,
    verdict: Verdict,
    novelties: &[NoveltyRecord],
    second: i64,
) -> VisitOutcome {
    let view = view(1000.0 + second as f64);
    // A quiet visit saw every place as it was taught, a changed one none of them.
    let incidents = store.incidents("hall").unwrap_or_default();
    let places: Vec<(i64, PlaceView)> = incidents
        .iter()
        .filter(|_| verdict == Verdict::Quiet)
        .map(|incident| (incident.id, PlaceView::AsTaught))
        .collect();
    let visit = NewVisit {
        waypoint: "hall",
        reference_id: Some(reference_id),
        sweep: Some(SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: None,
            quality: "{}",
        }),
        verdict,
        reason: "test",
        d_gmm: Some(0.005),
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties,
        places: &places,
        same_place_m: 0.5,
    };
    store
        .record_visit(&visit, &stamp(second))
        .expect("recorded")
}

/// A changed visit at `waypoint` that saw one thing at `x`, with view and raw data of its own.
pub(crate) fn changed_visit<R>(
    waypoint: &str,
    reference_id: i64,
    x: f64,
    use_it: impl FnOnce(&NewVisit<'_>) -> R,
) -> R {
    let view = view(2000.0 + x);
    let raw = format!("raw of {waypoint} at {x}");
    use_it(&NewVisit {
        waypoint,
        reference_id: Some(reference_id),
        sweep: Some(SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: Some(raw.as_bytes()),
            quality: "{}",
        }),
        verdict: Verdict::Changed,
        reason: "test",
        d_gmm: Some(0.005),
        u_th: 0.001,
        seed: 7,
        engine: "{}",
        report: "{}",
        novelties: &[novelty_at(x)],
        places: &[],
        same_place_m: 0.5,
    })
}

pub(crate) fn alarms(dir: &Path, filter: &AlarmFilter) -> Vec<(i64, String)> {
    let store = Store::open_for_reading(dir).expect("reader");
    let rows = store.alarms(filter).expect("query");
    rows.into_iter().map(|a| (a.id, a.state)).collect()
}

/// The first alarm that a visit raised.
pub(crate) fn first_raised(outcome: &VisitOutcome) -> Option<i64> {
    raised(outcome).first().copied()
}

/// The alarms that a visit raised.
pub(crate) fn raised(outcome: &VisitOutcome) -> Vec<i64> {
    by_relation(outcome, Relation::Raised)
}

/// The alarms that it is this to.
pub(crate) fn by_relation(outcome: &VisitOutcome, relation: Relation) -> Vec<i64> {
    let alarms = outcome.effects.alarms.iter();
    alarms
        .filter(|a| a.relation == relation)
        .map(|a| a.id)
        .collect()
}
