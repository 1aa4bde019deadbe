//! The steps of a sweep: the commands at the start of each, and the ways a sweep ends.

use super::{SweepAction, SweepPhase, SweepRun, stalled_error};
use crate::devices::constants::{END_LIMIT, STEP_LIMIT, TIME_SAMPLES};
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::HeadCommand;
use crate::devices::laser::LaserCommand;
use crate::devices::plan::TiltPlan;
use ptu::{Axis, MoveWatch};
use std::time::Duration;

impl SweepRun {
    pub(super) fn enter_phase(&mut self, phase: SweepPhase, now: Duration) {
        self.phase = phase;
        self.limit = now + STEP_LIMIT;
    }

    pub(super) fn start_segment(&mut self, now: Duration) {
        let Some((pan, _)) = self.plan.pans.get(self.segment).copied() else {
            return self.succeed();
        };
        let (pan_speed, tilt_speed) = self.plan.approach_steps_s;
        self.command_head(HeadCommand::SetSpeed(Axis::Pan, pan_speed));
        self.command_head(HeadCommand::SetSpeed(Axis::Tilt, tilt_speed));
        self.command_head(HeadCommand::MoveTo(Axis::Pan, pan));
        if let Some(start) = self.plan.tilt.start_steps() {
            self.command_head(HeadCommand::MoveTo(Axis::Tilt, start));
        }
        self.command_head(HeadCommand::PollPosition(Some(Axis::Pan)));
        let watch = self.move_watch(Axis::Pan, pan, pan_speed, now);
        self.enter_phase(SweepPhase::Moving(Axis::Pan, watch, pan), now);
    }

    /// Of a move from an unknown position: it takes no longer than the whole range.
    pub(super) fn move_watch(
        &self,
        axis: Axis,
        target: i32,
        speed: i32,
        now: Duration,
    ) -> MoveWatch {
        let axis = match axis {
            Axis::Pan => &self.plan.pan_axis,
            Axis::Tilt => &self.plan.tilt_axis,
        };
        let range = i64::from(axis.limits.max_steps) - i64::from(axis.limits.min_steps);
        MoveWatch::new(target, now, axis.profile(speed).travel_time(range))
    }

    pub(super) fn tilt_to_start(&mut self, now: Duration) {
        let Some(start) = self.plan.tilt.start_steps() else {
            return self.exchange_time(SweepPhase::TimeBefore, now);
        };
        self.command_head(HeadCommand::PollPosition(Some(Axis::Tilt)));
        let watch = self.move_watch(Axis::Tilt, start, self.plan.approach_steps_s.1, now);
        self.enter_phase(SweepPhase::Moving(Axis::Tilt, watch, start), now);
    }

    pub(super) fn exchange_time(&mut self, phase: SweepPhase, now: Duration) {
        self.command_head(HeadCommand::PollPosition(None));
        self.command_laser(LaserCommand::ExchangeTime(TIME_SAMPLES));
        self.enter_phase(phase, now);
    }

    pub(super) fn warm_up(&mut self, now: Duration) {
        self.command_laser(LaserCommand::Stream(self.plan.stream));
        self.enter_phase(SweepPhase::WarmingUp(0), now);
    }

    pub(super) fn restart_warm_up(&mut self) {
        if let SweepPhase::WarmingUp(good) = &mut self.phase {
            *good = 0;
        }
    }

    pub(super) fn start_tilt(&mut self, now: Duration) {
        // Poll first: the position at the start is needed.
        self.command_head(HeadCommand::PollPosition(Some(Axis::Tilt)));
        let TiltPlan::Continuous {
            start_steps,
            end_steps,
            speed_steps_s,
            ..
        } = self.plan.tilt
        else {
            return self.step_to(0, now);
        };
        self.command_head(HeadCommand::SetSpeed(Axis::Tilt, speed_steps_s));
        self.command_head(HeadCommand::MoveTo(Axis::Tilt, end_steps));
        let distance = i64::from(end_steps) - i64::from(start_steps);
        let time = self
            .plan
            .tilt_axis
            .profile(speed_steps_s)
            .travel_time(distance);
        self.phase = SweepPhase::Sweeping(MoveWatch::new(end_steps, now, time));
        self.limit = now.saturating_add(time).saturating_add(STEP_LIMIT);
    }

