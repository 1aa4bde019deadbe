//! What all dialogues share: the desk where outputs are laid down, and what a dialogue is.

use std::collections::VecDeque;
use std::fmt::Debug;

use super::action::{Action, Event, Identity, Rejection};
use super::options::SensorOptions;
use crate::Instant;
use crate::error::SensorError;
use crate::frame::Message;

/// Where outputs wait to be drained, with what every dialogue may read.
#[derive(Debug)]
pub(super) struct Desk {
    pub(super) actions: VecDeque<Action>,
    pub(super) options: SensorOptions,
    pub(super) identity: Option<Identity>,
    pub(super) rejected: u64,
}

impl Desk {
    pub(super) fn send(&mut self, bytes: Vec<u8>) {
        self.actions.push_back(Action::Send(bytes));
    }

    pub(super) fn tell(&mut self, event: Event) {
        self.actions.push_back(Action::Event(event));
    }

    pub(super) fn reject(&mut self, reason: Rejection) {
        self.rejected += 1;
        self.tell(Event::Rejected {
            reason,
            total: self.rejected,
        });
    }
}

/// Where an input leads.
#[derive(Debug)]
#[must_use]
pub(super) enum Outcome {
    /// Go on.
    Continue,
    /// Over; the device is idle.
    Idle,
    /// Over; the device must be opened and connected again.
    Fault(SensorError),
}

/// One dialogue with the device, from its first request to its end.
pub(super) trait Dialogue: Debug + Send {
    /// What it is doing, for messages.
    fn state(&self) -> &'static str;
    /// When it wants [`Dialogue::on_deadline`].
    fn deadline(&self) -> Instant;
    /// Takes a message.
    fn on_message(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome;
    /// The deadline has passed.
    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome;
}
