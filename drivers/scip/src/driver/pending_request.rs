//! A request that waits for its reply: its deadline and its retries.

use super::dialogue::DriverContext;
use super::error::ScipError;
use crate::command::request::ScipRequest;
use crate::error::ReplyError;
use crate::status::ScipCommand;
use std::time::Duration;

#[derive(Debug)]
pub(super) struct PendingRequest {
    bytes: Vec<u8>,
    command: ScipCommand,
    timeout: Duration,
    attempts_made: u8,
    attempts_allowed: u8,
    last_error: Option<ReplyError>,
    /// When it was last sent.
    pub(super) sent_at: Duration,
    pub(super) deadline: Duration,
}

impl PendingRequest {
    pub(super) fn send<R: ScipRequest>(
        request: &R,
        now: Duration,
        context: &mut DriverContext,
    ) -> Self {
        let bytes = request.to_bytes();
        context.send(bytes.clone());
        let timeout = context.options.reply_timeout;
        Self {
            bytes,
            command: R::COMMAND,
            timeout,
            attempts_made: 1,
            attempts_allowed: context.options.attempts.max(1),
            last_error: None,
            sent_at: now,
            deadline: now.saturating_add(timeout),
        }
    }

    /// The same with another time-out and number of attempts.
    pub(super) fn limited(mut self, (timeout, attempts): (Duration, u8)) -> Self {
        self.timeout = timeout;
        self.attempts_allowed = attempts.max(1);
        self.deadline = self.sent_at.saturating_add(timeout);
        self
    }

    pub(super) fn command(&self) -> ScipCommand {
        self.command
    }

    /// Keeps what was wrong with a reply for the final error.
    pub(super) fn note_error(&mut self, error: ReplyError) {
        self.last_error = Some(error);
    }

    /// Sends it again, or fails if it was sent as often as allowed.
    pub(super) fn resend(
        &mut self,
        now: Duration,
        context: &mut DriverContext,
    ) -> Result<(), ScipError> {
        if self.attempts_made >= self.attempts_allowed {
            return Err(self.failure());
        }
        self.attempts_made += 1;
        self.sent_at = now;
        self.deadline = now.saturating_add(self.timeout);
        context.send(self.bytes.clone());
        Ok(())
    }

    /// After an unusable reply: a damaged one is asked for again at once; a refusal, which may be temporary, at the
    /// deadline.
    pub(super) fn retry_after(
        &mut self,
        error: ReplyError,
        now: Duration,
        context: &mut DriverContext,
    ) -> Result<(), ScipError> {
        let refused = error.refusal().is_some();
        self.note_error(error);
        if refused {
            Ok(())
        } else {
            self.resend(now, context)
        }
    }

    /// The error of all attempts together.
    pub(super) fn failure(&self) -> ScipError {
        let (command, attempts) = (self.command, self.attempts_made);
        match self.last_error.clone() {
            Some(last) => ScipError::BadReply {
                command,
                attempts,
                last,
            },
            None => ScipError::NoReply {
                command,
                attempts,
                timeout: self.timeout,
            },
        }
    }
}
