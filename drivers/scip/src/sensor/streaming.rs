//! Streaming: scans judged one by one, and a silent device brought back. Protocol sections 6, 13 and 14.
//!
//! ```text
//! MD --00--> flowing --silence--> QT, MD --silence--> RS, MD --silence--> fault
//! ```
//!
//! The climb begins anew only after a run of good scans, so that a device which dies again and again is not nursed for
//! ever. On RS-232C at another than the default rate `RS` changes the rate too: the device falls silent, the dialogue ends
//! in a fault, and the port is opened again at the default rate.

use std::time::Duration;

use super::action::{Event, RecoveryCause, RecoveryStep, Rejection};
use super::continuity::{Advance, Continuity};
use super::dialogue::{Desk, Dialogue, Outcome};
use super::exchange::Exchange;
use crate::Instant;
use crate::command::Request;
use crate::command::laser::Quit;
use crate::command::reset::Reset;
use crate::command::stream::{Stream, StreamReply};
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::scan::RawScan;
use crate::status::Meaning;

#[derive(Debug)]
enum Stage {
    /// The request is sent.
    Arming(Exchange),
    /// Scans come; without data by then, something is wrong.
    Flowing(Instant),
    /// `QT` or `RS` is sent.
    Restarting(RecoveryStep, Exchange),
}

/// A stream, under way.
#[derive(Debug)]
pub(super) struct Streaming {
    request: Stream,
    /// Scans still wanted of a counted stream; 0 of an endless one.
    left: u8,
    data_timeout: Duration,
    stage: Stage,
    continuity: Continuity,
    damaged_in_a_row: u8,
    /// The restart now counted as the last one tried.
    tried: Option<RecoveryStep>,
    good_since_restart: u32,
    announced: bool,
    restarting: bool,
    timer_reset: bool,
}

impl Streaming {
    /// `period` is the time between two scans of the plan.
    pub(super) fn begin(request: Stream, period: Duration, now: Instant, desk: &mut Desk) -> Self {
        let bytes = request.span.reply_bytes(request.line().len());
        let on_the_wire = desk
            .options
            .link_bytes_per_second
            .map_or(Duration::ZERO, |rate| {
                Duration::try_from_secs_f64(bytes as f64 / f64::from(rate.max(1)))
                    .unwrap_or_default()
            });
        Self {
            request,
            left: request.count,
            data_timeout: period
                .max(on_the_wire)
                .saturating_mul(desk.options.silent_periods.max(1))
                .max(desk.options.least_silence),
            stage: Stage::Arming(Exchange::begin(&request, now, desk)),
            continuity: Continuity::new(period, &desk.options),
            damaged_in_a_row: 0,
            tried: None,
            good_since_restart: 0,
            announced: false,
            restarting: false,
            timer_reset: false,
        }
    }

    /// The first data after the laser went on: a command's time more.
    fn first_data_by(&self, now: Instant, desk: &Desk) -> Instant {
        now.saturating_add(desk.options.reply_timeout)
            .saturating_add(self.data_timeout)
    }

    fn flow(&mut self, now: Instant, desk: &mut Desk) {
        if !std::mem::replace(&mut self.announced, true) {
            desk.tell(Event::Streaming);
        }
        if std::mem::take(&mut self.restarting) {
            desk.tell(Event::Recovered {
                timer_reset: std::mem::take(&mut self.timer_reset),
            });
        }
        self.good_since_restart = 0;
        self.damaged_in_a_row = 0;
        self.stage = Stage::Flowing(self.first_data_by(now, desk));
    }

