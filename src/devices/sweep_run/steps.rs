//! The steps of a sweep: what is asked of the devices at the beginning of each, and the ways it can end.

use super::{Phase, RunAction, SweepRun, stalled};
use crate::devices::constants::{END_LIMIT, STEP_LIMIT, TIME_SAMPLES};
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::HeadCommand;
use crate::devices::laser::LaserCommand;
use crate::devices::plan::TiltPlan;
use patrold_engine::sweep::RawSweep;
use ptu::{Axis, MoveWatch};
use std::time::Duration;

impl SweepRun {
    pub(super) fn enter(&mut self, phase: Phase, now: Duration) {
        self.phase = phase;
        self.limit = now + STEP_LIMIT;
    }

    pub(super) fn begin_leg(&mut self, now: Duration) {
        let Some((pan, _)) = self.plan.pans.get(self.leg).copied() else {
            return self.succeed();
        };
        let (pan_speed, tilt_speed) = self.plan.approach_steps_s;
        self.head(HeadCommand::SetSpeed(Axis::Pan, pan_speed));
        self.head(HeadCommand::SetSpeed(Axis::Tilt, tilt_speed));
        self.head(HeadCommand::MoveTo(Axis::Pan, pan));
        if let Some(start) = self.plan.tilt.start_steps() {
            self.head(HeadCommand::MoveTo(Axis::Tilt, start));
        }
        self.head(HeadCommand::Watch(Some(Axis::Pan)));
        let watch = self.watch(Axis::Pan, pan, pan_speed, now);
        self.enter(Phase::Moving(Axis::Pan, watch, pan), now);
    }

    /// A move of unknown beginning: it takes no longer than the whole range.
    pub(super) fn watch(&self, axis: Axis, target: i32, speed: i32, now: Duration) -> MoveWatch {
        let axis = match axis {
            Axis::Pan => &self.plan.pan_axis,
            Axis::Tilt => &self.plan.tilt_axis,
        };
        let range = i64::from(axis.limits.max_steps) - i64::from(axis.limits.min_steps);
        MoveWatch::new(target, now, axis.profile(speed).travel_time(range))
    }

    pub(super) fn tilt_to_start(&mut self, now: Duration) {
        let Some(start) = self.plan.tilt.start_steps() else {
            return self.exchange_time(Phase::TimeBefore, now);
        };
        self.head(HeadCommand::Watch(Some(Axis::Tilt)));
        let watch = self.watch(Axis::Tilt, start, self.plan.approach_steps_s.1, now);
        self.enter(Phase::Moving(Axis::Tilt, watch, start), now);
    }

    pub(super) fn exchange_time(&mut self, phase: Phase, now: Duration) {
        self.head(HeadCommand::Watch(None));
        self.laser(LaserCommand::ExchangeTime(TIME_SAMPLES));
        self.enter(phase, now);
    }

    pub(super) fn warm_up(&mut self, now: Duration) {
        self.laser(LaserCommand::Stream(self.plan.stream));
        self.enter(Phase::Warming(0), now);
    }

    pub(super) fn warm_again(&mut self) {
        if let Phase::Warming(good) = &mut self.phase {
            *good = 0;
        }
    }

    pub(super) fn begin_tilt(&mut self, now: Duration) {
        // The watch first: the poll at the start tells where the motion began.
        self.head(HeadCommand::Watch(Some(Axis::Tilt)));
        let TiltPlan::Continuous {
            start_steps,
            end_steps,
            speed_steps_s,
            ..
        } = self.plan.tilt
        else {
            return self.step_to(0, now);
        };
        self.head(HeadCommand::SetSpeed(Axis::Tilt, speed_steps_s));
        self.head(HeadCommand::MoveTo(Axis::Tilt, end_steps));
        let way = i64::from(end_steps) - i64::from(start_steps);
        let time = self.plan.tilt_axis.profile(speed_steps_s).travel_time(way);
        self.phase = Phase::Sweeping(MoveWatch::new(end_steps, now, time));
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
        self.head(HeadCommand::MoveTo(Axis::Tilt, target));
        let watch = self.watch(Axis::Tilt, target, self.plan.approach_steps_s.1, now);
        self.enter(Phase::Stepping(line, watch), now);
    }

    pub(super) fn stop_laser(&mut self, now: Duration) {
        self.head(HeadCommand::Watch(None));
        self.laser(LaserCommand::Stop);
        self.enter(Phase::StoppingLaser, now);
    }

    pub(super) fn finish_leg(&mut self, now: Duration) {
        let pan_rad = self.plan.pans.get(self.leg).map_or(0.0, |(_, rad)| *rad);
        if self.draft.timer_stepped(&self.plan) {
            let what = "stepped by whole scan periods".to_owned();
            return self.timer_lost(what, now);
        }
        let draft = std::mem::take(&mut self.draft);
        self.legs.push(draft.finish(&self.plan, pan_rad));
        self.leg += 1;
        self.begin_leg(now);
    }

    pub(super) fn succeed(&mut self) {
        self.phase = Phase::Done;
        self.limit = Duration::MAX;
        let plan = &self.plan;
        self.outcome = Some(Ok(RawSweep {
            optics: plan.optics.clone(),
            mount: plan.mount.clone(),
            tilt_rad_per_step: plan.tilt_rad_per_step,
            tilt_zero_rad: plan.tilt_zero_rad,
            tilt_low_rad: plan.tilt_range_rad.0,
            tilt_high_rad: plan.tilt_range_rad.1,
            line_pitch_rad: plan.line_pitch_rad,
            time_offset_s: plan.time_offset_s,
            tilt_backlash_rad: plan.tilt_backlash_rad,
            legs: std::mem::take(&mut self.legs),
        }));
    }

    pub(super) fn tilt_stalled(&mut self, at: i32, now: Duration) {
        let target = match &self.plan.tilt {
            TiltPlan::Continuous { end_steps, .. } => *end_steps,
            TiltPlan::Steps(_) => match self.phase {
                Phase::Stepping(line, _) | Phase::Staring(line, _) => {
                    self.line_target(line).unwrap_or(at)
                }
                _ => at,
            },
        };
        self.fail(
            stalled(self.ports.head.clone(), Axis::Tilt, at, target),
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

    /// The first reason counts; laser off, head stopped.
    pub(super) fn fail(&mut self, error: DeviceError, now: Duration) {
        if matches!(self.phase, Phase::Ending { .. } | Phase::Done) {
            return;
        }
        self.laser(LaserCommand::Stop);
        self.head(HeadCommand::Watch(None));
        self.head(HeadCommand::Halt);
        self.phase = Phase::Ending {
            error,
            laser_rests: false,
            head_rests: false,
        };
        self.limit = now + END_LIMIT;
    }

    pub(super) fn rests(&mut self, device: Device) {
        let Phase::Ending {
            error,
            laser_rests,
            head_rests,
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
            self.phase = Phase::Done;
            self.limit = Duration::MAX;
        }
    }

    pub(super) fn laser(&mut self, command: LaserCommand) {
        self.actions.push_back(RunAction::Laser(command));
    }

    pub(super) fn head(&mut self, command: HeadCommand) {
        self.actions.push_back(RunAction::Head(command));
    }

    pub(super) fn note(&mut self, device: Device, text: String) {
        self.actions.push_back(RunAction::Note(device, text));
    }
}
