//! One sweep, from both devices' events to commands for both: no thread, no clock, no port (sweep-geometry section 7).
//!
//! ```text
//! pan -> tilt to the start -> time exchange -> stream, good scans -+-> tilt to the end, polls and scans --+-> QT ->
//!  ^                                                               +-> (stand, settle, one scan) per line -+      |
//!  +---------------------------- next pan <- time exchange <-----------------------------------------------------+
//! ```
//!
//! Whatever makes an angle or an instant doubtful ends the sweep with its reason; then the laser is turned off and the
//! head stopped before the outcome is told.

mod steps;

use super::constants::{SETTLE, STEP_LIMIT, WARM_SCANS};
use super::error::{Device, DeviceError};
use super::head::{HeadCommand, HeadEvent, head_error};
use super::laser::{LaserCommand, laser_error};
use super::plan::SweepPlan;
use super::sweep_data::{LegDraft, ScanDating, StampUnwrapper, time_sample};
use patrold_engine::sweep::{Leg, Poll, RawScan, RawSweep};
use ptu::{Axis, MoveState, MoveWatch};
use scip::Rejection;
use std::collections::VecDeque;
use std::time::Duration;

/// What the sweep wants done.
#[derive(Debug, Clone, PartialEq)]
pub enum RunAction {
    /// Ask this of the laser.
    Laser(LaserCommand),
    /// Ask this of the head.
    Head(HeadCommand),
    /// Something worth knowing that does not spoil the sweep.
    Note(Device, String),
}

/// Names of the two ports, for messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortNames {
    /// The laser's.
    pub laser: String,
    /// The head's.
    pub head: String,
}

#[derive(Debug)]
enum Phase {
    Moving(Axis, MoveWatch, i32),
    TimeBefore,
    Warming(u32),
    Sweeping(MoveWatch),
    /// On the way to this line.
    Stepping(usize, MoveWatch),
    /// Standing at this line since.
    Staring(usize, Duration),
    StoppingLaser,
    TimeAfter,
    Ending {
        error: DeviceError,
        laser_rests: bool,
        head_rests: bool,
    },
    Done,
}

/// A sweep under way. One input, then drain [`poll_action`](Self::poll_action); over when
/// [`take_outcome`](Self::take_outcome) gives something.
#[derive(Debug)]
pub struct SweepRun {
    plan: SweepPlan,
    ports: PortNames,
    phase: Phase,
    limit: Duration,
    actions: VecDeque<RunAction>,
    leg: usize,
    legs: Vec<Leg>,
    draft: LegDraft,
    stamps: StampUnwrapper,
    dating: ScanDating,
    last_steps: i32,
    outcome: Option<Result<RawSweep, DeviceError>>,
}

impl SweepRun {
    /// Begins. Both devices must be connected and idle, the head's position trusted.
    pub fn new(plan: SweepPlan, ports: PortNames, now: Duration) -> Self {
        let mut run = Self {
            plan,
            ports,
            phase: Phase::Done,
            limit: now,
            actions: VecDeque::new(),
            leg: 0,
            legs: Vec::new(),
            draft: LegDraft::default(),
            stamps: StampUnwrapper::default(),
            dating: ScanDating::default(),
            last_steps: 0,
            outcome: None,
        };
        run.begin_leg(now);
        run
    }

    /// The next thing to do, until `None`.
    pub fn poll_action(&mut self) -> Option<RunAction> {
        self.actions.pop_front()
    }

    /// What came of it, once.
    pub fn take_outcome(&mut self) -> Option<Result<RawSweep, DeviceError>> {
        self.outcome.take()
    }

    /// When [`on_time`](Self::on_time) is wanted.
    pub fn deadline(&self) -> Duration {
        match &self.phase {
            Phase::Moving(_, watch, _) | Phase::Sweeping(watch) | Phase::Stepping(_, watch) => {
                watch.overdue_at().min(self.limit)
            }
            _ => self.limit,
        }
    }

    /// Ends the sweep; the outcome is [`DeviceError::Cancelled`] as soon as laser and head rest.
    pub fn cancel(&mut self, now: Duration) {
        self.fail(DeviceError::Cancelled, now);
    }

    /// A device is gone: its port failed.
    pub fn on_lost(&mut self, device: Device, error: DeviceError, now: Duration) {
        self.fail(error, now);
        // The driver's last word to the laser was QT, which takes effect at the laser's next tick: wait for that.
        if device == Device::Head {
            self.rests(device);
        }
    }

