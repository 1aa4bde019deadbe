//! The twin's own small source of chance: seeded, so that a run can be told again byte for byte.

use std::time::Duration;

/// SplitMix64 (Steele, Lea and Flood 2014): enough for jitter and spoilt bytes.
#[derive(Debug, Clone)]
pub(super) struct Noise(u64);

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `low..=high` (`low` if the span is empty).
    pub(super) fn between(&mut self, low: u64, high: u64) -> u64 {
        let span = high.saturating_sub(low).saturating_add(1);
        low + self.next() % span.max(1)
    }

    /// A duration spread evenly over `0..width`.
    pub(super) fn spread(&mut self, width: Duration) -> Duration {
        let nanoseconds = u64::try_from(width.as_nanos()).unwrap_or(u64::MAX);
        Duration::from_nanos(self.between(0, nanoseconds.saturating_sub(1)))
    }

    /// Any byte.
    pub(super) fn byte(&mut self) -> u8 {
        (self.next() >> 56) as u8
    }
}
