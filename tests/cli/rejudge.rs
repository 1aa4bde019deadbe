//! `patrold rejudge`: the stored verdict with unchanged settings, another one with another threshold.

use crate::harness::clouds;
use crate::harness::program::{CommandOutput, patrold};
use crate::harness::schema;
use nalgebra::Point3;
use patrold::config::Settings;
use patrold::store::{NewReference, NewVisit, RecordTime, ReferenceFrame, Store, SweepRecord};
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
            dialogue: None,
            view: Some(&before),
            raw: None,
            quality: &quality(100),
        },
        mixture: &fitted.gamma,
        model: &engine.novelty.reference_model(seed),
        accepted: &[],
        frame: ReferenceFrame::Own,
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
                dialogue: None,
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
            places: &[],
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

/// Visit 1 (changed), 2 (quiet) and 3 (not observed) have a sweep, visit 4 none.
#[test]
fn a_stretch_of_the_log_is_judged_again_and_never_written() {
    let dir = store_folder();
    let database = dir.path().join("store/patrold.db");
    let before = fs::read(&database).expect("a database");
    let lines = |args: &[&str], code: i32| {
        let ran = patrold(
            dir.path(),
            &[&["rejudge", "--config", "c.toml", "--json"], args].concat(),
        );
        assert_eq!((ran.code, ran.err.as_str()), (code, ""), "{args:?} {ran:?}");
        let mut lines = ran.json_lines();
        let summary = lines.pop().expect("a summary");
        schema::check("rejudge-summary", &summary);
        lines
            .iter()
            .for_each(|line| schema::check("rejudge-difference", line));
        (lines, summary)
    };
    let same =
        json!({"judged": 3, "from_device_bytes": 0, "differ": 0, "not_kept": 1, "failed": 0});
    for args in [
        &["--since", "2020-01-01"][..],
        &["--since", "2020-01-01", "--threads", "1"],
        &["--waypoint", "hall"],
        &["1", "2", "3", "4"],
    ] {
        let (differ, summary) = lines(args, 0);
        assert_eq!((differ.len(), &summary), (0, &same), "{args:?}");
    }
    let (_, none) = lines(&["--until", "2020-01-01"], 0);
    assert_eq!(none["judged"], 0);

    // Another threshold: visit 1 is quiet then.
    fs::write(
        dir.path().join("c.toml"),
        "store.dir = \"store\"\nnovelty.u_th_m = 5.0\n",
    )
    .expect("written");
    let (differ, summary) = lines(&["--since", "2020-01-01"], 0);
    assert_eq!((differ.len(), &summary["differ"]), (1, &json!(1)));
    assert_eq!(
        (&differ[0]["visit_id"], &differ[0]["waypoint"]),
        (&json!(1), &json!("hall"))
    );
    assert_eq!(
        (
            &differ[0]["stored"]["verdict"],
            &differ[0]["judged"]["verdict"]
        ),
        (&json!("changed"), &json!("quiet"))
    );
    assert_eq!(
        differ[0]["why"].as_array().map(Vec::len),
        Some(1),
        "{}",
        differ[0]
    );
    assert!(
        differ[0]["why"][0]
            .as_str()
            .is_some_and(|why| why.starts_with("U_th 5.000000 instead of 0.000")),
        "{}",
        differ[0]
    );
    let (differ, _) = lines(&["--since", "2020-01-01", "--stored-u-th"], 0);
    assert_eq!(differ.len(), 0);
    let text = patrold(dir.path(), &["rejudge", "1", "2", "--config", "c.toml"]);
    assert!(
        text.out.starts_with("visit 1 at hall, ") && text.out.contains("quiet ("),
        "{text:?}"
    );
    assert!(
        text.out.ends_with(
            "2 visits judged again, 0 from the bytes of the devices: 1 differ; 0 without a stored sweep or reference, 0 failed\n"
        ),
        "{text:?}"
    );
    assert_eq!(fs::read(&database).expect("a database"), before);

    for wrong in [
        &[][..],
        &["1", "--since", "today"],
        &["1", "2", "--mixtures-out", "m"],
    ] {
        let ran = patrold(
            dir.path(),
            &[&["rejudge", "--config", "c.toml"], wrong].concat(),
        );
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{wrong:?}");
    }
}