    /// Takes the passing of time.
    pub fn on_time(&mut self, now: Duration) {
        if now < self.deadline() {
            return;
        }
        let port = || self.ports.head.clone();
        let error = match &self.phase {
            Phase::Done => return,
            Phase::Ending { .. } => {
                self.rests(Device::Laser);
                self.rests(Device::Head);
                return;
            }
            Phase::Moving(axis, _, target) => stalled(port(), *axis, self.last_steps, *target),
            Phase::Sweeping(_) | Phase::Stepping(..) => DeviceError::Overdue {
                device: Device::Head,
                port: port(),
                what: "a tilt at the speed it was told",
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

    /// Takes an event of the laser.
    pub fn on_laser(&mut self, event: scip::Event, now: Duration) {
        use scip::Event as E;
        match event {
            E::Stopped => match self.phase {
                Phase::Ending { .. } => self.rests(Device::Laser),
                Phase::StoppingLaser => self.exchange_time(Phase::TimeAfter, now),
                _ => {}
            },
            E::Fault(error) | E::Failed(error) => {
                self.fail(laser_error(&error, &self.ports.laser), now);
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
                Phase::TimeBefore => {
                    self.dating.begin(&self.draft.time_samples);
                    self.warm_up(now);
                }
                Phase::TimeAfter => self.finish_leg(now),
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
                self.timer_lost("was reset to bring its stream back".to_owned(), now);
            }
            E::Recovering { cause, .. } => {
                self.warm_again();
                self.note(Device::Laser, format!("its stream is restarted: {cause}"));
            }
            E::Verifying { status } => {
                self.warm_again();
                self.note(
                    Device::Laser,
                    format!("it stopped to check itself (status {status})"),
                );
            }
            E::LostScans(count) => self.note(Device::Laser, format!("{count} scans lost")),
            E::Connected(_) => self.timer_lost("was reset: it was connected anew".to_owned(), now),
            E::Rejected { .. }
            | E::Recovered { timer_reset: false }
            | E::VerifiedNormal
            | E::Streaming
            | E::Info(_)
            | E::Applied(_) => {}
        }
    }

    /// Takes an event of the head.
    pub fn on_head(&mut self, event: HeadEvent, now: Duration) {
        use ptu::Event as E;
        let event = match event {
            HeadEvent::Unit(event) => event,
            HeadEvent::NotTaken(error) => {
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
                if matches!(self.phase, Phase::Ending { .. }) {
                    self.rests(Device::Head);
                }
            }
            E::Fault(error) => {
                let error = head_error(&error, &self.ports.head);
                self.on_lost(Device::Head, error, now);
            }
            E::LimitHit(axis) => {
                self.position_lost(format!("{} ran into its limit", axis_name(axis)), now);
            }
            E::CableLost => self.position_lost("the cable to the head came off".to_owned(), now),
            E::EchoReturned | E::VerboseReturned | E::Restarted => {
                self.position_lost("the unit restarted in between".to_owned(), now);
            }
            // Making the settings anew begins with a halt.
            E::Connected(_) => {
                self.position_lost("the unit restarted in between".to_owned(), now);
                self.rests(Device::Head);
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
            | E::Speed { .. }
            | E::Target { .. }
            | E::HoldPowerSet { .. }
            | E::MovePowerSet { .. }
            | E::AxisHalted(_)
            | E::HoldPowerLow => {}
        }
    }

    fn on_position(&mut self, axis: Axis, steps: i32, at: (Duration, Duration), now: Duration) {
        let (tilt, observed_at) = (axis == Axis::Tilt, at.1);
        self.last_steps = steps;
        match &mut self.phase {
            Phase::Moving(moving, watch, target) if *moving == axis => {
                let target = *target;
                match watch.observe(steps, observed_at) {
                    MoveState::Moving => {}
                    MoveState::Arrived if tilt => self.exchange_time(Phase::TimeBefore, now),
                    MoveState::Arrived => self.tilt_to_start(now),
                    _ => self.fail(stalled(self.ports.head.clone(), axis, steps, target), now),
                }
            }
            Phase::Sweeping(watch) if tilt => {
                let state = watch.observe(steps, observed_at);
                self.draft.polls.push(Poll {
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
            Phase::Stepping(line, watch) if tilt => {
                let line = *line;
                match watch.observe(steps, observed_at) {
                    MoveState::Moving => {}
                    MoveState::Arrived => {
                        self.phase = Phase::Staring(line, observed_at + SETTLE);
                        self.limit = now + STEP_LIMIT;
                    }
                    _ => self.tilt_stalled(steps, now),
                }
            }
            Phase::Staring(line, _) if tilt => {
                let line = *line;
                if self.line_target(line) != Some(steps) {
                    self.tilt_stalled(steps, now);
                }
            }
            _ => {}
        }
    }

    fn on_scan(&mut self, scan: scip::RawScan, first_byte_at: Duration, now: Duration) {
        let raw = RawScan {
            stamp_ms: self.stamps.unwrap(scan.stamp_ms),
            arrived_s: first_byte_at.as_secs_f64(),
            values: scan.ranges,
        };
        let begun_s = self.dating.begun_s(&raw, self.plan.optics.period_s);
        match &mut self.phase {
            Phase::Warming(good) => {
                *good += 1;
                if *good >= WARM_SCANS {
                    self.begin_tilt(now);
                }
            }
            Phase::Sweeping(_) => self.draft.scans.push(raw),
            Phase::Staring(line, since) => {
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

/// An axis that did not come where it was sent.
pub(super) fn stalled(port: String, axis: Axis, at_steps: i32, target_steps: i32) -> DeviceError {
    DeviceError::Stalled {
        port,
        axis: axis_name(axis),
        at_steps,
        target_steps,
    }
}
