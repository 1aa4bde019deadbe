//! The driver against the emulator of every model, in every state a host can leave it in: it connects, or reports why not,
//! in bounded time; it never accepts a wrong scan.

mod common;

use common::driver_and_emulator::{DriverAndEmulator, MS};
use scip::emulator::{KeyedSumRule, LaserOptions, LaserProfile, LaserStartState};
use scip::{LaserEvent, ScipError, StreamPlan, ValueCoding};
use std::time::Duration;

#[test]
fn every_model_in_every_state_connects_and_streams() {
    for name in LaserProfile::NAMES {
        for start_state in [
            LaserStartState::PowerUp,
            LaserStartState::Idle,
            LaserStartState::LaserOn,
            LaserStartState::Streaming,
            LaserStartState::TimeAdjust,
            LaserStartState::FirmwareUpdate,
        ] {
            let mut options = LaserOptions {
                start_state,
                ..LaserOptions::default()
            };
            options.set_profile(LaserProfile::by_name(name).expect("of the list"));
            let mut pair = DriverAndEmulator::new(options);
            pair.connect();
            pair.driver.exchange_time(5, pair.now).expect("idle");
            let exchanged = pair.run_until(Duration::from_secs(3), |event| {
                matches!(event, LaserEvent::TimeExchanged { .. })
            });
            assert_eq!(
                exchanged,
                Some(LaserEvent::TimeExchanged { samples: 5 }),
                "{name}"
            );
            pair.stream(ValueCoding::ThreeCharacter);
            let started = pair.run_until(Duration::from_secs(1), |e| {
                matches!(e, LaserEvent::Scan { .. })
            });
            assert!(started.is_some(), "{name} {start_state:?}");
            let period = Duration::from_secs(60) / pair.profile.speed_rpm;
            let scans = pair.scans(100 * period) as i32;
            assert!((scans - 100).abs() <= 1, "{name} {start_state:?}: {scans}");
            pair.driver.stop(pair.now);
            let stopped =
                pair.run_until(Duration::from_secs(1), |e| matches!(e, LaserEvent::Stopped));
            assert!(
                stopped.is_some() && !pair.laser.laser_on(),
                "{name} {start_state:?}"
            );
        }
    }
}

#[test]
fn sums_by_every_rule_and_versions_of_old_units_are_accepted() {
    for keyed_sum in [
        KeyedSumRule::BeforeSemicolon,
        KeyedSumRule::WithSemicolon,
        KeyedSumRule::BeforeComment,
    ] {
        for name in LaserProfile::NAMES {
            DriverAndEmulator::with_profile(LaserProfile {
                keyed_sum,
                ..LaserProfile::by_name(name).expect("of the list")
            })
            .connect();
        }
    }
    for fault in ["odd-version", "odd-version:count=1", "torn-version:count=2"] {
        let mut pair = DriverAndEmulator::with_profile(LaserProfile::urg_04lx());
        pair.inject(fault);
        pair.connect();
    }
}

#[test]
fn intensity_is_requested_only_of_models_that_have_it() {
    for (profile, has_intensity) in [
        (LaserProfile::urg_04lx(), false),
        (LaserProfile::urg_04lx_ug01(), false),
        (LaserProfile::utm_30lx(), true),
        (LaserProfile::ust_20lx(), true),
    ] {
        let mut pair = DriverAndEmulator::with_profile(profile);
        // If it were requested all the same, this one would stop responding.
        pair.inject("deafened");
        pair.connect();
        let plan = pair.plan(ValueCoding::WithIntensity);
        let taken = pair.driver.start_streaming(plan, pair.now);
        if !has_intensity {
            assert!(matches!(
                taken,
                Err(ScipError::Unsupported {
                    what: "intensity",
                    ..
                })
            ));
            pair.stream(ValueCoding::TwoCharacter);
            assert!(pair.scans(Duration::from_secs(1)) >= 7);
            continue;
        }
        taken.expect("known to have it");
        let scan = pair.run_until(Duration::from_secs(1), |event| {
            matches!(event, LaserEvent::Scan { .. })
        });
        let Some(LaserEvent::Scan { scan, .. }) = scan else {
            panic!("no scan");
        };
        assert_eq!((scan.ranges.len(), scan.intensities.len()), (1081, 1081));
        assert_eq!(scan.intensities[0], 4000);
        assert!((39..=41).contains(&pair.scans(Duration::from_secs(1))));
    }
}

#[test]
fn counted_streams_end_by_themselves_with_clusters_and_skipped_turns() {
    for (cluster, interval, count) in [(1, 0, 1), (3, 2, 5), (99, 9, 2), (2, 0, 99)] {
        let mut pair = DriverAndEmulator::with_profile(LaserProfile::urg_04lx());
        pair.connect();
        let plan = StreamPlan {
            cluster,
            interval,
            count,
            ..pair.plan(ValueCoding::ThreeCharacter)
        };
        pair.driver.start_streaming(plan, pair.now).expect("idle");
        let mut left = Vec::new();
        while let Some(LaserEvent::Scan { scan, .. }) = pair
            .run_until(Duration::from_secs(5), |event| {
                matches!(event, LaserEvent::Scan { .. } | LaserEvent::Stopped)
            })
        {
            left.push(scan.remaining);
        }
        let expected: Vec<u8> = (0..count).rev().collect();
        assert_eq!(left, expected, "cluster {cluster}, interval {interval}");
        assert!(!pair.laser.laser_on());
        pair.driver.exchange_time(1, pair.now).expect("idle");
    }
}

/// 16 777.216 s (scip2 section 8): the stream goes on across the wrap, without a gap and without a jump.
#[test]
fn the_timer_wraps_under_a_stream() {
    let mut pair = DriverAndEmulator::with_profile(LaserProfile::urg_04lx());
    pair.connect();
    pair.inject("timer-set");
    pair.run_until(10 * MS, |_| false);
    pair.stream(ValueCoding::ThreeCharacter);
    assert!(pair.scans(Duration::from_secs(10)) >= 97);
    assert!(pair.laser.timer_ms(pair.now) < 10_000);
}
