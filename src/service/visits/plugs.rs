//! Seconds from a pulled plug to its notice, and from its return to work going on, in virtual time.

use super::patrol::{Patrol, taught};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

const TIMES: u32 = 20;

/// Median and worst.
fn figures(mut seconds: Vec<f64>) -> (f64, f64) {
    seconds.sort_by(f64::total_cmp);
    (seconds[seconds.len() / 2], seconds[seconds.len() - 1])
}

/// Pulls `device` so often; median and worst of noticing, and of being ready again after its return.
fn pulled(device: &str, power: &str) -> [(f64, f64); 2] {
    let mut patrol = Patrol::that_knows(&taught(), 40);
    let (mut notices, mut returns) = (Vec::new(), Vec::new());
    for turn in 0..TIMES {
        // Every phase of every period, absences short and long.
        patrol.idle(Duration::from_millis(1700 + 130 * u64::from(turn)));
        let away = Duration::from_millis(2500 + 1370 * u64::from(turn));
        let pulled_at = patrol.devices.now();
        patrol.inject(&format!(
            "{device}.unplug:for={},power={power}",
            away.as_secs_f64()
        ));
        patrol.until_ready(false).expect("noticed");
        notices.push((patrol.devices.now() - pulled_at).as_secs_f64());
        let back_at = pulled_at + away;
        patrol.until_ready(true).expect("ready again");
        returns.push(patrol.devices.now().saturating_sub(back_at).as_secs_f64());
    }
    let seen = patrol.visit();
    assert_eq!(seen.verdict, Verdict::Quiet, "{seen:?}");
    let told = [figures(notices), figures(returns)];
    eprintln!(
        "{device}, power {power}: noticed in {:.2} s (worst {:.2}), ready {:.2} s after its return (worst {:.2})",
        told[0].0, told[0].1, told[1].0, told[1].1
    );
    told
}

#[test]
fn a_laser_pulled_is_noticed_in_two_seconds_and_ready_five_after_its_return() {
    for power in ["kept", "lost"] {
        let [notice, back] = pulled("laser", power);
        assert!(notice.1 <= 2.0 && back.1 <= 5.0, "{notice:?} {back:?}");
    }
}

/// One that lost its power has to be calibrated before it is of use.
#[test]
fn a_head_pulled_is_noticed_in_two_seconds_and_ready_five_after_its_return_or_homed_from_then() {
    for (power, homing_s) in [("kept", 0.0), ("lost", 30.0)] {
        let [notice, back] = pulled("ptu", power);
        assert!(
            notice.1 <= 2.0 && back.1 <= 5.0 + homing_s,
            "{notice:?} {back:?}"
        );
    }
}
