//! One axis in time: the count that the unit reports, the rotor that may have lost it, the stops and the past.
//!
//! Counts are steps of the current step mode; true positions are half steps, whatever the mode.

use std::collections::VecDeque;
use std::time::Duration;

use super::Instant;
use super::constants::{HISTORY, HISTORY_SEGMENTS};
use super::profile::{Leg, Ramp, brake_distance, plan};
use super::segment::{Rotor, Segment, play, rest, settled};

/// Where an axis is told to go.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Goal {
    target: i32,
    ramp: Ramp,
}

/// One axis.
#[derive(Debug)]
pub(super) struct Axis {
    current: Segment,
    planned: VecDeque<Segment>,
    past: VecDeque<Segment>,
    goal: Option<Goal>,
    target: i32,
    /// Mechanical stops, half steps.
    stops: (f64, f64),
    counts_per_half_step: f64,
    whole: bool,
    /// The count does not advance.
    stalled: bool,
    /// The count advances, the rotor does not.
    blocked: bool,
    /// Factor on all speeds.
    pace: f64,
    /// Play between rotor and head, half steps.
    backlash: f64,
    /// Direction of travel in the last segment that is no longer remembered: 1, -1, or 0 where it never moved.
    heading: f64,
}

impl Axis {
    /// An axis at rest at `position` between `stops`, both in half steps.
    pub(super) fn new(position: i32, stops: (f64, f64), whole: bool, now: Instant) -> Self {
        Self {
            current: rest(now, f64::from(position), Rotor::Follows(0.0), 1.0),
            planned: VecDeque::new(),
            past: VecDeque::new(),
            goal: None,
            target: position,
            stops,
            counts_per_half_step: 1.0,
            whole,
            stalled: false,
            blocked: false,
            pace: 1.0,
            backlash: 0.0,
            heading: 0.0,
        }
    }

    /// With play between rotor and head, half steps.
    pub(super) fn with_backlash(mut self, half_steps: f64) -> Self {
        self.backlash = half_steps;
        self
    }

    /// The count that the unit reports.
    pub(super) fn position(&self, now: Instant) -> i32 {
        self.current.count_at(now).round() as i32
    }

    /// Signed speed of the count, positions/s.
    pub(super) fn speed(&self, now: Instant) -> f64 {
        self.current.speed_at(now)
    }

    /// The target in force.
    pub(super) fn target(&self) -> i32 {
        self.target
    }

    /// Whether the axis is on its way. A stalled axis is on its way for ever.
    pub(super) fn moving(&self) -> bool {
        self.goal.is_some()
    }

    /// When the motion changes next by itself.
    pub(super) fn next_change(&self) -> Option<Instant> {
        (self.current.end != Instant::MAX).then_some(self.current.end)
    }

    /// Counts per half step now in force.
    pub(super) fn counts_per_half_step(&self) -> f64 {
        self.counts_per_half_step
    }

    /// The stop towards lower or higher counts, as a true count.
    pub(super) fn stop_count(&self, upper: bool) -> i32 {
        let stop = if upper { self.stops.1 } else { self.stops.0 };
        (stop * self.counts_per_half_step).round() as i32
    }

    /// Goes to `target`, from whatever it is doing.
    pub(super) fn drive(&mut self, now: Instant, target: i32, ramp: Ramp) {
        self.target = target;
        self.goal = Some(Goal { target, ramp });
        self.relay(now);
    }

    /// Decelerates to a stop as soon as the ramp allows; the stop becomes the target (section 9, `H`).
    pub(super) fn halt(&mut self, now: Instant) {
        let Some(goal) = self.goal else { return };
        let (p, v) = (self.current.count_at(now), self.current.speed_at(now));
        let paced = self.paced(goal.ramp);
        let brake = brake_distance(v, &paced);
        if brake > 0.0 {
            let end = p + v.signum() * brake;
            let end = if v > 0.0 {
                (end - 1e-6).ceil()
            } else {
                (end + 1e-6).floor()
            };
            let speed = v.abs() / self.pace;
            self.drive(now, end as i32, Ramp { speed, ..goal.ramp });
        } else {
            self.stop_at_once(now);
        }
    }

    /// Ends the motion here, as the count stands.
    pub(super) fn stop_at_once(&mut self, now: Instant) {
        self.cut(now);
        self.planned.clear();
        self.goal = None;
        let p = self.current.p0.round();
        self.target = p as i32;
        self.current = rest(now, p, self.current.rotor, self.counts_per_half_step);
    }

