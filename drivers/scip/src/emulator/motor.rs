//! The motor: instants of revolutions and steps.

use std::time::Duration;

use super::constants::TICK_PERMILLE;

/// Constant speed: from revolution `first` on, each takes `period_ps`.
#[derive(Debug, Clone, Copy)]
struct SpeedSegment {
    first: u64,
    start: Duration,
    period_ps: u64,
}

impl SpeedSegment {
    fn start_time(&self, revolution: u64) -> Duration {
        self.start
            + picoseconds(
                u128::from(revolution.saturating_sub(self.first)) * u128::from(self.period_ps),
            )
    }
}

/// The motor turns from power-up on, whatever the laser does (scip2 section 15).
#[derive(Debug, Clone)]
pub(super) struct Motor {
    now: SpeedSegment,
    next: Option<SpeedSegment>,
    rate: f64,
    steps: u32,
}

impl Motor {
    /// A motor at step 0 of revolution 0 at `start`, at `rate` times the nominal speed `rpm`, with `steps` per revolution.
    pub(super) fn new(start: Duration, rpm: u32, rate: f64, steps: u32) -> Self {
        let now = SpeedSegment {
            first: 0,
            start,
            period_ps: period_ps(rpm, rate),
        };
        Self {
            now,
            next: None,
            rate,
            steps: steps.max(1),
        }
    }

    fn segment(&self, revolution: u64) -> &SpeedSegment {
        match &self.next {
            Some(next) if revolution >= next.first => next,
            _ => &self.now,
        }
    }

    /// The revolution at `t`; the first one for earlier instants.
    pub(super) fn revolution_at(&self, t: Duration) -> u64 {
        let segment = match &self.next {
            Some(next) if t >= next.start => next,
            _ => &self.now,
        };
        let ps = t.saturating_sub(segment.start).as_nanos() * 1000;
        let guess = segment.first
            + u64::try_from(ps / u128::from(segment.period_ps)).unwrap_or(u64::MAX / 2);
        // Starts are truncated to nanoseconds: the next one may already have begun.
        if self.start_time(guess + 1) <= t {
            guess + 1
        } else {
            guess
        }
    }

    /// The instant of step 0.
    pub(super) fn start_time(&self, revolution: u64) -> Duration {
        self.segment(revolution).start_time(revolution)
    }

    pub(super) fn period_of(&self, revolution: u64) -> Duration {
        picoseconds(u128::from(self.segment(revolution).period_ps))
    }

    pub(super) fn step_time(&self, revolution: u64, step: u64) -> Duration {
        let segment = self.segment(revolution);
        let part = u128::from(segment.period_ps) * u128::from(step) / u128::from(self.steps);
        segment.start_time(revolution) + picoseconds(part)
    }

    /// The first command tick after `t`.
    pub(super) fn tick_after(&self, t: Duration) -> Duration {
        let revolution = self.revolution_at(t);
        let tick = self.tick_time(revolution);
        if tick > t {
            tick
        } else {
            self.tick_time(revolution + 1)
        }
    }

    fn tick_time(&self, revolution: u64) -> Duration {
        let segment = self.segment(revolution);
        segment.start_time(revolution)
            + picoseconds(u128::from(segment.period_ps) * u128::from(TICK_PERMILLE) / 1000)
    }

    /// From the next revolution on.
    pub(super) fn set_speed(&mut self, rpm: u32, now: Duration) {
        let first = self.revolution_at(now) + 1;
        let start = self.start_time(first);
        if let Some(next) = self.next.filter(|next| now >= next.start) {
            self.now = next;
        }
        self.next = Some(SpeedSegment {
            first,
            start,
            period_ps: period_ps(rpm, self.rate),
        });
    }
}

fn period_ps(rpm: u32, rate: f64) -> u64 {
    ((60e12 / f64::from(rpm.max(1)) / rate).round() as u64).max(1)
}

fn picoseconds(ps: u128) -> Duration {
    Duration::from_nanos(u64::try_from(ps / 1000).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn constant_speed() {
        let motor = Motor::new(7 * MS, 600, 1.0, 1024);
        assert_eq!(motor.revolution_at(Duration::ZERO), 0);
        assert_eq!(motor.revolution_at(106 * MS), 0);
        assert_eq!(motor.revolution_at(107 * MS), 1);
        assert_eq!(motor.start_time(3), 307 * MS);
        assert_eq!(motor.step_time(3, 768), 382 * MS);
        assert_eq!(motor.tick_after(100 * MS), 101 * MS);
        assert_eq!(motor.tick_after(101 * MS), 201 * MS);
    }

    #[test]
    fn a_new_speed_begins_with_the_next_revolution() {
        let mut motor = Motor::new(Duration::ZERO, 600, 1.0, 1024);
        motor.set_speed(540, 194 * MS);
        assert_eq!(motor.start_time(2), 200 * MS);
        assert_eq!(motor.period_of(1), 100 * MS);
        assert_eq!(motor.period_of(2).as_nanos(), 111_111_111);
        motor.set_speed(600, 250 * MS);
        assert_eq!(motor.period_of(2).as_nanos(), 111_111_111);
        assert_eq!(motor.start_time(3).as_nanos(), 311_111_111);
        assert_eq!(motor.revolution_at(motor.start_time(4)), 4);
        assert_eq!((motor.start_time(5) - motor.start_time(4)), 100 * MS);
    }

    #[test]
    fn starts_and_indices_agree_after_days() {
        let motor = Motor::new(Duration::ZERO, 600, 1.0013 * 1.0012, 1024);
        for revolution in [0u64, 1, 999, 864_000, 86_400_000] {
            assert_eq!(
                motor.revolution_at(motor.start_time(revolution)),
                revolution
            );
        }
    }
}
