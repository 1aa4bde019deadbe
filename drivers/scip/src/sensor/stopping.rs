//! Stopping from anything: `QT` until it is answered, out of time adjust first if need be.

use super::action::Event;
use super::dialogue::{Desk, Dialogue, Outcome};
use super::exchange::Exchange;
use crate::Instant;
use crate::command::Request;
use crate::command::laser::Quit;
use crate::command::time_adjust::LeaveTimeAdjust;
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::status::Meaning;

/// Stopping, under way.
#[derive(Debug)]
pub(super) struct Stopping {
    exchange: Exchange,
    leaving_time_adjust: bool,
    mode_changes_left: u8,
}

impl Stopping {
    pub(super) fn begin(now: Instant, desk: &mut Desk) -> Self {
        Self {
            exchange: Exchange::begin(&Quit, now, desk),
            leaving_time_adjust: false,
            mode_changes_left: desk.options.mode_changes,
        }
    }

    fn quit(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        self.leaving_time_adjust = false;
        self.exchange = Exchange::begin(&Quit, now, desk);
        Outcome::Continue
    }
}

impl Dialogue for Stopping {
    fn state(&self) -> &'static str {
        "stopping"
    }

    fn deadline(&self) -> Instant {
        self.exchange.deadline
    }

    fn on_message(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        let reply = if self.leaving_time_adjust {
            LeaveTimeAdjust.parse(message).map(|()| false)
        } else {
            Quit.parse(message).map(|()| true)
        };
        let error = match reply {
            Ok(true) => {
                desk.tell(Event::Stopped);
                return Outcome::Idle;
            }
            Ok(false) => return self.quit(now, desk),
            // The tail of the scan in flight, or a late reply.
            Err(ReplyError::Echo { .. }) => return Outcome::Continue,
            Err(error) => error,
        };
        match error.refusal() {
            Some(Meaning::OldProtocol) => return Outcome::Fault(SensorError::Relapsed),
            Some(Meaning::Undefined) if !self.leaving_time_adjust && self.mode_changes_left > 0 => {
                self.mode_changes_left -= 1;
                self.leaving_time_adjust = true;
                self.exchange = Exchange::begin(&LeaveTimeAdjust, now, desk);
                return Outcome::Continue;
            }
            _ => {}
        }
        match self.exchange.unusable(error, now, desk) {
            Ok(()) => Outcome::Continue,
            Err(failure) => Outcome::Fault(failure),
        }
    }

    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        match self.exchange.again(now, desk) {
            Ok(()) => Outcome::Continue,
            Err(failure) => Outcome::Fault(failure),
        }
    }
}
