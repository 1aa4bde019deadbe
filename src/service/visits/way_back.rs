//! While a sweep is judged the head goes back to where it began, so that the next one does not wait for it.

use super::patrol::{Patrol, taught};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

#[test]
fn the_next_sweep_finds_the_head_where_it_begins() {
    let mut patrol = Patrol::that_knows(&taught(), 50);
    let stands = |patrol: &Patrol| patrol.devices.with(|e| e.attitude_rad());
    let mut swept = Vec::new();
    let mut places = Vec::new();
    for _ in 0..3 {
        let seen = patrol.visit();
        assert_eq!(
            (seen.verdict, patrol.sweeps),
            (Verdict::Quiet, swept.len() + 1)
        );
        swept.push(patrol.swept);
        places.push(stands(&patrol));
        let back = patrol.returned.expect("it went back");
        // 60 deg and the margins at both ends, at 51 deg/s, ramps and a look every few hundredths of a second.
        assert!(
            (1.2..1.8).contains(&back.as_secs_f64()),
            "{back:?} for the way back"
        );
    }
    eprintln!("sweeps {swept:?}, the way back {:?}", patrol.returned);
    assert_eq!(places[0], places[1]);
    assert_eq!(places[1], places[2]);
    // From 0, 0 the first had to go half of the way.
    let [first, second, third] = swept[..] else {
        panic!("three");
    };
    assert!(second + Duration::from_millis(300) < first, "{swept:?}");
    assert!(third + Duration::from_millis(300) < first, "{swept:?}");
}

#[test]
fn a_plug_pulled_on_the_way_back_is_noticed_in_two_seconds_and_spoils_no_verdict() {
    for device in ["laser", "ptu"] {
        let mut patrol = Patrol::that_knows(&taught(), 52);
        let pulled_at = patrol.devices.now() + Duration::from_millis(13_900);
        patrol.inject(&format!("{device}.unplug:at=13.9,for=10,power=kept"));
        let seen = patrol.visit();
        assert_eq!(
            seen.verdict,
            Verdict::Quiet,
            "{device}: {seen:?} {:?}",
            patrol.log
        );
        assert_eq!(patrol.returned, None, "{device}");
        patrol.until_ready(false).expect("noticed");
        let noticed = patrol.devices.now() - pulled_at;
        assert!(noticed <= Duration::from_secs(2), "{device}: {noticed:?}");
        patrol.until_ready(true).expect("ready again");
        let seen = patrol.visit();
        assert_eq!(
            seen.verdict,
            Verdict::Quiet,
            "{device}: {seen:?} {:?}",
            patrol.log
        );
    }
}

#[test]
fn a_head_that_is_stuck_on_its_way_back_is_homed_before_the_next_sweep() {
    let mut patrol = Patrol::that_knows(&taught(), 51);
    // The sweep ends 13.3 s after its visit begins.
    patrol.inject("ptu.stuck:at=13.8,for=60,axis=tilt");
    let seen = patrol.visit();
    assert_eq!(seen.verdict, Verdict::Quiet, "{seen:?} {:?}", patrol.log);
    assert_eq!(patrol.returned, None);
    patrol.idle(Duration::from_secs(60));
    let seen = patrol.visit();
    assert_eq!(seen.verdict, Verdict::Quiet, "{seen:?} {:?}", patrol.log);
    assert!(patrol.returned.is_some());
    assert!(
        patrol.swept > Duration::from_secs(20),
        "homed before: {:?}",
        patrol.swept
    );
}
