//! One sweep as a state machine: events of both devices in, commands for both out; no thread, clock or port
//! (sweep-geometry section 7).
//!
//! ```text
//! pan -> tilt to the start -> time exchange -> stream, warm up -+-> tilt to the end, polls and scans --+-> QT ->
//!  ^                                                            +-> (stop, settle, one scan) per line --+      |
//!  +-------------------------- next pan <- time exchange <----------------------------------------------------+
//! ```
//!
//! Anything that makes an angle or a time doubtful ends the sweep with an error. The laser is off and the head has stopped
//! before the outcome is available.

mod steps;
#[cfg(test)]
mod tests;

use super::constants::{SETTLE, STEP_LIMIT, WARM_UP_SCANS};
use super::error::{Device, DeviceError};
use super::head::{HeadCommand, HeadEvent, head_error};
use super::laser::{LaserCommand, laser_error};
use super::plan::SweepPlan;
use super::sweep_data::{PanSegmentDraft, ScanTimeEstimator, StampUnwrapper, time_sample};
use patrold_engine::sweep::{PanSegment, PositionPoll, RawSweep, StampedScan};
use ptu::{Axis, MoveState, MoveWatch};
use scip::Rejection;
use std::collections::VecDeque;
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SweepAction {
    Laser(LaserCommand),
    Head(HeadCommand),
    /// For the log; the sweep continues.
    Note(Device, String),
}

/// Names of the two ports, for errors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PortNames {
    pub laser: String,
    pub head: String,
}

#[derive(Debug)]
enum SweepPhase {
    /// Axis, watch, target in counts.
    Moving(Axis, MoveWatch, i32),
    TimeBefore,
    /// Valid scans so far.
    WarmingUp(u32),
    Sweeping(MoveWatch),
    /// Moving to this line.
    Stepping(usize, MoveWatch),
    /// Stopped at this line; scans that started from this time on count.
    Staring(usize, Duration),
    StoppingLaser,
    TimeAfter,
    Ending {
        error: DeviceError,
        laser_stopped: bool,
        head_stopped: bool,
    },
    Done,
}

/// A running sweep. After each input, drain [`poll_action`](Self::poll_action); it ends when
/// [`take_outcome`](Self::take_outcome) returns something.
#[derive(Debug)]
pub(crate) struct SweepRun {
    plan: SweepPlan,
    ports: PortNames,
    phase: SweepPhase,
    limit: Duration,
    actions: VecDeque<SweepAction>,
    segment: usize,
    segments: Vec<PanSegment>,
    draft: PanSegmentDraft,
    stamps: StampUnwrapper,
    scan_times: ScanTimeEstimator,
    last_steps: i32,
    outcome: Option<Result<RawSweep, DeviceError>>,
}

impl SweepRun {
    /// Starts. Both devices must be connected and idle, the head's position trusted.
    pub(super) fn new(plan: SweepPlan, ports: PortNames, now: Duration) -> Self {
        let mut run = Self {
            plan,
            ports,
            phase: SweepPhase::Done,
            limit: now,
            actions: VecDeque::new(),
            segment: 0,
            segments: Vec::new(),
            draft: PanSegmentDraft::default(),
            stamps: StampUnwrapper::default(),
            scan_times: ScanTimeEstimator::default(),
            last_steps: 0,
            outcome: None,
        };
        run.start_segment(now);
        run
    }

    pub(super) fn poll_action(&mut self) -> Option<SweepAction> {
        self.actions.pop_front()
    }

    /// The result, once.
    pub(super) fn take_outcome(&mut self) -> Option<Result<RawSweep, DeviceError>> {
        self.outcome.take()
    }

    /// When to call [`on_time`](Self::on_time).
    pub(super) fn deadline(&self) -> Duration {
        match &self.phase {
            SweepPhase::Moving(_, watch, _)
            | SweepPhase::Sweeping(watch)
            | SweepPhase::Stepping(_, watch) => watch.overdue_at().min(self.limit),
            _ => self.limit,
        }
    }

    /// Ends the sweep with [`DeviceError::Cancelled`].
    pub(super) fn cancel(&mut self, now: Duration) {
        self.fail(DeviceError::Cancelled, now);
    }