    /// The next rung: `QT`, then `RS`, then a fault.
    fn recover(&mut self, cause: RecoveryCause, now: Instant, desk: &mut Desk) -> Outcome {
        let step = match self.tried {
            None => RecoveryStep::Quit,
            Some(RecoveryStep::Quit) => RecoveryStep::Reset,
            Some(RecoveryStep::Reset) => {
                return Self::fault(SensorError::StreamLost { cause }, desk);
            }
        };
        self.tried = Some(step);
        self.restarting = true;
        desk.tell(Event::Recovering { cause, step });
        let exchange = match step {
            RecoveryStep::Quit => Exchange::begin(&Quit, now, desk),
            RecoveryStep::Reset => Exchange::begin(&Reset, now, desk),
        };
        self.stage = Stage::Restarting(step, exchange);
        Outcome::Continue
    }

    /// Nobody will read on: leave the laser off, if the device still hears.
    fn fault(error: SensorError, desk: &mut Desk) -> Outcome {
        desk.send(Quit.to_bytes());
        Outcome::Fault(error)
    }

    fn on_stream(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        let mut next_data_by = now.saturating_add(self.data_timeout);
        let outcome = match self.request.parse(message) {
            Err(ReplyError::Echo { .. }) => {
                desk.reject(Rejection::Unsolicited {
                    echo: message.echo().into(),
                });
                return Outcome::Continue;
            }
            Err(error) => self.on_damage(error, now, desk),
            Ok(StreamReply::Acknowledged) => Outcome::Continue,
            Ok(StreamReply::Scan(scan)) => self.on_scan(scan, message, desk),
            Ok(StreamReply::Verifying(status)) => {
                desk.tell(Event::Verifying { status });
                next_data_by = now.saturating_add(desk.options.verify_timeout);
                Outcome::Continue
            }
            Ok(StreamReply::Resumed) => {
                desk.tell(Event::VerifiedNormal);
                self.continuity.interrupted();
                next_data_by = self.first_data_by(now, desk);
                Outcome::Continue
            }
            Ok(StreamReply::Trouble(status)) => Self::fault(SensorError::Hardware { status }, desk),
        };
        if let Stage::Flowing(data_by) = &mut self.stage {
            *data_by = next_data_by;
        }
        outcome
    }

    fn on_damage(&mut self, error: ReplyError, now: Instant, desk: &mut Desk) -> Outcome {
        let relapsed = error.refusal() == Some(Meaning::OldProtocol);
        desk.reject(Rejection::Reply(error));
        self.damaged_in_a_row = self.damaged_in_a_row.saturating_add(1);
        if relapsed {
            Outcome::Fault(SensorError::Relapsed)
        } else if self.damaged_in_a_row >= desk.options.damaged_in_a_row {
            self.recover(RecoveryCause::Damage, now, desk)
        } else {
            Outcome::Continue
        }
    }

    fn on_scan(&mut self, scan: RawScan, message: &Message, desk: &mut Desk) -> Outcome {
        let stamp_ms = scan.stamp_ms;
        match self.continuity.advance(stamp_ms) {
            Advance::Next => {}
            Advance::Gap(lost) => desk.tell(Event::LostScans(lost)),
            Advance::Repeated(repeats) => {
                desk.reject(Rejection::RepeatedStamp { stamp_ms });
                return if repeats >= desk.options.stale_repeats {
                    Self::fault(SensorError::StaleStamp { stamp_ms, repeats }, desk)
                } else {
                    Outcome::Continue
                };
            }
            Advance::Jump {
                advance_ms,
                in_a_row: jumps,
            } => {
                let expected_ms = self.continuity.period_ms();
                desk.reject(Rejection::StampJump {
                    advance_ms,
                    expected_ms,
                });
                return if jumps >= desk.options.jumps_in_a_row {
                    Self::fault(
                        SensorError::ErraticStamps {
                            jumps,
                            advance_ms,
                            expected_ms,
                        },
                        desk,
                    )
                } else {
                    Outcome::Continue
                };
            }
        }
        let last = self.request.count > 0 && scan.remaining == 0;
        if self.request.count > 0 {
            // What a restart asks for again.
            self.left = scan.remaining;
        }
        self.damaged_in_a_row = 0;
        self.good_since_restart = self.good_since_restart.saturating_add(1);
        if self.good_since_restart >= desk.options.recovered_after {
            self.tried = None;
        }
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
        if last {
            desk.tell(Event::Stopped);
            return Outcome::Idle;
        }
        Outcome::Continue
    }

