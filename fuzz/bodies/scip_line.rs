//! The laser's driver and its twin on a line that spoils bytes: a whole dialogue, damaged anywhere.

use super::feed::Feed;
use super::scip_sums::Heard;
use scip::twin::{Fault, FaultSpec, Profile, Surroundings, Twin, TwinOptions};
use scip::{Action, Coding, Event, Sensor, SensorOptions, StreamPlan};
use std::time::Duration;

struct Room;

impl Surroundings for Room {
    fn revolve(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        for (step, range) in out.iter_mut().enumerate() {
            *range = 900 + step as u32 * 3;
        }
    }
}

/// Steps of virtual time a run may take, so that no input is slow.
const MOST_STEPS: usize = 3_000;

pub fn run(data: &[u8]) {
    scans(data);
}

/// Runs, and tells how many scans came through.
pub fn scans(data: &[u8]) -> usize {
    let mut scans = 0;
    let mut feed = Feed(data);
    let name = feed.one_of(&Profile::NAMES);
    let mut options = TwinOptions::default();
    options.set_profile(Profile::by_name(name).expect("of the list"));
    let mut twin = Twin::new(options, Duration::ZERO);
    let kinds: Vec<&str> = Fault::kinds().collect();
    for _ in 0..feed.byte() % 3 {
        let (kind, at) = (feed.one_of(&kinds), feed.byte());
        let spec = format!("{kind}:at={},for=1", f64::from(at) / 40.0);
        twin.inject(spec.parse::<FaultSpec>().expect("a fault"));
    }
    let mut sensor = Sensor::new(SensorOptions::default());
    let mut heard = Heard::default();
    let mut now = Duration::ZERO;
    // Bytes to let through, then what to do to the next.
    let mut clean = feed.word();
    sensor.connect(now);
    for _ in 0..MOST_STEPS {
        twin.advance(now, &mut Room);
        while let Some(output) = twin.poll_output() {
            let mut bytes = Vec::with_capacity(output.bytes.len());
            for byte in output.bytes {
                if clean > 0 || feed.is_over() {
                    clean = clean.saturating_sub(1);
                    bytes.push(byte);
                    continue;
                }
                match feed.byte() % 4 {
                    0 => {}
                    1 => bytes.push(byte ^ (1 << (feed.byte() % 8))),
                    2 => bytes.extend([byte, byte]),
                    _ => bytes.push(feed.byte()),
                }
                clean = feed.word() % 16_384;
            }
            heard.add(&bytes);
            sensor.handle_bytes(&bytes, now);
        }
        sensor.handle_deadline(now);
        while let Some(action) = sensor.poll_action() {
            match action {
                Action::Send(bytes) => twin.handle_bytes(&bytes, now),
                Action::Event(Event::Scan { scan, .. }) => {
                    heard.must_hold(&scan);
                    scans += 1;
                }
                Action::Event(Event::Connected(identity)) => {
                    let plan = StreamPlan {
                        first_step: identity.parameters.amin as u16,
                        last_step: identity.parameters.amax.min(9999) as u16,
                        cluster: 1,
                        interval: 0,
                        coding: Coding::ThreeCharacter,
                        count: 0,
                    };
                    // Refused where the damage made nonsense of a number.
                    drop(sensor.start_streaming(plan, now));
                }
                Action::Event(Event::Fault(_)) => return scans,
                Action::Event(_) => {}
            }
        }
        if feed.is_over() && clean == 0 {
            return scans;
        }
        let next = [twin.next_event(), sensor.deadline()];
        let next = next.into_iter().flatten().min();
        now = next.unwrap_or(now).max(now + Duration::from_micros(500));
    }
    scans
}

pub fn seeds() -> Vec<Vec<u8>> {
    (0..4)
        .map(|profile| {
            let mut seed = vec![profile, 0, 0, 4];
            for at in 0..12_u8 {
                seed.extend([at, at.wrapping_mul(37), at.wrapping_mul(91), 3]);
            }
            // A byte doubled, then quiet for some scans.
            seed.extend([2, 0xFF, 0x3F]);
            seed
        })
        .collect()
}
