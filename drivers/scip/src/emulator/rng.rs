//! Seeded random numbers, so that a run repeats byte for byte.

use std::time::Duration;

/// SplitMix64 (Steele, Lea and Flood 2014), for jitter and corrupted bytes.
#[derive(Debug, Clone)]
pub(super) struct JitterRng(u64);

impl JitterRng {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In `low..=high`; `low` if the range is empty.
    pub(super) fn between(&mut self, low: u64, high: u64) -> u64 {
        let span = high.saturating_sub(low).saturating_add(1);
        low + self.next() % span.max(1)
    }

    /// Uniform in `0..width`.
    pub(super) fn duration_below(&mut self, width: Duration) -> Duration {
        let nanoseconds = u64::try_from(width.as_nanos()).unwrap_or(u64::MAX);
        Duration::from_nanos(self.between(0, nanoseconds.saturating_sub(1)))
    }

    pub(super) fn byte(&mut self) -> u8 {
        (self.next() >> 56) as u8
    }
}
