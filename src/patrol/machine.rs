//! The patrol as a state machine: events in, actions out, time as an argument. It holds no sweep and no verdict,
//! only what happens next, so that every way through it can be tested as a table.

use super::action::{Action, Weight};
use super::constants::{FIRST_RETRY, MOST_WAITING};
use super::event::{Change, Event, Refusal, Request, Task};
use std::collections::VecDeque;
use std::time::Duration;

mod devices;
mod doubt;

/// Where the devices stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Devices {
    /// Being connected and homed.
    Opening,
    /// Ready to sweep.
    Ready,
    /// Gone; tried again at `retry_at`.
    Lost {
        /// Why.
        reason: String,
        /// When they are tried again.
        retry_at: Duration,
    },
    /// Let go at the end.
    Closed,
}

/// How far the request in hand has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Its reference is looked up.
    Preparing,
    /// It waits for the devices.
    Waiting,
    /// The devices sweep.
    Sweeping,
    /// The sweep is judged.
    Judging,
    /// The outcome goes to disk.
    Recording,
}

/// The patrol.
#[derive(Debug, Clone)]
pub struct Machine {
    devices: Devices,
    /// Pause before the next retry.
    pause: Duration,
    /// What was last said of absent devices.
    absent: Option<String>,
    in_hand: Option<(Request, Step)>,
    waiting: VecDeque<Request>,
    /// A request whose sweep is being called off because its asker went away.
    unwanted: Option<u64>,
    change: Option<Change>,
    stopping: bool,
    exited: bool,
}

impl Machine {
    /// A patrol that has just begun, and its first actions.
    pub fn start() -> (Self, Vec<Action>) {
        let machine = Self {
            devices: Devices::Opening,
            pause: FIRST_RETRY,
            absent: None,
            in_hand: None,
            waiting: VecDeque::new(),
            unwanted: None,
            change: None,
            stopping: false,
            exited: false,
        };
        (machine, vec![Action::OpenDevices])
    }

    /// Where the devices stand.
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// The request in hand and how far it has come.
    pub fn in_hand(&self) -> Option<(&Request, Step)> {
        self.in_hand.as_ref().map(|(r, step)| (r, *step))
    }

    /// Requests that wait behind it.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Whether the service is ending.
    pub fn is_stopping(&self) -> bool {
        self.stopping
    }

