//! What all dialogues have in common.

use std::collections::VecDeque;
use std::fmt::Debug;

use super::action::{LaserAction, LaserEvent, Rejection};
use super::error::ScipError;
use super::identity::LaserIdentity;
use super::options::ScipOptions;
use crate::constants::BITS_PER_BYTE;
use crate::frame::ScipMessage;
use heard::HeardBytes;
use std::time::Duration;

/// What dialogues share: the queue of outputs, the settings, the identity.
#[derive(Debug)]
pub(super) struct DriverContext {
    pub(super) actions: VecDeque<LaserAction>,
    pub(super) options: ScipOptions,
    pub(super) identity: Option<LaserIdentity>,
    pub(super) rejected: u64,
    /// While connecting.
    pub(super) heard: HeardBytes,
}

impl DriverContext {
    pub(super) fn send(&mut self, bytes: Vec<u8>) {
        self.heard.note_sent(&bytes);
        self.actions.push_back(LaserAction::Send(bytes));
    }

    /// Both ends have this rate from now on.
    pub(super) fn set_bit_rate(&mut self, bit_s: u32) {
        self.options.link_bytes_per_second = Some(bit_s / BITS_PER_BYTE);
        self.actions.push_back(LaserAction::SetBitRate(bit_s));
    }

    /// Ends connecting.
    pub(super) fn connected(&mut self, mut identity: LaserIdentity) -> DialogueOutcome {
        identity.line_bytes_s = self.options.link_bytes_per_second;
        self.identity = Some(identity.clone());
        self.emit(LaserEvent::Connected(identity));
        DialogueOutcome::Idle
    }

    pub(super) fn emit(&mut self, event: LaserEvent) {
        self.actions.push_back(LaserAction::Event(event));
    }

    pub(super) fn reject(&mut self, reason: Rejection) {
        self.rejected += 1;
        self.emit(LaserEvent::Rejected {
            reason,
            total: self.rejected,
        });
    }
}

/// What follows from an input.
#[derive(Debug)]
#[must_use]
pub(super) enum DialogueOutcome {
    /// The dialogue goes on.
    Continue,
    /// The dialogue has ended; the device is idle.
    Idle,
    /// Another dialogue goes on.
    Then(Box<dyn Dialogue>),
    /// The dialogue has failed; the device must be reopened and connected again.
    Fault(ScipError),
}

/// One dialogue with the device, from its first request to its end.
pub(super) trait Dialogue: Debug + Send {
    /// For error messages.
    fn state(&self) -> &'static str;
    /// When [`Dialogue::on_deadline`] is due.
    fn deadline(&self) -> Duration;
    fn on_message(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome;
    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome;
}
