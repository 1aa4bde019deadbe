//! Arbitrary input: no panic, bounded memory, and no message with a wrong sum becomes a scan.

mod common;

use common::{ScriptedLaser, SplitMix64, chunks, drain, scan_message};
use scip::constants::MAX_MESSAGE_BYTES;
use scip::encoding::checked_body;
use scip::{Framer, LaserEvent, ScipDriver, ScipOptions, StreamPlan, ValueCoding};
use std::time::Duration;

const ECHO: &str = "MD0044012501000";
const PLAN: StreamPlan = StreamPlan {
    first_step: 44,
    last_step: 125,
    cluster: 1,
    interval: 0,
    coding: ValueCoding::ThreeCharacter,
    count: 0,
};

/// Options under which the dialogue does not give up however bad the line.
fn patient() -> ScipOptions {
    ScipOptions {
        max_damaged_in_a_row: u8::MAX,
        max_jumps_in_a_row: u8::MAX,
        stale_repeats: u8::MAX,
        ..Default::default()
    }
}

fn streaming(options: ScipOptions) -> ScriptedLaser {
    let mut script = ScriptedLaser::connected(ScipDriver::new(options));
    script
        .driver
        .start_streaming(PLAN, script.now)
        .expect("idle");
    script.exchange("MD0044012501000\n", "MD0044012501000\n00P\n\n");
    assert_eq!(script.take_events(), [LaserEvent::Streaming]);
    script
}

fn scans(count: u32, rng: &mut SplitMix64) -> Vec<(u32, Vec<u32>)> {
    (0..count)
        .map(|k| {
            (
                1000 + 100 * k,
                (0..82).map(|_| rng.below(5600) as u32).collect(),
            )
        })
        .collect()
}

#[test]
fn seeded_garbage_at_every_stage() {
    for seed in 0..200 {
        let mut rng = SplitMix64(seed);
        let mut script = if seed % 2 == 0 {
            streaming(patient())
        } else {
            ScriptedLaser::new(ScipDriver::new(patient()))
        };
        if seed % 4 == 1 {
            script.driver.connect(script.now);
        }
        // Alphabets from "all bytes" to "nearly the protocol's own".
        let alphabet: Vec<u8> = match seed % 3 {
            0 => (0..=255).collect(),
            1 => b"\n\n\n09MD4QTP:;EVIRS".to_vec(),
            _ => (0x30..0x70).chain([b'\n']).collect(),
        };
        let garbage: Vec<u8> = (0..20_000)
            .map(|_| alphabet[rng.below(alphabet.len())])
            .collect();
        for chunk in chunks(&garbage, 500, &mut rng) {
            script.now += Duration::from_millis(7);
            script.driver.handle_bytes(&chunk, script.now);
            script.driver.handle_deadline(script.now);
            let (_, events) = drain(&mut script.driver);
            assert!(
                !events
                    .iter()
                    .any(|event| matches!(event, LaserEvent::Scan { .. })),
                "seed {seed}"
            );
        }
    }
}

#[test]
fn floods_without_an_end_never_grow_memory() {
    for flood in [
        &[0xFF_u8; 4096][..],
        &[b'0'; 4096],
        &[0; 4096],
        &b"0123456\n".repeat(512),
    ] {
        let mut framer = Framer::default();
        for _ in 0..1000 {
            assert_eq!(framer.take(&mut &*flood, Duration::ZERO), None);
            assert!(framer.held_bytes() <= MAX_MESSAGE_BYTES);
        }
        assert_eq!(
            framer.overruns(),
            1,
            "one flood is one overrun, however long"
        );

        // In the dialogue too: the scan after the next empty line is taken.
        let mut script = streaming(ScipOptions::default());
        script.driver.handle_bytes(flood, script.now);
        script.driver.handle_bytes(&flood.repeat(8), script.now);
        script.driver.handle_bytes(b"\n\n", script.now);
        script.reply(scan_message(ECHO, "99", 1000, &[500; 82]));
        let (_, events) = drain(&mut script.driver);
        assert!(
            matches!(events.last(), Some(LaserEvent::Scan { .. })),
            "{events:?}"
        );
    }
}