    pub(super) fn line_target(&self, line: usize) -> Option<i32> {
        match &self.plan.tilt {
            TiltPlan::Steps(targets) => targets.get(line).copied(),
            TiltPlan::Continuous { .. } => None,
        }
    }

    pub(super) fn step_to(&mut self, line: usize, now: Duration) {
        let Some(target) = self.line_target(line) else {
            return self.stop_laser(now);
        };
        self.command_head(HeadCommand::MoveTo(Axis::Tilt, target));
        let watch = self.move_watch(Axis::Tilt, target, self.plan.approach_steps_s.1, now);
        self.enter_phase(SweepPhase::Stepping(line, watch), now);
    }

    pub(super) fn stop_laser(&mut self, now: Duration) {
        self.command_head(HeadCommand::PollPosition(None));
        self.command_laser(LaserCommand::Stop);
        self.enter_phase(SweepPhase::StoppingLaser, now);
    }

    pub(super) fn finish_segment(&mut self, now: Duration) {
        let pan_rad = self
            .plan
            .pans
            .get(self.segment)
            .map_or(0.0, |(_, rad)| *rad);
        if self.draft.timer_stepped(&self.plan) {
            let what = "stepped by whole scan periods".to_owned();
            return self.timer_lost(what, now);
        }
        let draft = std::mem::take(&mut self.draft);
        self.segments.push(draft.finish(&self.plan, pan_rad));
        self.segment += 1;
        self.start_segment(now);
    }

    pub(super) fn succeed(&mut self) {
        self.phase = SweepPhase::Done;
        self.limit = Duration::MAX;
        let segments = std::mem::take(&mut self.segments);
        self.outcome = Some(Ok(self.plan.raw_sweep(segments)));
    }

    pub(super) fn tilt_stalled(&mut self, at: i32, now: Duration) {
        let target = match &self.plan.tilt {
            TiltPlan::Continuous { end_steps, .. } => *end_steps,
            TiltPlan::Steps(_) => match self.phase {
                SweepPhase::Stepping(line, _) | SweepPhase::Staring(line, _) => {
                    self.line_target(line).unwrap_or(at)
                }
                _ => at,
            },
        };
        self.fail(
            stalled_error(self.ports.head.clone(), Axis::Tilt, at, target),
            now,
        );
    }

    pub(super) fn timer_lost(&mut self, what: String, now: Duration) {
        let port = self.ports.laser.clone();
        self.fail(DeviceError::TimerLost { port, what }, now);
    }

    pub(super) fn position_lost(&mut self, detail: String, now: Duration) {
        let port = self.ports.head.clone();
        self.fail(DeviceError::PositionLost { port, detail }, now);
    }

    /// Keeps the first error; stops laser and head.
    pub(super) fn fail(&mut self, error: DeviceError, now: Duration) {
        if matches!(self.phase, SweepPhase::Ending { .. } | SweepPhase::Done) {
            return;
        }
        self.command_laser(LaserCommand::Stop);
        self.command_head(HeadCommand::PollPosition(None));
        self.command_head(HeadCommand::Halt);
        self.phase = SweepPhase::Ending {
            error,
            laser_stopped: false,
            head_stopped: false,
        };
        self.limit = now + END_LIMIT;
    }

    pub(super) fn stopped(&mut self, device: Device) {
        let SweepPhase::Ending {
            error,
            laser_stopped: laser_rests,
            head_stopped: head_rests,
        } = &mut self.phase
        else {
            return;
        };
        match device {
            Device::Laser => *laser_rests = true,
            Device::Head => *head_rests = true,
        }
        if *laser_rests && *head_rests {
            self.outcome = Some(Err(error.clone()));
            self.phase = SweepPhase::Done;
            self.limit = Duration::MAX;
        }
    }

    pub(super) fn command_laser(&mut self, command: LaserCommand) {
        self.actions.push_back(SweepAction::Laser(command));
    }

    pub(super) fn command_head(&mut self, command: HeadCommand) {
        self.actions.push_back(SweepAction::Head(command));
    }

    pub(super) fn note(&mut self, device: Device, text: String) {
        self.actions.push_back(SweepAction::Note(device, text));
    }
}
