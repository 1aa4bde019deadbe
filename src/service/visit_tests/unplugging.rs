//! How long it takes to notice an unplugged device, and to be ready again after it is plugged in; virtual time.

use super::virtual_patrol::{VirtualPatrol, taught_storeroom};
use patrold_engine::novelty::Verdict;
use std::time::Duration;

const TIMES: u32 = 20;

fn median_and_worst(mut seconds: Vec<f64>) -> (f64, f64) {
    seconds.sort_by(f64::total_cmp);
    (seconds[seconds.len() / 2], seconds[seconds.len() - 1])
}

/// Unplugs `device` [`TIMES`] times; median and worst seconds until noticed, and until ready after it was plugged in.
fn measure_unplugging(device: &str, power: &str) -> [(f64, f64); 2] {
    let mut patrol = VirtualPatrol::with_reference(&taught_storeroom(), 40);
    let (mut noticed, mut ready) = (Vec::new(), Vec::new());
    for i in 0..TIMES {
        // At every phase of the periods; short and long absences.
        patrol.idle(Duration::from_millis(1700 + 130 * u64::from(i)));
        let absence = Duration::from_millis(2500 + 1370 * u64::from(i));
        let unplugged_at = patrol.devices.now();
        patrol.inject(&format!(
            "{device}.unplug:for={},power={power}",
            absence.as_secs_f64()
        ));
        patrol.until_ready(false).expect("noticed");
        noticed.push((patrol.devices.now() - unplugged_at).as_secs_f64());
        let plugged_in_at = unplugged_at + absence;
        patrol.until_ready(true).expect("ready again");
        ready.push(
            patrol
                .devices
                .now()
                .saturating_sub(plugged_in_at)
                .as_secs_f64(),
        );
    }
    let result = patrol.visit();
    assert_eq!(result.verdict, Verdict::Quiet, "{result:?}");
    let [noticed, ready] = [noticed, ready].map(median_and_worst);
    eprintln!(
        "{device}, power {power}: noticed in {:.2} s (worst {:.2}), ready {:.2} s after plugging in (worst {:.2})",
        noticed.0, noticed.1, ready.0, ready.1
    );
    [noticed, ready]
}

#[test]
fn an_unplugged_laser_is_noticed_in_2_s_and_ready_5_s_after_plugging_in() {
    for power in ["kept", "lost"] {
        let [noticed, ready] = measure_unplugging("laser", power);
        assert!(noticed.1 <= 2.0 && ready.1 <= 5.0, "{noticed:?} {ready:?}");
    }
}

/// A head that lost power must be homed first.
#[test]
fn an_unplugged_head_is_noticed_in_2_s_and_ready_5_s_after_plugging_in_and_homing() {
    for (power, homing_s) in [("kept", 0.0), ("lost", 30.0)] {
        let [noticed, ready] = measure_unplugging("ptu", power);
        assert!(
            noticed.1 <= 2.0 && ready.1 <= 5.0 + homing_s,
            "{noticed:?} {ready:?}"
        );
    }
}
