//! Random bytes, floods and splits: no panic, bounded memory.

use std::time::Duration;

use crate::{Axis, PtuAction, PtuDriver, PtuOptions};

/// A seeded random number generator.
struct NoiseRng(u64);

impl NoiseRng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Parts of real replies, so that the dialogue gets far before it breaks.
const PIECES: [&[u8]; 20] = [
    b"*\r\n",
    b"* 22\r\n",
    b"* 22",
    b"\r",
    b"\n",
    b"!P",
    b"!T",
    b"!D",
    b"! Axis Error\r\n",
    b"#P",
    b"###\r\n",
    b"Initializing...",
    b"ED *\r\n",
    b"PP * 5\r\n",
    b"* Current Pan position is 5\r\n",
    b"* Echoing OFF\r\n",
    b"* ASCII terse mode\r\n",
    b"* Pan-Tilt Controller v2\r\n",
    b"\xff\xff\xff",
    b"* 185.1428\r\n",
];

fn random_request(driver: &mut PtuDriver, random: &mut NoiseRng, now: Duration) {
    let value = random.next() as i32;
    let _ = match random.below(60) {
        0 => driver.poll_position(Axis::Pan, now),
        1 => driver.move_to(Axis::Tilt, value, now),
        2 => driver.set_speed(Axis::Pan, value, now),
        3 => driver.halt(now),
        4 => driver.reset(now),
        5 => driver.query_health(now),
        6 => driver.hold_power_low(now),
        7 => {
            driver.connect(now);
            Ok(())
        }
        _ => Ok(()),
    };
}

#[test]
fn random_input_and_requests_never_break_the_driver() {
    for seed in 0..200 {
        let mut random = NoiseRng(seed);
        let mut driver = PtuDriver::new(PtuOptions::default());
        let mut now = Duration::ZERO;
        driver.connect(now);
        for _ in 0..2000 {
            let noise: Vec<u8> = (0..random.below(40)).map(|_| random.next() as u8).collect();
            let bytes = if random.below(4) == 0 {
                &noise[..]
            } else {
                PIECES[random.below(PIECES.len())]
            };
            driver.handle_bytes(bytes, now);
            random_request(&mut driver, &mut random, now);
            now += Duration::from_millis(random.next() % 120);
            driver.handle_deadline(now);
            let mut count = 0;
            while driver.poll_action().is_some() {
                count += 1;
            }
            assert!(count < 100, "seed {seed}: {count} actions at once");
            assert!(driver.pending() < 100);
        }
    }
}

#[test]
fn a_flood_with_or_without_line_ends_stays_bounded() {
    let notices: Vec<u8> = b"!P!T!D#P".repeat(50_000);
    let banners: Vec<u8> = b"###\r*\r".repeat(50_000);
    for flood in [
        vec![0xff; 400_000],
        vec![b'*'; 400_000],
        vec![b'\r'; 400_000],
        notices,
        banners,
        b"* 5\r\n".repeat(50_000),
    ] {
        let mut driver = PtuDriver::new(PtuOptions::default());
        driver.connect(Duration::ZERO);
        for (index, piece) in flood.chunks(4096).enumerate() {
            let now = Duration::from_millis(index as u64 * 100);
            driver.handle_bytes(piece, now);
            driver.handle_deadline(now);
        }
        // No action was taken meanwhile.
        let actions: Vec<PtuAction> = std::iter::from_fn(|| driver.poll_action()).collect();
        assert!(actions.len() < 200, "{} actions", actions.len());
    }
}
