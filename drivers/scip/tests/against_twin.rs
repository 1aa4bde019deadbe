//! The driver against the twin of every model, in every state a host can leave it in: it connects, or says why not, in bounded
//! time; it never takes a wrong scan.

mod common;

use common::pair::{MS, Pair};
use scip::command::motor_speed::SetMotorSpeed;
use scip::command::rehearsal::Rehearse;
use scip::command::span::Span;
use scip::twin::{KeyedSum, Profile, StartState, TwinOptions};
use scip::{Coding, Event, SensorError, Setting, StreamPlan};
use std::time::Duration;

#[test]
fn every_model_in_every_state_connects_and_streams() {
    for name in Profile::NAMES {
        for start_state in [
            StartState::PowerUp,
            StartState::Idle,
            StartState::LaserOn,
            StartState::Streaming,
            StartState::TimeAdjust,
            StartState::FirmwareUpdate,
        ] {
            let mut options = TwinOptions {
                start_state,
                ..TwinOptions::default()
            };
            options.set_profile(Profile::by_name(name).expect("of the list"));
            let mut pair = Pair::new(options);
            pair.connected();
            pair.sensor.exchange_time(5, pair.now).expect("idle");
            let exchanged = pair.until(Duration::from_secs(3), |event| {
                matches!(event, Event::TimeExchanged { .. })
            });
            assert_eq!(
                exchanged,
                Some(Event::TimeExchanged { samples: 5 }),
                "{name}"
            );
            pair.stream(Coding::ThreeCharacter);
            let started = pair.until(Duration::from_secs(1), |e| matches!(e, Event::Scan { .. }));
            assert!(started.is_some(), "{name} {start_state:?}");
            let period = Duration::from_secs(60) / pair.profile.speed_rpm;
            let scans = pair.scans(100 * period) as i32;
            assert!((scans - 100).abs() <= 1, "{name} {start_state:?}: {scans}");
            pair.sensor.stop(pair.now);
            let stopped = pair.until(Duration::from_secs(1), |e| matches!(e, Event::Stopped));
            assert!(
                stopped.is_some() && !pair.twin.laser_on(),
                "{name} {start_state:?}"
            );
        }
    }
}

#[test]
fn sums_of_every_habit_and_versions_of_old_units_are_taken() {
    for keyed_sum in [
        KeyedSum::BeforeSemicolon,
        KeyedSum::WithSemicolon,
        KeyedSum::BeforeComment,
    ] {
        for name in Profile::NAMES {
            Pair::of(Profile {
                keyed_sum,
                ..Profile::by_name(name).expect("of the list")
            })
            .connected();
        }
    }
    for fault in ["odd-version", "odd-version:count=1", "torn-version:count=2"] {
        let mut pair = Pair::of(Profile::urg_04lx());
        pair.inject(fault);
        pair.connected();
    }
}

#[test]
fn intensity_is_asked_of_models_that_have_it_only() {
    for (profile, knows) in [
        (Profile::urg_04lx(), false),
        (Profile::urg_04lx_ug01(), false),
        (Profile::utm_30lx(), true),
        (Profile::ust_20lx(), true),
    ] {
        let mut pair = Pair::of(profile);
        // Were it asked for all the same, this one would fall deaf.
        pair.inject("deafened");
        pair.connected();
        let plan = pair.plan(Coding::WithIntensity);
        let taken = pair.sensor.start_streaming(plan, pair.now);
        if !knows {
            assert!(matches!(
                taken,
                Err(SensorError::Unsupported {
                    what: "intensity",
                    ..
                })
            ));
            let span = Span {
                first_step: 44,
                last_step: 725,
                cluster: 1,
                coding: Coding::WithIntensity,
            };
            let taken = pair.sensor.single(span, pair.now);
            assert!(matches!(taken, Err(SensorError::Unsupported { .. })));
            pair.stream(Coding::TwoCharacter);
            assert!(pair.scans(Duration::from_secs(1)) >= 7);
            continue;
        }
        taken.expect("known to have it");
        let scan = pair.until(Duration::from_secs(1), |event| {
            matches!(event, Event::Scan { .. })
        });
        let Some(Event::Scan { scan, .. }) = scan else {
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
        let mut pair = Pair::of(Profile::urg_04lx());
        pair.connected();
        let plan = StreamPlan {
            cluster,
            interval,
            count,
            ..pair.plan(Coding::ThreeCharacter)
        };
        pair.sensor.start_streaming(plan, pair.now).expect("idle");
        let mut left = Vec::new();
        while let Some(Event::Scan { scan, .. }) = pair.until(Duration::from_secs(5), |event| {
            matches!(event, Event::Scan { .. } | Event::Stopped)
        }) {
            left.push(scan.remaining);
        }
        let expected: Vec<u8> = (0..count).rev().collect();
        assert_eq!(left, expected, "cluster {cluster}, interval {interval}");
        assert!(!pair.twin.laser_on());
        pair.sensor.query_info(pair.now).expect("idle");
    }
}

#[test]
fn settings_are_made_or_refused() {
    let mut pair = Pair::of(Profile::urg_04lx_ug01());
    pair.connected();
    let mut apply = |setting| {
        pair.sensor.apply(setting, pair.now).expect("idle");
        let over = |event: &Event| matches!(event, Event::Applied(_) | Event::Failed(_));
        pair.until(Duration::from_secs(4), over).expect("an answer")
    };
    let slower = Setting::MotorSpeed(SetMotorSpeed::Slower(5));
    assert_eq!(apply(slower), Event::Applied(slower));
    assert_eq!(apply(slower), Event::Applied(slower), "already so");
    let played = Setting::Rehearsal(Rehearse::OldMalfunction);
    assert!(matches!(apply(played), Event::Failed(_)), "not supported");
    assert!(
        matches!(apply(Setting::SoftReset), Event::Failed(_)),
        "a URG has no RT"
    );
    let end = Setting::Rehearsal(Rehearse::End);
    assert_eq!(apply(end), Event::Applied(end));
}

/// 16 777.216 s (section 8): the stream goes on across the wrap, without a gap and without a jump.
#[test]
fn the_timer_wraps_under_a_stream() {
    let mut pair = Pair::of(Profile::urg_04lx());
    pair.connected();
    pair.inject("timer-set");
    pair.until(10 * MS, |_| false);
    pair.stream(Coding::ThreeCharacter);
    assert!(pair.scans(Duration::from_secs(10)) >= 97);
    assert!(pair.twin.timer_ms(pair.now) < 10_000);
}
