//! The clock of all time limits and waits: real time, or scaled for the demo and the tests.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Longest single sleep, wall time; a changed scale takes effect after it.
const MAX_SLEEP: Duration = Duration::from_millis(50);

/// How far a paced clock runs past the last mark of a pacer, wall time. Chosen: at twice real time a fifth of a scan of the laser.
const PACER_LEAD: Duration = Duration::from_millis(10);

/// Longest wait of a pacer, wall time: three fit into the lead.
const PACER_WAIT: Duration = Duration::from_millis(3);

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
    /// Virtual instant of the last mark of each pacer, by number.
    marks: BTreeMap<u64, Duration>,
    pacers_begun: u64,
    is_paced: bool,
}

impl ClockState {
    fn new(wall: Instant, scale: f64, is_paced: bool) -> Self {
        Self {
            wall,
            virtual_at_wall: Duration::ZERO,
            scale: clamp_scale(scale),
            marks: BTreeMap::new(),
            pacers_begun: 0,
            is_paced,
        }
    }

    /// The time at `wall`, no further than the pacers let it run. What they held back is lost, and not caught up.
    fn run_to(&mut self, wall: Instant) -> Duration {
        let first_mark = self.marks.values().min().filter(|_| self.is_paced);
        let limit = first_mark.map(|mark| *mark + scaled(PACER_LEAD, self.scale));
        let at = self.at(wall);
        let held_at = limit.map_or(at, |limit| at.min(limit.max(self.virtual_at_wall)));
        (self.wall, self.virtual_at_wall) = (wall, held_at);
        held_at
    }

    fn at(&self, wall: Instant) -> Duration {
        let elapsed = wall.saturating_duration_since(self.wall);
        self.virtual_at_wall + scaled(elapsed, self.scale)
    }

    fn set_scale(&mut self, wall: Instant, scale: f64) {
        self.run_to(wall);
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
        Self::from_state(ClockState::new(Instant::now(), scale, false))
    }

    /// As [`scaled`](Self::scaled), but it stops while a [`Pacer`] is late, so that a loaded machine delays emulated devices and their
    /// host alike.
    pub fn paced(scale: f64) -> Self {
        Self::from_state(ClockState::new(Instant::now(), scale, true))
    }

    fn from_state(state: ClockState) -> Self {
        Self(Arc::new(Mutex::new(state)))
    }

    fn state(&self) -> MutexGuard<'_, ClockState> {
        // No code panics while it holds the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time since the clock was created.
    pub fn now(&self) -> Duration {
        let mut state = self.state();
        // Read under the lock: instants are in the order of the calls.
        state.run_to(Instant::now())
    }

    /// Lets the caller pace this clock, if it is a paced one, until the pacer is dropped.
    pub fn pacer(&self) -> Pacer {
        let mark = self.now();
        let mut state = self.state();
        let number = state.pacers_begun;
        state.pacers_begun += 1;
        state.marks.insert(number, mark);
        drop(state);
        Pacer {
            clock: self.clone(),
            number,
        }
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

/// One that a paced clock waits for.
#[derive(Debug)]
pub struct Pacer {
    clock: Clock,
    number: u64,
}

impl Pacer {
    /// Everything up to now is done. To be called whenever [`max_wait`](Self::max_wait) is over, or the clock runs slower.
    pub fn mark(&self) {
        let now = self.clock.now();
        self.clock.state().marks.insert(self.number, now);
    }

    /// How long to wait at most before the next mark, wall time.
    pub fn max_wait(&self) -> Duration {
        if self.clock.state().is_paced {
            PACER_WAIT
        } else {
            Duration::MAX
        }
    }
}

impl Drop for Pacer {
    fn drop(&mut self) {
        self.clock.state().marks.remove(&self.number);
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
    use super::{Clock, ClockState, MAX_SCALE, MIN_SCALE, PACER_LEAD};
    use std::collections::BTreeMap;
    use std::time::{Duration, Instant};

    #[test]
    fn a_second_of_the_wall_is_twenty_at_scale_twenty() {
        let wall = Instant::now();
        let mut state = ClockState::new(wall, 20.0, false);
        state.virtual_at_wall = Duration::from_secs(3);
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
        let mut state = ClockState::new(wall, 20.0, false);
        let second = |n| wall + Duration::from_secs(n);
        state.set_scale(second(3), 2.0);
        assert_eq!(state.scale, 2.0);
        assert_eq!(state.at(second(3)), Duration::from_secs(60), "no jump");
        assert_eq!(state.at(second(10)), Duration::from_secs(74));
        state.set_scale(second(10), 0.5);
        assert_eq!(state.at(second(14)), Duration::from_secs(76));
    }

    #[test]
    fn a_paced_clock_runs_no_further_than_its_pacers_let_it_and_catches_nothing_up() {
        let wall = Instant::now();
        let at = |ms: u64| wall + Duration::from_millis(ms);
        let ms = Duration::from_millis;
        let mut state = ClockState::new(wall, 2.0, true);
        assert_eq!(state.run_to(at(100)), ms(200), "nobody paces it");
        state.marks = BTreeMap::from([(0, ms(200)), (1, ms(204))]);
        assert_eq!(state.run_to(at(105)), ms(210));
        assert_eq!(state.run_to(at(1000)), ms(220), "10 ms of the wall later");
        state.marks.insert(0, ms(220));
        assert_eq!(state.run_to(at(1001)), ms(222));
        assert_eq!(state.run_to(at(2000)), ms(224), "the other one");
        state.marks.remove(&1);
        assert_eq!(state.run_to(at(2003)), ms(230));
        // A slower clock has a shorter lead: the time stands, and does not go back.
        state.set_scale(at(2003), 0.1);
        assert_eq!(state.run_to(at(2010)), ms(230));
        state.marks.insert(0, ms(230));
        assert_eq!(state.run_to(at(2020)), ms(231));
        // Another clock takes no notice.
        let mut free = ClockState::new(wall, 2.0, false);
        free.marks = BTreeMap::from([(0, Duration::ZERO)]);
        assert_eq!(free.run_to(at(1000)), ms(2000));
    }

    #[test]
    fn a_pacer_holds_its_clock_until_it_marks_or_ends() {
        let clock = Clock::paced(1000.0);
        let pacer = clock.pacer();
        let begun = clock.now();
        std::thread::sleep(Duration::from_millis(60));
        let held = clock.now();
        assert!(held <= begun + Duration::from_secs(10), "{held:?}");
        pacer.mark();
        std::thread::sleep(Duration::from_millis(5));
        let marked = clock.now();
        assert!(marked > held, "{marked:?}");
        assert!(pacer.max_wait() < PACER_LEAD);
        drop(pacer);
        assert_eq!(Clock::real().pacer().max_wait(), Duration::MAX);
        std::thread::sleep(Duration::from_millis(15));
        assert!(clock.now() >= marked + Duration::from_secs(15));
    }

    #[test]
    fn a_sleep_does_not_end_early() {
        let clock = Clock::scaled(1000.0);
        let until = clock.now() + Duration::from_secs(1);
        clock.sleep_until(until);
        assert!(clock.now() >= until);
    }
}
