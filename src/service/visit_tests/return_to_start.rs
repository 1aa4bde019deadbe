//! While a sweep is judged, the head returns to the start of it; the next sweep does not wait for it.

use super::virtual_patrol::{VirtualPatrol, taught_storeroom};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

#[test]
fn the_head_waits_at_the_start_of_the_next_sweep() {
    let mut patrol = VirtualPatrol::with_reference(&taught_storeroom(), 50);
    let attitude = |patrol: &VirtualPatrol| patrol.devices.with_emulation(|e| e.attitude_rad());
    let mut durations = Vec::new();
    let mut attitudes = Vec::new();
    for _ in 0..3 {
        let result = patrol.visit();
        assert_eq!(
            (result.verdict, patrol.sweep_count),
            (Verdict::Quiet, durations.len() + 1)
        );
        durations.push(patrol.sweep_duration);
        attitudes.push(attitude(&patrol));
        let duration = patrol.return_duration.expect("it returned");
        // 60 deg and the margins at both ends, at 51 deg/s with ramps; polled every few hundredths of a second.
        assert!(
            (1.2..1.8).contains(&duration.as_secs_f64()),
            "{duration:?} for the return"
        );
    }
    eprintln!("sweeps {durations:?}, return {:?}", patrol.return_duration);
    assert_eq!(attitudes[0], attitudes[1]);
    assert_eq!(attitudes[1], attitudes[2]);
    // The first sweep had to move the head from 0, 0 to its start.
    let [first, second, third] = durations[..] else {
        panic!("three");
    };
    assert!(second + Duration::from_millis(300) < first, "{durations:?}");
    assert!(third + Duration::from_millis(300) < first, "{durations:?}");
}

#[test]
fn unplugging_during_the_return_is_noticed_in_two_seconds_and_keeps_the_verdict() {
    for device in ["laser", "ptu"] {
        let mut patrol = VirtualPatrol::with_reference(&taught_storeroom(), 52);
        let pulled_at = patrol.devices.now() + Duration::from_millis(13_900);
        patrol.inject(&format!("{device}.unplug:at=13.9,for=10,power=kept"));
        let result = patrol.visit();
        assert_eq!(
            result.verdict,
            Verdict::Quiet,
            "{device}: {result:?} {:?}",
            patrol.event_log
        );
        assert_eq!(patrol.return_duration, None, "{device}");
        patrol.until_ready(false).expect("noticed");
        let noticed = patrol.devices.now() - pulled_at;
        assert!(noticed <= Duration::from_secs(2), "{device}: {noticed:?}");
        patrol.until_ready(true).expect("ready again");
        let result = patrol.visit();
        assert_eq!(
            result.verdict,
            Verdict::Quiet,
            "{device}: {result:?} {:?}",
            patrol.event_log
        );
    }
}

#[test]
fn a_head_stuck_during_the_return_is_homed_before_the_next_sweep() {
    let mut patrol = VirtualPatrol::with_reference(&taught_storeroom(), 51);
    // The sweep ends 13.3 s after the request.
    patrol.inject("ptu.stuck:at=13.8,for=60,axis=tilt");
    let result = patrol.visit();
    assert_eq!(
        result.verdict,
        Verdict::Quiet,
        "{result:?} {:?}",
        patrol.event_log
    );
    assert_eq!(patrol.return_duration, None);
    patrol.idle(Duration::from_secs(60));
    let result = patrol.visit();
    assert_eq!(
        result.verdict,
        Verdict::Quiet,
        "{result:?} {:?}",
        patrol.event_log
    );
    assert!(patrol.return_duration.is_some());
    assert!(
        patrol.sweep_duration > Duration::from_secs(20),
        "homed before: {:?}",
        patrol.sweep_duration
    );
}
