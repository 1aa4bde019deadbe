//! Connecting, from any state that the device was left in (scip2 sections 13 and 14).
//!
//! ```text
//! QT --00--> RS --> VV --> PP --> II --> connected
//!  | E            SCIP 1.1: SCIP2.0 (answers 0 or 0E), then QT again
//!  | 0E, 10       time adjust (10 in SCIP 2.2): TM2, then QT again
//!  | 0I           firmware update mode: RS, then QT again
//!  | silence      SCIP2.0 once (old units fall silent), then give up
//! ```
//!
//! On a line slower than wanted, `raising_rate` follows.
//!
//! Where nothing that came answers a request, the bytes decide what is there instead (`who_answers`).
//!
//! A device that was left streaming sends scans before its echo of `QT`; they are skipped. Nothing waits for silence,
//! since a stream has none.

use super::action::LaserEvent;
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::identity::LaserIdentity;
use super::line_pace::LinePace;
use super::pending_request::PendingRequest;
use super::raising_rate::RaisingRate;
use super::who_answers::not_a_laser;
use crate::command::info::{InfoReply, ReadInfo};
use crate::command::parameters::{ParameterReply, ReadParameters};
use crate::command::quit::Quit;
use crate::command::request::ScipRequest;
use crate::command::reset::ResetLaser;
use crate::command::switch_protocol::SwitchProtocol;
use crate::command::time_adjust::LeaveTimeAdjust;
use crate::command::version::{ReadVersion, VersionReply};
use crate::constants::BITS_PER_BYTE;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::{ScipCommand, StatusMeaning};
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ConnectStep {
    Quit,
    Switch,
    LeaveTimeAdjust,
    LeaveUpdate,
    Reset,
    Version,
    Parameters,
    Info,
}

#[derive(Debug)]
pub(super) struct Connecting {
    step: ConnectStep,
    pending: PendingRequest,
    give_up_at: Duration,
    mode_changes_left: u8,
    /// `SCIP2.0` was sent: silence or a bad `VV` is no reason to send it again.
    switched: bool,
    /// A reply to one of the requests came, good or bad.
    answered: bool,
    /// A version with so many wrong sums, for want of a better one.
    damaged_version: Option<(VersionReply, usize)>,
    version: Option<VersionReply>,
    parameters: Option<ParameterReply>,
    pace: LinePace,
}

impl Connecting {
    pub(super) fn start(now: Duration, context: &mut DriverContext) -> Self {
        context.identity = None;
        let pending = PendingRequest::send(&Quit, now, context);
        Self {
            step: ConnectStep::Quit,
            pending: match context.options.probe {
                Some(limits) => pending.limited(limits),
                None => pending,
            },
            give_up_at: now.saturating_add(context.options.connect_timeout),
            mode_changes_left: context.options.max_mode_changes,
            switched: false,
            answered: false,
            damaged_version: None,
            version: None,
            parameters: None,
            pace: LinePace::default(),
        }
    }

    fn enter(
        &mut self,
        step: ConnectStep,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        self.step = step;
        let pending = match step {
            ConnectStep::Quit => PendingRequest::send(&Quit, now, context),
            ConnectStep::Switch => PendingRequest::send(&SwitchProtocol, now, context),
            ConnectStep::LeaveTimeAdjust => PendingRequest::send(&LeaveTimeAdjust, now, context),
            ConnectStep::LeaveUpdate | ConnectStep::Reset => {
                PendingRequest::send(&ResetLaser, now, context)
            }
            ConnectStep::Version => PendingRequest::send(&ReadVersion, now, context),
            ConnectStep::Parameters => PendingRequest::send(&ReadParameters, now, context),
            ConnectStep::Info => PendingRequest::send(&ReadInfo, now, context),
        };
        self.pending = match context.options.probe {
            Some(limits) if !self.answered => pending.limited(limits),
            _ => pending,
        };
        DialogueOutcome::Continue
    }

    /// The device is in another mode than expected: leave it and start over, a limited number of times.
    fn change_mode(
        &mut self,
        to: ConnectStep,
        seen: StatusMeaning,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        if self.mode_changes_left == 0 {
            return DialogueOutcome::Fault(ScipError::WrongMode { last: seen });
        }
        self.mode_changes_left -= 1;
        self.switched |= to == ConnectStep::Switch;
        self.enter(to, now, context)
    }

    fn on_error(
        &mut self,
        error: ReplyError,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match error.refusal() {
            Some(seen @ StatusMeaning::OldProtocol) if self.step != ConnectStep::Switch => {
                self.change_mode(ConnectStep::Switch, seen, now, context)
            }
            Some(seen @ (StatusMeaning::Undefined | StatusMeaning::Denied))
                if self.step != ConnectStep::LeaveTimeAdjust =>
            {
                self.change_mode(ConnectStep::LeaveTimeAdjust, seen, now, context)
            }
            Some(seen @ StatusMeaning::FirmwareUpdate) => {
                self.change_mode(ConnectStep::LeaveUpdate, seen, now, context)
            }
            _ => match self.pending.retry_after(error, now, context) {
                Ok(()) => DialogueOutcome::Continue,
                Err(failure) => self.on_failure(failure, now, context),
            },
        }
    }

