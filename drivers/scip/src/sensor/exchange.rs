//! One request under way: its deadline, its repeats.

use super::dialogue::Desk;
use crate::Instant;
use crate::command::Request;
use crate::error::{ReplyError, SensorError};
use crate::status::Command;

/// A request that was sent and waits for its reply.
#[derive(Debug)]
pub(super) struct Exchange {
    bytes: Vec<u8>,
    command: Command,
    timeout: Instant,
    attempts_made: u8,
    attempts_allowed: u8,
    last_error: Option<ReplyError>,
    /// When it was last handed out.
    pub(super) sent_at: Instant,
    /// When the reply is late.
    pub(super) deadline: Instant,
}

impl Exchange {
    /// Sends `request` for the first time.
    pub(super) fn begin<R: Request>(request: &R, now: Instant, desk: &mut Desk) -> Self {
        Self::begin_with(request.to_bytes(), R::COMMAND, now, desk)
    }

    /// Sends the bytes of a request of `command` for the first time.
    pub(super) fn begin_with(
        bytes: Vec<u8>,
        command: Command,
        now: Instant,
        desk: &mut Desk,
    ) -> Self {
        desk.send(bytes.clone());
        let timeout = desk.options.reply_timeout;
        Self {
            bytes,
            command,
            timeout,
            attempts_made: 1,
            attempts_allowed: desk.options.attempts.max(1),
            last_error: None,
            sent_at: now,
            deadline: now.saturating_add(timeout),
        }
    }

    /// The command under way.
    pub(super) fn command(&self) -> Command {
        self.command
    }

    /// Remembers what was wrong with an answer, for the final error.
    pub(super) fn note(&mut self, error: ReplyError) {
        self.last_error = Some(error);
    }

    /// Sends it again.
    ///
    /// # Errors
    /// If it has been sent as often as allowed.
    pub(super) fn again(&mut self, now: Instant, desk: &mut Desk) -> Result<(), SensorError> {
        if self.attempts_made >= self.attempts_allowed {
            return Err(self.failure());
        }
        self.attempts_made += 1;
        self.sent_at = now;
        self.deadline = now.saturating_add(self.timeout);
        desk.send(self.bytes.clone());
        Ok(())
    }

    /// Takes an answer that cannot be used. Damage is asked for again at once; a refusal, which may pass, at the deadline.
    ///
    /// # Errors
    /// As [`Exchange::again`].
    pub(super) fn unusable(
        &mut self,
        error: ReplyError,
        now: Instant,
        desk: &mut Desk,
    ) -> Result<(), SensorError> {
        let refused = error.refusal().is_some();
        self.note(error);
        if refused {
            Ok(())
        } else {
            self.again(now, desk)
        }
    }

    /// What to say when it has failed.
    pub(super) fn failure(&self) -> SensorError {
        let (command, attempts) = (self.command, self.attempts_made);
        match self.last_error.clone() {
            Some(last) => SensorError::BadReply {
                command,
                attempts,
                last,
            },
            None => SensorError::NoReply {
                command,
                attempts,
                timeout: self.timeout,
            },
        }
    }
}
