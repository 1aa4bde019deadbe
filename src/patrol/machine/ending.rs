//! Requests that end before their outcome: their client has gone or asked for it, or the service stops.

use super::{PatrolMachine, RequestStage};
use crate::patrol::action::PatrolAction;
use crate::patrol::event::{PatrolTask, RefusalReason};

/// Why a request ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RequestEnd {
    ClientGone,
    Cancelled,
}

impl PatrolMachine {
    pub(super) fn client_gone(&mut self, id: u64, out: &mut Vec<PatrolAction>) {
        self.end_request(id, RequestEnd::ClientGone, out);
    }

    pub(super) fn cancelled(&mut self, id: u64, out: &mut Vec<PatrolAction>) {
        self.end_request(id, RequestEnd::Cancelled, out);
    }

    /// Whether the request can still be ended: its sweep is not taken.
    pub fn may_cancel(&self, id: u64) -> bool {
        let queued = self.queue.iter().any(|r| r.id == id);
        let current = self.current.as_ref().filter(|(r, _)| r.id == id);
        let is_before = |stage| {
            use RequestStage as S;
            matches!(stage, S::Preparing | S::Waiting | S::Sweeping) && !self.stopping
        };
        queued || current.is_some_and(|(_, stage)| is_before(*stage))
    }

    /// The robot may move on once its client is gone or ends the request, so a sweep is not started. A visit whose client is gone
    /// finishes its sweep, because its alarm matters to others; where the client says that the robot moves on, the sweep
    /// ends and the visit is not observed. A reference is not taken. What is swept is judged.
    fn end_request(&mut self, id: u64, end: RequestEnd, out: &mut Vec<PatrolAction>) {
        if let Some(at) = self.queue.iter().position(|r| r.id == id) {
            out.extend(self.queue.remove(at).map(PatrolAction::Abandon));
            return;
        }
        let Some((request, stage)) = self.current.take_if(|(r, _)| r.id == id) else {
            return;
        };
        match (stage, request.task) {
            (RequestStage::Preparing | RequestStage::Waiting, _)
            | (RequestStage::Judging, PatrolTask::Teach | PatrolTask::Sweep) => {
                out.push(PatrolAction::Abandon(request));
                return;
            }
            (RequestStage::Sweeping, task) if !self.stopping => {
                let ended = match (task, end) {
                    (PatrolTask::Visit, RequestEnd::ClientGone) => None,
                    (PatrolTask::Visit, RequestEnd::Cancelled) => Some(&mut self.cancelled_visit),
                    (PatrolTask::Teach | PatrolTask::Sweep, _) => Some(&mut self.abandoned),
                };
                if let Some(ended) = ended {
                    *ended = Some(id);
                    out.push(PatrolAction::CancelDevices);
                }
            }
            _ => {}
        }
        self.current = Some((request, stage));
    }

    /// Whether the sweep of this request ends early: its client is gone or asked for it, or the service stops.
    pub fn is_cancelled(&self, id: u64) -> bool {
        self.stopping || [self.abandoned, self.cancelled_visit].contains(&Some(id))
    }

    pub(super) fn shutdown(&mut self, out: &mut Vec<PatrolAction>) {
        if self.stopping {
            return;
        }
        self.stopping = true;
        out.extend([PatrolAction::CancelDevices, PatrolAction::CloseDevices]);
        let refuse = |request| PatrolAction::Refuse(request, RefusalReason::Stopping);
        out.extend(self.queue.drain(..).map(refuse));
        match self.current.take() {
            Some((request, RequestStage::Preparing | RequestStage::Waiting)) => {
                out.push(refuse(request))
            }
            Some((request, RequestStage::Judging)) => {
                let reason = "the service was stopped before the sweep was judged".to_owned();
                self.sweep_unavailable(request, reason, out);
            }
            other => self.current = other,
        }
    }
}
