//! Stopping from any state: `QT` until it is answered, after `TM2` in time adjust.

use super::action::LaserEvent;
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::pending_request::PendingRequest;
use crate::command::quit::Quit;
use crate::command::request::ScipRequest;
use crate::command::time_adjust::LeaveTimeAdjust;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::StatusMeaning;
use std::time::Duration;

#[derive(Debug)]
pub(super) struct Stopping {
    pending: PendingRequest,
    leaving_time_adjust: bool,
    mode_changes_left: u8,
}

impl Stopping {
    pub(super) fn start(now: Duration, context: &mut DriverContext) -> Self {
        Self {
            pending: PendingRequest::send(&Quit, now, context),
            leaving_time_adjust: false,
            mode_changes_left: context.options.max_mode_changes,
        }
    }

    fn quit(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        self.leaving_time_adjust = false;
        self.pending = PendingRequest::send(&Quit, now, context);
        DialogueOutcome::Continue
    }
}

impl Dialogue for Stopping {
    fn state(&self) -> &'static str {
        "stopping"
    }

    fn deadline(&self) -> Duration {
        self.pending.deadline
    }

    fn on_message(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let reply = if self.leaving_time_adjust {
            LeaveTimeAdjust.parse(message).map(|()| false)
        } else {
            Quit.parse(message).map(|()| true)
        };
        let error = match reply {
            Ok(true) => {
                context.emit(LaserEvent::Stopped);
                return DialogueOutcome::Idle;
            }
            Ok(false) => return self.quit(now, context),
            // The tail of the scan in flight, or a late reply.
            Err(ReplyError::Echo { .. }) => return DialogueOutcome::Continue,
            Err(error) => error,
        };
        match error.refusal() {
            Some(StatusMeaning::OldProtocol) => {
                return DialogueOutcome::Fault(ScipError::FellBackToScip11);
            }
            Some(StatusMeaning::Undefined)
                if !self.leaving_time_adjust && self.mode_changes_left > 0 =>
            {
                self.mode_changes_left -= 1;
                self.leaving_time_adjust = true;
                self.pending = PendingRequest::send(&LeaveTimeAdjust, now, context);
                return DialogueOutcome::Continue;
            }
            _ => {}
        }
        match self.pending.retry_after(error, now, context) {
            Ok(()) => DialogueOutcome::Continue,
            Err(failure) => DialogueOutcome::Fault(failure),
        }
    }

    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        match self.pending.resend(now, context) {
            Ok(()) => DialogueOutcome::Continue,
            Err(failure) => DialogueOutcome::Fault(failure),
        }
    }
}
