//! A sensor that streams one plan, and how its scans look on the line.

use super::{ScriptedLaser, scan_message};
use scip::{LaserEvent, ScipDriver, ScipOptions, StreamPlan, ValueCoding};

pub(crate) const PLAN: StreamPlan = StreamPlan {
    first_step: 44,
    last_step: 725,
    cluster: 1,
    interval: 0,
    coding: ValueCoding::ThreeCharacter,
    count: 0,
};

pub(crate) const REQUEST: &str = "MD0044072501000\n";

pub(crate) const ECHO: &str = "MD0044072501000";

pub(crate) const ACK: &str = "MD0044072501000\n00P\n\n";

pub(crate) fn connected() -> ScriptedLaser {
    ScriptedLaser::connected(ScipDriver::new(ScipOptions::default()))
}

pub(crate) fn streaming() -> ScriptedLaser {
    let mut script = connected();
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange(REQUEST, ACK);
    assert_eq!(script.take_events(), [LaserEvent::Streaming]);
    script
}

pub(crate) fn scan(stamp_ms: u32) -> Vec<u8> {
    scan_message(ECHO, "99", stamp_ms, &[1234; 682])
}

/// The stamps of the scans among the events, and the other events.
pub(crate) fn sort(events: Vec<LaserEvent>) -> (Vec<u32>, Vec<LaserEvent>) {
    let (scans, others): (Vec<_>, Vec<_>) = events
        .into_iter()
        .partition(|event| matches!(event, LaserEvent::Scan { .. }));
    let stamps = scans.into_iter().filter_map(|event| match event {
        LaserEvent::Scan { scan, .. } => Some(scan.stamp_ms),
        _ => None,
    });
    (stamps.collect(), others)
}
