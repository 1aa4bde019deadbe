//! The sensor's 24-bit millisecond timer (protocol section 8).

use super::Instant;
use super::constants::TIMER_MASK;

/// A stretch of undisturbed counting.
#[derive(Debug, Clone, Copy)]
struct Count {
    epoch: Instant,
    at_epoch_ms: i64,
}

/// A timer that counts milliseconds at a rate of its own.
#[derive(Debug, Clone)]
pub(super) struct Timer {
    count: Count,
    /// How it counted before it was last set, and when that was: a scan that had begun then keeps its stamp.
    before: Option<(Count, Instant)>,
    rate_ppb: i128,
}

impl Timer {
    /// A timer that shows `start_ms` at `now` and gains `rate_error` of itself on the host's clock.
    pub(super) fn new(now: Instant, start_ms: u32, rate_error: f64) -> Self {
        Self {
            count: Count {
                epoch: now,
                at_epoch_ms: i64::from(start_ms),
            },
            before: None,
            rate_ppb: (rate_error * 1e9).round() as i128,
        }
    }

    /// What the timer shows at `t`, or showed.
    pub(super) fn at(&self, t: Instant) -> u32 {
        let count = match self.before {
            Some((before, until)) if t < until => before,
            _ => self.count,
        };
        let elapsed_ns = t.as_nanos() as i128 - count.epoch.as_nanos() as i128;
        let elapsed_ms =
            (elapsed_ns * (1_000_000_000 + self.rate_ppb)).div_euclid(1_000_000_000_000_000);
        let ms =
            (i128::from(count.at_epoch_ms) + elapsed_ms).rem_euclid(i128::from(TIMER_MASK) + 1);
        ms as u32
    }

    /// Sets the timer to zero.
    pub(super) fn reset(&mut self, now: Instant) {
        self.set(0, now);
    }

    /// Sets the timer to `ms`.
    pub(super) fn set(&mut self, ms: u32, now: Instant) {
        self.before = Some((self.count, now));
        self.count = Count {
            epoch: now,
            at_epoch_ms: i64::from(ms & TIMER_MASK),
        };
    }

    /// Moves the timer by `by_ms`.
    pub(super) fn jump(&mut self, by_ms: i32, now: Instant) {
        self.before = Some((self.count, now));
        // Kept within one turn, so that no number of jumps can overflow.
        self.count.at_epoch_ms =
            (self.count.at_epoch_ms + i64::from(by_ms)).rem_euclid(i64::from(TIMER_MASK) + 1);
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
        timer.jump(-10, Duration::from_millis(2003));
        assert_eq!(timer.at(Duration::from_millis(2002)), 2);
        assert_eq!(timer.at(Duration::from_millis(2005)), TIMER_MASK - 4);
    }
}
