//! Whether the stamps of a stream advance by the scan period (scip2 sections 8 and 14).

use std::time::Duration;

use super::options::ScipOptions;
use crate::stamp::stamp_advance_ms;

/// How a stamp follows the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StampAdvance {
    /// By one period, or the first stamp.
    Next,
    /// This many scans are missing in between.
    Gap(u32),
    /// The same stamp, repeated this often by now.
    Repeated(u8),
    /// No multiple of the period, or too large.
    Jump { advance_ms: u32, in_a_row: u8 },
}

#[derive(Debug)]
pub(super) struct StampContinuity {
    period_ms: f64,
    tolerance: f64,
    speed_tolerance: f64,
    max_gap_ms: f64,
    last_ms: Option<u32>,
    after_interruption: bool,
    repeats: u8,
    jumps: u8,
}

impl StampContinuity {
    pub(super) fn new(period: Duration, options: &ScipOptions) -> Self {
        Self {
            period_ms: (period.as_secs_f64() * 1e3).max(1.0),
            tolerance: options.stamp_tolerance,
            speed_tolerance: options.speed_tolerance,
            max_gap_ms: options.max_gap.as_secs_f64() * 1e3,
            last_ms: None,
            after_interruption: false,
            repeats: 0,
            jumps: 0,
        }
    }

    pub(super) fn period_ms(&self) -> u32 {
        self.period_ms.round() as u32
    }

    /// For a timer that was reset.
    pub(super) fn reset(&mut self) {
        self.last_ms = None;
        self.repeats = 0;
        self.jumps = 0;
    }

    /// After an interruption the next advance may be any length up to the maximum gap.
    pub(super) fn interrupted(&mut self) {
        self.after_interruption = true;
    }

    pub(super) fn advance(&mut self, stamp_ms: u32) -> StampAdvance {
        let Some(last) = self.last_ms.replace(stamp_ms) else {
            return StampAdvance::Next;
        };
        let advance_ms = stamp_advance_ms(last, stamp_ms);
        if advance_ms == 0 {
            self.repeats = self.repeats.saturating_add(1);
            return StampAdvance::Repeated(self.repeats);
        }
        self.repeats = 0;
        let advance = f64::from(advance_ms);
        let periods = (advance / self.period_ms).round();
        let deviation = (advance - periods * self.period_ms).abs();
        let allowed = if self.after_interruption {
            self.period_ms
        } else if periods <= 1.0 {
            self.tolerance * self.period_ms
        } else {
            self.tolerance * self.period_ms + self.speed_tolerance * advance
        };
        if deviation > allowed
            || (periods < 1.0 && !self.after_interruption)
            || advance > self.max_gap_ms
        {
            self.jumps = self.jumps.saturating_add(1);
            return StampAdvance::Jump {
                advance_ms,
                in_a_row: self.jumps,
            };
        }
        self.jumps = 0;
        self.after_interruption = false;
        match (periods as u32).saturating_sub(1) {
            0 => StampAdvance::Next,
            lost => StampAdvance::Gap(lost),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stamp::STAMP_MODULUS_MS;

    fn advances(stamps: &[u32]) -> Vec<StampAdvance> {
        let mut continuity =
            StampContinuity::new(Duration::from_millis(100), &ScipOptions::default());
        stamps
            .iter()
            .map(|stamp| continuity.advance(*stamp))
            .collect()
    }

    #[test]
    fn steps_of_99_and_100_are_next() {
        assert_eq!(
            advances(&[5, 105, 204, 304, 414, 504]),
            [StampAdvance::Next; 6]
        );
    }

    #[test]
    fn multiples_are_gaps() {
        assert_eq!(
            advances(&[0, 200, 1199])[1..],
            [StampAdvance::Gap(1), StampAdvance::Gap(9)]
        );
    }

    #[test]
    fn the_wrap_is_no_jump() {
        assert_eq!(
            advances(&[STAMP_MODULUS_MS - 30, 70, 170]),
            [StampAdvance::Next; 3]
        );
    }

    #[test]
    fn repeats_and_jumps_are_counted() {
        let repeated = advances(&[0, 0, 0, 100]);
        assert_eq!(
            repeated[1..],
            [
                StampAdvance::Repeated(1),
                StampAdvance::Repeated(2),
                StampAdvance::Next
            ]
        );
        let jumped = advances(&[0, 150, 100, 200]);
        assert_eq!(
            jumped[1],
            StampAdvance::Jump {
                advance_ms: 150,
                in_a_row: 1
            }
        );
        assert!(
            matches!(jumped[2], StampAdvance::Jump { in_a_row: 2, .. }),
            "back in time"
        );
        assert_eq!(jumped[3], StampAdvance::Next);
        assert!(matches!(advances(&[0, 40])[1], StampAdvance::Jump { .. }));
        assert!(
            matches!(advances(&[0, 30_000])[1], StampAdvance::Jump { .. }),
            "longer than plausible"
        );
    }
}
