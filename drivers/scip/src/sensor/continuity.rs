//! Do the stamps of a stream advance as planned? Protocol sections 8 and 14.

use std::time::Duration;

use super::options::SensorOptions;
use crate::stamp::stamp_advance_ms;

/// How a stamp follows the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Advance {
    /// The first, or the next.
    Next,
    /// So many scans are missing in between.
    Gap(u32),
    /// The same again, so many times by now.
    Repeated(u8),
    /// No multiple of the period, or not to be believed; so many times in a row by now.
    Jump { advance_ms: u32, in_a_row: u8 },
}

/// Follows the stamps of one stream.
#[derive(Debug)]
pub(super) struct Continuity {
    period_ms: f64,
    tolerance: f64,
    speed_tolerance: f64,
    longest_gap_ms: f64,
    last_ms: Option<u32>,
    lenient: bool,
    repeats: u8,
    jumps: u8,
}

impl Continuity {
    pub(super) fn new(period: Duration, options: &SensorOptions) -> Self {
        Self {
            period_ms: (period.as_secs_f64() * 1e3).max(1.0),
            tolerance: options.stamp_tolerance,
            speed_tolerance: options.speed_tolerance,
            longest_gap_ms: options.longest_gap.as_secs_f64() * 1e3,
            last_ms: None,
            lenient: false,
            repeats: 0,
            jumps: 0,
        }
    }

    /// The planned advance, ms.
    pub(super) fn period_ms(&self) -> u32 {
        self.period_ms.round() as u32
    }

    /// The timer went back to zero.
    pub(super) fn forget(&mut self) {
        self.last_ms = None;
        self.repeats = 0;
        self.jumps = 0;
    }

    /// Scanning was interrupted: the next advance need not be a multiple of the period, and may be long.
    pub(super) fn interrupted(&mut self) {
        self.lenient = true;
    }

    /// Judges the next stamp and remembers it.
    pub(super) fn advance(&mut self, stamp_ms: u32) -> Advance {
        let Some(last) = self.last_ms.replace(stamp_ms) else {
            return Advance::Next;
        };
        let advance_ms = stamp_advance_ms(last, stamp_ms);
        if advance_ms == 0 {
            self.repeats = self.repeats.saturating_add(1);
            return Advance::Repeated(self.repeats);
        }
        self.repeats = 0;
        let advance = f64::from(advance_ms);
        let periods = (advance / self.period_ms).round();
        let deviation = (advance - periods * self.period_ms).abs();
        let allowed = if self.lenient {
            self.period_ms
        } else if periods <= 1.0 {
            self.tolerance * self.period_ms
        } else {
            self.tolerance * self.period_ms + self.speed_tolerance * advance
        };
        if deviation > allowed || (periods < 1.0 && !self.lenient) || advance > self.longest_gap_ms
        {
            self.jumps = self.jumps.saturating_add(1);
            return Advance::Jump {
                advance_ms,
                in_a_row: self.jumps,
            };
        }
        self.jumps = 0;
        self.lenient = false;
        match (periods as u32).saturating_sub(1) {
            0 => Advance::Next,
            lost => Advance::Gap(lost),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stamp::STAMP_MODULUS_MS;

    fn judge(stamps: &[u32]) -> Vec<Advance> {
        let mut continuity = Continuity::new(Duration::from_millis(100), &SensorOptions::default());
        stamps
            .iter()
            .map(|stamp| continuity.advance(*stamp))
            .collect()
    }

    #[test]
    fn steps_of_99_and_100_are_next() {
        assert_eq!(judge(&[5, 105, 204, 304, 414, 504]), [Advance::Next; 6]);
    }

    #[test]
    fn multiples_are_gaps() {
        assert_eq!(
            judge(&[0, 200, 1199])[1..],
            [Advance::Gap(1), Advance::Gap(9)]
        );
    }

    #[test]
    fn the_wrap_is_no_jump() {
        assert_eq!(judge(&[STAMP_MODULUS_MS - 30, 70, 170]), [Advance::Next; 3]);
    }

    #[test]
    fn repeats_and_jumps_are_counted() {
        let repeated = judge(&[0, 0, 0, 100]);
        assert_eq!(
            repeated[1..],
            [Advance::Repeated(1), Advance::Repeated(2), Advance::Next]
        );
        let jumped = judge(&[0, 150, 100, 200]);
        assert_eq!(
            jumped[1],
            Advance::Jump {
                advance_ms: 150,
                in_a_row: 1
            }
        );
        assert!(
            matches!(jumped[2], Advance::Jump { in_a_row: 2, .. }),
            "back in time"
        );
        assert_eq!(jumped[3], Advance::Next);
        assert!(matches!(judge(&[0, 40])[1], Advance::Jump { .. }));
        assert!(
            matches!(judge(&[0, 30_000])[1], Advance::Jump { .. }),
            "longer than believed"
        );
    }
}
