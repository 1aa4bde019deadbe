//! The head's tilt at an instant: a line through the polls, its slope the commanded speed (sweep-geometry section 3).

use super::constants::{LEAST_POLLS, STALL_POLLS, STALL_POSITIONS};
use super::raw::Poll;

/// `tilt_steps(t) = at_zero_steps + speed_steps_s t`, valid between the two ends of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    at_zero_steps: f64,
    speed_steps_s: f64,
    first_s: f64,
    last_s: f64,
    /// Largest distance of a poll from the line that its own timing does not explain, counts.
    pub residual_steps: f64,
    /// Polls of the moving head behind the line.
    pub polls: usize,
}

/// Why the polls give no attitude.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum AttitudeError {
    /// Too few polls of a moving head.
    #[error("head answered {got} position polls while tilting, expected at least {LEAST_POLLS}")]
    TooFewPolls {
        /// How many there were.
        got: usize,
    },
    /// The head did not follow the command.
    #[error(
        "head left the commanded motion by {by_steps:.1} positions at {at_s:.2} s: stalled, stopped or lost steps"
    )]
    Stalled {
        /// By how much.
        by_steps: f64,
        /// When, host seconds.
        at_s: f64,
    },
    /// The positions asked for do not show the head at both ends of the sweep.
    #[error(
        "head was seen going from {from_deg:.1} to {to_deg:.1} deg only, expected beyond {low_deg:.1} and {high_deg:.1} deg: stalled, or no longer asked"
    )]
    NotCovered {
        /// Tilt at the first poll, degrees.
        from_deg: f64,
        /// Tilt at the last poll, degrees.
        to_deg: f64,
        /// Lowest tilt of the sweep, degrees.
        low_deg: f64,
        /// Highest tilt of the sweep, degrees.
        high_deg: f64,
    },
}

/// The tilts that a leg must have gone through, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Tilt at count 0.
    pub zero_rad: f64,
    /// Signed radians per count.
    pub rad_per_step: f64,
    /// Lowest tilt.
    pub low_rad: f64,
    /// Highest tilt.
    pub high_rad: f64,
    /// Pitch of the lines.
    pub pitch_rad: f64,
}

impl Wanted {
    /// One line and one position: as far as a head may be seen short of an end that it passed.
    fn allowed_rad(&self) -> f64 {
        self.pitch_rad + self.rad_per_step.abs()
    }

    /// Whether the first and the last poll lie beyond the two ends. The polls at either end are where the head stands,
    /// wherever that is: only this tells a head that arrived from one that stopped on its way.
    ///
    /// # Errors
    /// They do not.
    pub fn check(&self, polls: &[Poll]) -> Result<(), AttitudeError> {
        let (Some(first), Some(last)) = (polls.first(), polls.last()) else {
            return Err(AttitudeError::TooFewPolls { got: 0 });
        };
        let tilt = |p: &Poll| self.zero_rad + self.rad_per_step * f64::from(p.tilt_steps);
        let (from, to) = (tilt(first), tilt(last));
        let allowed = self.allowed_rad();
        if from.min(to) <= self.low_rad + allowed && from.max(to) >= self.high_rad - allowed {
            return Ok(());
        }
        Err(AttitudeError::NotCovered {
            from_deg: from.to_degrees(),
            to_deg: to.to_degrees(),
            low_deg: self.low_rad.to_degrees(),
            high_deg: self.high_rad.to_degrees(),
        })
    }

    /// Time in seconds that the motion takes for what [`check`](Self::check) allows.
    pub fn allowed_s(&self, attitude: &Attitude) -> f64 {
        self.allowed_rad() / (attitude.speed_steps_s * self.rad_per_step).abs()
    }
}

impl Attitude {
    /// Fits the line. Polls at either end, where the head still stands or stands again, are left out.
    ///
    /// # Errors
    /// Too few polls, or three in a row off the line by more than their timing explains.
    pub fn fit(polls: &[Poll], speed_steps_s: f64) -> Result<Self, AttitudeError> {
        let moving = moving_polls(polls);
        if moving.len() < LEAST_POLLS {
            return Err(AttitudeError::TooFewPolls { got: moving.len() });
        }
        // The tightest half carries the offset: a poll that waited for the scheduler says little about when.
        let mut by_width: Vec<&Poll> = moving.iter().collect();
        by_width.sort_by(|a, b| width_s(a).total_cmp(&width_s(b)));
        let half = by_width.len().div_ceil(2).max(LEAST_POLLS);
        let mut offsets: Vec<f64> = by_width
            .iter()
            .take(half)
            .map(|p| f64::from(p.tilt_steps) - speed_steps_s * (p.sent_s + p.received_s) / 2.0)
            .collect();
        offsets.sort_by(f64::total_cmp);
        let mut fitted = Self {
            // The head reports whole positions, rounded down in its direction of travel on average by a half.
            at_zero_steps: offsets[offsets.len() / 2],
            speed_steps_s,
            first_s: moving[0].sent_s,
            last_s: moving[moving.len() - 1].received_s,
            residual_steps: 0.0,
            polls: moving.len(),
        };
        let residuals: Vec<f64> = moving.iter().map(|p| fitted.unexplained_steps(p)).collect();
        let stalled = residuals
            .windows(STALL_POLLS)
            .position(|w| w.iter().all(|r| *r > STALL_POSITIONS));
        if let Some(at) = stalled {
            let by_steps = residuals[at];
            let at_s = moving[at].received_s;
            return Err(AttitudeError::Stalled { by_steps, at_s });
        }
        fitted.residual_steps = residuals.into_iter().fold(0.0, f64::max);
        Ok(fitted)
    }

