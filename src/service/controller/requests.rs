//! Requests come in; those whose clients do not wait can be asked for, and ended.

use super::Controller;
use crate::devices::SweepRequest;
use crate::patrol::event::{PatrolEvent, PatrolRequest, PatrolTask};
use crate::service::message::{CancelResult, ClientRequest, ReplyTo};
use crate::service::replies::{RequestReply, WorkProgress};
use crate::service::work_estimate::planned_sweep;
use std::time::Instant;
use tokio::sync::oneshot;

impl Controller {
    pub(super) fn accept_request(&mut self, client: ClientRequest) {
        self.last_request_id += 1;
        let id = self.last_request_id;
        if client.task == PatrolTask::Teach {
            self.teach_options.insert(id, client.teach);
        }
        let request = PatrolRequest {
            id,
            task: client.task,
            waypoint: client.waypoint,
        };
        match client.reply_to {
            ReplyTo::Client(channel) => {
                self.reply_channels.insert(id, channel);
                self.handle(PatrolEvent::Requested(request));
            }
            ReplyTo::Later(channel) => {
                self.later.add(request.clone());
                self.handle(PatrolEvent::Requested(request));
                if let Some(reply) = self.request_reply(id) {
                    // Where the client is gone already, the log has the outcome.
                    let _ = channel.send(reply);
                }
            }
        }
    }

    pub(super) fn report_request(
        &mut self,
        id: &str,
        client: oneshot::Sender<Option<RequestReply>>,
    ) {
        self.later.forget(Instant::now());
        let number = self.later.number(id);
        let reply = number.and_then(|number| self.request_reply(number));
        // The client may be gone.
        let _ = client.send(reply);
    }

    pub(super) fn cancel_request(&mut self, id: &str, client: oneshot::Sender<CancelResult>) {
        let result = match self.later.number(id) {
            None => CancelResult::Unknown,
            Some(number) => {
                if self.machine.may_cancel(number) {
                    self.later.set_cancelled(number);
                    self.handle(PatrolEvent::Cancelled(number));
                }
                match self.request_reply(number) {
                    Some(reply) if reply.cancelled => CancelResult::Cancelled(reply),
                    Some(reply) => CancelResult::TooLate(reply.state),
                    None => CancelResult::Unknown,
                }
            }
        };
        // The client may be gone.
        let _ = client.send(result);
    }

    fn request_reply(&self, number: u64) -> Option<RequestReply> {
        let current = self.machine.current();
        let current = current.filter(|(request, _)| request.id == number);
        let current = current.map(|(request, stage)| (stage, self.progress_of(request)));
        self.later.reply(number, current)
    }

    /// Of the request under way.
    pub(super) fn progress_of(&self, request: &PatrolRequest) -> WorkProgress {
        let waypoint = (request.task != PatrolTask::Sweep).then_some(request.waypoint.as_str());
        let planned = planned_sweep(
            &SweepRequest::new(&self.settings, waypoint),
            self.services.scanner.clock(),
        );
        self.estimate.progress(planned, Instant::now())
    }
}
