//! From silence to a unit whose settings are known (section 11, steps 1 to 3).

use std::collections::VecDeque;

use crate::action::{Action, Event, HeadError};
use crate::command::{Command, Quantity};
use crate::constants::{CALIBRATION_QUIET, CALIBRATION_TIMEOUT, PREAMBLE_TIMEOUT, SETTLE, TRIES};
use crate::head::{Head, Phase, Script};
use crate::identity::Draft;
use crate::line::{Line, Notice};
use crate::reply::{self, Outcome};
use crate::{Axis, Instant};

/// Ends a half-typed command left by somebody else, and a running monitor (sections 2 and 8).
const SPACES: &[u8] = b"   ";

/// Takes a network id away from every unit on the line (section 11, step 1).
const RESCUE: &[u8] = b" _0 U0 ";

/// Halts first: a unit found in velocity mode or with held-back targets must not start when the mode changes (section 6).
const SETTINGS: [Command; 8] = [
    Command::Halt,
    Command::Independent,
    Command::Immediate,
    Command::LimitsOn,
    Command::EchoState,
    Command::FeedbackState,
    Command::ControlState,
    Command::LimitState,
];

/// Read of both axes, in this order.
const PROPERTIES: [Quantity; 8] = [
    Quantity::Resolution,
    Quantity::MinPosition,
    Quantity::MaxPosition,
    Quantity::SpeedMin,
    Quantity::SpeedMax,
    Quantity::Speed,
    Quantity::Acceleration,
    Quantity::BaseSpeed,
];

fn setup_script() -> VecDeque<Command> {
    let both = |quantity| Axis::BOTH.map(|axis| Command::Query(axis, quantity));
    SETTINGS
        .into_iter()
        .chain(PROPERTIES.into_iter().flat_map(both))
        .chain(Axis::BOTH.map(Command::HoldState))
        .chain(Axis::BOTH.map(Command::MoveState))
        .chain([Command::Supply])
        .collect()
}

/// Whether a line belongs to the power-up text (section 7).
pub(crate) fn is_banner(line: &[u8]) -> bool {
    line.starts_with(b"###")
        || line
            .windows(12)
            .any(|w| w.eq_ignore_ascii_case(b"Initializing"))
}

impl Head {
    /// Forgets everything and begins with the first try.
    pub(crate) fn restart_connection(&mut self, now: Instant) {
        self.connect_tries = 0;
        self.calibration_seen = false;
        self.calibration_end = None;
        self.bytes_heard = 0;
        self.position_trusted = false;
        self.identity = None;
        self.begin_attempt(now);
    }

    fn begin_attempt(&mut self, now: Instant) {
        self.forget_dialogue();
        self.draft = Draft::default();
        let spaces = Action::Send(SPACES.to_vec());
        if self.actions.back() != Some(&spaces) {
            self.actions.push_back(spaces);
        }
        let until = now
            .saturating_add(self.wire_time(SPACES.len()))
            .saturating_add(SETTLE);
        self.phase = Phase::Settling { until };
    }

    pub(crate) fn settled(&mut self, now: Instant) {
        self.lines.clear();
        self.phase = Phase::Preamble;
        self.send(Command::EchoOff, 1, PREAMBLE_TIMEOUT, now);
    }

    /// A notice before the unit is known.
    pub(crate) fn notice_at_connecting(&mut self, notice: Notice, now: Instant) {
        match notice {
            Notice::Limit(_) => self.wait_for_calibration(now),
            Notice::Cable => self.emit(Event::CableLost),
            Notice::Trigger => {}
        }
    }

