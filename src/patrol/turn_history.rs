//! Whether the head lost steps before a sweep, from how far the views of past visits lay turned against their references
//! (docs/novelty.md section 11).
//!
//! A view is turned by what the robot's heading is off at this stop, and by the steps that the head has lost. The robot errs
//! anew at every stop; lost steps stay until the head is homed. So the mean turn since some visit after the last homing is
//! compared with the spread of this robot's own errors.

use super::constants::{
    LOST_STEPS_SIGMAS, MAX_ERRORS, MAX_VIEWS_SINCE_HOMING, MIN_HOMING_INTERVAL, MIN_TURN_SD_RAD,
};
use std::collections::{HashMap, HashSet, VecDeque};
use std::time::Duration;

/// How far the view of a visit lay turned against the waypoint's reference about the axes of the head, radians.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenTurn {
    /// Name of the waypoint.
    pub waypoint: String,
    /// The version whose sweep gave the reference its frame.
    pub frame_version: i64,
    /// About the pan axis.
    pub pan_rad: f64,
    /// About the tilt axis, where the sweep had one.
    pub tilt_rad: Option<f64>,
}

/// Why the head should be homed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HomingReason {
    /// Past views stand out; which, in one line.
    LostSteps(String),
    /// Every waypoint was visited since the last homing, and one of them again.
    RoundOver,
}

/// The turns of one robot's views.
#[derive(Debug, Clone)]
pub struct TurnHistory {
    pan: AxisTurns,
    tilt: AxisTurns,
    /// Waypoints since the last homing.
    round: HashSet<String>,
    round_is_over: bool,
    homed_at: Option<Duration>,
}

impl TurnHistory {
    /// A robot whose errors are not known: from turns of one view by these on, radians, steps may be lost.
    pub fn new(suspect_pan_rad: f64, suspect_tilt_rad: f64) -> Self {
        Self {
            pan: AxisTurns::new(suspect_pan_rad / LOST_STEPS_SIGMAS),
            tilt: AxisTurns::new(suspect_tilt_rad / LOST_STEPS_SIGMAS),
            round: HashSet::new(),
            round_is_over: false,
            homed_at: None,
        }
    }

    /// Takes other turns of one view for suspect; what was seen stays.
    pub fn suspect(&mut self, pan_rad: f64, tilt_rad: f64) {
        self.pan.expected_sd_rad = pan_rad / LOST_STEPS_SIGMAS;
        self.tilt.expected_sd_rad = tilt_rad / LOST_STEPS_SIGMAS;
    }

    /// A visit was judged.
    pub fn observe(&mut self, seen: &SeenTurn) {
        let place = (seen.waypoint.as_str(), seen.frame_version);
        self.pan.observe(place, seen.pan_rad);
        if let Some(tilt_rad) = seen.tilt_rad {
            self.tilt.observe(place, tilt_rad);
        }
        self.round_is_over |= !self.round.insert(seen.waypoint.clone());
    }

    /// The head was homed: no steps are lost.
    pub fn homed(&mut self, now: Duration) {
        self.pan.homed();
        self.tilt.homed();
        self.round.clear();
        self.round_is_over = false;
        self.homed_at = Some(now);
    }

    /// Why the head should be homed at the next idle moment, if it should.
    pub fn reason_to_home(&self, now: Duration) -> Option<HomingReason> {
        for (axis, turns) in [("pan", &self.pan), ("tilt", &self.tilt)] {
            if let Some(excess) = turns.excess().filter(|e| e.sigmas >= LOST_STEPS_SIGMAS) {
                return Some(HomingReason::LostSteps(format!(
                    "the last {} views lie {:.1} deg of {axis} off, {:.1} standard deviations of this robot's own errors: the head may have lost steps",
                    excess.views,
                    excess.mean_rad.to_degrees(),
                    excess.sigmas
                )));
            }
        }
        // A head that is used as it was found is left alone.
        let rested = self
            .homed_at
            .is_some_and(|at| now.saturating_sub(at) >= MIN_HOMING_INTERVAL);
        (self.round_is_over && rested).then_some(HomingReason::RoundOver)
    }
}

/// The strongest mean turn of the last views.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Excess {
    views: usize,
    mean_rad: f64,
    /// In standard deviations of such a mean.
    sigmas: f64,
}

/// The robot's mean turn at a waypoint. The reference is its first view, turned by nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WaypointMean {
    frame_version: i64,
    views: f64,
    sum_rad: f64,
}

impl WaypointMean {
    fn taught(frame_version: i64) -> Self {
        Self {
            frame_version,
            views: 1.0,
            sum_rad: 0.0,
        }
    }
}

