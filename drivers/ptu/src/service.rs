//! The dialogue of a connected unit: one command, one reply, and the way back into step (section 11, steps 4 and 5).

use crate::action::{Action, Event, HeadError};
use crate::axis::StepSize;
use crate::command::{Command, Expected, Quantity};
use crate::connect::is_banner;
use crate::constants::{CALIBRATION_TIMEOUT, DRAIN, DRAIN_LIMIT, DRAIN_QUIET, TRIES};
use crate::head::{Head, InFlight, Phase, Resync, Script};
use crate::identity::{AxisDraft, Health};
use crate::line::{Line, Notice, Token};
use crate::reply::{self, Outcome};
use crate::{Axis, HoldPower, Instant, MovePower};

/// A success reply after its form was checked.
enum Content<'a> {
    Nothing,
    Number(f64),
    Text(&'a str),
    /// The setting stands the other way.
    Otherwise(&'static str),
    /// A number in a phrase: the unit is verbose.
    Verbose(f64),
    Unfit,
}

fn content(expected: Expected, text: &str) -> Content<'_> {
    let number = reply::number(text);
    match expected {
        Expected::Done if text.is_empty() => Content::Nothing,
        Expected::DoneOrWords if number.is_none() => Content::Nothing,
        Expected::Done | Expected::DoneOrWords => Content::Unfit,
        Expected::Text if text.is_empty() => Content::Unfit,
        Expected::Text => Content::Text(text),
        Expected::Either { wanted, other } => match reply::either(text, wanted, other) {
            Some(true) => Content::Nothing,
            Some(false) => Content::Otherwise(wanted),
            None => Content::Unfit,
        },
        Expected::Whole | Expected::Decimal => match number {
            Some(n) if expected == Expected::Whole && reply::whole(n.value).is_none() => {
                Content::Unfit
            }
            Some(n) if n.verbose => Content::Verbose(n.value),
            Some(n) => Content::Number(n.value),
            None => Content::Unfit,
        },
    }
}