    /// A line before the unit is known.
    pub(crate) fn line_at_connecting(&mut self, line: &Line, now: Instant) {
        let outcome = reply::parse(&line.bytes).outcome;
        if is_banner(&line.bytes) {
            // The last line of the banner ends with the `*` of the calibration.
            match outcome {
                Outcome::Success(_) => self.calibration_ended(true, now),
                _ => self.wait_for_calibration(now),
            }
            return;
        }
        match (self.phase, outcome) {
            (Phase::Calibrating { .. }, Outcome::Success(_)) => self.calibration_ended(true, now),
            (Phase::Calibrating { .. }, Outcome::Refusal(_)) => self.calibration_ended(false, now),
            (Phase::Preamble, Outcome::Success(text)) => self.preamble_reply(text, now),
            (Phase::Preamble, Outcome::Refusal(_)) => self.preamble_reply("", now),
            _ => {}
        }
    }

    fn wait_for_calibration(&mut self, now: Instant) {
        self.in_flight = None;
        self.calibration_end
            .get_or_insert(now.saturating_add(CALIBRATION_TIMEOUT));
        self.phase = Phase::Calibrating {
            quiet_until: now.saturating_add(CALIBRATION_QUIET),
        };
    }

    fn calibration_ended(&mut self, well: bool, now: Instant) {
        self.calibration_seen = well;
        self.calibration_end = None;
        self.begin_attempt(now);
    }

    /// Quiet for long: perhaps its end was lost, or it was no calibration. Asking shows. At the end of all patience: give up.
    pub(crate) fn calibration_timed_out(&mut self, now: Instant) {
        if self.calibration_end.is_some_and(|end| now >= end) {
            return self.go_offline(HeadError::CalibrationTimedOut {
                waited_s: CALIBRATION_TIMEOUT.as_secs(),
            });
        }
        self.begin_attempt(now);
    }

    /// `ED` and `FT` are done with any answer; the answer to `V` must be a text, and what is not is a late answer to the others.
    fn preamble_reply(&mut self, text: &str, now: Instant) {
        match self.in_flight.map(|f| f.command) {
            Some(Command::EchoOff) => self.send(Command::Terse, 1, PREAMBLE_TIMEOUT, now),
            Some(Command::Terse) => self.send(
                Command::Version,
                1,
                self.reply_timeout(Command::Version),
                now,
            ),
            Some(Command::Version) if is_version(text) => {
                self.draft.version = text.to_owned();
                self.calibration_end = None;
                self.in_flight = None;
                self.phase = Phase::Running;
                self.script = Some((Script::Setup, setup_script()));
                self.start_next(now);
            }
            _ => {}
        }
    }

    pub(crate) fn preamble_timed_out(&mut self, now: Instant) {
        match self.in_flight.map(|f| f.command) {
            Some(Command::EchoOff | Command::Terse) => self.preamble_reply("", now),
            _ => {
                self.counters.timeouts += 1;
                self.attempt_failed(
                    HeadError::Silent {
                        bytes_heard: self.bytes_heard,
                    },
                    now,
                );
            }
        }
    }

    /// Tries again, or gives up with `fault`.
    pub(crate) fn attempt_failed(&mut self, fault: HeadError, now: Instant) {
        if self.calibration_end.is_some() {
            // A unit that calibrates answers nothing; it was heard doing so.
            return self.wait_for_calibration(now);
        }
        self.connect_tries += 1;
        if self.connect_tries < TRIES {
            self.begin_attempt(now);
        } else if self.options.network_rescue && !self.rescued {
            self.rescued = true;
            self.actions.push_back(Action::Send(RESCUE.to_vec()));
            self.begin_attempt(now);
        } else {
            self.go_offline(fault);
        }
    }

    /// All settings are made and everything is read.
    pub(crate) fn setup_done(&mut self, now: Instant) {
        let Some(identity) = self.draft.finish(self.calibration_seen) else {
            let text = "limits that leave no range, or a resolution that is none".to_owned();
            return self.go_offline(HeadError::SetupRefused {
                command: "PN PX TN TX PR TR".to_owned(),
                text,
            });
        };
        self.position_trusted = self.calibration_seen;
        self.connect_tries = 0;
        self.identity = Some(identity.clone());
        self.emit(Event::Connected(Box::new(identity)));
        self.start_next(now);
    }
}

fn is_version(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_alphabetic()) && text.contains(|c: char| c.is_ascii_digit())
}
