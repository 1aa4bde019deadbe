//! A mixture that was made anew takes the place of the stored one, once.

use super::kit::{MODEL, changed_visit, gaussian, mixture, stamp};
use nalgebra::Point3;
use patrold::store::{
    NewMixture, NewReference, ReadyReference, ReferenceFrame, Store, StoredMixture,
    StoredReference, SweepRecord,
};
use patrold_engine::geometry::View;
use patrold_engine::inspect::EngineSettings;
use patrold_engine::mixture::Mixture;
use patrold_engine::novelty::ReferenceMixture;

/// A wall two metres away, seen by 1681 beams; its mixture is not that of a fit.
fn teach(store: &mut Store) -> StoredReference {
    let side = || (-20..=20).map(|i| 0.05 * f64::from(i));
    let points = side().flat_map(|y| side().map(move |z| Point3::new(2.0, y, z)));
    let view = View::from_points(points.collect(), Point3::origin());
    let new = NewReference {
        waypoint: "hall",
        sweep: SweepRecord {
            dialogue: None,
            view: Some(&view),
            raw: None,
            quality: "{}",
        },
        mixture: &mixture(),
        model: MODEL,
        engine: r#"{"by": "hand"}"#,
        seed: 7,
        accepted: &[],
        frame: ReferenceFrame::Own,
    };
    store.teach(&new, &stamp(0)).expect("taught");
    store.reference("hall").expect("stored")
}

fn replace(store: &mut Store, stored: &StoredReference, ready: &ReadyReference) -> bool {
    let new = NewMixture {
        waypoint: "hall",
        stored,
        ready,
        made_anew: ready.made_anew.as_ref().expect("made anew"),
        engine: "{}",
        seed: 8,
    };
    store.replace_mixture(&new, &stamp(1)).expect("no failure")
}

#[test]
fn the_first_to_replace_a_mixture_wins() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    let stored = teach(&mut store);
    let settings = EngineSettings::standard();
    let ready = stored.make_ready("hall", &settings, 7).expect("ready");
    let model = settings.novelty.reference_model(7);
    let why = &ready.made_anew.as_ref().expect("another model").why;
    assert_eq!(*why, format!("other settings: {model} instead of {MODEL}"));

    assert!(replace(&mut store, &stored, &ready));
    let now = store.reference("hall").expect("stored");
    let intact = StoredMixture::Intact {
        gamma: ready.reference.gamma.clone(),
        model,
    };
    assert_eq!(now.mixture, intact);
    assert_eq!(now.components, ready.reference.gamma.mixture.len());
    assert_eq!((now.engine.as_str(), now.seed), ("{}", 8));
    assert_eq!((now.id, now.version), (stored.id, stored.version));
    let rows = store.waypoint("hall").expect("hall").references;
    assert_eq!(
        (rows.len(), rows[0].components as usize),
        (1, now.components)
    );

    // Who read the row before comes too late.
    assert!(!replace(&mut store, &stored, &ready));
    let events = store.events(10).expect("events");
    let texts: Vec<&str> = events.iter().map(|event| event.text.as_str()).collect();
    let components = now.components;
    let expected = format!(
        "reference hall/1: mixture made anew from its view, {components} components instead of 1: {why}"
    );
    assert_eq!(texts, [expected]);
    assert_eq!(
        (events[0].device.as_str(), events[0].level.as_str()),
        ("service", "info")
    );
    let again = now.make_ready("hall", &settings, 7).expect("ready");
    assert!(again.made_anew.is_none());
    assert_eq!(again.reference.gamma, ready.reference.gamma);
}

#[test]
fn a_visit_knows_the_mixture_that_it_was_compared_with() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut store = Store::open(dir.path()).expect("store");
    let gamma = |x| ReferenceMixture {
        mixture: Mixture {
            weights: vec![1.0],
            components: vec![gaussian(x)],
        },
        ..mixture()
    };
    let view = View::from_points(vec![Point3::new(1.0, 0.0, 0.0); 4], Point3::origin());
    for (waypoint, x, second) in [("hall", 2.0, 0), ("yard", 3.0, 1), ("hall", 4.0, 2)] {
        let new = NewReference {
            waypoint,
            sweep: SweepRecord {
                dialogue: None,
                view: Some(&view),
                raw: None,
                quality: "{}",
            },
            mixture: &gamma(x),
            model: MODEL,
            engine: "{}",
            seed: 7,
            accepted: &[],
            frame: ReferenceFrame::Own,
        };
        store.teach(&new, &stamp(second)).expect("taught");
    }
    let older = store.reference_version("hall", 1).expect("kept").id;
    let newer = store.reference("hall").expect("taught").id;
    let yard = store.reference("yard").expect("taught").id;
    for (waypoint, reference, x) in [
        ("hall", older, 2.0),
        ("yard", yard, 3.0),
        ("hall", newer, 4.0),
    ] {
        let visit = changed_visit(waypoint, reference, 9.0, |new| {
            store.record_visit(new, &stamp(10)).expect("recorded")
        });
        let found = store.reference_of_visit(visit.visit_id).expect("asked");
        assert_eq!(found, Some(gamma(x)), "{waypoint}");
    }
    assert_eq!(store.reference_of_visit(99).expect("asked"), None);
}
