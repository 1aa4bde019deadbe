//! One axis in time: the count that the unit reports, the rotor that may have lost steps, the stops and the history.
//!
//! Counts are steps of the current step mode; true positions are half steps, whatever the mode.

use std::collections::VecDeque;
use std::time::Duration;

use super::constants::{HISTORY_TIME, MAX_HISTORY_SEGMENTS};
use super::motion_profile::{ProfileSegment, SpeedRamp, brake_distance, plan};
use super::segment::{MotionSegment, Rotor, backlash_offset, rest_segment, rotor_after};

#[derive(Debug, Clone, Copy, PartialEq)]
struct Goal {
    target: i32,
    ramp: SpeedRamp,
}

/// One axis.
#[derive(Debug)]
pub(super) struct EmulatedAxis {
    current: MotionSegment,
    planned: VecDeque<MotionSegment>,
    history: VecDeque<MotionSegment>,
    goal: Option<Goal>,
    target: i32,
    /// Mechanical stops, half steps.
    stops: (f64, f64),
    counts_per_half_step: f64,
    whole_steps: bool,
    /// The count does not advance.
    stalled: bool,
    /// The count advances, the rotor does not.
    blocked: bool,
    /// Factor on all speeds.
    speed_factor: f64,
    /// Play between rotor and head, half steps.
    backlash: f64,
    /// Direction of travel in the last segment dropped from the history: 1, -1, or 0 if it never moved.
    heading: f64,
}

impl EmulatedAxis {
    /// An axis at rest at `position` between `stops`, both in half steps.
    pub(super) fn new(position: i32, stops: (f64, f64), whole_steps: bool, now: Duration) -> Self {
        Self {
            current: rest_segment(now, f64::from(position), Rotor::Follows(0.0), 1.0),
            planned: VecDeque::new(),
            history: VecDeque::new(),
            goal: None,
            target: position,
            stops,
            counts_per_half_step: 1.0,
            whole_steps,
            stalled: false,
            blocked: false,
            speed_factor: 1.0,
            backlash: 0.0,
            heading: 0.0,
        }
    }

    /// Sets the play between rotor and head, half steps.
    pub(super) fn with_backlash(mut self, half_steps: f64) -> Self {
        self.backlash = half_steps;
        self
    }

    /// The count that the unit reports.
    pub(super) fn position(&self, now: Duration) -> i32 {
        self.current.count_at(now).round() as i32
    }

    /// Signed speed of the count, positions/s.
    pub(super) fn speed(&self, now: Duration) -> f64 {
        self.current.speed_at(now)
    }

    pub(super) fn target(&self) -> i32 {
        self.target
    }

    /// Whether a move is under way. That of a stalled axis never ends.
    pub(super) fn moving(&self) -> bool {
        self.goal.is_some()
    }

    /// When the current segment ends, unless the axis is at rest.
    pub(super) fn next_change(&self) -> Option<Duration> {
        (self.current.end != Duration::MAX).then_some(self.current.end)
    }

    pub(super) fn counts_per_half_step(&self) -> f64 {
        self.counts_per_half_step
    }

    /// The lower or upper stop, as a true count.
    pub(super) fn stop_count(&self, upper: bool) -> i32 {
        let stop = if upper { self.stops.1 } else { self.stops.0 };
        (stop * self.counts_per_half_step).round() as i32
    }

    /// Moves to `target`, whatever the axis is doing.
    pub(super) fn drive(&mut self, now: Duration, target: i32, ramp: SpeedRamp) {
        self.target = target;
        self.goal = Some(Goal { target, ramp });
        self.replan(now);
    }

    /// Decelerates to a stop as soon as the ramp allows; the stop becomes the target (ptu-d46 section 9, `H`).
    pub(super) fn halt(&mut self, now: Duration) {
        let Some(goal) = self.goal else { return };
        let (p, v) = (self.current.count_at(now), self.current.speed_at(now));
        let scaled = self.scaled(goal.ramp);
        let brake = brake_distance(v, &scaled);
        if brake > 0.0 {
            let end = p + v.signum() * brake;
            let end = if v > 0.0 {
                (end - 1e-6).ceil()
            } else {
                (end + 1e-6).floor()
            };
            let speed = v.abs() / self.speed_factor;
            self.drive(now, end as i32, SpeedRamp { speed, ..goal.ramp });
        } else {
            self.stop_at_once(now);
        }
    }

