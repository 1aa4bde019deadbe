//! Raising the bit rate of a serial line (scip2 section 6, SS), the last part of connecting.
//!
//! ```text
//! SS --00--> pause, new rate, II --> connected
//!  | refused                  | no reply: old rate, QT --> connected, or lost
//!  +--------------------------------> connected at the old rate
//! ```

use std::time::Duration;

use super::action::LaserEvent;
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::identity::LaserIdentity;
use super::pending_request::PendingRequest;
use crate::command::bit_rate::SetBitRate;
use crate::command::info::ReadInfo;
use crate::command::quit::Quit;
use crate::command::request::ScipRequest;
use crate::constants::BIT_RATE_PAUSE;
use crate::error::ReplyError;
use crate::frame::ScipMessage;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RateStep {
    Ask,
    /// The sensor changes its rate.
    Pause,
    Verify,
    FallBack,
}

#[derive(Debug)]
pub(super) struct RaisingRate {
    step: RateStep,
    pending: PendingRequest,
    pause_until: Duration,
    identity: LaserIdentity,
    /// Bit/s.
    old: u32,
    wanted: u32,
}

impl RaisingRate {
    /// From the rate `old` to `wanted`, bit/s.
    pub(super) fn start(
        identity: LaserIdentity,
        old: u32,
        wanted: u32,
        now: Duration,
        context: &mut DriverContext,
    ) -> Self {
        Self {
            step: RateStep::Ask,
            pending: PendingRequest::send(&SetBitRate(wanted), now, context),
            pause_until: now,
            identity,
            old,
            wanted,
        }
    }

    fn keep_old(&self, context: &mut DriverContext) -> DialogueOutcome {
        context.emit(LaserEvent::BitRateKept {
            wanted: self.wanted,
        });
        context.connected(self.identity.clone())
    }

    fn handle_reply(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> Result<DialogueOutcome, ReplyError> {
        Ok(match self.step {
            RateStep::Ask => {
                SetBitRate(self.wanted).parse(message)?;
                self.step = RateStep::Pause;
                self.pause_until = now.saturating_add(BIT_RATE_PAUSE);
                DialogueOutcome::Continue
            }
            RateStep::Pause => DialogueOutcome::Continue,
            RateStep::Verify => {
                ReadInfo.parse(message)?;
                context.connected(self.identity.clone())
            }
            RateStep::FallBack => {
                Quit.parse(message)?;
                self.keep_old(context)
            }
        })
    }

    /// All attempts of a step failed.
    fn on_failure(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        match self.step {
            RateStep::Ask | RateStep::Pause => self.keep_old(context),
            RateStep::Verify => {
                context.set_bit_rate(self.old);
                self.step = RateStep::FallBack;
                self.pending = PendingRequest::send(&Quit, now, context);
                DialogueOutcome::Continue
            }
            RateStep::FallBack => DialogueOutcome::Fault(ScipError::BitRateLost {
                wanted: self.wanted,
            }),
        }
    }
}

impl Dialogue for RaisingRate {
    fn state(&self) -> &'static str {
        "connecting"
    }

    fn deadline(&self) -> Duration {
        match self.step {
            RateStep::Pause => self.pause_until,
            _ => self.pending.deadline,
        }
    }

    fn on_message(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match self.handle_reply(message, now, context) {
            Ok(outcome) => outcome,
            Err(ReplyError::Echo { .. }) => DialogueOutcome::Continue,
            // Another rate is a wish.
            Err(error) if self.step == RateStep::Ask && error.refusal().is_some() => {
                self.keep_old(context)
            }
            Err(error) => match self.pending.retry_after(error, now, context) {
                Ok(()) => DialogueOutcome::Continue,
                Err(_) => self.on_failure(now, context),
            },
        }
    }

    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        if self.step == RateStep::Pause {
            context.set_bit_rate(self.wanted);
            self.step = RateStep::Verify;
            self.pending = PendingRequest::send(&ReadInfo, now, context);
            return DialogueOutcome::Continue;
        }
        match self.pending.resend(now, context) {
            Ok(()) => DialogueOutcome::Continue,
            Err(_) => self.on_failure(now, context),
        }
    }
}
