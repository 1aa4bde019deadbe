//! The clock of all time limits and waits: real time, or scaled for the demo and the tests.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest single sleep, wall time; a changed scale takes effect after it.
const MAX_SLEEP: Duration = Duration::from_millis(50);

const MIN_SCALE: f64 = 1e-3;
const MAX_SCALE: f64 = 1e3;

/// A monotonic clock of virtual time; clones share it. At scale 20 one second of wall time is twenty seconds for the drivers, the
/// emulators and every deadline.
#[derive(Debug, Clone)]
pub struct Clock(Arc<Mutex<ClockState>>);

#[derive(Debug)]
struct ClockState {
    wall: Instant,
    virtual_at_wall: Duration,
    scale: f64,
}

impl ClockState {
    fn at(&self, wall: Instant) -> Duration {
        let elapsed = wall.saturating_duration_since(self.wall);
        self.virtual_at_wall + scaled(elapsed, self.scale)
    }

    fn set_scale(&mut self, wall: Instant, scale: f64) {
        self.virtual_at_wall = self.at(wall);
        self.wall = wall;
        self.scale = clamp_scale(scale);
    }
}

fn scaled(duration: Duration, factor: f64) -> Duration {
    Duration::try_from_secs_f64(duration.as_secs_f64() * factor).unwrap_or(Duration::MAX)
}

impl Clock {
    /// A clock that runs in real time.
    pub fn real() -> Self {
        Self::scaled(1.0)
    }

    /// A clock that runs `scale` times as fast as real time; clamped to 0.001 to 1000.
    pub fn scaled(scale: f64) -> Self {
        Self(Arc::new(Mutex::new(ClockState {
            wall: Instant::now(),
            virtual_at_wall: Duration::ZERO,
            scale: clamp_scale(scale),
        })))
    }

    fn state(&self) -> MutexGuard<'_, ClockState> {
        // No code panics while it holds the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time since the clock was created.
    pub fn now(&self) -> Duration {
        let state = self.state();
        state.at(Instant::now())
    }

    /// Virtual seconds per second of wall time.
    pub fn scale(&self) -> f64 {
        self.state().scale
    }

    /// Changes the scale from now on; the time does not jump.
    pub fn set_scale(&self, scale: f64) {
        let mut state = self.state();
        // Read under the lock: instants are in the order of the changes.
        state.set_scale(Instant::now(), scale);
    }

    /// Wall time of a virtual duration at the current scale.
    pub fn wall_time(&self, duration: Duration) -> Duration {
        scaled(duration, 1.0 / self.scale())
    }

    /// Sleeps until the clock shows `instant`.
    pub fn sleep_until(&self, instant: Duration) {
        loop {
            let left = instant.saturating_sub(self.now());
            if left.is_zero() {
                return;
            }
            // At least a nanosecond, so that rounding cannot make it spin.
            thread::sleep(
                self.wall_time(left)
                    .clamp(Duration::from_nanos(1), MAX_SLEEP),
            );
        }
    }
}

fn clamp_scale(scale: f64) -> f64 {
    if scale.is_finite() {
        scale.clamp(MIN_SCALE, MAX_SCALE)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::{Clock, ClockState, MAX_SCALE, MIN_SCALE};
    use std::time::{Duration, Instant};

    #[test]
    fn a_second_of_the_wall_is_twenty_at_scale_twenty() {
        let wall = Instant::now();
        let state = ClockState {
            wall,
            virtual_at_wall: Duration::from_secs(3),
            scale: 20.0,
        };
        assert_eq!(
            state.at(wall + Duration::from_secs(1)),
            Duration::from_secs(23)
        );
        assert_eq!(state.at(wall), Duration::from_secs(3));
    }

    #[test]
    fn a_changed_scale_makes_no_jump_and_time_never_goes_back() {
        let clock = Clock::scaled(1000.0);
        let mut last = clock.now();
        for (scale, in_force) in [
            (0.0, MIN_SCALE),
            (2e-3, 2e-3),
            (50.0, 50.0),
            (f64::NAN, 1.0),
            (1e9, MAX_SCALE),
        ] {
            clock.set_scale(scale);
            assert_eq!(clock.scale(), in_force, "{scale}");
            let now = clock.now();
            assert!(now >= last, "{now:?} after {last:?}");
            last = now;
        }
        assert_eq!(clock.scale(), 1000.0);
        assert_eq!(
            clock.wall_time(Duration::from_secs(1)),
            Duration::from_millis(1)
        );
    }

    #[test]
    fn a_scale_counts_from_its_change_on() {
        let wall = Instant::now();
        let mut state = ClockState {
            wall,
            virtual_at_wall: Duration::ZERO,
            scale: 20.0,
        };
        let second = |n| wall + Duration::from_secs(n);
        state.set_scale(second(3), 2.0);
        assert_eq!(state.scale, 2.0);
        assert_eq!(state.at(second(3)), Duration::from_secs(60), "no jump");
        assert_eq!(state.at(second(10)), Duration::from_secs(74));
        state.set_scale(second(10), 0.5);
        assert_eq!(state.at(second(14)), Duration::from_secs(76));
    }

    #[test]
    fn a_sleep_does_not_end_early() {
        let clock = Clock::scaled(1000.0);
        let until = clock.now() + Duration::from_secs(1);
        clock.sleep_until(until);
        assert!(clock.now() >= until);
    }
}