#[derive(Debug, Clone)]
struct AxisTurns {
    expected_sd_rad: f64,
    /// Squares of the robot's errors, of unit weight, the newest last; square radians.
    squares: VecDeque<f64>,
    means: HashMap<String, WaypointMean>,
    /// Views since the last homing, each with its turn: what they say of the robot is not known yet.
    open: VecDeque<(String, f64)>,
    /// Turns for which the head was homed, by waypoint.
    accused: HashMap<String, f64>,
}

impl AxisTurns {
    fn new(expected_sd_rad: f64) -> Self {
        Self {
            expected_sd_rad,
            squares: VecDeque::new(),
            means: HashMap::new(),
            open: VecDeque::new(),
            accused: HashMap::new(),
        }
    }

    fn observe(&mut self, (waypoint, frame_version): (&str, i64), turn_rad: f64) {
        let mean = self.means.get(waypoint);
        if mean.is_none_or(|mean| mean.frame_version != frame_version) {
            let taught = WaypointMean::taught(frame_version);
            self.means.insert(waypoint.to_owned(), taught);
            self.open.retain(|(name, _)| name != waypoint);
            self.accused.remove(waypoint);
        }
        self.answer_accusation(waypoint, turn_rad);
        self.open.push_back((waypoint.to_owned(), turn_rad));
        if self.open.len() > MAX_VIEWS_SINCE_HOMING
            && let Some((waypoint, turn_rad)) = self.open.pop_front()
        {
            self.learn(&waypoint, turn_rad);
        }
    }

    /// A view that led to a homing was right to do so, unless the place lies as it did then.
    fn answer_accusation(&mut self, waypoint: &str, turn_rad: f64) {
        let Some(then_rad) = self.accused.remove(waypoint) else {
            return;
        };
        let mean_rad = self.mean(waypoint).sum_rad / self.mean(waypoint).views;
        if (turn_rad - then_rad).abs() < (turn_rad - mean_rad).abs() {
            self.learn(waypoint, then_rad);
        }
    }

    fn mean(&self, waypoint: &str) -> WaypointMean {
        let known = self.means.get(waypoint).copied();
        known.unwrap_or_else(|| WaypointMean::taught(0))
    }

    /// This view was turned by the robot alone.
    fn learn(&mut self, waypoint: &str, turn_rad: f64) {
        let Some(mean) = self.means.get_mut(waypoint) else {
            return;
        };
        let error_rad = turn_rad - mean.sum_rad / mean.views;
        self.squares
            .push_back(error_rad * error_rad / (1.0 + 1.0 / mean.views));
        mean.views += 1.0;
        mean.sum_rad += turn_rad;
        if self.squares.len() > MAX_ERRORS {
            self.squares.pop_front();
        }
    }

    /// Variance of the robot's errors: what is expected counts as one of them.
    fn variance(&self) -> f64 {
        let sum: f64 = self.squares.iter().sum();
        let expected = self.expected_sd_rad * self.expected_sd_rad;
        let variance = (sum + expected) / (1.0 + self.squares.len() as f64);
        variance.max(MIN_TURN_SD_RAD * MIN_TURN_SD_RAD)
    }

    /// Of all runs of last views since the homing the one whose mean stands out most.
    fn excess(&self) -> Option<Excess> {
        let variance = self.variance();
        let mut taken: HashMap<&str, f64> = HashMap::new();
        // Sum of the errors; its variance: their own, and those of the means they are taken against.
        let (mut sum_rad, mut own, mut of_means) = (0.0, 0.0, 0.0);
        let mut strongest: Option<Excess> = None;
        for (waypoint, turn_rad) in self.open.iter().rev() {
            let mean = self.mean(waypoint);
            let count = taken.entry(waypoint).or_default();
            sum_rad += turn_rad - mean.sum_rad / mean.views;
            own += 1.0;
            of_means += (2.0 * *count + 1.0) / mean.views;
            *count += 1.0;
            let sigmas = f64::abs(sum_rad) / (variance * (own + of_means)).sqrt();
            if strongest.is_none_or(|s| sigmas > s.sigmas) {
                strongest = Some(Excess {
                    views: own as usize,
                    mean_rad: sum_rad / own,
                    sigmas,
                });
            }
        }
        strongest
    }

    fn homed(&mut self) {
        let excess = self.excess().filter(|e| e.sigmas >= LOST_STEPS_SIGMAS);
        let accused = excess.map_or(0, |e| e.views);
        let mut views = Vec::from(std::mem::take(&mut self.open));
        for (waypoint, turn_rad) in views.split_off(views.len().saturating_sub(accused)) {
            self.accused.insert(waypoint, turn_rad);
        }
        for (waypoint, turn_rad) in views {
            self.learn(&waypoint, turn_rad);
        }
    }
}

#[cfg(test)]
mod tests;
