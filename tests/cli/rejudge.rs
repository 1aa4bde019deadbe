//! `patrold rejudge`: the stored verdict with unchanged settings, another one with another threshold.

use crate::harness::clouds;
use crate::harness::program::{CommandOutput, patrold};
use crate::harness::schema;
use nalgebra::Point3;
use patrold::config::Settings;
use patrold::store::{NewReference, NewVisit, RecordTime, Store, SweepRecord};
use patrold_engine::geometry::View;
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::novelty::Verdict;
use patrold_engine::sweep::{PanSegmentLines, SweepQuality};
use serde_json::json;
use std::fs;
use std::path::Path;

fn record_time(second: i64) -> RecordTime {
    RecordTime {
        at: jiff::Timestamp::from_second(1_800_000_000 + second).expect("a time"),
        boot_id: "boot-1".to_owned(),
    }
}

fn quality(lines_got: usize) -> String {
    let quality = SweepQuality {
        lines_expected: 100,
        lines_got,
        gaps: 0,
        widest_gap_lines: 0,
        widest_gap_rad: 0.0,
        line_pitch_rad: 0.01,
        pan_segments: vec![PanSegmentLines {
            pan_rad: 0.0,
            expected: 100,
            got: lines_got,
        }],
        hit_share: 0.9,
        no_return_share: 0.0,
        position_residual_steps: 0.1,
        position_residual_rad: 1e-4,
        clock_uncertainty_s: 1e-4,
        clock_uncertainty_rad: 1e-5,
        clock_rate: 1.0,
        frozen: false,
        blind_lines: 0,
    };
    json!(quality).to_string()
}

/// A reference without a crate. Visit 1 has one, visit 2 none, visit 3 the crate in an incomplete sweep, visit 4 no sweep.
fn store_folder() -> tempfile::TempDir {
    store_folder_with(&[])
}

/// The same with these crates in the reference.
pub(crate) fn store_folder_with(before: &[clouds::Crate]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("temp dir");
    fs::write(dir.path().join("c.toml"), "store.dir = \"store\"\n").expect("written");
    let mut store = Store::open(&dir.path().join("store")).expect("store");
    let settings = Settings::defaults();
    let (engine, seed) = (settings.engine_settings(Some("hall")), 7);
    let view = |crates: &[_], noise| {
        View::from_points(clouds::room_points(crates, noise), Point3::origin())
    };
    let before = view(before, 1);
    let fitted = prepare(&before, &engine, seed).expect("a reference");
    let new = NewReference {
        waypoint: "hall",
        sweep: SweepRecord {
            view: Some(&before),
            raw: None,
            quality: &quality(100),
        },
        mixture: &fitted.gamma,
        model: &engine.novelty.reference_model(seed),
        engine: &settings.engine_json(),
        seed,
    };
    store.teach(&new, &record_time(0)).expect("taught");
    let stored = store.reference("hall").expect("stored");
    let ready = stored.make_ready("hall", &engine, seed).expect("ready");
    for (second, crates, lines) in [
        (10, &[clouds::CRATE][..], 100),
        (20, &[], 100),
        (30, &[clouds::CRATE], 50),
        (40, &[], 0),
    ] {
        let now = view(crates, 3);
        let found = inspect(&ready.reference, &now, &engine, seed, &mut |_| ()).expect("compared");
        let complete = lines == 100;
        let quality = quality(lines);
        let visit = NewVisit {
            waypoint: "hall",
            reference_id: Some(1),
            sweep: (lines > 0).then_some(SweepRecord {
                view: Some(&now),
                raw: None,
                quality: &quality,
            }),
            verdict: if complete {
                found.detection.verdict
            } else {
                Verdict::NotObserved
            },
            reason: "test",
            d_gmm: complete.then_some(found.detection.d_gmm),
            u_th: found.detection.u_th,
            seed,
            engine: &settings.engine_json(),
            report: "{}",
            novelties: &[],
            same_place_m: 0.5,
        };
        store
            .record_visit(&visit, &record_time(second))
            .expect("recorded");
    }
    dir
}

/// `patrold rejudge` in `dir`.
pub(crate) fn rejudge(dir: &Path, args: &[&str]) -> CommandOutput {
    patrold(dir, &[&["rejudge", "--config", "c.toml"], args].concat())
}

#[test]
fn a_stored_sweep_gets_its_stored_verdict_and_another_threshold_another_one() {
    let dir = store_folder();
    let run = |args: &[&str]| rejudge(dir.path(), args);
    for (id, code) in [("1", 10), ("2", 0), ("3", 11)] {
        let ran = run(&[id, "--json"]);
        assert_eq!(
            (ran.code, ran.err.as_str()),
            (code, ""),
            "visit {id}: {ran:?}"
        );
        let json = ran.json();
        schema::check("rejudge", &json);
        assert!(json["reference_made_anew"].is_null(), "visit {id}");
        assert_eq!(
            json["judged"]["verdict"], json["stored"]["verdict"],
            "visit {id}"
        );
        assert_eq!(
            json["judged"]["d_gmm"], json["stored"]["d_gmm"],
            "visit {id}"
        );
    }
    let none = run(&["4"]);
    assert_eq!((none.code, none.out.as_str()), (1, ""));
    assert!(
        none.err
            .contains("the sweep of visit 4 is not in the store: none was taken"),
        "{}",
        none.err
    );
    assert!(run(&["99"]).err.contains("no visit 99"));

    fs::write(
        dir.path().join("c.toml"),
        "store.dir = \"store\"\n[waypoint.hall]\nu_th_m = 0.9\n",
    )
    .expect("written");
    let flipped = run(&["1", "--json"]);
    assert_eq!(flipped.code, 0, "{flipped:?}");
    let json = flipped.json();
    assert_eq!(json["stored"]["verdict"], "changed");
    assert_eq!(json["judged"]["u_th"], 0.9);
    assert_eq!(json["judged"]["d_gmm"], json["stored"]["d_gmm"]);
    assert_eq!(run(&["1", "--stored-u-th"]).code, 10);
    let text = run(&["1"]).out;
    assert!(
        text.contains("stored: changed") && text.contains("now:    quiet"),
        "{text}"
    );
}
