//! Pairs of host instants and timer values: `TM0`, `TM1` n times, `TM2` (scip2 sections 6 and 8).
//!
//! A `TM1` without reply ends the exchange with the samples so far. Commands are answered in order, so a late reply comes
//! before that to `TM2` and is not taken for another sample.

use super::action::{LaserEvent, Rejection};
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::pending_request::PendingRequest;
use crate::command::request::ScipRequest;
use crate::command::time_adjust::{EnterTimeAdjust, LeaveTimeAdjust, ReadTimer};
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::StatusMeaning;
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TimeExchangeStep {
    Enter,
    Read,
    Leave,
}

#[derive(Debug)]
pub(super) struct TimeExchange {
    step: TimeExchangeStep,
    pending: PendingRequest,
    requests_left: u32,
    samples: u32,
    failure: Option<ScipError>,
}

impl TimeExchange {
    pub(super) fn start(samples: u32, now: Duration, context: &mut DriverContext) -> Self {
        Self {
            step: TimeExchangeStep::Enter,
            pending: PendingRequest::send(&EnterTimeAdjust, now, context),
            requests_left: samples,
            samples: 0,
            failure: None,
        }
    }

    fn read_or_leave(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        if self.requests_left == 0 {
            return self.leave(now, context);
        }
        self.requests_left -= 1;
        self.step = TimeExchangeStep::Read;
        self.pending = PendingRequest::send(&ReadTimer, now, context);
        DialogueOutcome::Continue
    }

    fn leave(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        self.step = TimeExchangeStep::Leave;
        self.pending = PendingRequest::send(&LeaveTimeAdjust, now, context);
        DialogueOutcome::Continue
    }

    fn handle_reply(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> Result<DialogueOutcome, ReplyError> {
        Ok(match self.step {
            TimeExchangeStep::Enter => {
                EnterTimeAdjust.parse(message)?;
                self.read_or_leave(now, context)
            }
            TimeExchangeStep::Read => {
                let stamp_ms = ReadTimer.parse(message)?;
                let (sent, received) = (self.pending.sent_at, message.first_byte_at);
                context.emit(LaserEvent::TimeSample {
                    sent,
                    received,
                    stamp_ms,
                });
                self.samples += 1;
                self.read_or_leave(now, context)
            }
            TimeExchangeStep::Leave => {
                LeaveTimeAdjust.parse(message)?;
                context.emit(match self.failure.take() {
                    Some(error) if self.samples == 0 => LaserEvent::RequestFailed(error),
                    _ => LaserEvent::TimeExchanged {
                        samples: self.samples,
                    },
                });
                DialogueOutcome::Idle
            }
        })
    }
}

impl Dialogue for TimeExchange {
    fn state(&self) -> &'static str {
        "exchanging time"
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
        let error = match self.handle_reply(message, now, context) {
            Ok(outcome) => return outcome,
            Err(ReplyError::Echo { .. }) => return DialogueOutcome::Continue,
            Err(error) => error,
        };
        context.reject(Rejection::Reply(error.clone()));
        if error.refusal() == Some(StatusMeaning::OldProtocol) {
            return DialogueOutcome::Fault(ScipError::FellBackToScip11);
        }
        match self.step {
            TimeExchangeStep::Enter | TimeExchangeStep::Leave => {
                match self.pending.retry_after(error, now, context) {
                    Ok(()) => DialogueOutcome::Continue,
                    Err(failure) if self.step == TimeExchangeStep::Enter => {
                        self.failure = Some(failure);
                        self.leave(now, context)
                    }
                    Err(failure) => DialogueOutcome::Fault(failure),
                }
            }
            TimeExchangeStep::Read if error.refusal().is_some() => {
                self.pending.note_error(error);
                self.failure = Some(self.pending.failure());
                self.leave(now, context)
            }
            // A damaged time uses up one request, so a permanently bad line ends the exchange.
            TimeExchangeStep::Read => {
                self.pending.note_error(error);
                self.failure = Some(self.pending.failure());
                self.read_or_leave(now, context)
            }
        }
    }

    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        if self.step == TimeExchangeStep::Read {
            self.failure = Some(self.pending.failure());
            return self.leave(now, context);
        }
        match self.pending.resend(now, context) {
            Ok(()) => DialogueOutcome::Continue,
            Err(failure) if self.step == TimeExchangeStep::Enter => {
                self.failure = Some(failure);
                self.leave(now, context)
            }
            Err(failure) => DialogueOutcome::Fault(failure),
        }
    }
}
