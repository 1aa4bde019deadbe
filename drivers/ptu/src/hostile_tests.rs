//! Random bytes, floods and splits: no panic, no growth without bound.

use std::time::Duration;

use crate::{Action, Axis, Head, HeadOptions, Instant};

/// SplitMix64: seeded, small, good enough to scatter bytes.
struct Dice(u64);

impl Dice {
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

/// Pieces of real replies, so that the dialogue gets deep before it breaks.
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

fn ask(head: &mut Head, dice: &mut Dice, now: Instant) {
    let value = dice.next() as i32;
    let _ = match dice.below(60) {
        0 => head.poll_position(Axis::Pan, now),
        1 => head.move_to(Axis::Tilt, value, now),
        2 => head.set_speed(Axis::Pan, value, now),
        3 => head.halt(now),
        4 => head.reset(now),
        5 => head.query_health(now),
        6 => head.hold_power_low(now),
        7 => {
            head.connect(now);
            Ok(())
        }
        _ => Ok(()),
    };
}

#[test]
fn nothing_from_the_line_breaks_the_driver() {
    for seed in 0..200 {
        let mut dice = Dice(seed);
        let mut head = Head::new(HeadOptions::default());
        let mut now = Duration::ZERO;
        head.connect(now);
        for _ in 0..2000 {
            let random: Vec<u8> = (0..dice.below(40)).map(|_| dice.next() as u8).collect();
            let bytes = if dice.below(4) == 0 {
                &random[..]
            } else {
                PIECES[dice.below(PIECES.len())]
            };
            head.handle_bytes(bytes, now);
            ask(&mut head, &mut dice, now);
            now += Duration::from_millis(dice.next() % 120);
            head.handle_deadline(now);
            let mut count = 0;
            while head.poll_action().is_some() {
                count += 1;
            }
            assert!(count < 100, "seed {seed}: {count} actions at once");
            assert!(head.pending() < 100);
        }
    }
}

#[test]
fn a_flood_without_line_ends_or_with_nothing_else_stays_small() {
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
        let mut head = Head::new(HeadOptions::default());
        head.connect(Duration::ZERO);
        for (index, piece) in flood.chunks(4096).enumerate() {
            let now = Duration::from_millis(index as u64 * 100);
            head.handle_bytes(piece, now);
            head.handle_deadline(now);
        }
        // Nobody took the actions meanwhile.
        let actions: Vec<Action> = std::iter::from_fn(|| head.poll_action()).collect();
        assert!(actions.len() < 200, "{} actions", actions.len());
    }
}