    /// All attempts of a step failed.
    fn on_failure(
        &mut self,
        failure: ScipError,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match (self.step, self.damaged_version.take()) {
            // Whether TM2 helped shows in the reply to the QT after it.
            (ConnectStep::LeaveTimeAdjust, _) => self.enter(ConnectStep::Quit, now, context),
            (ConnectStep::Quit | ConnectStep::Version, damaged) if !self.switched => {
                self.damaged_version = damaged;
                self.switched = true;
                self.enter(ConnectStep::Switch, now, context)
            }
            (ConnectStep::Version, Some((version, lines))) => {
                context.emit(LaserEvent::WrongSumsTolerated { lines });
                self.version = Some(version);
                self.enter(ConnectStep::Parameters, now, context)
            }
            _ => DialogueOutcome::Fault(self.judged(failure, context)),
        }
    }

    /// A failure, said as what it shows about the device.
    fn judged(&self, failure: ScipError, context: &DriverContext) -> ScipError {
        if !self.answered && context.heard.total() > 0 {
            return not_a_laser(&context.heard);
        }
        match &failure {
            ScipError::BadReply {
                command: ScipCommand::SwitchProtocol,
                last,
                ..
            } if last.refusal() == Some(StatusMeaning::OldProtocol) => ScipError::Scip11Only {
                heard: context.heard.end().into(),
            },
            _ => failure,
        }
    }

    fn on_info(
        &mut self,
        info: InfoReply,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let (Some(version), Some(parameters)) = (self.version.take(), self.parameters.take())
        else {
            return DialogueOutcome::Fault(self.pending.failure());
        };
        let options = &mut context.options;
        options.link_bytes_per_second = options
            .link_bytes_per_second
            .or_else(|| self.pace.confirmed_bytes_s(info.bit_rate.as_deref()));
        let identity = LaserIdentity {
            line_bytes_s: options.link_bytes_per_second,
            model: parameters.model,
            vendor: version.vendor,
            product: version.product,
            firmware: version.firmware,
            protocol: version.protocol,
            serial: version.serial,
            parameters: parameters.parameters,
            status: info.status,
        };
        let bit_s = options
            .link_bytes_per_second
            .map(|bytes_s| bytes_s * BITS_PER_BYTE);
        match (bit_s, options.wanted_bit_rate) {
            (Some(bit_s), Some(wanted)) if bit_s < wanted => {
                let raising = RaisingRate::start(identity, bit_s, wanted, now, context);
                DialogueOutcome::Then(Box::new(raising))
            }
            _ => context.connected(identity),
        }
    }

    fn handle_reply(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> Result<DialogueOutcome, ReplyError> {
        Ok(match self.step {
            ConnectStep::Quit => {
                Quit.parse(message)?;
                let next = if context.options.reset_on_connect {
                    ConnectStep::Reset
                } else {
                    ConnectStep::Version
                };
                self.enter(next, now, context)
            }
            ConnectStep::Switch => {
                SwitchProtocol.parse(message)?;
                self.enter(ConnectStep::Quit, now, context)
            }
            ConnectStep::LeaveTimeAdjust => {
                LeaveTimeAdjust.parse(message)?;
                self.enter(ConnectStep::Quit, now, context)
            }
            ConnectStep::LeaveUpdate => {
                ResetLaser.parse(message)?;
                self.enter(ConnectStep::Quit, now, context)
            }
            ConnectStep::Reset => {
                ResetLaser.parse(message)?;
                self.enter(ConnectStep::Version, now, context)
            }
            ConnectStep::Version => {
                if let Ok(damaged) = ReadVersion.parse_leniently(message) {
                    self.damaged_version = Some(damaged);
                }
                self.version = Some(ReadVersion.parse(message)?);
                self.enter(ConnectStep::Parameters, now, context)
            }
            ConnectStep::Parameters => {
                self.parameters = Some(ReadParameters.parse(message)?);
                self.enter(ConnectStep::Info, now, context)
            }
            ConnectStep::Info => {
                let info = ReadInfo.parse(message)?;
                if info.is_trouble() {
                    return Ok(DialogueOutcome::Fault(ScipError::Trouble {
                        status: info.status,
                    }));
                }
                self.on_info(info, now, context)
            }
        })
    }
}

impl Dialogue for Connecting {
    fn state(&self) -> &'static str {
        "connecting"
    }

    fn deadline(&self) -> Duration {
        self.pending.deadline.min(self.give_up_at)
    }

    fn on_message(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        if matches!(
            self.step,
            ConnectStep::Version | ConnectStep::Parameters | ConnectStep::Info
        ) {
            self.pace.note(message);
        }
        let outcome = self.handle_reply(message, now, context);
        // Anything else is a scan of a stream that was left on, or a late reply.
        self.answered |= !matches!(outcome, Err(ReplyError::Echo { .. }));
        match outcome {
            Ok(outcome) => outcome,
            Err(ReplyError::Echo { .. }) => DialogueOutcome::Continue,
            Err(error) => self.on_error(error, now, context),
        }
    }

    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        if now >= self.give_up_at {
            let (limit, command) = (context.options.connect_timeout, self.pending.command());
            let timeout = ScipError::ConnectTimeout { limit, command };
            return DialogueOutcome::Fault(self.judged(timeout, context));
        }
        if context.options.gives_up_on_garbage && !self.answered && context.heard.is_garbage() {
            return DialogueOutcome::Fault(not_a_laser(&context.heard));
        }
        match self.pending.resend(now, context) {
            Ok(()) => DialogueOutcome::Continue,
            Err(failure) => self.on_failure(failure, now, context),
        }
    }
}