    /// Loses `steps` counts: the rotor jumps (no further than a stop), the count does not.
    pub(super) fn lose(&mut self, now: Instant, steps: i32) {
        self.cut(now);
        let (low, high) = (
            f64::from(self.stop_count(false)),
            f64::from(self.stop_count(true)),
        );
        let count = self.current.p0.round();
        if let Rotor::Follows(lost) = &mut self.current.rotor {
            *lost = (count + *lost + f64::from(steps)).clamp(low, high.max(low)) - count;
        }
        self.relay(now);
    }

    /// What hinders the axis: a count that stalls, a rotor that is blocked, a factor on speed.
    pub(super) fn hinder(&mut self, now: Instant, stalled: bool, blocked: bool, pace: f64) {
        if (stalled, blocked, pace) != (self.stalled, self.blocked, self.pace) {
            self.cut(now);
            (self.stalled, self.blocked, self.pace) = (stalled, blocked, pace);
            self.relay(now);
        }
    }

    /// Makes the true position the count, in steps of `counts_per_half_step`: what calibration amounts to.
    pub(super) fn adopt_truth(&mut self, now: Instant, counts_per_half_step: f64) {
        let truth = self.true_half_steps_now(now) * counts_per_half_step;
        self.restart(now, truth.round(), 0.0, counts_per_half_step);
    }

    /// Calls the place where the axis stands 0, as a unit does that was switched on without calibrating.
    pub(super) fn forget(&mut self, now: Instant, counts_per_half_step: f64) {
        let truth = self.true_half_steps_now(now) * counts_per_half_step;
        self.restart(now, 0.0, truth.round(), counts_per_half_step);
    }

    /// Moves through every segment that ends by `now`; the instants at which a stop was met.
    pub(super) fn advance(&mut self, now: Instant) -> Vec<Instant> {
        let mut contacts = Vec::new();
        while self.current.end <= now {
            let (end, p1) = (self.current.end, self.current.p1);
            let rotor = settled(self.current.rotor, p1, self.blocked);
            let next = self.planned.pop_front().unwrap_or_else(|| {
                self.goal = None;
                rest(end, p1, rotor, self.counts_per_half_step)
            });
            if next.contact {
                contacts.push(next.start);
            }
            let done = std::mem::replace(&mut self.current, next);
            self.remember(done);
        }
        while self.past.front().is_some_and(|s| s.end + HISTORY < now) {
            self.forget_oldest();
        }
        contacts
    }

    /// Where the head points at an instant of the last two seconds, half steps.
    pub(super) fn true_at(&self, at: Instant) -> f64 {
        let segments = std::iter::once(&self.current).chain(self.past.iter().rev());
        self.rotor_at(at) + play(segments, at, self.backlash, self.heading)
    }

    /// Where the rotor is at an instant of the last two seconds, half steps: the play of the gears is behind it.
    pub(super) fn rotor_at(&self, at: Instant) -> f64 {
        let mut segment = &self.current;
        for past in self.past.iter().rev() {
            if at >= segment.start {
                break;
            }
            segment = past;
        }
        segment.true_half_steps(at.max(segment.start), self.whole)
    }

    /// Remembered segments, for the bound on memory.
    #[cfg(test)]
    pub(super) fn remembered(&self) -> usize {
        self.past.len()
    }

    fn true_half_steps_now(&self, now: Instant) -> f64 {
        self.current.true_half_steps(now, true)
    }

    fn restart(&mut self, now: Instant, count: f64, lost: f64, counts_per_half_step: f64) {
        self.cut(now);
        self.planned.clear();
        self.goal = None;
        self.counts_per_half_step = counts_per_half_step;
        self.target = count as i32;
        self.current = rest(now, count, Rotor::Follows(lost), counts_per_half_step);
    }

    fn remember(&mut self, segment: Segment) {
        if segment.end > segment.start {
            self.past.push_back(segment);
            if self.past.len() > HISTORY_SEGMENTS {
                self.forget_oldest();
            }
        }
    }

    fn forget_oldest(&mut self) {
        let moved = self.past.pop_front().map_or(0.0, |s| s.p1 - s.p0);
        if moved.abs() > 1e-9 {
            self.heading = moved.signum();
        }
    }

