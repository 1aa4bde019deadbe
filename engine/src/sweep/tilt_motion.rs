//! The tilt of the moving head over time: a line through the polls, with the commanded speed as its slope
//! (sweep-geometry section 3).

use super::constants::{MIN_POLLS, STALL_COUNTS, STALL_POLLS};
use super::raw::PositionPoll;

/// `tilt_steps(t) = at_zero_steps + speed_steps_s t`, valid between the ends of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TiltMotion {
    at_zero_steps: f64,
    speed_steps_s: f64,
    first_s: f64,
    last_s: f64,
    /// Largest distance of a poll from the line beyond what its own timing explains, counts.
    pub(super) residual_steps: f64,
    /// Number of polls of the moving head.
    pub(super) polls: usize,
}

/// Why the polls give no motion.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TiltMotionError {
    /// Too few polls of a moving head.
    #[error("head answered {got} position polls while tilting, expected at least {MIN_POLLS}")]
    TooFewPolls {
        /// Number of such polls.
        got: usize,
    },
    /// The head did not follow the command.
    #[error(
        "head left the commanded motion by {by_steps:.1} counts at {at_s:.2} s: stalled, stopped or lost steps"
    )]
    Stalled {
        /// Distance from the commanded motion, counts.
        by_steps: f64,
        /// Host time, seconds.
        at_s: f64,
    },
    /// The polls do not show the head at both ends of the sweep.
    #[error(
        "polls show the head from {from_deg:.1} to {to_deg:.1} deg only, expected beyond {low_deg:.1} and {high_deg:.1} deg: it stalled, or polling stopped"
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

/// The tilts that a pan segment must cover, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TiltRange {
    /// Tilt at count 0.
    pub(super) zero_rad: f64,
    /// Signed radians per count.
    pub(super) rad_per_step: f64,
    /// Lowest tilt.
    pub(super) low_rad: f64,
    /// Highest tilt.
    pub(super) high_rad: f64,
    /// Angle between lines.
    pub(super) pitch_rad: f64,
}

impl TiltRange {
    /// How far the first or last poll may lie inside the range: one line and one count.
    fn tolerance_rad(&self) -> f64 {
        self.pitch_rad + self.rad_per_step.abs()
    }

    /// Checks that the first and the last poll lie beyond the two ends. The head is stationary at both, wherever that is: only
    /// this check distinguishes a head that arrived from one that stopped on its way.
    ///
    /// # Errors
    /// No polls, or polls that do not cover the range.
    pub(super) fn check(&self, polls: &[PositionPoll]) -> Result<(), TiltMotionError> {
        let (Some(first), Some(last)) = (polls.first(), polls.last()) else {
            return Err(TiltMotionError::TooFewPolls { got: 0 });
        };
        let tilt = |p: &PositionPoll| self.zero_rad + self.rad_per_step * f64::from(p.tilt_steps);
        let (from, to) = (tilt(first), tilt(last));
        let tolerance = self.tolerance_rad();
        if from.min(to) <= self.low_rad + tolerance && from.max(to) >= self.high_rad - tolerance {
            return Ok(());
        }
        Err(TiltMotionError::NotCovered {
            from_deg: from.to_degrees(),
            to_deg: to.to_degrees(),
            low_deg: self.low_rad.to_degrees(),
            high_deg: self.high_rad.to_degrees(),
        })
    }

    /// Duration, seconds, of the motion over the tolerance of [`check`](Self::check).
    pub(super) fn tolerance_s(&self, motion: &TiltMotion) -> f64 {
        self.tolerance_rad() / (motion.speed_steps_s * self.rad_per_step).abs()
    }
}

impl TiltMotion {
    /// Fits the line. Polls of the stationary head at both ends are left out.
    ///
    /// # Errors
    /// Too few polls, or three in a row off the line by more than their timing explains (a stall).
    pub(super) fn fit(polls: &[PositionPoll], speed_steps_s: f64) -> Result<Self, TiltMotionError> {
        let moving = moving_polls(polls);
        if moving.len() < MIN_POLLS {
            return Err(TiltMotionError::TooFewPolls { got: moving.len() });
        }
        // The offset comes from the faster half of the polls: slow ones are uncertain in time.
        let mut by_width: Vec<&PositionPoll> = moving.iter().collect();
        by_width.sort_by(|a, b| width_s(a).total_cmp(&width_s(b)));
        let half = by_width.len().div_ceil(2).max(MIN_POLLS);
        let mut offsets: Vec<f64> = by_width
            .iter()
            .take(half)
            .map(|p| f64::from(p.tilt_steps) - speed_steps_s * (p.sent_s + p.received_s) / 2.0)
            .collect();
        offsets.sort_by(f64::total_cmp);
        let mut fitted = Self {
            // The head reports whole counts: half a count too few in the direction of travel on average.
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
            .position(|w| w.iter().all(|r| *r > STALL_COUNTS));
        if let Some(at) = stalled {
            let by_steps = residuals[at];
            let at_s = moving[at].received_s;
            return Err(TiltMotionError::Stalled { by_steps, at_s });
        }
        fitted.residual_steps = residuals.into_iter().fold(0.0, f64::max);
        Ok(fitted)
    }

    /// Signed speed, counts per second.
    pub(super) fn speed_steps_s(&self) -> f64 {
        self.speed_steps_s
    }

    /// Tilt in counts at a host time.
    pub(super) fn tilt_steps(&self, host_s: f64) -> f64 {
        self.at_zero_steps + self.speed_steps_s * host_s
    }

    /// Whether a host time lies within the polled motion, extended by `margin_s` on both sides.
    pub(super) fn covers(&self, host_s: f64, margin_s: f64) -> bool {
        (self.first_s - margin_s..=self.last_s + margin_s).contains(&host_s)
    }

    /// Distance of a poll's count from all counts of the line between request and reply.
    fn unexplained_steps(&self, poll: &PositionPoll) -> f64 {
        let a = self.tilt_steps(poll.sent_s);
        let b = self.tilt_steps(poll.received_s);
        let count = f64::from(poll.tilt_steps);
        (count - a.max(b)).max(a.min(b) - count).max(0.0)
    }
}

/// Time between request and reply.
fn width_s(poll: &PositionPoll) -> f64 {
    poll.received_s - poll.sent_s
}

/// The polls between the last one at the starting count and the first one at the final count.
fn moving_polls(polls: &[PositionPoll]) -> &[PositionPoll] {
    let (Some(first), Some(last)) = (polls.first(), polls.last()) else {
        return &[];
    };
    let begin = polls
        .iter()
        .rposition(|p| p.tilt_steps == first.tilt_steps)
        .map_or(0, |i| i + 1);
    // A head that overshoots comes back: it has arrived where it first reaches the end.
    let upwards = last.tilt_steps >= first.tilt_steps;
    let has_arrived = |p: &PositionPoll| {
        if upwards {
            p.tilt_steps >= last.tilt_steps
        } else {
            p.tilt_steps <= last.tilt_steps
        }
    };
    let end = polls.iter().position(has_arrived).unwrap_or(polls.len());
    polls.get(begin..end).unwrap_or(&[])
}

#[cfg(test)]
mod tests {
    use super::{TiltMotion, TiltMotionError, TiltRange};
    use crate::sweep::PositionPoll;

