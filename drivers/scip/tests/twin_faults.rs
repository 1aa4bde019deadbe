//! The driver against a twin with every fault: told, or ridden out, in bounded time; never a wrong scan.

mod common;

use common::pair::Pair;
use scip::command::rehearsal::Rehearse;
use scip::twin::{Fault, Generation, Profile};
use scip::{Coding, Event, SensorError, Setting};
use std::time::Duration;

/// `DB03`, `DB04` and `DB05` as a stream without end sees them (section 6).
#[test]
fn played_malfunctions_are_told_as_such() {
    for (play, recovers) in [
        (Rehearse::Recovery, true),
        (Rehearse::Failure, false),
        (Rehearse::SuddenFailure, false),
    ] {
        let mut pair = Pair::of(Profile::urg_04lx_ug01());
        pair.connected();
        pair.sensor
            .apply(Setting::Rehearsal(play), pair.now)
            .expect("idle");
        pair.until(Duration::from_secs(1), |event| {
            matches!(event, Event::Applied(_))
        })
        .expect("applied");
        pair.stream(Coding::ThreeCharacter);
        if play != Rehearse::SuddenFailure {
            let told = pair.until(Duration::from_secs(2), |e| {
                matches!(e, Event::Verifying { .. })
            });
            assert_eq!(told, Some(Event::Verifying { status: 21 }));
        }
        let told = pair.until(Duration::from_secs(3), |event| {
            matches!(event, Event::VerifiedNormal | Event::Fault(_))
        });
        if recovers {
            assert_eq!(told, Some(Event::VerifiedNormal));
            // What the pause cost is told with the first scan after it.
            pair.until(Duration::from_secs(1), |event| {
                matches!(event, Event::Scan { .. })
            });
            assert!(pair.scans(Duration::from_secs(1)) >= 8);
        } else {
            let hardware = Event::Fault(SensorError::Hardware { status: 50 });
            assert_eq!(told, Some(hardware));
        }
    }
}

/// Every fault, once while connecting and once while streaming: no wrong scan, no endless wait, and once it is over and
/// the power was cycled the sensor works as before.
#[test]
fn no_fault_is_a_dead_end() {
    for name in Profile::NAMES {
        for kind in Fault::kinds() {
            for at_s in [0.0, 0.35] {
                let profile = Profile::by_name(name).expect("of the list");
                let urg = profile.generation == Generation::Urg;
                let mut pair = Pair::of(profile);
                pair.inject(&format!("{kind}:at={at_s},for=1"));
                let first = pair.connect();
                if matches!(first, Event::Connected(_)) {
                    pair.stream(Coding::ThreeCharacter);
                    pair.inject(&format!("{kind}:at=0.5,for=1"));
                    pair.until(Duration::from_secs(12), |event| {
                        matches!(event, Event::Fault(_))
                    });
                }
                pair.twin.power_cycle(pair.now);
                pair.now += Duration::from_secs(2);
                pair.connected();
                pair.stream(Coding::ThreeCharacter);
                let scans = pair.scans(Duration::from_secs(2));
                let least = if urg { 17 } else { 70 };
                assert!(scans >= least, "{name} {kind} {at_s}: {scans}");
            }
        }
    }
}