    /// Splits the current segment at `now`; the rest of it goes on as before.
    fn cut(&mut self, now: Instant) {
        let p = self.current.count_at(now);
        let v = self.current.speed_at(now);
        let mut done = self.current;
        done.end = done.end.min(now.max(done.start));
        done.p1 = p;
        self.remember(done);
        self.current = Segment {
            start: now,
            p0: p,
            v0: v,
            contact: false,
            ..self.current
        };
    }

    fn paced(&self, ramp: Ramp) -> Ramp {
        Ramp {
            speed: ramp.speed * self.pace,
            base: ramp.base * self.pace,
            acceleration: ramp.acceleration * self.pace,
        }
    }

    /// Plans afresh from here to the goal.
    fn relay(&mut self, now: Instant) {
        self.cut(now);
        self.planned.clear();
        let (p, v, was) = (self.current.p0, self.current.v0, self.current.rotor);
        let touching = matches!(was, Rotor::Held(_)) && !self.blocked;
        let rotor = settled(was, p, self.blocked);
        let Some(goal) = self.goal else {
            self.current = rest(now, p, rotor, self.counts_per_half_step);
            return;
        };
        if self.stalled {
            self.current = rest(now, p, rotor, self.counts_per_half_step);
            return;
        }
        let ramp = self.paced(goal.ramp);
        let legs = plan(p, v, f64::from(goal.target), &ramp);
        let mut laid = self.lay(now, p, f64::from(goal.target), &legs, rotor, touching);
        self.current = laid.pop_front().unwrap_or_else(|| {
            // Already there: an empty segment, so that arrival is noticed like any other.
            let target = f64::from(goal.target);
            Segment {
                end: now,
                ..rest(now, target, rotor, self.counts_per_half_step)
            }
        });
        self.planned = laid;
    }

    /// Lays legs onto the clock and splits them where the rotor meets a stop.
    fn lay(
        &self,
        now: Instant,
        p: f64,
        target: f64,
        legs: &[Leg],
        rotor: Rotor,
        touching: bool,
    ) -> VecDeque<Segment> {
        let (mut p, mut elapsed, mut rotor, mut touching) = (p, 0.0, rotor, touching);
        let mut laid = VecDeque::with_capacity(legs.len() + 1);
        for (i, leg) in legs.iter().enumerate() {
            let end = if i + 1 == legs.len() {
                target
            } else {
                p + leg.distance
            };
            rotor = settled(rotor, p, self.blocked);
            let mut piece = Segment {
                start: after(now, elapsed),
                end: after(now, elapsed + leg.duration),
                p0: p,
                v0: leg.v0,
                a: leg.a,
                p1: end,
                rotor,
                contact: false,
                counts_per_half_step: self.counts_per_half_step,
            };
            if let Rotor::Follows(lost) = rotor {
                let stop = f64::from(self.stop_count(leg.distance > 0.0));
                let past_stop = |q: f64| {
                    if leg.distance > 0.0 {
                        q + lost - stop
                    } else {
                        stop - q - lost
                    }
                };
                if past_stop(end) > 1e-6 {
                    let meets = leg_time(leg, -past_stop(p) * leg.distance.signum());
                    let held = Rotor::Held(stop);
                    if meets > 0.0 {
                        let at = after(now, elapsed + meets).min(piece.end);
                        let before = Segment {
                            end: at,
                            p1: stop - lost,
                            ..piece
                        };
                        piece = Segment {
                            start: at,
                            p0: stop - lost,
                            v0: leg.v0 + leg.a * meets,
                            ..piece
                        };
                        laid.push_back(before);
                        touching = false;
                    }
                    piece.rotor = held;
                    piece.contact = !touching;
                    touching = true;
                    rotor = held;
                } else {
                    touching = false;
                }
            }
            laid.push_back(piece);
            p = end;
            elapsed += leg.duration;
        }
        laid
    }
}

/// The time at which a leg has travelled `distance` (signed like the leg), seconds; 0 if it starts beyond.
fn leg_time(leg: &Leg, distance: f64) -> f64 {
    let (d, v, a) = (distance.abs(), leg.v0.abs(), leg.a * leg.distance.signum());
    if distance * leg.distance <= 0.0 {
        return 0.0;
    }
    let root = (v * v + 2.0 * a * d).max(0.0).sqrt();
    (2.0 * d / (v + root)).min(leg.duration)
}

/// `start` plus seconds, saturating.
fn after(start: Instant, seconds: f64) -> Instant {
    Duration::try_from_secs_f64(seconds.max(0.0)).map_or(Instant::MAX, |d| start.saturating_add(d))
}
