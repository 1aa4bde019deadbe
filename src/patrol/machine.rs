//! The state machine. Time is an argument; sweeps and verdicts are held by the service, so that every path can be tested as
//! a table of events and actions.

use super::action::PatrolAction;
use super::constants::{CANCELLED_DURING_SWEEP, INITIAL_RETRY_PAUSE, MAX_QUEUED};
use super::event::{PatrolEvent, PatrolRequest, PatrolTask, RefusalReason, SettingsChange};
use super::severity::Severity;
use super::turn_history::TurnHistory;
use std::collections::VecDeque;
use std::time::Duration;

mod devices;
mod ending;
mod lost_steps;

/// State of the devices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceAvailability {
    /// Being connected and homed.
    Opening,
    /// Ready to sweep.
    Ready,
    /// The head is being homed at an idle moment.
    Homing,
    /// Absent or failed.
    Lost {
        /// Reason, one line.
        reason: String,
        /// Time of the next try.
        retry_at: Duration,
    },
    /// Released at the end of the service.
    Closed,
}

/// Stage of the current request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequestStage {
    /// Its reference is loading.
    Preparing,
    /// It waits for the devices.
    Waiting,
    /// The devices sweep.
    Sweeping,
    /// The sweep is judged.
    Judging,
    /// The result is written to disk.
    Recording,
}

impl RequestStage {
    /// As in the API.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Preparing => "preparing",
            Self::Waiting => "waiting",
            Self::Sweeping => "sweeping",
            Self::Judging => "judging",
            Self::Recording => "recording",
        }
    }
}

/// The patrol: one current request, a queue, and the state of the devices.
#[derive(Debug, Clone)]
pub struct PatrolMachine {
    devices: DeviceAvailability,
    /// Pause before the next retry.
    retry_pause: Duration,
    /// Last logged reason of absent devices.
    reported_absence: Option<String>,
    current: Option<(PatrolRequest, RequestStage)>,
    queue: VecDeque<PatrolRequest>,
    /// Request whose sweep is being cancelled because its client has disconnected.
    abandoned: Option<u64>,
    /// Visit whose sweep is being cancelled because its client asked for it.
    cancelled_visit: Option<u64>,
    pending_change: Option<SettingsChange>,
    turns: TurnHistory,
    stopping: bool,
    exited: bool,
}

impl PatrolMachine {
    /// A new patrol and its first actions. From turns of one view by these on, radians of pan and tilt, steps may be lost as long
    /// as the robot's own errors are not known.
    pub fn start(suspect_pan_rad: f64, suspect_tilt_rad: f64) -> (Self, Vec<PatrolAction>) {
        let machine = Self {
            devices: DeviceAvailability::Opening,
            retry_pause: INITIAL_RETRY_PAUSE,
            reported_absence: None,
            current: None,
            queue: VecDeque::new(),
            abandoned: None,
            cancelled_visit: None,
            pending_change: None,
            turns: TurnHistory::new(suspect_pan_rad, suspect_tilt_rad),
            stopping: false,
            exited: false,
        };
        (machine, vec![PatrolAction::OpenDevices])
    }

    /// State of the devices.
    pub fn devices(&self) -> &DeviceAvailability {
        &self.devices
    }

    /// Takes other turns of one view for suspect, as at the [`start`](Self::start).
    pub fn suspect_turns(&mut self, pan_rad: f64, tilt_rad: f64) {
        self.turns.suspect(pan_rad, tilt_rad);
    }

    /// The current request and its stage.
    pub fn current(&self) -> Option<(&PatrolRequest, RequestStage)> {
        self.current.as_ref().map(|(r, stage)| (r, *stage))
    }

    /// Number of requests in the queue.
    pub fn queued(&self) -> usize {
        self.queue.len()
    }

