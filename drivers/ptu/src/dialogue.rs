//! The dialogue with a connected unit: one command, one reply, and resynchronisation (ptu-d46 section 11, steps 4 and 5).

use std::time::Duration;

use crate::action::{PtuAction, PtuEvent};
use crate::command::{AxisProperty, ExpectedReply, PtuCommand};
use crate::connect::is_banner;
use crate::constants::{
    CALIBRATION_TIMEOUT, DRAIN_TIME, MAX_DRAIN_TIME, MAX_TRIES, QUIET_TIME, REPLY_TIMEOUT,
};
use crate::driver::{DialoguePhase, InFlight, PtuDriver, Resync, ScriptKind};
use crate::error::HeadError;
use crate::identity::{AxisDraft, Health};
use crate::line::{Notice, ReplyLine, Token};
use crate::reply::{self, ReplyOutcome};
use crate::{Axis, HoldPower, MovePower};

/// A success reply, checked against its expected form.
enum ReplyContent<'a> {
    Empty,
    Number(f64),
    Text(&'a str),
    /// The setting is the other one; holds the expected keyword.
    OtherKeyword(&'static str),
    /// A number in a phrase: the unit sends verbose replies.
    VerboseNumber(f64),
    Mismatch,
}

fn classify(expected: ExpectedReply, text: &str) -> ReplyContent<'_> {
    let number = reply::number(text);
    match expected {
        ExpectedReply::Ack if text.is_empty() => ReplyContent::Empty,
        ExpectedReply::AckOrText if number.is_none() => ReplyContent::Empty,
        ExpectedReply::Ack | ExpectedReply::AckOrText => ReplyContent::Mismatch,
        ExpectedReply::Text if text.is_empty() => ReplyContent::Mismatch,
        ExpectedReply::Text => ReplyContent::Text(text),
        ExpectedReply::Keyword { wanted, other } => match reply::keyword(text, wanted, other) {
            Some(true) => ReplyContent::Empty,
            Some(false) => ReplyContent::OtherKeyword(wanted),
            None => ReplyContent::Mismatch,
        },
        ExpectedReply::Integer | ExpectedReply::Decimal => match number {
            Some(n) if expected == ExpectedReply::Integer && reply::integer(n.value).is_none() => {
                ReplyContent::Mismatch
            }
            Some(n) if n.verbose => ReplyContent::VerboseNumber(n.value),
            Some(n) => ReplyContent::Number(n.value),
            None => ReplyContent::Mismatch,
        },
    }
}