    /// 60 polls a second of a head that leaves count 100 at 1 s with 97 counts a second.
    fn polls(count: impl Fn(f64) -> f64) -> Vec<PositionPoll> {
        (0..720)
            .map(|i| {
                let at_s = f64::from(i) / 60.0;
                let late_s = if i % 20 == 0 { 0.012 } else { 0.002 };
                PositionPoll {
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

    /// 30 counts over the end within a tenth of a second, and back.
    #[test]
    fn a_head_that_overshoots_the_end_has_followed_the_motion() {
        let end_s = 1.0 + 900.0 / 97.0;
        let overshoot = |at_s: f64| (30.0 - 300.0 * (at_s - end_s - 0.1).abs()).max(0.0);
        for sign in [1.0, -1.0] {
            let counts = |at_s: f64| sign * (sweep(at_s) + overshoot(at_s));
            let motion = TiltMotion::fit(&polls(counts), sign * 97.0).expect("a motion");
            assert!((motion.speed_steps_s - sign * 97.0).abs() < 1e-9);
            assert!(motion.residual_steps < 1.5, "{motion:?}");
        }
    }

    #[test]
    fn the_motion_is_found_despite_delays_and_rounding() {
        let fitted = TiltMotion::fit(&polls(sweep), 97.0).expect("fits");
        // Rounding down costs half a position on average.
        let error = fitted.tilt_steps(5.0) + 0.5 - sweep(5.0);
        assert!(error.abs() < 0.15, "{error}");
        assert!(fitted.residual_steps < 1.5, "{}", fitted.residual_steps);
    }

    #[test]
    fn a_stall_is_detected() {
        let stuck = |at_s: f64| {
            if at_s < 6.0 {
                sweep(at_s)
            } else {
                sweep(6.0) + 0.3 * (at_s - 6.0)
            }
        };
        let error = TiltMotion::fit(&polls(stuck), 97.0).expect_err("stalled");
        assert!(matches!(error, TiltMotionError::Stalled { .. }), "{error}");
    }

    /// Counts 150 to 950 at a milliradian each, lines ten counts apart.
    const RANGE: TiltRange = TiltRange {
        zero_rad: 0.0,
        rad_per_step: 1e-3,
        low_rad: 0.15,
        high_rad: 0.95,
        pitch_rad: 0.01,
    };

    #[test]
    fn a_head_that_stops_does_not_cover_the_sweep() {
        // All its stalled polls are at the final count, so the line fits.
        let stopped = polls(|at_s| sweep(at_s.min(6.0)));
        assert!(TiltMotion::fit(&stopped, 97.0).is_ok());
        let error = RANGE.check(&stopped).expect_err("stopped");
        assert!(
            matches!(error, TiltMotionError::NotCovered { .. }),
            "{error}"
        );
        let mut late = polls(sweep);
        assert_eq!(RANGE.check(&late), Ok(()));
        late.drain(..240);
        assert!(RANGE.check(&late).is_err(), "polls began late");
        let mut early = polls(sweep);
        early.truncate(360);
        assert!(RANGE.check(&early).is_err(), "polls ended early");
        assert!(RANGE.check(&[]).is_err());
    }

    #[test]
    fn only_the_motion_is_covered() {
        let fitted = TiltMotion::fit(&polls(sweep), 97.0).expect("fits");
        let margin_s = RANGE.tolerance_s(&fitted);
        assert!((margin_s - 0.011 / 0.097).abs() < 1e-12);
        let at = [0.7, 1.0, 5.0, 10.3, 10.6];
        let covered = at.map(|at_s| fitted.covers(at_s, margin_s));
        assert_eq!(covered, [false, true, true, true, false]);
    }

    #[test]
    fn a_head_that_never_moved_is_an_error() {
        let error = TiltMotion::fit(&polls(|_| 100.0), 97.0).expect_err("standing");
        assert_eq!(error, TiltMotionError::TooFewPolls { got: 0 });
    }
}
