//! Configurations with errors, stores that cannot be opened, and wrong usage.

use crate::bad_input::{check_failures, folder, listing};
use crate::harness::program::patrold;

#[test]
fn configurations_with_errors() {
    let dir = folder();
    let before = listing(dir.path());
    for (file, names) in [
        (
            "unknown.toml",
            &[
                "unknown.toml:2",
                "novelty.u_th;",
                "did you mean novelty.u_th_m?",
            ][..],
        ),
        ("nan.toml", &["nan.toml:1", "novelty.u_th_m wants a number"]),
        (
            "zero.toml",
            &["zero.toml:1", "novelty.u_th_m wants a number"],
        ),
        ("broken.toml", &["broken.toml:1", "is not TOML"]),
        ("binary.toml", &["binary.toml"]),
        ("missing.toml", &["missing.toml", "cannot be read"]),
        ("folder", &["folder", "cannot be read"]),
    ] {
        for command in [
            &["config", "check"][..],
            &["config", "show"],
            &["compare", "good.ply", "good.ply"],
            &["waypoints", "forget", "hall"],
            &["rejudge", "1"],
        ] {
            let ran = patrold(dir.path(), &[command, &["--config", file]].concat());
            let case = format!("{command:?} with {file}: {ran:?}");
            assert_eq!(
                (ran.code, ran.out.as_str(), ran.err.lines().count()),
                (2, "", 1),
                "{case}"
            );
            assert!(ran.err.starts_with("patrold: "), "{case}");
            assert!(names.iter().all(|name| ran.err.contains(name)), "{case}");
        }
    }
    assert_eq!(listing(dir.path()), before);
}

/// Reading the log needs only the store's place.
#[test]
fn a_bad_configuration_stops_no_reader() {
    let dir = crate::log::store_folder();
    let mistakes = [
        (
            "novelty.u_th = 1\n",
            "c.toml:2: unknown key novelty.u_th; did you mean novelty.u_th_m?",
        ),
        ("[novelty\n", "c.toml:2: is not TOML"),
        (
            "laser.port = \"/dev/patrold-ptu\"\n",
            "c.toml:2: laser.port and ptu.port",
        ),
    ];
    for (wrong, names) in mistakes {
        let text = format!("store.dir = \"store\"\n{wrong}");
        std::fs::write(dir.path().join("c.toml"), text).expect("written");
        for command in [
            &["alarms"][..],
            &["alarms", "show", "2"],
            &["alarms", "export"],
            &["alarms", "ack", "2"],
            &["visits"],
            &["visits", "show", "1"],
            &["events"],
            &["waypoints"],
            &["waypoints", "show", "hall"],
        ] {
            let ran = crate::log::run(dir.path(), command);
            assert_eq!(ran.code, 0, "{command:?} {ran:?}");
            let warned =
                ran.err.starts_with("patrold: warning: c.toml:") && ran.err.contains(names);
            assert!(
                warned && ran.err.lines().count() == 1,
                "{command:?} {ran:?}"
            );
            assert!(!ran.out.is_empty(), "{command:?}");
        }
        let status = crate::log::run(dir.path(), &["status"]);
        assert_eq!((status.code, status.err.as_str()), (0, ""));
        assert!(
            status.out.contains("has mistakes") && status.out.contains(names),
            "{status:?}"
        );
    }
    // Where the file itself cannot be read nothing is known.
    let none = patrold(dir.path(), &["alarms", "--config", "none.toml"]);
    assert_eq!((none.code, none.out.as_str()), (2, ""), "{none:?}");
}

