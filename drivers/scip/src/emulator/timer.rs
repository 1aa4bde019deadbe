//! The sensor's 24-bit millisecond timer (scip2 section 8).

use super::constants::TIMER_MASK;
use std::time::Duration;

/// Counting from a known value.
#[derive(Debug, Clone, Copy)]
struct TimerSegment {
    epoch: Duration,
    at_epoch_ms: i64,
}

#[derive(Debug, Clone)]
pub(super) struct Timer {
    count: TimerSegment,
    /// The segment before the timer was last set, and its end: a scan that began in it keeps its stamp.
    before: Option<(TimerSegment, Duration)>,
    rate_ppb: i128,
}

impl Timer {
    /// A timer at `start_ms` at `now`, with a rate of 1 + `rate_error` against the host's clock.
    pub(super) fn new(now: Duration, start_ms: u32, rate_error: f64) -> Self {
        Self {
            count: TimerSegment {
                epoch: now,
                at_epoch_ms: i64::from(start_ms),
            },
            before: None,
            rate_ppb: (rate_error * 1e9).round() as i128,
        }
    }

    /// The timer at `t`, ms of 24 bits.
    pub(super) fn at(&self, t: Duration) -> u32 {
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

    pub(super) fn reset(&mut self, now: Duration) {
        self.set(0, now);
    }

    pub(super) fn set(&mut self, ms: u32, now: Duration) {
        self.before = Some((self.count, now));
        self.count = TimerSegment {
            epoch: now,
            at_epoch_ms: i64::from(ms & TIMER_MASK),
        };
    }

    pub(super) fn jump(&mut self, by_ms: i32, now: Duration) {
        self.before = Some((self.count, now));
        // Kept within 24 bits, so that no number of jumps can overflow.
        self.count.at_epoch_ms =
            (self.count.at_epoch_ms + i64::from(by_ms)).rem_euclid(i64::from(TIMER_MASK) + 1);
    }
}

#[cfg(test)]
mod tests {
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