impl PtuDriver {
    /// Handles received bytes; `now` is when they arrived.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        for byte in bytes {
            if !matches!(self.phase, DialoguePhase::Running | DialoguePhase::Offline) {
                self.heard.note(&[*byte]);
            }
            if let Some(resync) = &mut self.resync {
                resync.until = resync
                    .until
                    .max(now.saturating_add(QUIET_TIME))
                    .min(resync.hard_end);
            }
            match (self.lines.push(*byte, now), self.phase) {
                (None, _) => {}
                (Some(Token::Overlong), _) | (Some(_), DialoguePhase::Offline) => {}
                (Some(Token::Notice(notice)), DialoguePhase::Running) => self.handle_notice(notice),
                (Some(Token::Line(line)), DialoguePhase::Running) => self.handle_line(&line, now),
                (Some(Token::Notice(notice)), _) => self.handle_connecting_notice(notice, now),
                (Some(Token::Line(line)), _) => self.handle_connecting_line(&line, now),
            }
        }
    }

    fn handle_notice(&mut self, notice: Notice) {
        let resetting = self
            .in_flight
            .is_some_and(|f| f.command == PtuCommand::Reset);
        let reading_limits = matches!(self.script, Some((ScriptKind::Limits, _)));
        let spoils = reading_limits || (resetting && notice == Notice::Cable);
        if spoils && notice != Notice::Trigger {
            self.reset_spoilt_by.get_or_insert(notice);
        }
        match notice {
            // A calibration sends a notice at every stop.
            Notice::Limit(_) if resetting => {}
            Notice::Limit(axis) => {
                self.calibration_seen = false;
                self.emit(PtuEvent::LimitHit(axis));
            }
            Notice::Cable => self.emit(PtuEvent::CableLost),
            Notice::Trigger => {}
        }
    }

    fn handle_line(&mut self, line: &ReplyLine, now: Duration) {
        if is_banner(&line.bytes) {
            self.settings_lost(PtuEvent::Restarted, now);
            // The line may be the end of the banner already.
            return self.handle_connecting_line(line, now);
        }
        if self.resync.is_some() {
            return self.note_unmatched(line);
        }
        let Some(in_flight) = self.in_flight else {
            self.note_unmatched(line);
            return self.begin_resync(None, now);
        };
        let reply = reply::parse(&line.bytes);
        let setting_up = matches!(self.script, Some((ScriptKind::Setup, _)));
        if !setting_up && reply.echoes(&in_flight.command.to_text()) {
            return self.settings_lost(PtuEvent::EchoReturned, now);
        }
        match reply.outcome {
            // Line noise: the reply itself may still come.
            ReplyOutcome::Unmarked => self.note_unmatched(line),
            ReplyOutcome::Garbled => self.handle_mismatch(line, in_flight, now),
            ReplyOutcome::Refusal(text) => self.handle_refusal(in_flight.command, text, now),
            ReplyOutcome::Success(text) => match classify(in_flight.command.expected_reply(), text)
            {
                ReplyContent::VerboseNumber(_) if !setting_up => {
                    self.settings_lost(PtuEvent::VerboseReturned, now)
                }
                ReplyContent::Mismatch => self.handle_mismatch(line, in_flight, now),
                ReplyContent::OtherKeyword(wanted) => {
                    let command = in_flight.command.to_text();
                    let fault = HeadError::SettingNotTaken {
                        command,
                        expected: wanted.to_owned(),
                        got: text.to_owned(),
                    };
                    self.attempt_failed(fault, now);
                }
                valid => self.complete(in_flight, line.reply_at, &valid, now),
            },
        }
    }

    fn complete(
        &mut self,
        in_flight: InFlight,
        first_byte_at: Duration,
        content: &ReplyContent<'_>,
        now: Duration,
    ) {
        self.in_flight = None;
        match (in_flight.command, content) {
            (PtuCommand::Query(axis, AxisProperty::Position), ReplyContent::Number(value)) => {
                if let Some(steps) = reply::integer(*value) {
                    let sent_at = in_flight.sent_at.min(first_byte_at);
                    self.emit(PtuEvent::Position {
                        axis,
                        steps,
                        sent_at,
                        first_byte_at,
                    });
                }
            }
            (PtuCommand::QueryHoldPower(axis), ReplyContent::Text(text)) => {
                self.draft.axis_mut(axis).hold_power = HoldPower::from_text(text);
            }
            (PtuCommand::QueryMovePower(axis), ReplyContent::Text(text)) => {
                self.draft.axis_mut(axis).move_power = MovePower::from_text(text);
            }
            (
                PtuCommand::Query(axis, property),
                ReplyContent::Number(value) | ReplyContent::VerboseNumber(value),
            ) => {
                store_property(self.draft.axis_mut(axis), property, *value);
            }
            (PtuCommand::QuerySupply, ReplyContent::Text(text)) => {
                let health = Health::from_text(text);
                if self.script.is_some() {
                    self.draft.health = health;
                } else if let Some(health) = health {
                    self.emit(PtuEvent::Health(health));
                } else {
                    self.emit(PtuEvent::Refused {
                        command: PtuCommand::QuerySupply.to_text(),
                        text: (*text).to_owned(),
                    });
                }
            }
            (PtuCommand::SetSpeed(axis, steps_per_s), _) => {
                self.emit(PtuEvent::SpeedSet { axis, steps_per_s })
            }
            (PtuCommand::MoveTo(axis, target_steps), _) => {
                self.emit(PtuEvent::MoveAccepted {
                    axis,
                    target_steps,
                    at: first_byte_at,
                });
            }
            (PtuCommand::Halt, _) if self.script.is_none() => self.emit(PtuEvent::Halted),
            (PtuCommand::SetHoldPowerLow(Axis::Tilt), _) => self.emit(PtuEvent::HoldPowerLow),
            (PtuCommand::Reset, _) => return self.reset_done(now),
            _ => {}
        }
        self.start_next(now);
    }

    /// The calibration succeeded: drains the line, then reads the limits anew.
    fn reset_done(&mut self, now: Duration) {
        self.begin_resync(None, now);
        self.begin_script(ScriptKind::Limits);
    }

    fn finish_reset(&mut self, now: Duration) {
        let (pan, tilt) = match self.draft.limits() {
            Ok(limits) => limits,
            Err(fault) => return self.restart_script(ScriptKind::Limits, fault, now),
        };
        self.emit(match self.reset_spoilt_by {
            None => PtuEvent::HomeDone { pan, tilt },
            Some(notice) => {
                let text = match notice {
                    Notice::Cable => "the cable to the head was disconnected during the reset",
                    _ => "an axis hit its limit right after the reset",
                };
                let text = text.to_owned();
                PtuEvent::Fault(HeadError::ResetFailed { text })
            }
        });
        self.start_next(now);
    }

    fn handle_refusal(&mut self, command: PtuCommand, text: &str, now: Duration) {
        self.in_flight = None;
        let text = text.to_owned();
        match (command, &self.script) {
            // Not every unit reports its supply or its powers.
            (
                PtuCommand::QuerySupply
                | PtuCommand::QueryHoldPower(_)
                | PtuCommand::QueryMovePower(_),
                Some(_),
            ) => {}
            (_, Some(_)) => {
                return self.go_offline(HeadError::SetupRefused {
                    command: command.to_text(),
                    text,
                });
            }
            (PtuCommand::Reset, None) => {
                self.emit(PtuEvent::Fault(HeadError::ResetFailed { text }));
            }
            (_, None) => self.emit(PtuEvent::Refused {
                command: command.to_text(),
                text,
            }),
        }
        self.start_next(now);
    }

    /// Sends the next command, unless one is in flight or the line is being resynchronised.
    pub(crate) fn start_next(&mut self, now: Duration) {
        if self.phase != DialoguePhase::Running || self.in_flight.is_some() || self.resync.is_some()
        {
            return;
        }
        let next = match &mut self.script {
            Some((_, commands)) => commands.pop_front(),
            None => self.queue.pop_front(),
        };
        match (next, self.script.as_ref().map(|(script, _)| *script)) {
            (Some(command), _) => self.send(command, 1, now),
            (None, Some(script)) => {
                self.script = None;
                match script {
                    ScriptKind::Setup => self.finish_setup(now),
                    ScriptKind::Limits => self.finish_reset(now),
                }
            }
            (None, None) => {}
        }
    }

    pub(crate) fn reply_timed_out(&mut self, now: Duration) {
        if let Some(in_flight) = self.in_flight {
            self.retry(in_flight, now);
        }
    }

    /// Resynchronises and sends the command once more, or gives up. A reset is never repeated on the driver's own account.
    fn retry(&mut self, failed: InFlight, now: Duration) {
        if failed.command == PtuCommand::Reset {
            return self.go_offline(HeadError::ResetTimedOut {
                waited_s: CALIBRATION_TIMEOUT.as_secs(),
            });
        }
        if failed.tries >= MAX_TRIES {
            let heard = std::mem::take(&mut self.last_unmatched_line);
            return self.go_offline(HeadError::NoReply {
                command: failed.command.to_text(),
                tries: failed.tries,
                heard,
            });
        }
        self.begin_resync(Some((failed.command, failed.tries)), now);
    }

    pub(crate) fn begin_resync(&mut self, retry: Option<(PtuCommand, u32)>, now: Duration) {
        self.in_flight = None;
        // What is read once has the time that a late reply takes; a poll has the next poll.
        let drain = if self.script.is_some() {
            REPLY_TIMEOUT
        } else {
            DRAIN_TIME
        };
        let (until, hard_end) = (
            now.saturating_add(drain),
            now.saturating_add(drain.max(MAX_DRAIN_TIME)),
        );
        self.resync = Some(Resync {
            space_sent: false,
            until,
            hard_end,
            retry,
        });
    }

    pub(crate) fn resync_step(&mut self, now: Duration) {
        let Some(resync) = self.resync else { return };
        self.lines.clear();
        if !resync.space_sent {
            self.actions.push_back(PtuAction::Send(b" ".to_vec()));
            let (until, hard_end) = (
                now.saturating_add(DRAIN_TIME),
                now.saturating_add(MAX_DRAIN_TIME),
            );
            self.resync = Some(Resync {
                space_sent: true,
                until,
                hard_end,
                retry: resync.retry,
            });
            return;
        }
        self.resync = None;
        match resync.retry {
            Some((command, tries)) => {
                self.send(command, tries + 1, now);
            }
            None => self.start_next(now),
        }
    }

    /// A reply, but not to the command in flight. In a script those before it are in doubt too. During a calibration the
    /// driver keeps waiting for its end.
    fn handle_mismatch(&mut self, line: &ReplyLine, in_flight: InFlight, now: Duration) {
        self.note_unmatched(line);
        if let Some((kind, _)) = self.script {
            let fault = HeadError::OutOfStep {
                command: in_flight.command.to_text(),
                heard: line.bytes.escape_ascii().to_string(),
            };
            return self.restart_script(kind, fault, now);
        }
        if in_flight.command != PtuCommand::Reset {
            self.retry(in_flight, now);
        }
    }

    fn note_unmatched(&mut self, line: &ReplyLine) {
        self.last_unmatched_line = line.bytes.escape_ascii().to_string();
    }

    /// The unit's settings are lost, and perhaps its position: connects anew.
    fn settings_lost(&mut self, event: PtuEvent, now: Duration) {
        self.emit(event);
        self.restart_connection(now);
    }
}

fn store_property(draft: &mut AxisDraft, property: AxisProperty, value: f64) {
    let whole = reply::integer(value);
    match property {
        AxisProperty::Position => {}
        AxisProperty::Resolution => draft.arcsec = Some(value),
        AxisProperty::MinPosition => draft.min_steps = whole,
        AxisProperty::MaxPosition => draft.max_steps = whole,
        AxisProperty::MinSpeed => draft.speed_min = whole,
        AxisProperty::MaxSpeed => draft.speed_max = whole,
        AxisProperty::Speed => draft.speed = whole,
        AxisProperty::Acceleration => draft.acceleration = whole,
        AxisProperty::BaseSpeed => draft.base_speed = whole,
    }
}
