//! The motor: which revolution it is in, and when each began.

use std::time::Duration;

use super::Instant;
use super::constants::TICK_PERMILLE;

/// A stretch of even turning: from revolution `first` on, each takes `period_ps`.
#[derive(Debug, Clone, Copy)]
struct Turning {
    first: u64,
    start: Instant,
    period_ps: u64,
}

impl Turning {
    fn start_of(&self, revolution: u64) -> Instant {
        self.start
            + picoseconds(
                u128::from(revolution.saturating_sub(self.first)) * u128::from(self.period_ps),
            )
    }
}

/// The motor turns from power-up on, whatever the laser does (protocol section 15).
#[derive(Debug, Clone)]
pub(super) struct Motor {
    now: Turning,
    next: Option<Turning>,
    rate: f64,
    steps: u32,
}

impl Motor {
    /// A motor that passes step 0 of revolution 0 at `start`; it turns `rate` times as fast as it is told, `steps` to a
    /// revolution.
    pub(super) fn new(start: Instant, rpm: u32, rate: f64, steps: u32) -> Self {
        let now = Turning {
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

    fn turning(&self, revolution: u64) -> &Turning {
        match &self.next {
            Some(next) if revolution >= next.first => next,
            _ => &self.now,
        }
    }

    /// The revolution in which `t` lies (the first, if `t` is before it).
    pub(super) fn revolution_at(&self, t: Instant) -> u64 {
        let turning = match &self.next {
            Some(next) if t >= next.start => next,
            _ => &self.now,
        };
        let ps = t.saturating_sub(turning.start).as_nanos() * 1000;
        let guess = turning.first
            + u64::try_from(ps / u128::from(turning.period_ps)).unwrap_or(u64::MAX / 2);
        // Starts are cut to whole nanoseconds: the next one may already have begun.
        if self.start_of(guess + 1) <= t {
            guess + 1
        } else {
            guess
        }
    }

    /// The instant at which the head passes step 0 of `revolution`.
    pub(super) fn start_of(&self, revolution: u64) -> Instant {
        self.turning(revolution).start_of(revolution)
    }

    /// How long `revolution` takes.
    pub(super) fn period_of(&self, revolution: u64) -> Duration {
        picoseconds(u128::from(self.turning(revolution).period_ps))
    }

    /// The instant at which the head has passed `step` of `revolution`.
    pub(super) fn step_of(&self, revolution: u64, step: u64) -> Instant {
        let turning = self.turning(revolution);
        let part = u128::from(turning.period_ps) * u128::from(step) / u128::from(self.steps);
        turning.start_of(revolution) + picoseconds(part)
    }

    /// The first command tick after `t`.
    pub(super) fn tick_after(&self, t: Instant) -> Instant {
        let revolution = self.revolution_at(t);
        let tick = self.tick_of(revolution);
        if tick > t {
            tick
        } else {
            self.tick_of(revolution + 1)
        }
    }

    fn tick_of(&self, revolution: u64) -> Instant {
        let turning = self.turning(revolution);
        turning.start_of(revolution)
            + picoseconds(u128::from(turning.period_ps) * u128::from(TICK_PERMILLE) / 1000)
    }

    /// Turns at `rpm` from the next revolution on.
    pub(super) fn set_speed(&mut self, rpm: u32, now: Instant) {
        let first = self.revolution_at(now) + 1;
        let start = self.start_of(first);
        if let Some(next) = self.next.filter(|next| now >= next.start) {
            self.now = next;
        }
        self.next = Some(Turning {
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
    fn even_turning() {
        let motor = Motor::new(7 * MS, 600, 1.0, 1024);
        assert_eq!(motor.revolution_at(Duration::ZERO), 0);
        assert_eq!(motor.revolution_at(106 * MS), 0);
        assert_eq!(motor.revolution_at(107 * MS), 1);
        assert_eq!(motor.start_of(3), 307 * MS);
        assert_eq!(motor.step_of(3, 768), 382 * MS);
        assert_eq!(motor.tick_after(100 * MS), 101 * MS);
        assert_eq!(motor.tick_after(101 * MS), 201 * MS);
    }

    #[test]
    fn a_new_speed_begins_with_the_next_revolution() {
        let mut motor = Motor::new(Duration::ZERO, 600, 1.0, 1024);
        motor.set_speed(540, 194 * MS);
        assert_eq!(motor.start_of(2), 200 * MS);
        assert_eq!(motor.period_of(1), 100 * MS);
        assert_eq!(motor.period_of(2).as_nanos(), 111_111_111);
        motor.set_speed(600, 250 * MS);
        assert_eq!(motor.period_of(2).as_nanos(), 111_111_111);
        assert_eq!(motor.start_of(3).as_nanos(), 311_111_111);
        assert_eq!(motor.revolution_at(motor.start_of(4)), 4);
        assert_eq!((motor.start_of(5) - motor.start_of(4)), 100 * MS);
    }

    #[test]
    fn starts_and_indices_agree_after_days() {
        let motor = Motor::new(Duration::ZERO, 600, 1.0013 * 1.0012, 1024);
        for revolution in [0u64, 1, 999, 864_000, 86_400_000] {
            assert_eq!(motor.revolution_at(motor.start_of(revolution)), revolution);
        }
    }
}