    /// Ends the motion at the current count.
    pub(super) fn stop_at_once(&mut self, now: Duration) {
        self.split_current(now);
        self.planned.clear();
        self.goal = None;
        let p = self.current.p0.round();
        self.target = p as i32;
        self.current = rest_segment(now, p, self.current.rotor, self.counts_per_half_step);
    }

    /// Loses `steps` counts: the rotor jumps (as far as a stop at most), the count does not.
    pub(super) fn lose_steps(&mut self, now: Duration, steps: i32) {
        self.split_current(now);
        let (low, high) = (
            f64::from(self.stop_count(false)),
            f64::from(self.stop_count(true)),
        );
        let count = self.current.p0.round();
        if let Rotor::Follows(lost) = &mut self.current.rotor {
            *lost = (count + *lost + f64::from(steps)).clamp(low, high.max(low)) - count;
        }
        self.replan(now);
    }

    /// Sets what hinders the axis: a stalled count, a blocked rotor, a factor on all speeds.
    pub(super) fn set_hindrance(
        &mut self,
        now: Duration,
        stalled: bool,
        blocked: bool,
        speed_factor: f64,
    ) {
        if (stalled, blocked, speed_factor) != (self.stalled, self.blocked, self.speed_factor) {
            self.split_current(now);
            (self.stalled, self.blocked, self.speed_factor) = (stalled, blocked, speed_factor);
            self.replan(now);
        }
    }

    /// Sets the count to the true position, in steps of `counts_per_half_step`: the effect of a calibration.
    pub(super) fn recalibrate(&mut self, now: Duration, counts_per_half_step: f64) {
        let truth = self.true_half_steps_now(now) * counts_per_half_step;
        self.rest_at(now, truth.round(), 0.0, counts_per_half_step);
    }

    /// Declares the current position to be 0, as at power-up without a calibration.
    pub(super) fn declare_zero(&mut self, now: Duration, counts_per_half_step: f64) {
        let truth = self.true_half_steps_now(now) * counts_per_half_step;
        self.rest_at(now, 0.0, truth.round(), counts_per_half_step);
    }

    /// Moves through every segment that ends by `now`; returns the instants at which a stop was hit.
    pub(super) fn advance(&mut self, now: Duration) -> Vec<Duration> {
        let mut contacts = Vec::new();
        while self.current.end <= now {
            let (end, p1) = (self.current.end, self.current.p1);
            let rotor = rotor_after(self.current.rotor, p1, self.blocked);
            let next = self.planned.pop_front().unwrap_or_else(|| {
                self.goal = None;
                rest_segment(end, p1, rotor, self.counts_per_half_step)
            });
            if next.contact {
                contacts.push(next.start);
            }
            let done = std::mem::replace(&mut self.current, next);
            self.remember(done);
        }
        while self
            .history
            .front()
            .is_some_and(|s| s.end + HISTORY_TIME < now)
        {
            self.drop_oldest();
        }
        contacts
    }

    /// Where the head points at an instant of the last two seconds, half steps.
    pub(super) fn head_at(&self, at: Duration) -> f64 {
        let segments = std::iter::once(&self.current).chain(self.history.iter().rev());
        self.rotor_at(at) + backlash_offset(segments, at, self.backlash, self.heading)
    }

    /// Position of the rotor, before the play of the gears, at an instant of the last two seconds, half steps.
    pub(super) fn rotor_at(&self, at: Duration) -> f64 {
        let mut segment = &self.current;
        for past in self.history.iter().rev() {
            if at >= segment.start {
                break;
            }
            segment = past;
        }
        segment.true_half_steps(at.max(segment.start), self.whole_steps)
    }

    #[cfg(test)]
    pub(super) fn history_len(&self) -> usize {
        self.history.len()
    }

    fn true_half_steps_now(&self, now: Duration) -> f64 {
        self.current.true_half_steps(now, true)
    }

    fn rest_at(&mut self, now: Duration, count: f64, lost: f64, counts_per_half_step: f64) {
        self.split_current(now);
        self.planned.clear();
        self.goal = None;
        self.counts_per_half_step = counts_per_half_step;
        self.target = count as i32;
        self.current = rest_segment(now, count, Rotor::Follows(lost), counts_per_half_step);
    }

    fn remember(&mut self, segment: MotionSegment) {
        if segment.end > segment.start {
            self.history.push_back(segment);
            if self.history.len() > MAX_HISTORY_SEGMENTS {
                self.drop_oldest();
            }
        }
    }

