//! Whether the wall clock is stable enough to delete sweeps by age.

use super::constants::{WALL_CLOCK_STABLE_FOR, WALL_CLOCK_STEP};
use jiff::Timestamp;
use std::time::Duration;

/// Compares the wall clock with the monotonic one. It starts over when the wall clock is set and after a suspend; a wrong
/// clock that is never set goes unnoticed.
#[derive(Debug, Default)]
pub(super) struct WallClockMonitor {
    /// Monotonic and wall time.
    stable_since: Option<(Duration, Timestamp)>,
}

impl WallClockMonitor {
    /// Whether the wall clock was set since the last call.
    pub(super) fn update(&mut self, monotonic: Duration, wall: Timestamp) -> bool {
        let stable = self.stable_since.is_some_and(|(then, wall_then)| {
            let wall_s = wall.duration_since(wall_then).as_secs_f64();
            let monotonic_s = monotonic.saturating_sub(then).as_secs_f64();
            (wall_s - monotonic_s).abs() < WALL_CLOCK_STEP.as_secs_f64()
        });
        let was_set = !stable && self.stable_since.is_some();
        if !stable {
            self.stable_since = Some((monotonic, wall));
        }
        was_set
    }

    pub(super) fn is_stable(&self, monotonic: Duration) -> bool {
        let long_enough = |then| monotonic.saturating_sub(then) >= WALL_CLOCK_STABLE_FOR;
        self.stable_since.is_some_and(|(then, _)| long_enough(then))
    }
}

#[cfg(test)]
mod tests {
    use super::{WALL_CLOCK_STABLE_FOR, WallClockMonitor};
    use jiff::{SignedDuration, Timestamp};
    use std::time::Duration;

    #[test]
    fn a_clock_that_was_set_is_stable_an_hour_later() {
        let wall = |elapsed: Duration, ahead_s: i64| {
            let start = Timestamp::from_second(1_700_000_000).expect("a time");
            let ahead = SignedDuration::from_secs(ahead_s);
            start + SignedDuration::try_from(elapsed).expect("short") + ahead
        };
        let minutes = |n: u64| Duration::from_secs(60 * n);
        let mut monitor = WallClockMonitor::default();
        assert!(!monitor.is_stable(WALL_CLOCK_STABLE_FOR), "never updated");
        // Ten years ahead at boot, set from the network after five minutes.
        let years_s = 10 * 365 * 86_400;
        for minute in 0..5 {
            monitor.update(minutes(minute), wall(minutes(minute), years_s));
        }
        for minute in 5..=64 {
            monitor.update(minutes(minute), wall(minutes(minute), 0));
            assert!(!monitor.is_stable(minutes(minute)), "minute {minute}");
        }
        monitor.update(minutes(65), wall(minutes(65), 1));
        assert!(monitor.is_stable(minutes(65)));
        // Slewed by less than a minute, then by a minute.
        assert!(!monitor.update(minutes(66), wall(minutes(66), 59)));
        assert!(monitor.is_stable(minutes(66)));
        assert!(monitor.update(minutes(66), wall(minutes(66), 60)));
        assert!(!monitor.is_stable(minutes(66)));
        monitor.update(minutes(66), wall(minutes(66), years_s));
        assert!(!monitor.is_stable(minutes(66)), "set again");
    }
}
