//! The sensor's 24-bit millisecond timer (protocol section 8).

use super::Instant;
use super::constants::TIMER_MASK;

/// A timer that counts milliseconds at a rate of its own.
#[derive(Debug, Clone)]
pub(super) struct Timer {
    epoch: Instant,
    at_epoch_ms: i64,
    rate_ppb: i128,
}

impl Timer {
    /// A timer that shows `start_ms` at `now` and gains `rate_error` of itself on the host's clock.
    pub(super) fn new(now: Instant, start_ms: u32, rate_error: f64) -> Self {
        Self {
            epoch: now,
            at_epoch_ms: i64::from(start_ms),
            rate_ppb: (rate_error * 1e9).round() as i128,
        }
    }

    /// The timer at `t`, which may lie before the last reset: the arithmetic is modular.
    pub(super) fn at(&self, t: Instant) -> u32 {
        let elapsed_ns = t.as_nanos() as i128 - self.epoch.as_nanos() as i128;
        let elapsed_ms =
            (elapsed_ns * (1_000_000_000 + self.rate_ppb)).div_euclid(1_000_000_000_000_000);
        let ms = (i128::from(self.at_epoch_ms) + elapsed_ms).rem_euclid(i128::from(TIMER_MASK) + 1);
        ms as u32
    }

    /// Sets the timer to zero.
    pub(super) fn reset(&mut self, now: Instant) {
        self.epoch = now;
        self.at_epoch_ms = 0;
    }

    /// Moves the timer by `by_ms`.
    pub(super) fn jump(&mut self, by_ms: i32) {
        // Kept within one turn, so that no number of jumps can overflow.
        self.at_epoch_ms =
            (self.at_epoch_ms + i64::from(by_ms)).rem_euclid(i64::from(TIMER_MASK) + 1);
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn wraps_after_24_bits() {
        let timer = Timer::new(Duration::ZERO, TIMER_MASK - 1, 0.0);
        assert_eq!(timer.at(Duration::from_millis(1)), TIMER_MASK);
        assert_eq!(timer.at(Duration::from_millis(2)), 0);
        assert_eq!(timer.at(Duration::from_millis(16_777_216)), TIMER_MASK - 1);
    }

    #[test]
    fn gains_on_the_host() {
        let timer = Timer::new(Duration::ZERO, 0, 0.0013);
        assert_eq!(timer.at(Duration::from_secs(1000)), 1_001_300);
    }

    #[test]
    fn reset_and_jump() {
        let mut timer = Timer::new(Duration::ZERO, 77, 0.0);
        timer.reset(Duration::from_secs(2));
        assert_eq!(timer.at(Duration::from_millis(2005)), 5);
        timer.jump(-10);
        assert_eq!(timer.at(Duration::from_millis(2005)), TIMER_MASK - 4);
    }
}