    /// As in the status.
    pub fn phase(&self) -> &'static str {
        if self.stopping {
            return "stopping";
        }
        match (&self.current, &self.devices) {
            (Some((_, RequestStage::Preparing)), _) => "preparing",
            (Some((_, RequestStage::Sweeping)), _) => "sweeping",
            (Some((_, RequestStage::Judging)), _) => "judging",
            (Some((_, RequestStage::Recording)), _) => "recording",
            (_, DeviceAvailability::Opening) => "starting",
            (_, DeviceAvailability::Homing) => "homing",
            (_, DeviceAvailability::Lost { .. }) => "devices lost",
            (_, DeviceAvailability::Ready | DeviceAvailability::Closed) => "idle",
        }
    }

    /// Handles one event at `now` (any monotonic clock); returns the actions in order.
    pub fn handle(&mut self, now: Duration, event: PatrolEvent) -> Vec<PatrolAction> {
        let mut out = Vec::new();
        match event {
            PatrolEvent::DevicesReady => self.devices_ready(&mut out),
            PatrolEvent::HeadHomed => self.turns.homed(now),
            PatrolEvent::HomingDone => self.homing_done(now, &mut out),
            PatrolEvent::ViewTurned(seen) => self.turns.observe(&seen),
            PatrolEvent::DevicesFailed(reason) => self.devices_failed(now, reason, &mut out),
            PatrolEvent::DevicesAbsent(reason) => self.devices_absent(now, reason, &mut out),
            PatrolEvent::DevicesLost(reason) => {
                // A running sweep reports the loss itself.
                let sweeping = matches!(self.current, Some((_, RequestStage::Sweeping)));
                let idle = [DeviceAvailability::Ready, DeviceAvailability::Homing];
                if idle.contains(&self.devices) && !sweeping {
                    self.devices_absent(now, reason, &mut out);
                }
            }
            PatrolEvent::DevicesClosed => {
                if self.stopping {
                    self.devices = DeviceAvailability::Closed;
                }
            }
            PatrolEvent::Requested(request) => self.enqueue(request, &mut out),
            PatrolEvent::ClientGone(id) => self.client_gone(id, &mut out),
            PatrolEvent::Cancelled(id) => self.cancelled(id, &mut out),
            PatrolEvent::Prepared(id, result) => {
                if let Some(request) = self.take_current(id, RequestStage::Preparing) {
                    match result {
                        Ok(()) => self.start_sweep(request, &mut out),
                        // The disk fails, not the client: the log says that nobody looked.
                        Err(RefusalReason::Failed(why)) => {
                            self.record_not_observed(request, why, &mut out);
                        }
                        Err(refusal) => out.push(PatrolAction::Refuse(request, refusal)),
                    }
                }
            }
            PatrolEvent::SweepDone(id) => self.sweep_done(id, &mut out),
            PatrolEvent::SweepFailed { id, reason, lost } => {
                self.sweep_failed(id, reason, lost, &mut out);
            }
            PatrolEvent::LostStepsSuspected(id, reason) => {
                self.lost_steps_suspected(id, &reason, &mut out)
            }
            PatrolEvent::Judged(id, result) => {
                if let Some(request) = self.take_current(id, RequestStage::Judging) {
                    self.judged(request, result, &mut out);
                }
            }
            PatrolEvent::Recorded(id, result) => {
                if let Some(request) = self.take_current(id, RequestStage::Recording) {
                    out.push(match result {
                        Ok(()) => PatrolAction::Reply(request),
                        Err(why) => PatrolAction::Refuse(request, RefusalReason::Failed(why)),
                    });
                }
            }
            PatrolEvent::Reload(Ok(change)) => {
                let reopen = [Some(change), self.pending_change]
                    .contains(&Some(SettingsChange::ReopenDevices));
                self.pending_change = Some(if reopen {
                    SettingsChange::ReopenDevices
                } else {
                    SettingsChange::KeepDevices
                });
            }
            PatrolEvent::Reload(Err(errors)) => out.push(PatrolAction::KeepSettings(errors)),
            PatrolEvent::Shutdown => self.shutdown(&mut out),
            PatrolEvent::Tick => self.tick(now, &mut out),
        }
        self.advance(now, &mut out);
        out
    }

    /// Ends, applies settings, starts the next request, or homes the head while there is none.
    fn advance(&mut self, now: Duration, out: &mut Vec<PatrolAction>) {
        if self.stopping {
            if self.current.is_none() && self.devices == DeviceAvailability::Closed && !self.exited
            {
                self.exited = true;
                out.push(PatrolAction::Exit);
            }
            return;
        }
        self.apply_change(out);
        while self.current.is_none() {
            let Some(request) = self.queue.pop_front() else {
                return self.home_if_due(now, out);
            };
            if request.task != PatrolTask::Sweep {
                out.push(PatrolAction::Prepare(request.clone()));
                self.current = Some((request, RequestStage::Preparing));
            } else {
                self.start_sweep(request, out);
            }
        }
    }

    fn enqueue(&mut self, request: PatrolRequest, out: &mut Vec<PatrolAction>) {
        if self.stopping {
            out.push(PatrolAction::Refuse(request, RefusalReason::Stopping));
        } else if self.queue.len() >= MAX_QUEUED {
            out.push(PatrolAction::Refuse(request, RefusalReason::Busy));
        } else {
            self.queue.push_back(request);
        }
    }

    fn start_sweep(&mut self, request: PatrolRequest, out: &mut Vec<PatrolAction>) {
        let stage = match &self.devices {
            DeviceAvailability::Ready => {
                out.push(PatrolAction::StartSweep(request.clone()));
                RequestStage::Sweeping
            }
            DeviceAvailability::Opening | DeviceAvailability::Homing => RequestStage::Waiting,
            // They may be back before the next retry.
            DeviceAvailability::Lost { .. } => {
                self.open(out);
                RequestStage::Waiting
            }
            DeviceAvailability::Closed => {
                out.push(PatrolAction::Refuse(request, RefusalReason::Stopping));
                return;
            }
        };
        self.current = Some((request, stage));
    }

    /// A visit without a sweep is stored as not observed; other tasks are refused.
    fn sweep_unavailable(
        &mut self,
        request: PatrolRequest,
        reason: String,
        out: &mut Vec<PatrolAction>,
    ) {
        if request.task == PatrolTask::Visit {
            self.record_not_observed(request, reason, out);
        } else {
            let task = request.task.as_str();
            let refusal = RefusalReason::NoSweep(format!("{task} refused: {reason}"));
            out.push(PatrolAction::Refuse(request, refusal));
        }
    }

    fn record_not_observed(
        &mut self,
        request: PatrolRequest,
        reason: String,
        out: &mut Vec<PatrolAction>,
    ) {
        out.push(PatrolAction::RecordNotObserved(request.clone(), reason));
        self.current = Some((request, RequestStage::Recording));
    }

    fn sweep_done(&mut self, id: u64, out: &mut Vec<PatrolAction>) {
        let Some(request) = self.take_current(id, RequestStage::Sweeping) else {
            return;
        };
        if self.abandoned.take() == Some(id) {
            out.push(PatrolAction::Abandon(request));
            return;
        }
        if self.stopping {
            let reason = "the service was stopped before the sweep was judged".to_owned();
            return self.sweep_unavailable(request, reason, out);
        }
        if self.cancelled_visit.take() == Some(id) {
            return self.record_not_observed(request, CANCELLED_DURING_SWEEP.to_owned(), out);
        }
        out.push(PatrolAction::Judge(request.clone()));
        self.current = Some((request, RequestStage::Judging));
    }

    fn sweep_failed(&mut self, id: u64, reason: String, lost: bool, out: &mut Vec<PatrolAction>) {
        let Some(request) = self.take_current(id, RequestStage::Sweeping) else {
            return;
        };
        if self.stopping {
            let reason = "the service was stopped during the sweep".to_owned();
            return self.sweep_unavailable(request, reason, out);
        }
        if self.abandoned.take() == Some(id) {
            if lost {
                self.open(out);
            }
            out.push(PatrolAction::Abandon(request));
            return;
        }
        if self.cancelled_visit.take() == Some(id) {
            if lost {
                self.open(out);
            }
            return self.record_not_observed(request, CANCELLED_DURING_SWEEP.to_owned(), out);
        }
        out.push(PatrolAction::LogEvent(
            Severity::Error,
            format!("sweep failed: {reason}"),
        ));
        if lost {
            self.open(out);
        }
        self.sweep_unavailable(request, reason, out);
    }

    fn judged(
        &mut self,
        request: PatrolRequest,
        result: Result<(), String>,
        out: &mut Vec<PatrolAction>,
    ) {
        match (result, request.task) {
            (Ok(()), PatrolTask::Sweep) => out.push(PatrolAction::Reply(request)),
            (Ok(()), PatrolTask::Visit | PatrolTask::Teach) => {
                out.push(PatrolAction::Record(request.clone()));
                self.current = Some((request, RequestStage::Recording));
            }
            (Err(reason), PatrolTask::Visit) => self.record_not_observed(request, reason, out),
            (Err(reason), task) => {
                let refusal =
                    RefusalReason::BadSweep(format!("{} refused: {reason}", task.as_str()));
                out.push(PatrolAction::Refuse(request, refusal));
            }
        }
    }

    fn tick(&mut self, now: Duration, out: &mut Vec<PatrolAction>) {
        let due =
            matches!(&self.devices, DeviceAvailability::Lost { retry_at, .. } if now >= *retry_at);
        if due && !self.stopping {
            self.open(out);
        }
    }

    /// Takes the current request if it has this number and stage.
    fn take_current(&mut self, id: u64, stage: RequestStage) -> Option<PatrolRequest> {
        let matches = matches!(&self.current, Some((r, s)) if r.id == id && *s == stage);
        let taken = if matches { self.current.take() } else { None };
        taken.map(|(request, _)| request)
    }
}

#[cfg(test)]
mod tests;
