//! Short requests at idle: `II`, settings, and one scan (`BM`, then `GD`, `GS` or `GE`). Protocol section 6.

use super::action::{Event, Rejection};
use super::dialogue::{Desk, Dialogue, Outcome};
use super::exchange::Exchange;
use crate::Instant;
use crate::command::Request;
use crate::command::info::ReadInfo;
use crate::command::laser::LaserOn;
use crate::command::setting::Setting;
use crate::command::single::MeasureOnce;
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::status::Meaning;

#[derive(Debug, Clone, Copy)]
enum Question {
    Info,
    Setting(Setting),
    LaserOn(MeasureOnce),
    Scan(MeasureOnce),
}

/// A question, under way.
#[derive(Debug)]
pub(super) struct Asking {
    question: Question,
    exchange: Exchange,
}

impl Asking {
    pub(super) fn info(now: Instant, desk: &mut Desk) -> Self {
        Self {
            question: Question::Info,
            exchange: Exchange::begin(&ReadInfo, now, desk),
        }
    }

    pub(super) fn setting(setting: Setting, now: Instant, desk: &mut Desk) -> Self {
        Self {
            question: Question::Setting(setting),
            exchange: Exchange::begin_with(setting.to_bytes(), setting.command(), now, desk),
        }
    }

    /// One scan. The laser stays on for the next; [`Sensor::stop`](crate::Sensor::stop) turns it off.
    pub(super) fn scan(request: MeasureOnce, now: Instant, desk: &mut Desk) -> Self {
        Self {
            question: Question::LaserOn(request),
            exchange: Exchange::begin(&LaserOn, now, desk),
        }
    }

    fn take(
        &mut self,
        message: &Message,
        now: Instant,
        desk: &mut Desk,
    ) -> Result<Outcome, ReplyError> {
        Ok(match self.question {
            Question::Info => {
                desk.tell(Event::Info(ReadInfo.parse(message)?));
                Outcome::Idle
            }
            Question::Setting(setting) => {
                setting.parse(message)?;
                desk.tell(Event::Applied(setting));
                Outcome::Idle
            }
            Question::LaserOn(request) => {
                LaserOn.parse(message)?;
                self.question = Question::Scan(request);
                self.exchange = Exchange::begin(&request, now, desk);
                Outcome::Continue
            }
            Question::Scan(request) => {
                let scan = request.parse(message)?;
                let Message {
                    first_byte_at,
                    last_byte_at,
                    ..
                } = *message;
                desk.tell(Event::Scan {
                    scan,
                    first_byte_at,
                    last_byte_at,
                });
                Outcome::Idle
            }
        })
    }

    fn give_up(failure: SensorError, desk: &mut Desk) -> Outcome {
        desk.tell(Event::Failed(failure));
        Outcome::Idle
    }
}

impl Dialogue for Asking {
    fn state(&self) -> &'static str {
        "waiting for an answer"
    }

    fn deadline(&self) -> Instant {
        self.exchange.deadline
    }

    fn on_message(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        let error = match self.take(message, now, desk) {
            Ok(outcome) => return outcome,
            Err(ReplyError::Echo { .. }) => return Outcome::Continue,
            Err(error) => error,
        };
        desk.reject(Rejection::Reply(error.clone()));
        match error.refusal() {
            Some(Meaning::OldProtocol) => Outcome::Fault(SensorError::Relapsed),
            Some(Meaning::HardwareTrouble(status)) => {
                Outcome::Fault(SensorError::Hardware { status })
            }
            Some(Meaning::Busy | Meaning::CannotReply) | None => {
                match self.exchange.unusable(error, now, desk) {
                    Ok(()) => Outcome::Continue,
                    Err(failure) => Self::give_up(failure, desk),
                }
            }
            // Asking again would bring the same answer.
            Some(_) => {
                self.exchange.note(error);
                Self::give_up(self.exchange.failure(), desk)
            }
        }
    }

    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        match self.exchange.again(now, desk) {
            Ok(()) => Outcome::Continue,
            Err(failure) => Self::give_up(failure, desk),
        }
    }
}
