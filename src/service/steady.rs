//! Whether the wall clock can be believed where belief deletes: it is only as old as its last jump.

use super::constants::{STEADY_FOR, WALL_STEP};
use jiff::Timestamp;
use std::time::Duration;

/// The wall clock beside the monotone one. A clock that is wrong and never set stays unseen; one that is set, or a
/// machine that slept, begins anew.
#[derive(Debug, Default)]
pub struct SteadyWall {
    /// Both clocks when the present pace began.
    began: Option<(Duration, Timestamp)>,
}

impl SteadyWall {
    /// Compares both clocks, again and again.
    pub fn look(&mut self, monotone: Duration, wall: Timestamp) {
        let kept = self.began.is_some_and(|(then, wall_then)| {
            let passed = wall.duration_since(wall_then).as_secs_f64();
            let should = monotone.saturating_sub(then).as_secs_f64();
            (passed - should).abs() < WALL_STEP.as_secs_f64()
        });
        if !kept {
            self.began = Some((monotone, wall));
        }
    }

    /// Whether the wall clock has kept pace long enough.
    pub fn is_steady(&self, monotone: Duration) -> bool {
        let long_enough = |then| monotone.saturating_sub(then) >= STEADY_FOR;
        self.began.is_some_and(|(then, _)| long_enough(then))
    }
}

#[cfg(test)]
mod tests {
    use super::{STEADY_FOR, SteadyWall};
    use jiff::{SignedDuration, Timestamp};
    use std::time::Duration;

    #[test]
    fn a_clock_that_jumps_is_believed_an_hour_later() {
        let at = |passed: Duration, ahead_s: i64| {
            let begin = Timestamp::from_second(1_700_000_000).expect("a time");
            let off = SignedDuration::from_secs(ahead_s);
            begin + SignedDuration::try_from(passed).expect("short") + off
        };
        let minutes = |n: u64| Duration::from_secs(60 * n);
        let mut wall = SteadyWall::default();
        assert!(!wall.is_steady(STEADY_FOR), "never looked at");
        // Ten years ahead at boot, set from the network after five minutes.
        let years = 10 * 365 * 86_400;
        for minute in 0..5 {
            wall.look(minutes(minute), at(minutes(minute), years));
        }
        for minute in 5..=64 {
            wall.look(minutes(minute), at(minutes(minute), 0));
            assert!(!wall.is_steady(minutes(minute)), "minute {minute}");
        }
        wall.look(minutes(65), at(minutes(65), 1));
        assert!(wall.is_steady(minutes(65)));
        wall.look(minutes(66), at(minutes(66), years));
        assert!(!wall.is_steady(minutes(66)), "set again");
    }
}