    fn on_arming(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        match self.request.parse(message) {
            Ok(StreamReply::Acknowledged) => {
                self.flow(now, desk);
                Outcome::Continue
            }
            // Data of our request: only the acknowledgement was lost.
            Ok(_) => {
                self.flow(now, desk);
                self.on_stream(message, now, desk)
            }
            Err(ReplyError::Echo { .. }) => Outcome::Continue,
            Err(error) => {
                desk.reject(Rejection::Reply(error.clone()));
                match error.refusal() {
                    Some(Meaning::OldProtocol) => Outcome::Fault(SensorError::Relapsed),
                    // The plan itself is refused: no restart changes that.
                    Some(Meaning::BadParameter(_)) => {
                        if let Stage::Arming(exchange) = &mut self.stage {
                            exchange.note(error);
                            desk.tell(Event::Failed(exchange.failure()));
                        }
                        Outcome::Idle
                    }
                    _ => self.recover(RecoveryCause::NotAcknowledged, now, desk),
                }
            }
        }
    }

    fn on_restarting(
        &mut self,
        step: RecoveryStep,
        message: &Message,
        now: Instant,
        desk: &mut Desk,
    ) -> Outcome {
        let reply = match step {
            RecoveryStep::Quit => Quit.parse(message),
            RecoveryStep::Reset => Reset.parse(message),
        };
        match reply {
            Ok(()) => {
                match step {
                    RecoveryStep::Quit => self.continuity.interrupted(),
                    RecoveryStep::Reset => {
                        self.continuity.forget();
                        self.timer_reset = true;
                    }
                }
                self.request.count = self.left;
                let request = self.request;
                self.stage = Stage::Arming(Exchange::begin(&request, now, desk));
                Outcome::Continue
            }
            // Scans of the old stream, still under way.
            Err(ReplyError::Echo { .. }) => Outcome::Continue,
            Err(error) => {
                desk.reject(Rejection::Reply(error.clone()));
                if error.refusal() == Some(Meaning::OldProtocol) {
                    return Outcome::Fault(SensorError::Relapsed);
                }
                let again = match &mut self.stage {
                    Stage::Restarting(_, exchange) => exchange.unusable(error, now, desk),
                    _ => Ok(()),
                };
                self.on_restart_attempt(again, now, desk)
            }
        }
    }

    fn on_restart_attempt(
        &mut self,
        again: Result<(), SensorError>,
        now: Instant,
        desk: &mut Desk,
    ) -> Outcome {
        match again {
            Ok(()) => Outcome::Continue,
            Err(_) => self.recover(RecoveryCause::Silence, now, desk),
        }
    }
}

impl Dialogue for Streaming {
    fn state(&self) -> &'static str {
        "streaming"
    }

    fn deadline(&self) -> Instant {
        match &self.stage {
            Stage::Arming(exchange) | Stage::Restarting(_, exchange) => exchange.deadline,
            Stage::Flowing(data_by) => *data_by,
        }
    }

    fn on_message(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        match self.stage {
            Stage::Arming(_) => self.on_arming(message, now, desk),
            Stage::Flowing(_) => self.on_stream(message, now, desk),
            Stage::Restarting(step, _) => self.on_restarting(step, message, now, desk),
        }
    }

    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        match &mut self.stage {
            // A second MD while one is under way is an error, so a lost acknowledgement needs QT first.
            Stage::Arming(_) => self.recover(RecoveryCause::NotAcknowledged, now, desk),
            Stage::Flowing(_) => self.recover(RecoveryCause::Silence, now, desk),
            Stage::Restarting(_, exchange) => {
                let again = exchange.again(now, desk);
                self.on_restart_attempt(again, now, desk)
            }
        }
    }
}
