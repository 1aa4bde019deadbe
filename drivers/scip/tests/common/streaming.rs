//! A sensor that streams one plan, and how its scans look on the line.

use super::{Story, scan_message};
use scip::{Coding, Event, Sensor, SensorOptions, StreamPlan};

pub const PLAN: StreamPlan = StreamPlan {
    first_step: 44,
    last_step: 725,
    cluster: 1,
    interval: 0,
    coding: Coding::ThreeCharacter,
    count: 0,
};

pub const REQUEST: &str = "MD0044072501000\n";

pub const ECHO: &str = "MD0044072501000";

pub const ACK: &str = "MD0044072501000\n00P\n\n";

pub fn connected() -> Story {
    Story::connected(Sensor::new(SensorOptions::default()))
}

pub fn streaming() -> Story {
    let mut story = connected();
    story.sensor.start_streaming(PLAN, story.now).expect("idle");
    story.turn(REQUEST, ACK);
    assert_eq!(story.take_events(), [Event::Streaming]);
    story
}

pub fn scan(stamp_ms: u32) -> Vec<u8> {
    scan_message(ECHO, "99", stamp_ms, &[1234; 682])
}

/// The stamps of the scans among the events, and the other events.
pub fn sort(events: Vec<Event>) -> (Vec<u32>, Vec<Event>) {
    let (scans, others): (Vec<_>, Vec<_>) = events
        .into_iter()
        .partition(|event| matches!(event, Event::Scan { .. }));
    let stamps = scans.into_iter().filter_map(|event| match event {
        Event::Scan { scan, .. } => Some(scan.stamp_ms),
        _ => None,
    });
    (stamps.collect(), others)
}