    /// Signed speed, counts per second.
    pub fn speed_steps_s(&self) -> f64 {
        self.speed_steps_s
    }

    /// Tilt in counts at a host time.
    pub fn tilt_steps(&self, host_s: f64) -> f64 {
        self.at_zero_steps + self.speed_steps_s * host_s
    }

    /// Whether the head was seen moving at a host time, but for `margin_s` before and after.
    pub fn covers(&self, host_s: f64, margin_s: f64) -> bool {
        (self.first_s - margin_s..=self.last_s + margin_s).contains(&host_s)
    }

    /// Distance of a poll's count from everything the line passes between its two instants.
    fn unexplained_steps(&self, poll: &Poll) -> f64 {
        let a = self.tilt_steps(poll.sent_s);
        let b = self.tilt_steps(poll.received_s);
        let count = f64::from(poll.tilt_steps);
        (count - a.max(b)).max(a.min(b) - count).max(0.0)
    }
}

fn width_s(poll: &Poll) -> f64 {
    poll.received_s - poll.sent_s
}

/// The polls between the last one at the starting count and the first one at the final count.
fn moving_polls(polls: &[Poll]) -> &[Poll] {
    let (Some(first), Some(last)) = (polls.first(), polls.last()) else {
        return &[];
    };
    let begin = polls
        .iter()
        .rposition(|p| p.tilt_steps == first.tilt_steps)
        .map_or(0, |i| i + 1);
    let end = polls
        .iter()
        .position(|p| p.tilt_steps == last.tilt_steps)
        .unwrap_or(polls.len());
    polls.get(begin..end).unwrap_or(&[])
}

#[cfg(test)]
mod tests {
    use super::{Attitude, AttitudeError, Wanted};
    use crate::sweep::Poll;

    /// 60 polls a second of a head that leaves count 100 at 1 s with 97 counts a second.
    fn polls(count: impl Fn(f64) -> f64) -> Vec<Poll> {
        (0..720)
            .map(|i| {
                let at_s = f64::from(i) / 60.0;
                let late_s = if i % 20 == 0 { 0.012 } else { 0.002 };
                Poll {
                    sent_s: at_s - 0.002,
                    received_s: at_s + late_s,
                    tilt_steps: count(at_s).floor() as i32,
                }
            })
            .collect()
    }

    fn sweep(at_s: f64) -> f64 {
        (100.0 + 97.0 * (at_s - 1.0)).clamp(100.0, 1000.0)
    }

    #[test]
    fn the_line_is_found_under_spikes_and_rounding() {
        let fitted = Attitude::fit(&polls(sweep), 97.0).expect("fits");
        // Rounding down costs half a position on average.
        let error = fitted.tilt_steps(5.0) + 0.5 - sweep(5.0);
        assert!(error.abs() < 0.15, "{error}");
        assert!(fitted.residual_steps < 1.5, "{}", fitted.residual_steps);
    }

    #[test]
    fn a_stall_is_seen() {
        let stuck = |at_s: f64| {
            if at_s < 6.0 {
                sweep(at_s)
            } else {
                sweep(6.0) + 0.3 * (at_s - 6.0)
            }
        };
        let error = Attitude::fit(&polls(stuck), 97.0).expect_err("stalled");
        assert!(matches!(error, AttitudeError::Stalled { .. }), "{error}");
    }

    /// Counts 150 to 950 at a milliradian each, lines ten counts apart.
    const WANTED: Wanted = Wanted {
        zero_rad: 0.0,
        rad_per_step: 1e-3,
        low_rad: 0.15,
        high_rad: 0.95,
        pitch_rad: 0.01,
    };

    #[test]
    fn a_head_that_stops_dead_does_not_cover_the_sweep() {
        // All its stalled polls are at the final count, so the line fits.
        let dead = polls(|at_s| sweep(at_s.min(6.0)));
        assert!(Attitude::fit(&dead, 97.0).is_ok());
        let error = WANTED.check(&dead).expect_err("stopped");
        assert!(matches!(error, AttitudeError::NotCovered { .. }), "{error}");
        let mut late = polls(sweep);
        assert_eq!(WANTED.check(&late), Ok(()));
        late.drain(..240);
        assert!(WANTED.check(&late).is_err(), "polls began late");
        let mut early = polls(sweep);
        early.truncate(360);
        assert!(WANTED.check(&early).is_err(), "polls ended early");
        assert!(WANTED.check(&[]).is_err());
    }

    #[test]
    fn the_line_covers_the_motion_and_no_more() {
        let fitted = Attitude::fit(&polls(sweep), 97.0).expect("fits");
        let margin_s = WANTED.allowed_s(&fitted);
        assert!((margin_s - 0.011 / 0.097).abs() < 1e-12);
        let at = [0.7, 1.0, 5.0, 10.3, 10.6];
        let covered = at.map(|at_s| fitted.covers(at_s, margin_s));
        assert_eq!(covered, [false, true, true, true, false]);
    }

    #[test]
    fn a_head_that_never_moved_is_told() {
        let error = Attitude::fit(&polls(|_| 100.0), 97.0).expect_err("standing");
        assert_eq!(error, AttitudeError::TooFewPolls { got: 0 });
    }
}