impl Head {
    /// Takes what came over the line; `now` is when it came.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Instant) {
        for byte in bytes {
            self.bytes_heard = self.bytes_heard.saturating_add(1);
            if let Some(resync) = &mut self.resync {
                resync.until = resync
                    .until
                    .max(now.saturating_add(DRAIN_QUIET))
                    .min(resync.hard_end);
            }
            match (self.lines.push(*byte, now), self.phase) {
                (None, _) => {}
                (Some(Token::Overlong), _) => self.counters.overlong_lines += 1,
                (Some(_), Phase::Offline) => {}
                (Some(Token::Notice(notice)), Phase::Running) => self.notice(notice),
                (Some(Token::Line(line)), Phase::Running) => self.line(&line, now),
                (Some(Token::Notice(notice)), _) => self.notice_at_connecting(notice, now),
                (Some(Token::Line(line)), _) => self.line_at_connecting(&line, now),
            }
        }
    }

    fn notice(&mut self, notice: Notice) {
        let homing = self.in_flight.is_some_and(|f| f.command == Command::Reset);
        let ending = matches!(self.script, Some((Script::Limits, _)));
        let spoils = ending || (homing && notice == Notice::Cable);
        if spoils && notice != Notice::Trigger {
            self.homing_spoilt.get_or_insert(notice);
        }
        match notice {
            // A calibration says so at every stop.
            Notice::Limit(_) if homing => {}
            Notice::Limit(axis) => {
                (self.position_trusted, self.calibration_seen) = (false, false);
                self.emit(Event::LimitHit(axis));
            }
            Notice::Cable => {
                self.position_trusted = false;
                self.emit(Event::CableLost);
            }
            Notice::Trigger => {}
        }
    }

    fn line(&mut self, line: &Line, now: Instant) {
        if is_banner(&line.bytes) {
            self.settings_lost(Event::Restarted, now);
            // The line may be the end of the banner already.
            return self.line_at_connecting(line, now);
        }
        if self.resync.is_some() {
            return self.odd_line(line);
        }
        let Some(in_flight) = self.in_flight else {
            self.odd_line(line);
            return self.begin_resync(None, now);
        };
        let reply = reply::parse(&line.bytes);
        let setting_up = matches!(self.script, Some((Script::Setup, _)));
        if !setting_up && reply.echoes(&in_flight.command.text()) {
            return self.settings_lost(Event::EchoReturned, now);
        }
        match reply.outcome {
            // Dirt: the reply itself may still come.
            Outcome::Unmarked => self.odd_line(line),
            Outcome::Garbled => self.misfit(line, in_flight, now),
            Outcome::Refusal(text) => self.refused(in_flight.command, text, now),
            Outcome::Success(text) => match content(in_flight.command.expected(), text) {
                Content::Verbose(_) if !setting_up => {
                    self.settings_lost(Event::VerboseReturned, now)
                }
                Content::Unfit => self.misfit(line, in_flight, now),
                Content::Otherwise(wanted) => {
                    let command = in_flight.command.text();
                    let fault = HeadError::SettingNotTaken {
                        command,
                        expected: wanted.to_owned(),
                        got: text.to_owned(),
                    };
                    self.attempt_failed(fault, now);
                }
                fitting => self.done(in_flight, line.reply_at, &fitting, now),
            },
        }
    }

    fn done(
        &mut self,
        in_flight: InFlight,
        first_byte_at: Instant,
        content: &Content<'_>,
        now: Instant,
    ) {
        self.in_flight = None;
        match (in_flight.command, content) {
            (Command::Query(axis, Quantity::Position), Content::Number(value)) => {
                if let Some(steps) = reply::whole(*value) {
                    let sent_at = in_flight.sent_at.min(first_byte_at);
                    self.emit(Event::Position {
                        axis,
                        steps,
                        sent_at,
                        first_byte_at,
                    });
                }
            }
            (Command::Query(axis, Quantity::SpeedNow), Content::Number(value)) => {
                if let Some(steps_per_s) = reply::whole(*value) {
                    self.emit(Event::Speed { axis, steps_per_s });
                }
            }
            (Command::Query(axis, Quantity::Target), Content::Number(value)) => {
                if let Some(steps) = reply::whole(*value) {
                    self.emit(Event::Target { axis, steps });
                }
            }
            (Command::HoldState(axis), Content::Text(text)) => {
                self.draft.axis_mut(axis).hold_power = HoldPower::from_text(text);
            }
            (Command::MoveState(axis), Content::Text(text)) => {
                self.draft.axis_mut(axis).move_power = MovePower::from_text(text);
            }
            (Command::SetHold(axis, power), _) => self.emit(Event::HoldPowerSet { axis, power }),
            (Command::SetMove(axis, power), _) => self.emit(Event::MovePowerSet { axis, power }),
            (Command::HaltAxis(axis), _) => self.emit(Event::AxisHalted(axis)),
            (Command::Query(axis, quantity), Content::Number(value) | Content::Verbose(value)) => {
                note(self.draft.axis_mut(axis), quantity, *value);
            }
            (Command::Supply, Content::Text(text)) => {
                let health = Health::from_text(text);
                if self.script.is_some() {
                    self.draft.health = health;
                } else if let Some(health) = health {
                    self.emit(Event::Health(health));
                } else {
                    self.emit(Event::Refused {
                        command: Command::Supply.text(),
                        text: (*text).to_owned(),
                    });
                }
            }
            (Command::SetSpeed(axis, steps_per_s), _) => {
                self.emit(Event::SpeedSet { axis, steps_per_s })
            }
            (Command::MoveTo(axis, target_steps), _) => {
                self.emit(Event::MoveAccepted {
                    axis,
                    target_steps,
                    at: first_byte_at,
                });
            }
            (Command::Halt, _) if self.script.is_none() => self.emit(Event::Halted),
            (Command::HoldLow(Axis::Tilt), _) => self.emit(Event::HoldPowerLow),
            (Command::Reset, _) => return self.homed(now),
            _ => {}
        }
        self.start_next(now);
    }

    /// The calibration ended well: what still trickles in is drained, then the limits are read anew.
    fn homed(&mut self, now: Instant) {
        for axis in Axis::BOTH {
            let draft = self.draft.axis_mut(axis);
            (draft.min_steps, draft.max_steps) = (None, None);
        }
        let limits = [Quantity::MinPosition, Quantity::MaxPosition];
        let queries = Axis::BOTH
            .into_iter()
            .flat_map(|axis| limits.map(|limit| Command::Query(axis, limit)));
        self.script = Some((Script::Limits, queries.collect()));
        self.drain(None, now);
    }

    fn limits_read(&mut self, now: Instant) {
        let (Some(pan), Some(tilt)) = (self.draft.pan.limits(), self.draft.tilt.limits()) else {
            let text = "limits that leave no range".to_owned();
            return self.go_offline(HeadError::SetupRefused {
                command: "PN PX TN TX".to_owned(),
                text,
            });
        };
        if let Some(identity) = &mut self.identity {
            identity.axis_mut(Axis::Pan).limits = pan;
            identity.axis_mut(Axis::Tilt).limits = tilt;
        }
        let spoilt = self.homing_spoilt.take();
        self.position_trusted = spoilt.is_none();
        self.emit(match spoilt {
            None => Event::HomeDone { pan, tilt },
            Some(notice) => {
                let text = match notice {
                    Notice::Cable => "the cable to the head came off meanwhile",
                    _ => "an axis ran into its limit just after it",
                };
                let text = text.to_owned();
                Event::Fault(HeadError::ResetFailed { text })
            }
        });
        self.start_next(now);
    }

    fn refused(&mut self, command: Command, text: &str, now: Instant) {
        self.in_flight = None;
        let text = text.to_owned();
        match (command, &self.script) {
            // Not every unit tells its supply or its powers.
            (Command::Supply | Command::HoldState(_) | Command::MoveState(_), Some(_)) => {}
            (_, Some(_)) => {
                return self.go_offline(HeadError::SetupRefused {
                    command: command.text(),
                    text,
                });
            }
            (Command::Reset, None) => {
                self.position_trusted = false;
                self.emit(Event::Fault(HeadError::ResetFailed { text }));
            }
            (_, None) => self.emit(Event::Refused {
                command: command.text(),
                text,
            }),
        }
        self.start_next(now);
    }

    /// Sends the next command, if none is in flight and the line is in step.
    pub(crate) fn start_next(&mut self, now: Instant) {
        if self.phase != Phase::Running || self.in_flight.is_some() || self.resync.is_some() {
            return;
        }
        let next = match &mut self.script {
            Some((_, commands)) => commands.pop_front(),
            None => self.queue.pop_front(),
        };
        match (next, self.script.as_ref().map(|(script, _)| *script)) {
            (Some(command), _) => self.send(command, 1, self.reply_timeout(command), now),
            (None, Some(script)) => {
                self.script = None;
                match script {
                    Script::Setup => self.setup_done(now),
                    Script::Limits => self.limits_read(now),
                }
            }
            (None, None) => {}
        }
    }

    pub(crate) fn reply_timed_out(&mut self, now: Instant) {
        if let Some(in_flight) = self.in_flight {
            self.counters.timeouts += 1;
            self.try_again(in_flight, now);
        }
    }

    /// Gets into step and sends the command once more, or gives up. A reset is never sent twice by itself.
    fn try_again(&mut self, failed: InFlight, now: Instant) {
        if failed.command == Command::Reset {
            return self.go_offline(HeadError::ResetTimedOut {
                waited_s: CALIBRATION_TIMEOUT.as_secs(),
            });
        }
        if failed.tries >= TRIES {
            let heard = std::mem::take(&mut self.last_odd_line);
            return self.go_offline(HeadError::NoReply {
                command: failed.command.text(),
                tries: failed.tries,
                heard,
            });
        }
        self.begin_resync(Some((failed.command, failed.tries)), now);
    }

    fn begin_resync(&mut self, retry: Option<(Command, u32)>, now: Instant) {
        self.counters.resyncs += 1;
        self.drain(retry, now);
    }

    fn drain(&mut self, retry: Option<(Command, u32)>, now: Instant) {
        self.in_flight = None;
        let (until, hard_end) = (now.saturating_add(DRAIN), now.saturating_add(DRAIN_LIMIT));
        self.resync = Some(Resync {
            space_sent: false,
            until,
            hard_end,
            retry,
        });
    }

    pub(crate) fn resync_step(&mut self, now: Instant) {
        let Some(resync) = self.resync else { return };
        self.lines.clear();
        if !resync.space_sent {
            self.actions.push_back(Action::Send(b" ".to_vec()));
            let (until, hard_end) = (now.saturating_add(DRAIN), now.saturating_add(DRAIN_LIMIT));
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
                self.counters.retries += 1;
                self.send(command, tries + 1, self.reply_timeout(command), now);
            }
            None => self.start_next(now),
        }
    }

    /// A reply, but not one to the command in flight. A calibration is waited for all the same.
    fn misfit(&mut self, line: &Line, in_flight: InFlight, now: Instant) {
        self.odd_line(line);
        if in_flight.command != Command::Reset {
            self.try_again(in_flight, now);
        }
    }

    fn odd_line(&mut self, line: &Line) {
        self.counters.unmatched_lines += 1;
        self.last_odd_line = line.bytes.escape_ascii().to_string();
    }

    /// The unit is not as it was set: whatever it knew of its position may be gone too. Connects anew.
    fn settings_lost(&mut self, event: Event, now: Instant) {
        self.emit(event);
        self.restart_connection(now);
    }
}

fn note(draft: &mut AxisDraft, quantity: Quantity, value: f64) {
    let whole = reply::whole(value);
    match quantity {
        Quantity::Position | Quantity::Target | Quantity::SpeedNow => {}
        Quantity::Resolution => draft.step = StepSize::from_print(value),
        Quantity::MinPosition => draft.min_steps = whole,
        Quantity::MaxPosition => draft.max_steps = whole,
        Quantity::SpeedMin => draft.speed_min = whole,
        Quantity::SpeedMax => draft.speed_max = whole,
        Quantity::Speed => draft.speed = whole,
        Quantity::Acceleration => draft.acceleration = whole,
        Quantity::BaseSpeed => draft.base_speed = whole,
    }
}
