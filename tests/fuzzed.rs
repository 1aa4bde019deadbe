//! Runs the fuzz bodies on their seeds, mutated seeds and random bytes, the same on every machine. Long runs are done by
//! cargo-fuzz (`fuzz/`).

#[path = "../fuzz/bodies/mod.rs"]
mod bodies;

use bodies::ALL;

/// Of each body; all together take some seconds.
const EXECUTIONS: usize = 2_000;

/// SplitMix64.
struct FuzzRng(u64);

impl FuzzRng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    /// Flips, replaces, removes, inserts or repeats bytes, truncates, or appends bytes of `other`.
    fn mutate(&mut self, mut bytes: Vec<u8>, other: &[u8]) -> Vec<u8> {
        for _ in 0..=self.below(6) {
            let at = self.below(bytes.len());
            match self.below(8) {
                0 => bytes.truncate(at),
                1 => bytes.extend_from_slice(&other[self.below(other.len() + 1)..]),
                2 if !bytes.is_empty() => drop(bytes.remove(at)),
                3 => bytes.insert(at, self.next() as u8),
                4 => {
                    let chunk = bytes[at..(at + self.below(40)).min(bytes.len())].to_vec();
                    bytes.splice(at..at, chunk);
                }
                5 => {
                    if let Some(byte) = bytes.get_mut(at) {
                        *byte = self.next() as u8;
                    }
                }
                _ => {
                    if let Some(byte) = bytes.get_mut(at) {
                        *byte ^= 1 << self.below(8);
                    }
                }
            }
        }
        bytes.truncate(8192);
        bytes
    }
}

fn fuzz(name: &str) {
    let (_, run, seeds) = ALL
        .iter()
        .find(|(known, ..)| *known == name)
        .expect("a body");
    let seeds = seeds();
    for seed in &seeds {
        run(seed);
    }
    let mut random = FuzzRng(0x5EED);
    for _ in 0..EXECUTIONS {
        let (one, other) = (random.below(seeds.len()), random.below(seeds.len()));
        let bytes = random.mutate(seeds[one].clone(), &seeds[other]);
        run(&bytes);
    }
    for length in 0..200 {
        let bytes: Vec<u8> = (0..length * 5).map(|_| random.next() as u8).collect();
        run(&bytes);
    }
    eprintln!("{name}: {} executions", seeds.len() + EXECUTIONS + 200);
}

macro_rules! fuzzed {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            fuzz(stringify!($name));
        }
    )*};
}

fuzzed!(
    scip_driver,
    scip_line,
    scip_emulator,
    ptu_driver,
    ptu_line,
    ptu_emulator,
    config,
    clouds,
    blobs,
    texts
);

/// Without scans the check of their sums would be empty.
#[test]
fn scans_are_received_and_checked() {
    use bodies::{scip_driver, scip_line};
    let scans: usize = scip_driver::seeds()
        .iter()
        .map(|seed| scip_driver::scans(seed))
        .sum();
    assert_eq!(scans, 1, "the second has the stamp of the first");
    for seed in scip_line::seeds() {
        let scans = scip_line::scans(&seed);
        assert!(scans >= 2, "{scans}");
    }
}

fn one_range() -> scip::LaserScan {
    scip::LaserScan {
        first_step: 44,
        cluster: 1,
        coding: scip::ValueCoding::ThreeCharacter,
        ranges: vec![1234],
        intensities: Vec::new(),
        stamp_ms: 5,
        remaining: 0,
    }
}

#[test]
#[should_panic(expected = "no intact message holds")]
fn a_scan_without_a_message_is_detected() {
    bodies::scip_sums::ReceivedBytes::default().assert_contains(&one_range());
}

/// A line with more characters than a stamp has is none.
#[test]
#[should_panic(expected = "no intact message holds")]
fn a_scan_with_an_overlong_stamp_is_detected() {
    let mut received = bodies::scip_sums::ReceivedBytes::default();
    received.add(b"MD0044004501000\n99b\nooooooooh\n0C2U\n\n");
    received.assert_contains(&one_range());
}

#[test]
fn every_body_has_a_test() {
    assert_eq!(ALL.len(), 10);
}

#[test]
#[ignore = "writes fuzz/corpus for cargo-fuzz"]
fn seeds_for_cargo_fuzz() {
    let corpus = patrold_test_support::workspace_root().join("fuzz/corpus");
    for (name, _, seeds) in ALL {
        let folder = corpus.join(name);
        std::fs::create_dir_all(&folder).expect("made");
        for (number, seed) in seeds().into_iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{number}")), seed).expect("written");
        }
    }
}
