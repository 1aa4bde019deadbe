//! Connecting: from silence to a unit whose settings and identity are known (ptu-d46 section 11, steps 1 to 3).

use std::collections::VecDeque;
use std::time::Duration;

use crate::Axis;
use crate::action::{PtuAction, PtuEvent};
use crate::command::{AxisProperty, PtuCommand};
use crate::constants::{CALIBRATION_POLL_AFTER, CALIBRATION_TIMEOUT, MAX_SCRIPT_RUNS, SETTLE_TIME};
use crate::driver::{DialoguePhase, PtuDriver, ScriptKind};
use crate::error::HeadError;
use crate::identity::IdentityDraft;
use crate::line::{Notice, ReplyLine};
use crate::reply::{self, ReplyOutcome};
use crate::who_answers::not_a_head;

/// Terminates a half-typed command of another program, and a running monitor (ptu-d46 sections 2 and 8).
const FLUSH_SPACES: &[u8] = b"   ";

/// The same from the second attempt on. A CR is a delimiter as well (ptu-d46 section 2), and makes other devices answer to
/// what they take for their command, so that a laser on this port is recognised.
const FLUSH_LINE: &[u8] = b"  \r";

/// Clears the network id of every unit on the line (ptu-d46 section 11, step 1).
const NETWORK_RESCUE: &[u8] = b" _0 U0 ";

/// Halts first: a unit in velocity mode or with held-back targets must not start moving when the mode changes (ptu-d46 section 6).
const SETTING_COMMANDS: [PtuCommand; 4] = [
    PtuCommand::Halt,
    PtuCommand::IndependentMode,
    PtuCommand::ImmediateMode,
    PtuCommand::LimitsOn,
];

/// Read in this order, of both axes each. The queries of settings in between have replies of their own: a number in place of
/// one shows that the replies before it belonged to other commands.
const IDENTITY_QUERIES: [(PtuCommand, &[AxisProperty]); 3] = [
    (
        PtuCommand::QueryFeedback,
        &[
            AxisProperty::Resolution,
            AxisProperty::MinPosition,
            AxisProperty::MaxPosition,
        ],
    ),
    (
        PtuCommand::QueryControlMode,
        &[
            AxisProperty::MinSpeed,
            AxisProperty::MaxSpeed,
            AxisProperty::Speed,
            AxisProperty::Acceleration,
            AxisProperty::BaseSpeed,
        ],
    ),
    (PtuCommand::QueryLimits, &[]),
];

fn setup_script() -> VecDeque<PtuCommand> {
    let both = |property: &AxisProperty| Axis::BOTH.map(|axis| PtuCommand::Query(axis, *property));
    let identity = IDENTITY_QUERIES
        .into_iter()
        .flat_map(|(setting, properties)| {
            [setting]
                .into_iter()
                .chain(properties.iter().flat_map(both))
        });
    SETTING_COMMANDS
        .into_iter()
        .chain(identity)
        .chain(Axis::BOTH.map(PtuCommand::QueryHoldPower))
        .chain(Axis::BOTH.map(PtuCommand::QueryMovePower))
        .chain([PtuCommand::QuerySupply, PtuCommand::QueryEcho])
        .collect()
}

/// The limits, and a setting whose reply is no number, to see that each reply belonged to its query.
fn limits_script() -> VecDeque<PtuCommand> {
    let limits = [AxisProperty::MinPosition, AxisProperty::MaxPosition];
    Axis::BOTH
        .into_iter()
        .flat_map(|axis| limits.map(|limit| PtuCommand::Query(axis, limit)))
        .chain([PtuCommand::QueryLimits])
        .collect()
}

/// Whether a line belongs to the power-up text (ptu-d46 section 7).
pub(crate) fn is_banner(line: &[u8]) -> bool {
    line.starts_with(b"###")
        || line
            .windows(12)
            .any(|w| w.eq_ignore_ascii_case(b"Initializing"))
}

impl PtuDriver {
    /// Drops all state but the actions not taken yet, and makes the first attempt.
    pub(crate) fn restart_connection(&mut self, now: Duration) {
        *self = Self {
            actions: std::mem::take(&mut self.actions),
            network_rescue_sent: self.network_rescue_sent,
            ..Self::new(self.options.clone())
        };
        self.begin_attempt(now);
    }

    fn begin_attempt(&mut self, now: Duration) {
        self.clear_dialogue();
        self.draft = IdentityDraft::default();
        let bytes = if self.connect_attempts == 0 {
            FLUSH_SPACES
        } else {
            FLUSH_LINE
        };
        let flush = PtuAction::Send(bytes.to_vec());
        if self.actions.back() != Some(&flush) {
            self.heard.note_sent(bytes);
            self.actions.push_back(flush);
        }
        let until = now
            .saturating_add(self.wire_time(FLUSH_SPACES.len()))
            .saturating_add(SETTLE_TIME);
        self.phase = DialoguePhase::Settling { until };
    }

    pub(crate) fn begin_preamble(&mut self, now: Duration) {
        self.lines.clear();
        self.phase = DialoguePhase::Preamble;
        self.send(PtuCommand::EchoOff, 1, now);
    }

    /// A notice before the unit is identified.
    pub(crate) fn handle_connecting_notice(&mut self, notice: Notice, now: Duration) {
        match notice {
            Notice::Limit(_) => self.wait_for_calibration(now),
            Notice::Cable => self.emit(PtuEvent::CableLost),
            Notice::Trigger => {}
        }
    }

