//! The PTU driver and the emulated head on a line that corrupts bytes.

use super::choices::Choices;
use ptu::emulator::{EmulatedHead, HeadFaultKind, HeadFaultSpec, HeadOptions};
use ptu::{Axis, PtuAction, PtuDriver, PtuEvent, PtuOptions};
use std::time::Duration;

/// Steps of virtual time a run may take, so that no input is slow.
const MAX_STEPS: usize = 6_000;

pub(crate) fn run(data: &[u8]) {
    let mut choices = Choices(data);
    let mut options = HeadOptions {
        seed: u64::from(choices.byte()),
        power_up: choices.byte() & 3 == 3,
        e_series: choices.byte() & 1 == 1,
        ..HeadOptions::default()
    };
    options.start.velocity_mode = choices.byte() & 3 == 3;
    options.start.monitor = choices.byte() & 3 == 3;
    let mut head = EmulatedHead::new(options, Duration::ZERO);
    let kinds: Vec<&str> = HeadFaultKind::kinds().collect();
    for _ in 0..choices.byte() % 3 {
        let (kind, at) = (choices.one_of(&kinds), f64::from(choices.byte()) / 20.0);
        let spec = format!("{kind}:at={at},for=2");
        head.inject(spec.parse::<HeadFaultSpec>().expect("a fault"));
    }
    let mut driver = PtuDriver::new(PtuOptions::default());
    let mut now = Duration::ZERO;
    let mut clean = choices.u16() % 1024;
    driver.connect(now);
    for _ in 0..MAX_STEPS {
        head.advance(now);
        while let Some(output) = head.poll_output() {
            for byte in output.bytes {
                if clean > 0 || choices.is_over() {
                    clean = clean.saturating_sub(1);
                    driver.handle_bytes(&[byte], now);
                    continue;
                }
                match choices.byte() % 4 {
                    0 => {}
                    1 => driver.handle_bytes(&[byte ^ (1 << (choices.byte() % 8))], now),
                    2 => driver.handle_bytes(&[byte, byte], now),
                    _ => driver.handle_bytes(&[choices.byte(), byte], now),
                }
                clean = choices.u16() % 512;
            }
        }
        driver.handle_deadline(now);
        while let Some(action) = driver.poll_action() {
            match action {
                PtuAction::Send(bytes) => head.handle_bytes(&bytes, now),
                PtuAction::Event(PtuEvent::Connected(_)) => {
                    // Accepted or not: the queue may be full.
                    let _ = driver.move_to(Axis::Tilt, i32::from(choices.byte()), now);
                    let _ = driver.poll_position(Axis::Tilt, now);
                }
                PtuAction::Event(PtuEvent::Position { axis, .. }) => {
                    let _ = driver.poll_position(axis, now);
                }
                PtuAction::Event(PtuEvent::Fault(_)) => return,
                PtuAction::Event(_) => {}
            }
        }
        if choices.is_over() && clean == 0 {
            return;
        }
        let next = [head.next_event(), driver.deadline()];
        let next = next.into_iter().flatten().min();
        now = next.unwrap_or(now).max(now + Duration::from_micros(500));
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
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
