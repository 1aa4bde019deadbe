//! How long a move takes, and monitoring of a move by polled positions.

use std::time::Duration;

use crate::constants::{ARRIVAL_POLLS, OVERDUE_MARGIN, STALL_AFTER};

/// What shapes a move: at or below the base speed there is no ramp (ptu-d46 section 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MotionProfile {
    /// Set speed, counts per second.
    pub speed: i32,
    /// Base (start-up) speed, counts per second.
    pub base_speed: i32,
    /// Acceleration above the base speed, counts per second squared.
    pub acceleration: i32,
}

impl MotionProfile {
    /// Duration of a move from rest to rest over `distance_steps`: the closed form of ptu-d46 section 9. A profile that cannot move (speed or,
    /// where a ramp is needed, acceleration not positive) takes [`Duration::MAX`].
    #[must_use]
    pub fn travel_time(&self, distance_steps: i64) -> Duration {
        let distance = distance_steps.unsigned_abs() as f64;
        if distance == 0.0 {
            return Duration::ZERO;
        }
        let speed = f64::from(self.speed);
        if self.speed <= 0 || (self.has_ramp() && self.acceleration <= 0) {
            return Duration::MAX;
        }
        let seconds = if self.has_ramp() {
            let (base, acceleration) = (
                f64::from(self.base_speed.max(0)),
                f64::from(self.acceleration),
            );
            let ramps = 2.0 * self.ramp_steps();
            if distance >= ramps {
                2.0 * (speed - base) / acceleration + (distance - ramps) / speed
            } else {
                let peak = (base * base + acceleration * distance).sqrt();
                2.0 * (peak - base) / acceleration
            }
        } else {
            distance / speed
        };
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
    }

    /// Counts covered by one ramp between base speed and set speed; 0 without a ramp. A sweep starts this far before its first
    /// line (sweep-geometry section 3).
    #[must_use]
    pub fn ramp_steps(&self) -> f64 {
        if !self.has_ramp() || self.acceleration <= 0 {
            return 0.0;
        }
        let (speed, base) = (f64::from(self.speed), f64::from(self.base_speed.max(0)));
        (speed * speed - base * base) / (2.0 * f64::from(self.acceleration))
    }

    const fn has_ramp(&self) -> bool {
        self.speed > self.base_speed
    }
}

/// State of a move, from its polled positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MoveState {
    /// Not yet at the target.
    Moving,
    /// At rest at the target.
    Arrived,
    /// Away from the target without a change of position for a second: blocked, halted or never started.
    Stalled,
    /// The expected travel time and its margin have passed.
    Overdue,
}

/// Monitors one move by its polled positions. Pure: no clock, no dialogue.
#[derive(Debug, Clone)]
pub struct MoveWatch {
    target_steps: i32,
    overdue_at: Duration,
    last_change_at: Duration,
    last_steps: Option<i32>,
    polls_at_target: u32,
}

impl MoveWatch {
    /// Monitors a move to `target_steps`, accepted at `started_at` and expected to take `expected`
    /// ([`MotionProfile::travel_time`]).
    #[must_use]
    pub fn new(target_steps: i32, started_at: Duration, expected: Duration) -> Self {
        let overdue_at = started_at
            .saturating_add(expected)
            .saturating_add(OVERDUE_MARGIN);
        Self {
            target_steps,
            overdue_at,
            last_change_at: started_at,
            last_steps: None,
            polls_at_target: 0,
        }
    }

    /// When the move counts as overdue.
    #[must_use]
    pub const fn overdue_at(&self) -> Duration {
        self.overdue_at
    }

    /// Takes a polled position. Arrived means equal to the target in three polls in a row (ptu-d46 section 11, step 6).
    pub fn observe(&mut self, steps: i32, at: Duration) -> MoveState {
        if self.last_steps != Some(steps) {
            self.last_steps = Some(steps);
            self.last_change_at = self.last_change_at.max(at);
        }
        if steps == self.target_steps {
            self.polls_at_target = self.polls_at_target.saturating_add(1);
            return if self.polls_at_target >= ARRIVAL_POLLS {
                MoveState::Arrived
            } else {
                MoveState::Moving
            };
        }
        self.polls_at_target = 0;
        self.state_at(at)
    }