    /// The phase in one word.
    pub fn phase(&self) -> &'static str {
        if self.stopping {
            return "stopping";
        }
        match (&self.in_hand, &self.devices) {
            (Some((_, Step::Preparing)), _) => "preparing",
            (Some((_, Step::Sweeping)), _) => "sweeping",
            (Some((_, Step::Judging)), _) => "judging",
            (Some((_, Step::Recording)), _) => "recording",
            (_, Devices::Opening) => "starting",
            (_, Devices::Lost { .. }) => "devices lost",
            (_, Devices::Ready | Devices::Closed) => "idle",
        }
    }

    /// Takes one event at `now` (any monotone clock), gives what is to be done, in order.
    pub fn handle(&mut self, now: Duration, event: Event) -> Vec<Action> {
        let mut out = Vec::new();
        match event {
            Event::DevicesReady => self.devices_ready(&mut out),
            Event::DevicesFailed(reason) => self.devices_failed(now, reason, &mut out),
            Event::DevicesAbsent(reason) => self.devices_absent(now, reason, &mut out),
            Event::DevicesLost(reason) => {
                // During a sweep, the sweep tells it.
                let sweeping = matches!(self.in_hand, Some((_, Step::Sweeping)));
                if self.devices == Devices::Ready && !sweeping {
                    self.devices_absent(now, reason, &mut out);
                }
            }
            Event::DevicesClosed => {
                if self.stopping {
                    self.devices = Devices::Closed;
                }
            }
            Event::Requested(request) => self.requested(request, &mut out),
            Event::AskerGone(id) => self.asker_gone(id, &mut out),
            Event::Prepared(id, result) => {
                if let Some(request) = self.take(id, Step::Preparing) {
                    match result {
                        Ok(()) => self.sweep(request, &mut out),
                        Err(refusal) => out.push(Action::Refuse(request, refusal)),
                    }
                }
            }
            Event::SweepDone(id) => self.swept(id, &mut out),
            Event::SweepFailed { id, reason, lost } => {
                self.sweep_failed(id, reason, lost, &mut out);
            }
            Event::Doubted(id, reason) => self.doubted(id, &reason, &mut out),
            Event::Judged(id, result) => {
                if let Some(request) = self.take(id, Step::Judging) {
                    self.judged(request, result, &mut out);
                }
            }
            Event::Recorded(id, result) => {
                if let Some(request) = self.take(id, Step::Recording) {
                    out.push(match result {
                        Ok(()) => Action::Reply(request),
                        Err(why) => Action::Refuse(request, Refusal::Failed(why)),
                    });
                }
            }
            Event::Reload(Ok(change)) => {
                let devices = change == Change::Devices || self.change == Some(Change::Devices);
                self.change = Some(if devices {
                    Change::Devices
                } else {
                    Change::Plain
                });
            }
            Event::Reload(Err(mistakes)) => out.push(Action::KeepSettings(mistakes)),
            Event::Shutdown => self.shutdown(&mut out),
            Event::Tick => self.tick(now, &mut out),
        }
        self.go_on(&mut out);
        out
    }

    /// What follows by itself once an event is dealt with.
    fn go_on(&mut self, out: &mut Vec<Action>) {
        if self.stopping {
            if self.in_hand.is_none() && self.devices == Devices::Closed && !self.exited {
                self.exited = true;
                out.push(Action::Exit);
            }
            return;
        }
        self.apply_change(out);
        while self.in_hand.is_none() {
            let Some(request) = self.waiting.pop_front() else {
                return;
            };
            if request.task == Task::Visit {
                out.push(Action::Prepare(request.clone()));
                self.in_hand = Some((request, Step::Preparing));
            } else {
                self.sweep(request, out);
            }
        }
    }

    fn requested(&mut self, request: Request, out: &mut Vec<Action>) {
        if self.stopping {
            out.push(Action::Refuse(request, Refusal::Stopping));
        } else if self.waiting.len() >= MOST_WAITING {
            out.push(Action::Refuse(request, Refusal::Busy));
        } else {
            self.waiting.push_back(request);
        }
    }

    /// Nobody waits for the outcome: a robot that moved on must not be swept for it. A visit whose sweep has begun
    /// is finished, for its alarm counts whoever asked; a reference that nobody is told of is not taken.
    fn asker_gone(&mut self, id: u64, out: &mut Vec<Action>) {
        if let Some(at) = self.waiting.iter().position(|r| r.id == id) {
            out.extend(self.waiting.remove(at).map(Action::Drop));
            return;
        }
        let Some((request, step)) = self.in_hand.take_if(|(r, _)| r.id == id) else {
            return;
        };
        match (step, request.task) {
            (Step::Preparing | Step::Waiting, _) | (Step::Judging, Task::Teach | Task::Sweep) => {
                out.push(Action::Drop(request));
            }
            (step, task) => {
                if step == Step::Sweeping && task != Task::Visit && !self.stopping {
                    self.unwanted = Some(id);
                    out.push(Action::CancelDevices);
                }
                self.in_hand = Some((request, step));
            }
        }
    }

    fn sweep(&mut self, request: Request, out: &mut Vec<Action>) {
        let step = match &self.devices {
            Devices::Ready => {
                out.push(Action::StartSweep(request.clone()));
                Step::Sweeping
            }
            Devices::Opening => Step::Waiting,
            // They may be back long before the next attempt is due.
            Devices::Lost { .. } => {
                self.open(out);
                Step::Waiting
            }
            Devices::Closed => {
                out.push(Action::Refuse(request, Refusal::Stopping));
                return;
            }
        };
        self.in_hand = Some((request, step));
    }

    /// A visit without a sweep is not observed, and the log shall know; other tasks change nothing.
    fn not_swept(&mut self, request: Request, reason: String, out: &mut Vec<Action>) {
        if request.task == Task::Visit {
            self.record_not_observed(request, reason, out);
        } else {
            let word = request.task.word();
            let refusal = Refusal::NoSweep(format!("{word} refused: {reason}"));
            out.push(Action::Refuse(request, refusal));
        }
    }

    fn record_not_observed(&mut self, request: Request, reason: String, out: &mut Vec<Action>) {
        out.push(Action::RecordNotObserved(request.clone(), reason));
        self.in_hand = Some((request, Step::Recording));
    }

    fn swept(&mut self, id: u64, out: &mut Vec<Action>) {
        let Some(request) = self.take(id, Step::Sweeping) else {
            return;
        };
        if self.unwanted.take() == Some(id) {
            out.push(Action::Drop(request));
            return;
        }
        if self.stopping {
            let reason = "the service was stopped before the sweep was judged".to_owned();
            return self.not_swept(request, reason, out);
        }
        out.push(Action::Judge(request.clone()));
        self.in_hand = Some((request, Step::Judging));
    }

    fn sweep_failed(&mut self, id: u64, reason: String, lost: bool, out: &mut Vec<Action>) {
        let Some(request) = self.take(id, Step::Sweeping) else {
            return;
        };
        if self.stopping {
            let reason = "the service was stopped during the sweep".to_owned();
            return self.not_swept(request, reason, out);
        }
        if self.unwanted.take() == Some(id) {
            if lost {
                self.open(out);
            }
            out.push(Action::Drop(request));
            return;
        }
        out.push(Action::Note(
            Weight::Error,
            format!("sweep failed: {reason}"),
        ));
        if lost {
            self.open(out);
        }
        self.not_swept(request, reason, out);
    }

    fn judged(&mut self, request: Request, result: Result<(), String>, out: &mut Vec<Action>) {
        match (result, request.task) {
            (Ok(()), Task::Sweep) => out.push(Action::Reply(request)),
            (Ok(()), Task::Visit | Task::Teach) => {
                out.push(Action::Record(request.clone()));
                self.in_hand = Some((request, Step::Recording));
            }
            (Err(reason), Task::Visit) => self.record_not_observed(request, reason, out),
            (Err(reason), task) => {
                let refusal = Refusal::BadSweep(format!("{} refused: {reason}", task.word()));
                out.push(Action::Refuse(request, refusal));
            }
        }
    }

    fn shutdown(&mut self, out: &mut Vec<Action>) {
        if self.stopping {
            return;
        }
        self.stopping = true;
        out.extend([Action::CancelDevices, Action::CloseDevices]);
        let refuse = |request| Action::Refuse(request, Refusal::Stopping);
        out.extend(self.waiting.drain(..).map(refuse));
        match self.in_hand.take() {
            Some((request, Step::Preparing | Step::Waiting)) => out.push(refuse(request)),
            Some((request, Step::Judging)) => {
                let reason = "the service was stopped before the sweep was judged".to_owned();
                self.not_swept(request, reason, out);
            }
            other => self.in_hand = other,
        }
    }

    fn tick(&mut self, now: Duration, out: &mut Vec<Action>) {
        let due = matches!(&self.devices, Devices::Lost { retry_at, .. } if now >= *retry_at);
        if due && !self.stopping {
            self.open(out);
        }
    }

    /// The request in hand, if it is this one at this step; it is out of hand then.
    fn take(&mut self, id: u64, step: Step) -> Option<Request> {
        let fits = matches!(&self.in_hand, Some((r, s)) if r.id == id && *s == step);
        let taken = if fits { self.in_hand.take() } else { None };
        taken.map(|(request, _)| request)
    }

    fn take_waiting(&mut self) -> Option<Request> {
        let id = match &self.in_hand {
            Some((request, Step::Waiting)) => request.id,
            _ => return None,
        };
        self.take(id, Step::Waiting)
    }
}

#[cfg(test)]
mod tests;
