//! The head's tilt at an instant: a line through the polls, its slope the commanded speed (sweep-geometry section 3).

use super::constants::{LEAST_POLLS, STALL_POLLS, STALL_POSITIONS};
use super::raw::Poll;

/// `tilt_steps(t) = at_zero_steps + speed_steps_s t`, valid between the two ends of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    at_zero_steps: f64,
    speed_steps_s: f64,
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

    /// Tilt in counts at a host time.
    pub fn tilt_steps(&self, host_s: f64) -> f64 {
        self.at_zero_steps + self.speed_steps_s * host_s
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
    use super::{Attitude, AttitudeError};
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

    #[test]
    fn a_head_that_never_moved_is_told() {
        let error = Attitude::fit(&polls(|_| 100.0), 97.0).expect_err("standing");
        assert_eq!(error, AttitudeError::TooFewPolls { got: 0 });
    }
}
