//! Driver and emulator of the laser on a line that corrupts bytes: a whole dialogue, damaged anywhere.

use super::choices::Choices;
use super::scip_sums::ReceivedBytes;
use scip::emulator::{
    EmulatedLaser, LaserFault, LaserFaultSpec, LaserOptions, LaserProfile, RangeSource,
};
use scip::{LaserAction, LaserEvent, ScipDriver, ScipOptions, StreamPlan, ValueCoding};
use std::time::Duration;

struct RangeRamp;

impl RangeSource for RangeRamp {
    fn fill_revolution(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        for (step, range) in out.iter_mut().enumerate() {
            *range = 900 + step as u32 * 3;
        }
    }
}

/// Steps of virtual time of a run, so that no input is slow.
const MAX_STEPS: usize = 3_000;

pub(crate) fn run(data: &[u8]) {
    scans(data);
}

/// Returns the number of scans.
pub(crate) fn scans(data: &[u8]) -> usize {
    let mut scans = 0;
    let mut choices = Choices(data);
    let name = choices.one_of(&LaserProfile::NAMES);
    let mut options = LaserOptions::default();
    options.set_profile(LaserProfile::by_name(name).expect("of the list"));
    let mut laser = EmulatedLaser::new(options, Duration::ZERO);
    let kinds: Vec<&str> = LaserFault::kinds().collect();
    for _ in 0..choices.byte() % 3 {
        let (kind, at) = (choices.one_of(&kinds), choices.byte());
        let spec = format!("{kind}:at={},for=1", f64::from(at) / 40.0);
        laser.inject(spec.parse::<LaserFaultSpec>().expect("a fault"));
    }
    let mut driver = ScipDriver::new(ScipOptions::default());
    let mut received = ReceivedBytes::default();
    let mut now = Duration::ZERO;
    // Bytes to pass before the next damage.
    let mut clean = choices.u16();
    driver.connect(now);
    for _ in 0..MAX_STEPS {
        laser.advance(now, &mut RangeRamp);
        while let Some(output) = laser.poll_output() {
            let mut bytes = Vec::with_capacity(output.bytes.len());
            for byte in output.bytes {
                if clean > 0 || choices.is_over() {
                    clean = clean.saturating_sub(1);
                    bytes.push(byte);
                    continue;
                }
                match choices.byte() % 4 {
                    0 => {}
                    1 => bytes.push(byte ^ (1 << (choices.byte() % 8))),
                    2 => bytes.extend([byte, byte]),
                    _ => bytes.push(choices.byte()),
                }
                clean = choices.u16() % 16_384;
            }
            received.add(&bytes);
            driver.handle_bytes(&bytes, now);
        }
        driver.handle_deadline(now);
        while let Some(action) = driver.poll_action() {
            match action {
                LaserAction::Send(bytes) => laser.handle_bytes(&bytes, now),
                LaserAction::SetBitRate(bit_s) => laser.set_host_baud(bit_s),
                LaserAction::Event(LaserEvent::Scan { scan, .. }) => {
                    received.assert_contains(&scan);
                    scans += 1;
                }
                LaserAction::Event(LaserEvent::Connected(identity)) => {
                    let plan = StreamPlan {
                        first_step: identity.parameters.amin as u16,
                        last_step: identity.parameters.amax.min(9999) as u16,
                        cluster: 1,
                        interval: 0,
                        coding: ValueCoding::ThreeCharacter,
                        count: 0,
                    };
                    // Refused if the damage made a number invalid.
                    drop(driver.start_streaming(plan, now));
                }
                LaserAction::Event(LaserEvent::ConnectionFailed(_)) => return scans,
                LaserAction::Event(_) => {}
            }
        }
        if choices.is_over() && clean == 0 {
            return scans;
        }
        let next = [laser.next_event(), driver.deadline()];
        let next = next.into_iter().flatten().min();
        now = next.unwrap_or(now).max(now + Duration::from_micros(500));
    }
    scans
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
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
