//! Pairs of host instants and timer values: `TM0`, `TM1` n times, `TM2`. Protocol sections 6 and 8.
//!
//! Commands are answered in order, so `TM2` is also a fence: when a `TM1` goes unanswered the exchange ends there with
//! the samples it has, and its late reply can never be taken for the next one's.

use super::action::{Event, Rejection};
use super::dialogue::{Desk, Dialogue, Outcome};
use super::exchange::Exchange;
use crate::Instant;
use crate::command::Request;
use crate::command::time_adjust::{EnterTimeAdjust, LeaveTimeAdjust, ReadTime};
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::status::Meaning;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Enter,
    Read,
    Leave,
}

/// A time exchange, under way.
#[derive(Debug)]
pub(super) struct TimeExchange {
    step: Step,
    exchange: Exchange,
    requests_left: u32,
    samples: u32,
    failure: Option<SensorError>,
}

impl TimeExchange {
    pub(super) fn begin(samples: u32, now: Instant, desk: &mut Desk) -> Self {
        Self {
            step: Step::Enter,
            exchange: Exchange::begin(&EnterTimeAdjust, now, desk),
            requests_left: samples,
            samples: 0,
            failure: None,
        }
    }

    fn read_or_leave(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        if self.requests_left == 0 {
            return self.leave(now, desk);
        }
        self.requests_left -= 1;
        self.step = Step::Read;
        self.exchange = Exchange::begin(&ReadTime, now, desk);
        Outcome::Continue
    }

    fn leave(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        self.step = Step::Leave;
        self.exchange = Exchange::begin(&LeaveTimeAdjust, now, desk);
        Outcome::Continue
    }

    fn take(
        &mut self,
        message: &Message,
        now: Instant,
        desk: &mut Desk,
    ) -> Result<Outcome, ReplyError> {
        Ok(match self.step {
            Step::Enter => {
                EnterTimeAdjust.parse(message)?;
                self.read_or_leave(now, desk)
            }
            Step::Read => {
                let stamp_ms = ReadTime.parse(message)?;
                let (sent, received) = (self.exchange.sent_at, message.first_byte_at);
                desk.tell(Event::TimeSample {
                    sent,
                    received,
                    stamp_ms,
                });
                self.samples += 1;
                self.read_or_leave(now, desk)
            }
            Step::Leave => {
                LeaveTimeAdjust.parse(message)?;
                desk.tell(match self.failure.take() {
                    Some(error) if self.samples == 0 => Event::Failed(error),
                    _ => Event::TimeExchanged {
                        samples: self.samples,
                    },
                });
                Outcome::Idle
            }
        })
    }
}

impl Dialogue for TimeExchange {
    fn state(&self) -> &'static str {
        "exchanging time"
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
        if error.refusal() == Some(Meaning::OldProtocol) {
            return Outcome::Fault(SensorError::Relapsed);
        }
        match self.step {
            Step::Enter | Step::Leave => match self.exchange.unusable(error, now, desk) {
                Ok(()) => Outcome::Continue,
                Err(failure) if self.step == Step::Enter => {
                    self.failure = Some(failure);
                    self.leave(now, desk)
                }
                Err(failure) => Outcome::Fault(failure),
            },
            Step::Read if error.refusal().is_some() => {
                self.exchange.note(error);
                self.failure = Some(self.exchange.failure());
                self.leave(now, desk)
            }
            // A damaged time costs one of the requests, so that damage for ever ends too.
            Step::Read => {
                self.exchange.note(error);
                self.failure = Some(self.exchange.failure());
                self.read_or_leave(now, desk)
            }
        }
    }

    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        if self.step == Step::Read {
            self.failure = Some(self.exchange.failure());
            return self.leave(now, desk);
        }
        match self.exchange.again(now, desk) {
            Ok(()) => Outcome::Continue,
            Err(failure) if self.step == Step::Enter => {
                self.failure = Some(failure);
                self.leave(now, desk)
            }
            Err(failure) => Outcome::Fault(failure),
        }
    }
}