    /// A line before the unit is identified.
    pub(crate) fn handle_connecting_line(&mut self, line: &ReplyLine, now: Duration) {
        let outcome = reply::parse(&line.bytes).outcome;
        if is_banner(&line.bytes) {
            // The last line of the banner ends with the `*` of the calibration.
            match outcome {
                ReplyOutcome::Success(_) => self.calibration_ended(true, now),
                _ => self.wait_for_calibration(now),
            }
            return;
        }
        match (self.phase, outcome) {
            (DialoguePhase::Calibrating { .. }, ReplyOutcome::Success(_)) => {
                self.calibration_ended(true, now)
            }
            (DialoguePhase::Calibrating { .. }, ReplyOutcome::Refusal(_)) => {
                self.calibration_ended(false, now)
            }
            (DialoguePhase::Preamble, ReplyOutcome::Success(text)) => {
                self.handle_preamble_reply(text, now)
            }
            (DialoguePhase::Preamble, ReplyOutcome::Refusal(_)) => {
                self.handle_preamble_reply("", now)
            }
            _ => {}
        }
    }

    fn wait_for_calibration(&mut self, now: Duration) {
        self.in_flight = None;
        self.calibration_end
            .get_or_insert(now.saturating_add(CALIBRATION_TIMEOUT));
        self.phase = DialoguePhase::Calibrating {
            quiet_until: now.saturating_add(CALIBRATION_POLL_AFTER),
        };
    }

    fn calibration_ended(&mut self, succeeded: bool, now: Duration) {
        self.calibration_seen = succeeded;
        self.calibration_end = None;
        self.begin_attempt(now);
    }

    /// After a long silence the end of the calibration may have been lost, or there was none: asks again. Gives up at the time limit.
    pub(crate) fn calibration_timed_out(&mut self, now: Duration) {
        if self.calibration_end.is_some_and(|end| now >= end) {
            return self.go_offline(HeadError::CalibrationTimedOut {
                waited_s: CALIBRATION_TIMEOUT.as_secs(),
            });
        }
        self.begin_attempt(now);
    }

    /// Any reply will do for `ED` and `FT`; the reply to `V` must be a text, anything else is a late reply to the other two.
    fn handle_preamble_reply(&mut self, text: &str, now: Duration) {
        match self.in_flight.map(|f| f.command) {
            Some(PtuCommand::EchoOff) => self.send(PtuCommand::Terse, 1, now),
            Some(PtuCommand::Terse) => self.send(PtuCommand::QueryVersion, 1, now),
            Some(PtuCommand::QueryVersion) if is_version(text) => {
                self.draft.version = text.to_owned();
                self.calibration_end = None;
                self.in_flight = None;
                self.phase = DialoguePhase::Running;
                self.begin_script(ScriptKind::Setup);
                self.start_next(now);
            }
            _ => {}
        }
    }

    pub(crate) fn preamble_timed_out(&mut self, now: Duration) {
        match self.in_flight.map(|f| f.command) {
            _ if self.options.gives_up_on_garbage && self.heard.is_garbage() => {
                self.go_offline(not_a_head(&self.heard));
            }
            Some(PtuCommand::EchoOff | PtuCommand::Terse) => self.handle_preamble_reply("", now),
            _ => self.attempt_failed(not_a_head(&self.heard), now),
        }
    }

    /// Makes another attempt, or gives up with `fault`.
    pub(crate) fn attempt_failed(&mut self, fault: HeadError, now: Duration) {
        if self.calibration_end.is_some() {
            // A calibrating unit answers nothing, and this one was seen calibrating.
            return self.wait_for_calibration(now);
        }
        self.connect_attempts += 1;
        if self.connect_attempts < self.options.attempts {
            self.begin_attempt(now);
        } else if self.options.network_rescue && !self.network_rescue_sent {
            self.network_rescue_sent = true;
            self.actions
                .push_back(PtuAction::Send(NETWORK_RESCUE.to_vec()));
            self.begin_attempt(now);
        } else {
            self.go_offline(fault);
        }
    }

    pub(crate) fn begin_script(&mut self, kind: ScriptKind) {
        self.script_restarts = 0;
        self.fill_script(kind);
    }

    fn fill_script(&mut self, kind: ScriptKind) {
        let commands = match kind {
            ScriptKind::Setup => {
                self.draft = IdentityDraft {
                    version: std::mem::take(&mut self.draft.version),
                    ..IdentityDraft::default()
                };
                setup_script()
            }
            ScriptKind::Limits => {
                for axis in Axis::BOTH {
                    let draft = self.draft.axis_mut(axis);
                    (draft.min_steps, draft.max_steps) = (None, None);
                }
                limits_script()
            }
        };
        self.script = Some((kind, commands));
    }

    /// Replies did not fit their commands: gets back into step and reads all again, a few times, then gives up with `fault`.
    pub(crate) fn restart_script(&mut self, kind: ScriptKind, fault: HeadError, now: Duration) {
        self.script_restarts += 1;
        if self.script_restarts >= MAX_SCRIPT_RUNS {
            return self.go_offline(fault);
        }
        self.fill_script(kind);
        self.begin_resync(None, now);
    }

    /// All settings are made and the identity is read.
    pub(crate) fn finish_setup(&mut self, now: Duration) {
        let identity = match self.draft.finish(self.calibration_seen) {
            Ok(identity) => identity,
            Err(fault) => return self.restart_script(ScriptKind::Setup, fault, now),
        };
        self.emit(PtuEvent::Connected(Box::new(identity)));
        self.start_next(now);
    }
}

fn is_version(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_alphabetic()) && text.contains(|c: char| c.is_ascii_digit())
}
