//! The head's driver and its twin on a line that spoils bytes: a whole dialogue, damaged anywhere.

use super::feed::Feed;
use ptu::twin::{FaultKind, FaultSpec, Twin, TwinOptions};
use ptu::{Action, Axis, Event, Head, HeadOptions};
use std::time::Duration;

/// Steps of virtual time a run may take, so that no input is slow.
const MOST_STEPS: usize = 6_000;

pub fn run(data: &[u8]) {
    let mut feed = Feed(data);
    let mut options = TwinOptions {
        seed: u64::from(feed.byte()),
        power_up: feed.byte() & 3 == 3,
        e_series: feed.byte() & 1 == 1,
        ..TwinOptions::default()
    };
    options.start.velocity_mode = feed.byte() & 3 == 3;
    options.start.monitor = feed.byte() & 3 == 3;
    let mut twin = Twin::new(options, Duration::ZERO);
    let kinds: Vec<&str> = FaultKind::kinds().collect();
    for _ in 0..feed.byte() % 3 {
        let (kind, at) = (feed.one_of(&kinds), f64::from(feed.byte()) / 20.0);
        let spec = format!("{kind}:at={at},for=2");
        twin.inject(spec.parse::<FaultSpec>().expect("a fault"));
    }
    let mut head = Head::new(HeadOptions::default());
    let mut now = Duration::ZERO;
    let mut clean = feed.word() % 1024;
    head.connect(now);
    for _ in 0..MOST_STEPS {
        twin.advance(now);
        while let Some(output) = twin.poll_output() {
            for byte in output.bytes {
                if clean > 0 || feed.is_over() {
                    clean = clean.saturating_sub(1);
                    head.handle_bytes(&[byte], now);
                    continue;
                }
                match feed.byte() % 4 {
                    0 => {}
                    1 => head.handle_bytes(&[byte ^ (1 << (feed.byte() % 8))], now),
                    2 => head.handle_bytes(&[byte, byte], now),
                    _ => head.handle_bytes(&[feed.byte(), byte], now),
                }
                clean = feed.word() % 512;
            }
        }
        head.handle_deadline(now);
        while let Some(action) = head.poll_action() {
            match action {
                Action::Send(bytes) => twin.handle_bytes(&bytes, now),
                Action::Event(Event::Connected(_)) => {
                    // Taken or not: the queue may be full by then.
                    let _ = head.move_to(Axis::Tilt, i32::from(feed.byte()), now);
                    let _ = head.poll_position(Axis::Tilt, now);
                }
                Action::Event(Event::Position { axis, .. }) => {
                    let _ = head.poll_position(axis, now);
                }
                Action::Event(Event::Fault(_)) => return,
                Action::Event(_) => {}
            }
        }
        if feed.is_over() && clean == 0 {
            return;
        }
        let next = [twin.next_event(), head.deadline()];
        let next = next.into_iter().flatten().min();
        now = next.unwrap_or(now).max(now + Duration::from_micros(500));
    }
}

pub fn seeds() -> Vec<Vec<u8>> {
    (0..6_u8)
        .map(|start| {
            let mut seed = vec![start, start, start, start, start, 0, 200, 0];
            for at in 0..10_u8 {
                seed.extend([at, at.wrapping_mul(53), at.wrapping_mul(29), 0]);
            }
            seed
        })
        .collect()
}