#[test]
fn stores_that_are_missing_or_foreign() {
    check_failures(&[
        (
            &["alarms", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database", "store.dir"],
        ),
        (
            &["alarms", "ack", "1", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database"],
        ),
        (
            &["waypoints", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db", "no database"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "nowhere.toml"],
            1,
            &["nowhere/patrold.db"],
        ),
        (
            &["alarms", "--config", "file.toml"],
            1,
            &["good.ply", "store.dir"],
        ),
        (
            &["alarms", "--config", "foreign.toml"],
            1,
            &["foreign/patrold.db", "not a patrold database", "store.dir"],
        ),
        (
            &["alarms", "ack", "1", "--config", "foreign.toml"],
            1,
            &["foreign/patrold.db", "store.dir"],
        ),
        (
            &["alarms", "--config", "newer.toml"],
            1,
            &["newer/patrold.db", "newer patrold", "install"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "newer.toml"],
            1,
            &["newer/patrold.db", "newer patrold"],
        ),
        (
            &["alarms", "--config", "garbage.toml"],
            1,
            &["garbage/patrold.db", "not a patrold database"],
        ),
        (
            &["alarms", "ack", "1", "--config", "garbage.toml"],
            1,
            &["garbage/patrold.db", "not a patrold database"],
        ),
        (
            &["alarms", "show", "42", "--config", "ours.toml"],
            1,
            &["alarm 42", "patrold alarms list"],
        ),
        (
            &["alarms", "ack", "42", "--config", "ours.toml"],
            1,
            &["alarm 42", "patrold alarms list"],
        ),
        (
            &["waypoints", "show", "hall", "--config", "ours.toml"],
            1,
            &["\"hall\"", "patrold teach hall"],
        ),
        (
            &["waypoints", "forget", "hall", "--config", "ours.toml"],
            1,
            &["\"hall\"", "known: none yet"],
        ),
    ]);
}

#[test]
fn wrong_usage_exits_2_and_prints_the_usage() {
    let dir = folder();
    let before = listing(dir.path());
    for args in [
        &[][..],
        &["guard"],
        &["compare"],
        &["diagnose"],
        &["setup", "--time-scale", "0"],
        &["visit", ".."],
        &["teach", "a/b"],
        &["tune", "--waypoint", "../x"],
        &["compare", "good.ply"],
        &["compare", "good.ply", "good.ply", "--frobnicate"],
        &["compare", "good.ply", "good.ply", "--u-th", "0"],
        &["compare", "good.ply", "good.ply", "--u-th", "-1"],
        &["compare", "good.ply", "good.ply", "--u-th", "nan"],
        &["compare", "good.ply", "good.ply", "--seed", "-1"],
        &["compare", "good.ply", "good.ply", "--engine", "best"],
        &["compare", "good.ply", "good.ply", "--sensor-origin", "1,2"],
        &[
            "compare",
            "good.ply",
            "good.ply",
            "--sensor-origin",
            "1,2,nan",
        ],
        &["compare", "good.ply", "good.ply", "--manifest", "list.json"],
        &["fit", "good.ply", "--components", "0"],
        &["fit", "good.ply", "--components", "some"],
        &["fit", "good.ply", "--max-components", "0"],
        &["fit", "good.ply", "--threads", "0"],
        &[
            "fit",
            "good.ply",
            "--components",
            "3",
            "--init",
            "flat.json",
        ],
        &["distance", "flat.json", "flat.json", "--ground", "l1"],
        &["distance", "flat.json", "flat.json", "--repeat", "0"],
        &["fuse", "flat.json"],
        &["fuse", "flat.json", "flat.json", "--max-components", "0"],
        &["shapes", "good.ply", "--method", "guess"],
        &["visits", "--verdict", "loud"],
        &["visits", "--since", "soon"],
        &["visits", "--limit", "1", "show", "1"],
        &["visits", "show", "first"],
        &["events", "--level", "fatal"],
        &["events", "--limit", "-1"],
        &["alarms", "--kind", "moved"],
        &["alarms", "--min-size", "-1"],
        &["alarms", "--map-near", "1"],
        &["status", "hall"],
        &["reload", "hall"],
        &["tune", "--apply", "0.001"],
        &["tune", "--waypoint", "hall", "--apply", "0"],
        &["rejudge", "first"],
        &["reproduce", "table1", "--ellipsoid-sigmas", "0"],
        &["reproduce", "table1", "--ellipsoid-sigmas", "nan"],
        &["alarms", "show", "first"],
        &["alarms", "list", "--state", "lost"],
        &["alarms", "list", "--since", "yesterday-ish"],
        &["alarms", "list", "--limit", "-3"],
        &["config"],
    ] {
        let ran = patrold(dir.path(), args);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{args:?}: {ran:?}");
        assert!(
            ran.err.contains("Usage") || ran.err.contains("--help"),
            "{args:?}: {}",
            ran.err
        );
        assert!(
            !ran.err.contains("stack backtrace"),
            "{args:?}: {}",
            ran.err
        );
    }
    assert_eq!(listing(dir.path()), before);
}