    /// The port of a device failed.
    pub(super) fn on_lost(&mut self, device: Device, error: DeviceError, now: Duration) {
        self.fail(error, now);
        // The laser's driver sent QT before; it takes effect at the laser's next tick, so wait for that.
        if device == Device::Head {
            self.stopped(device);
        }
    }

    pub(super) fn on_time(&mut self, now: Duration) {
        if now < self.deadline() {
            return;
        }
        let port = || self.ports.head.clone();
        let error = match &self.phase {
            SweepPhase::Done => return,
            SweepPhase::Ending { .. } => {
                self.stopped(Device::Laser);
                self.stopped(Device::Head);
                return;
            }
            SweepPhase::Moving(axis, _, target) => {
                stalled_error(port(), *axis, self.last_steps, *target)
            }
            SweepPhase::Sweeping(_) | SweepPhase::Stepping(..) => DeviceError::Overdue {
                device: Device::Head,
                port: port(),
                what: "a tilt at the commanded speed",
                limit_s: STEP_LIMIT.as_secs(),
            },
            _ => DeviceError::Overdue {
                device: Device::Laser,
                port: self.ports.laser.clone(),
                what: "its part of the sweep",
                limit_s: STEP_LIMIT.as_secs(),
            },
        };
        self.fail(error, now);
    }

    pub(super) fn on_laser(&mut self, event: scip::LaserEvent, now: Duration) {
        use scip::LaserEvent as E;
        match event {
            E::Stopped => match self.phase {
                SweepPhase::Ending { .. } => self.stopped(Device::Laser),
                SweepPhase::StoppingLaser => self.exchange_time(SweepPhase::TimeAfter, now),
                _ => {}
            },
            E::ConnectionFailed(error) | E::RequestFailed(error) => {
                self.fail(
                    laser_error(&error, &self.ports.laser, Device::Laser.port_key()),
                    now,
                );
            }
            E::TimeSample {
                sent,
                received,
                stamp_ms,
            } => {
                let sample = time_sample(sent, received, stamp_ms, &mut self.stamps);
                self.draft.time_samples.push(sample);
            }
            E::TimeExchanged { .. } => match self.phase {
                SweepPhase::TimeBefore => {
                    self.scan_times.restart(&self.draft.time_samples);
                    self.warm_up(now);
                }
                SweepPhase::TimeAfter => self.finish_segment(now),
                _ => {}
            },
            E::Scan {
                scan,
                first_byte_at,
                ..
            } => self.on_scan(scan, first_byte_at, now),
            E::Rejected {
                reason: Rejection::StampJump { advance_ms, .. },
                ..
            } => self.timer_lost(format!("jumped by {advance_ms} ms"), now),
            E::Recovered { timer_reset: true } => {
                self.timer_lost("was reset to recover its stream".to_owned(), now);
            }
            E::Recovering { cause, .. } => {
                self.restart_warm_up();
                self.note(Device::Laser, format!("restarting its stream: {cause}"));
            }
            E::Verifying { status } => {
                self.restart_warm_up();
                self.note(
                    Device::Laser,
                    format!("stopped for a self-check (status {status})"),
                );
            }
            E::LostScans(count) => self.note(Device::Laser, format!("{count} scans lost")),
            E::Connected(_) => self.timer_lost("was reset: it reconnected".to_owned(), now),
            E::Rejected { .. }
            | E::WrongSumsTolerated { .. }
            | E::Recovered { timer_reset: false }
            | E::VerifiedNormal
            | E::BitRateKept { .. }
            | E::Streaming => {}
        }
    }