    fn drop_oldest(&mut self) {
        let moved = self.history.pop_front().map_or(0.0, |s| s.p1 - s.p0);
        if moved.abs() > 1e-9 {
            self.heading = moved.signum();
        }
    }

    /// Splits the current segment at `now`; the second part continues unchanged.
    fn split_current(&mut self, now: Duration) {
        let p = self.current.count_at(now);
        let v = self.current.speed_at(now);
        let mut done = self.current;
        done.end = done.end.min(now.max(done.start));
        done.p1 = p;
        self.remember(done);
        self.current = MotionSegment {
            start: now,
            p0: p,
            v0: v,
            contact: false,
            ..self.current
        };
    }

    fn scaled(&self, ramp: SpeedRamp) -> SpeedRamp {
        SpeedRamp {
            speed: ramp.speed * self.speed_factor,
            base: ramp.base * self.speed_factor,
            acceleration: ramp.acceleration * self.speed_factor,
        }
    }

    /// Plans the motion from here to the goal.
    fn replan(&mut self, now: Duration) {
        self.split_current(now);
        self.planned.clear();
        let (p, v, rotor_before) = (self.current.p0, self.current.v0, self.current.rotor);
        let touching = matches!(rotor_before, Rotor::Held(_)) && !self.blocked;
        let rotor = rotor_after(rotor_before, p, self.blocked);
        let Some(goal) = self.goal else {
            self.current = rest_segment(now, p, rotor, self.counts_per_half_step);
            return;
        };
        if self.stalled {
            self.current = rest_segment(now, p, rotor, self.counts_per_half_step);
            return;
        }
        let ramp = self.scaled(goal.ramp);
        let segments = plan(p, v, f64::from(goal.target), &ramp);
        let mut scheduled =
            self.schedule(now, p, f64::from(goal.target), &segments, rotor, touching);
        self.current = scheduled.pop_front().unwrap_or_else(|| {
            // Already there: an empty segment, so that the arrival is handled like any other.
            let target = f64::from(goal.target);
            MotionSegment {
                end: now,
                ..rest_segment(now, target, rotor, self.counts_per_half_step)
            }
        });
        self.planned = scheduled;
    }

    /// Puts the profile on the time axis and splits it where the rotor hits a stop.
    fn schedule(
        &self,
        now: Duration,
        p: f64,
        target: f64,
        segments: &[ProfileSegment],
        rotor: Rotor,
        touching: bool,
    ) -> VecDeque<MotionSegment> {
        let (mut p, mut elapsed, mut rotor, mut touching) = (p, 0.0, rotor, touching);
        let mut scheduled = VecDeque::with_capacity(segments.len() + 1);
        for (i, segment) in segments.iter().enumerate() {
            let end = if i + 1 == segments.len() {
                target
            } else {
                p + segment.distance
            };
            rotor = rotor_after(rotor, p, self.blocked);
            let mut motion = MotionSegment {
                start: after(now, elapsed),
                end: after(now, elapsed + segment.duration),
                p0: p,
                v0: segment.v0,
                a: segment.a,
                p1: end,
                rotor,
                contact: false,
                counts_per_half_step: self.counts_per_half_step,
            };
            if let Rotor::Follows(lost) = rotor {
                let stop = f64::from(self.stop_count(segment.distance > 0.0));
                let past_stop = |q: f64| {
                    if segment.distance > 0.0 {
                        q + lost - stop
                    } else {
                        stop - q - lost
                    }
                };
                if past_stop(end) > 1e-6 {
                    let meets = segment.time_to_distance(-past_stop(p) * segment.distance.signum());
                    let held = Rotor::Held(stop);
                    if meets > 0.0 {
                        let at = after(now, elapsed + meets).min(motion.end);
                        let before = MotionSegment {
                            end: at,
                            p1: stop - lost,
                            ..motion
                        };
                        motion = MotionSegment {
                            start: at,
                            p0: stop - lost,
                            v0: segment.v0 + segment.a * meets,
                            ..motion
                        };
                        scheduled.push_back(before);
                        touching = false;
                    }
                    motion.rotor = held;
                    motion.contact = !touching;
                    touching = true;
                    rotor = held;
                } else {
                    touching = false;
                }
            }
            scheduled.push_back(motion);
            p = end;
            elapsed += segment.duration;
        }
        scheduled
    }
}

fn after(start: Duration, seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds.max(0.0)).map_or(Duration::MAX, |d| start.saturating_add(d))
}