    /// The state by the clock alone, for when no position comes.
    fn state_at(&self, now: Duration) -> MoveState {
        if now >= self.overdue_at {
            MoveState::Overdue
        } else if now.saturating_sub(self.last_change_at) >= STALL_AFTER
            && self.polls_at_target == 0
        {
            MoveState::Stalled
        } else {
            MoveState::Moving
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{prop_assert, proptest};

    fn ms(value: u64) -> Duration {
        Duration::from_millis(value)
    }

    #[test]
    fn travel_time_of_the_documents_example() {
        let profile = MotionProfile {
            speed: 1900,
            base_speed: 1000,
            acceleration: 2000,
        };
        assert!((profile.travel_time(2600).as_secs_f64() - 1.58).abs() < 0.005);
        assert_eq!(profile.travel_time(-2600), profile.travel_time(2600));
    }

    #[test]
    fn below_base_speed_there_is_no_ramp() {
        let profile = MotionProfile {
            speed: 97,
            base_speed: 1000,
            acceleration: 2000,
        };
        assert_eq!(profile.travel_time(970), Duration::from_secs(10));
        assert_eq!(profile.travel_time(0), Duration::ZERO);
        assert!(profile.ramp_steps().abs() < f64::EPSILON);
        assert_eq!(
            MotionProfile {
                speed: 0,
                ..profile
            }
            .travel_time(1),
            Duration::MAX
        );
    }

    proptest! {
        /// The closed form against the motion itself, integrated in small steps.
        #[test]
        fn the_closed_form_agrees_with_the_integrated_ramp(
            speed in 100i32..3000, base_speed in 50i32..1500, acceleration in 200i32..5000, distance in 1i64..4000,
        ) {
            let profile = MotionProfile { speed, base_speed, acceleration };
            let (s, b, a) = (f64::from(speed), f64::from(base_speed), f64::from(acceleration));
            let (dt, mut x, mut v, mut t) = (1e-5, 0.0, s.min(b), 0.0);
            // Up to the middle; the second half mirrors it.
            while x < distance as f64 / 2.0 {
                x += v * dt;
                v = if s > b { (v + a * dt).min(s) } else { s };
                t += dt;
            }
            prop_assert!((2.0 * t - profile.travel_time(distance).as_secs_f64()).abs() < 1e-3);
        }
    }

    #[test]
    fn an_arrival_needs_three_equal_polls() {
        let mut watch = MoveWatch::new(100, ms(0), ms(1000));
        assert_eq!(watch.observe(99, ms(900)), MoveState::Moving);
        assert_eq!(watch.observe(100, ms(915)), MoveState::Moving);
        assert_eq!(
            watch.observe(101, ms(930)),
            MoveState::Moving,
            "it only passed"
        );
        for (at, state) in [
            (945, MoveState::Moving),
            (960, MoveState::Moving),
            (975, MoveState::Arrived),
        ] {
            assert_eq!(watch.observe(100, ms(at)), state);
        }
    }

    #[test]
    fn no_change_is_a_stall_and_too_long_is_overdue() {
        let mut watch = MoveWatch::new(1000, ms(0), ms(10_000));
        assert_eq!(watch.observe(10, ms(500)), MoveState::Moving);
        assert_eq!(watch.observe(10, ms(1400)), MoveState::Moving);
        assert_eq!(watch.observe(10, ms(1500)), MoveState::Stalled);
        assert_eq!(watch.observe(11, ms(1600)), MoveState::Moving);
        assert_eq!(watch.state_at(ms(11_000)), MoveState::Overdue);
        let mut crawling = MoveWatch::new(1000, ms(0), ms(500));
        assert_eq!(crawling.observe(10, ms(1600)), MoveState::Overdue);
    }
}