    pub(super) fn on_head(&mut self, event: HeadEvent, now: Duration) {
        use ptu::PtuEvent as E;
        let event = match event {
            HeadEvent::Ptu(event) => event,
            HeadEvent::Rejected(error) => {
                let lost = DeviceError::NotConnected {
                    device: Device::Head,
                    port: self.ports.head.clone(),
                    detail: error.to_string(),
                };
                return self.fail(lost, now);
            }
        };
        match event {
            E::Position {
                axis,
                steps,
                sent_at,
                first_byte_at,
            } => self.on_position(axis, steps, (sent_at, first_byte_at), now),
            E::Halted => {
                if matches!(self.phase, SweepPhase::Ending { .. }) {
                    self.stopped(Device::Head);
                }
            }
            E::Fault(error) => {
                let error = head_error(&error, &self.ports.head, Device::Head.port_key());
                self.on_lost(Device::Head, error, now);
            }
            E::LimitHit(axis) => {
                self.position_lost(format!("{} ran into its limit", axis_name(axis)), now);
            }
            E::CableLost => self.position_lost("the cable to the head came off".to_owned(), now),
            E::EchoReturned | E::VerboseReturned | E::Restarted => {
                self.position_lost("the unit restarted in between".to_owned(), now);
            }
            // Reconnecting starts with a halt.
            E::Connected(_) => {
                self.position_lost("the unit restarted in between".to_owned(), now);
                self.stopped(Device::Head);
            }
            E::Refused { command, text } => {
                let refused = DeviceError::Refused {
                    device: Device::Head,
                    port: self.ports.head.clone(),
                    command,
                    detail: text,
                };
                self.fail(refused, now);
            }
            E::SpeedSet { .. }
            | E::MoveAccepted { .. }
            | E::HomeDone { .. }
            | E::Health(_)
            | E::HoldPowerLow => {}
        }
    }

    fn on_position(&mut self, axis: Axis, steps: i32, at: (Duration, Duration), now: Duration) {
        let (tilt, observed_at) = (axis == Axis::Tilt, at.1);
        self.last_steps = steps;
        match &mut self.phase {
            SweepPhase::Moving(moving, watch, target) if *moving == axis => {
                let target = *target;
                match watch.observe(steps, observed_at) {
                    MoveState::Moving => {}
                    MoveState::Arrived if tilt => self.exchange_time(SweepPhase::TimeBefore, now),
                    MoveState::Arrived => self.tilt_to_start(now),
                    _ => self.fail(
                        stalled_error(self.ports.head.clone(), axis, steps, target),
                        now,
                    ),
                }
            }
            SweepPhase::Sweeping(watch) if tilt => {
                let state = watch.observe(steps, observed_at);
                self.draft.polls.push(PositionPoll {
                    sent_s: at.0.as_secs_f64(),
                    received_s: at.1.as_secs_f64(),
                    tilt_steps: steps,
                });
                match state {
                    MoveState::Moving => {}
                    MoveState::Arrived => self.stop_laser(now),
                    _ => self.tilt_stalled(steps, now),
                }
            }
            SweepPhase::Stepping(line, watch) if tilt => {
                let line = *line;
                match watch.observe(steps, observed_at) {
                    MoveState::Moving => {}
                    MoveState::Arrived => {
                        self.phase = SweepPhase::Staring(line, observed_at + SETTLE);
                        self.limit = now + STEP_LIMIT;
                    }
                    _ => self.tilt_stalled(steps, now),
                }
            }
            SweepPhase::Staring(line, _) if tilt => {
                let line = *line;
                if self.line_target(line) != Some(steps) {
                    self.tilt_stalled(steps, now);
                }
            }
            _ => {}
        }
    }

    fn on_scan(&mut self, scan: scip::LaserScan, first_byte_at: Duration, now: Duration) {
        let raw = StampedScan {
            stamp_ms: self.stamps.unwrap(scan.stamp_ms),
            arrived_s: first_byte_at.as_secs_f64(),
            values: scan.ranges,
        };
        let begun_s = self
            .scan_times
            .start_time_s(&raw, self.plan.scan_geometry.period_s);
        match &mut self.phase {
            SweepPhase::WarmingUp(good) => {
                *good += 1;
                if *good >= WARM_UP_SCANS {
                    self.start_tilt(now);
                }
            }
            SweepPhase::Sweeping(_) => self.draft.scans.push(raw),
            SweepPhase::Staring(line, since) => {
                let line = *line;
                if begun_s >= since.as_secs_f64() {
                    self.draft.scans.push(raw);
                    self.draft.tilt_steps.extend(self.line_target(line));
                    self.step_to(line + 1, now);
                }
            }
            _ => {}
        }
    }
}

fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::Pan => "pan",
        Axis::Tilt => "tilt",
    }
}

pub(super) fn stalled_error(
    port: String,
    axis: Axis,
    at_steps: i32,
    target_steps: i32,
) -> DeviceError {
    DeviceError::Stalled {
        port,
        axis: axis_name(axis),
        at_steps,
        target_steps,
    }
}