/// The scans among `stream`'s lines whose every sum is right and that are whole, found without the driver's parser.
fn intact(stream: &[u8], originals: &[Vec<u8>]) -> usize {
    let text = stream
        .split_inclusive(|byte| *byte == b'\n')
        .collect::<Vec<_>>();
    let mut found = 0;
    let mut message: Vec<u8> = Vec::new();
    for line in text {
        message.extend_from_slice(line);
        if line == b"\n" {
            found += usize::from(originals.contains(&message));
            message.clear();
        }
    }
    found
}

#[test]
fn one_flipped_bit_costs_its_scan_and_no_more_than_its_neighbour() {
    let mut rng = SplitMix64(11);
    let scans = scans(3, &mut rng);
    let originals: Vec<Vec<u8>> = scans
        .iter()
        .map(|(stamp, ranges)| scan_message(ECHO, "99", *stamp, ranges))
        .collect();
    let clean = originals.concat();
    for position in 0..clean.len() {
        let mut stream = clean.clone();
        stream[position] ^= 1 << rng.below(8);
        let mut script = streaming(patient());
        script.driver.handle_bytes(&stream, script.now);
        let mut accepted = 0;
        for event in drain(&mut script.driver).1 {
            if let LaserEvent::Scan { scan, .. } = event {
                assert!(
                    scans.contains(&(scan.stamp_ms, scan.ranges)),
                    "a scan nobody sent, position {position}"
                );
                accepted += 1;
            }
        }
        assert_eq!(accepted, intact(&stream, &originals), "position {position}");
        assert!(accepted >= 1, "position {position}");
    }
}

#[test]
fn many_flips_drops_and_insertions_never_make_a_scan_with_a_wrong_sum() {
    for seed in 0..300 {
        let mut rng = SplitMix64(1000 + seed);
        let scans = scans(20, &mut rng);
        let mut stream: Vec<u8> = scans
            .iter()
            .flat_map(|(stamp, ranges)| scan_message(ECHO, "99", *stamp, ranges))
            .collect();
        for _ in 0..rng.below(12) {
            let at = rng.below(stream.len());
            match rng.below(4) {
                0 => stream[at] ^= 1 << rng.below(8),
                1 => drop(stream.remove(at)),
                2 => stream.insert(at, rng.below(256) as u8),
                _ => stream.truncate(stream.len() - rng.below(50)),
            }
        }
        let mut script = streaming(patient());
        for chunk in chunks(&stream, 300, &mut rng) {
            script.driver.handle_bytes(&chunk, script.now);
        }
        // Ask the bytes themselves: the messages whose every line after the echo verifies.
        let mut verified = Vec::new();
        let mut framer = Framer::default();
        let mut rest = stream.as_slice();
        while let Some(message) = framer.take(&mut rest, Duration::ZERO) {
            if message
                .lines()
                .skip(1)
                .all(|line| checked_body(line).is_ok())
            {
                verified.push(message);
            }
        }
        let accepted = drain(&mut script.driver)
            .1
            .into_iter()
            .filter_map(|event| match event {
                LaserEvent::Scan { scan, .. } => Some(scan),
                _ => None,
            })
            .collect::<Vec<_>>();
        assert!(accepted.len() <= verified.len(), "seed {seed}");
        for scan in accepted {
            let original = scan_message(ECHO, "99", scan.stamp_ms, &scan.ranges);
            let same = |message: &scip::ScipMessage| message.lines().eq(lines(&original));
            assert!(
                verified.iter().any(same),
                "seed {seed}: accepted though not verified"
            );
        }
    }
}

fn lines(message: &[u8]) -> impl Iterator<Item = &[u8]> {
    message
        .strip_suffix(b"\n\n")
        .expect("complete")
        .split(|byte| *byte == b'\n')
}
