//! The driver against the emulator with every fault: reported or overcome, in bounded time; never a wrong scan.

mod common;

use common::driver_and_emulator::DriverAndEmulator;
use scip::emulator::{LaserFault, LaserGeneration, LaserProfile};
use scip::{LaserEvent, ScipError, ValueCoding};
use std::time::Duration;

/// `DB03`, `DB04` and `DB05` as a stream without end sees them (scip2 section 6).
#[test]
fn simulated_failures_are_reported() {
    for (request, recovers) in [
        (&b"DB03\n"[..], true),
        (b"DB04\n", false),
        (b"DB05\n", false),
    ] {
        let mut pair = DriverAndEmulator::with_profile(LaserProfile::urg_04lx_ug01());
        pair.connect();
        // As if another program had sent it.
        pair.laser.handle_bytes(request, pair.now);
        pair.run_until(Duration::from_secs(1), |_| false);
        pair.stream(ValueCoding::ThreeCharacter);
        if request != b"DB05\n" {
            let event = pair.run_until(Duration::from_secs(2), |e| {
                matches!(e, LaserEvent::Verifying { .. })
            });
            assert_eq!(event, Some(LaserEvent::Verifying { status: 21 }));
        }
        let event = pair.run_until(Duration::from_secs(3), |event| {
            matches!(
                event,
                LaserEvent::VerifiedNormal | LaserEvent::ConnectionFailed(_)
            )
        });
        if recovers {
            assert_eq!(event, Some(LaserEvent::VerifiedNormal));
            // The first scan after the pause comes with the number of lost ones.
            pair.run_until(Duration::from_secs(1), |event| {
                matches!(event, LaserEvent::Scan { .. })
            });
            assert!(pair.scans(Duration::from_secs(1)) >= 8);
        } else {
            let hardware = LaserEvent::ConnectionFailed(ScipError::Hardware { status: 50 });
            assert_eq!(event, Some(hardware));
        }
    }
}

/// Every fault, once while connecting and once while streaming: no wrong scan, no endless wait, and once it is over and
/// the power was cycled the sensor works as before.
#[test]
fn no_fault_is_a_dead_end() {
    for name in LaserProfile::NAMES {
        for kind in LaserFault::kinds() {
            for at_s in [0.0, 0.35] {
                let profile = LaserProfile::by_name(name).expect("of the list");
                let urg = profile.generation == LaserGeneration::Urg;
                let mut pair = DriverAndEmulator::with_profile(profile);
                pair.inject(&format!("{kind}:at={at_s},for=1"));
                let first = pair.try_connect();
                if matches!(first, LaserEvent::Connected(_)) {
                    pair.stream(ValueCoding::ThreeCharacter);
                    pair.inject(&format!("{kind}:at=0.5,for=1"));
                    pair.run_until(Duration::from_secs(12), |event| {
                        matches!(event, LaserEvent::ConnectionFailed(_))
                    });
                }
                pair.laser.power_cycle(pair.now);
                pair.now += Duration::from_secs(2);
                pair.connect();
                pair.stream(ValueCoding::ThreeCharacter);
                let scans = pair.scans(Duration::from_secs(2));
                let least = if urg { 17 } else { 70 };
                assert!(scans >= least, "{name} {kind} {at_s}: {scans}");
            }
        }
    }
}
