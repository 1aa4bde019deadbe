//! The one clock of everything that waits: real, or scaled for the demo and the tests.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest piece of one sleep, wall time: within it a changed scale is noticed.
const SLEEP_PIECE: Duration = Duration::from_millis(50);

/// Slowest and fastest scale.
const SCALES: (f64, f64) = (1e-3, 1e3);

/// Virtual time since the clock was made. Monotonic; copies share it. At scale 20 one second of wall time is twenty
/// seconds for the devices, the twins and every deadline.
#[derive(Debug, Clone)]
pub struct Clock(Arc<Mutex<Pace>>);

#[derive(Debug)]
struct Pace {
    wall: Instant,
    virtual_then: Duration,
    scale: f64,
}

impl Pace {
    fn at(&self, wall: Instant) -> Duration {
        let passed = wall.saturating_duration_since(self.wall);
        self.virtual_then + scaled(passed, self.scale)
    }
}

fn scaled(duration: Duration, factor: f64) -> Duration {
    Duration::try_from_secs_f64(duration.as_secs_f64() * factor).unwrap_or(Duration::MAX)
}

impl Clock {
    /// A clock that runs as the wall's.
    pub fn real() -> Self {
        Self::scaled(1.0)
    }

    /// A clock that runs `scale` times as fast as the wall's; kept between 0.001 and 1000.
    pub fn scaled(scale: f64) -> Self {
        Self(Arc::new(Mutex::new(Pace {
            wall: Instant::now(),
            virtual_then: Duration::ZERO,
            scale: bounded(scale),
        })))
    }

    fn pace(&self) -> MutexGuard<'_, Pace> {
        // Nothing panics while it holds this.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time since the clock was made.
    pub fn now(&self) -> Duration {
        let pace = self.pace();
        pace.at(Instant::now())
    }

    /// Virtual seconds per second of wall time.
    pub fn scale(&self) -> f64 {
        self.pace().scale
    }

    /// Runs at another pace from now on; the time itself does not jump.
    pub fn set_scale(&self, scale: f64) {
        let mut pace = self.pace();
        let wall = Instant::now();
        pace.virtual_then = pace.at(wall);
        pace.wall = wall;
        pace.scale = bounded(scale);
    }

    /// Wall time that a virtual duration takes at the present pace.
    pub fn wall(&self, duration: Duration) -> Duration {
        scaled(duration, 1.0 / self.scale())
    }

    /// Sleeps until the clock shows `instant`.
    pub fn sleep_until(&self, instant: Duration) {
        loop {
            let left = instant.saturating_sub(self.now());
            if left.is_zero() {
                return;
            }
            // At least a nanosecond, so that rounding cannot spin for ever.
            thread::sleep(self.wall(left).clamp(Duration::from_nanos(1), SLEEP_PIECE));
        }
    }
}

fn bounded(scale: f64) -> f64 {
    if scale.is_finite() {
        scale.clamp(SCALES.0, SCALES.1)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::{Clock, Pace};
    use std::time::{Duration, Instant};

    #[test]
    fn a_second_of_the_wall_is_twenty_at_scale_twenty() {
        let wall = Instant::now();
        let pace = Pace {
            wall,
            virtual_then: Duration::from_secs(3),
            scale: 20.0,
        };
        assert_eq!(
            pace.at(wall + Duration::from_secs(1)),
            Duration::from_secs(23)
        );
        assert_eq!(pace.at(wall), Duration::from_secs(3));
    }

    #[test]
    fn a_changed_scale_makes_no_jump_and_time_never_goes_back() {
        let clock = Clock::scaled(1000.0);
        let mut last = clock.now();
        for scale in [0.0, 1e-3, 50.0, f64::NAN, 1e9] {
            clock.set_scale(scale);
            let now = clock.now();
            assert!(now >= last, "{now:?} after {last:?}");
            last = now;
        }
        assert_eq!(clock.scale(), 1000.0);
        assert_eq!(clock.wall(Duration::from_secs(1)), Duration::from_millis(1));
    }

    #[test]
    fn sleeping_ends_no_earlier_than_told() {
        let clock = Clock::scaled(1000.0);
        let until = clock.now() + Duration::from_secs(1);
        clock.sleep_until(until);
        assert!(clock.now() >= until);
    }
}
