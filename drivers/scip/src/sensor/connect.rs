//! Connecting: from whatever state the device was left in to a known one. Protocol sections 13 and 14.
//!
//! ```text
//! QT --00--> RS --> VV --> PP --> II --> connected
//!  | E            SCIP 1.1: SCIP2.0 (answers 0 or 0E), then QT again
//!  | 0E, 10       time adjust (10 in SCIP 2.2): TM2, then QT again
//!  | 0I           firmware update mode: RS, then QT again
//!  | silence      SCIP2.0 once (old units fall silent), then give up
//! ```
//!
//! A device that was left streaming keeps sending scans before its echo of `QT`; they are skipped. Nothing here waits
//! for silence: a stream has none.

use super::action::{Event, Identity, Rejection};
use super::dialogue::{Desk, Dialogue, Outcome};
use super::exchange::Exchange;
use crate::Instant;
use crate::command::Request;
use crate::command::info::ReadInfo;
use crate::command::laser::Quit;
use crate::command::parameters::{ParameterReply, ReadParameters};
use crate::command::reset::Reset;
use crate::command::switch_protocol::SwitchProtocol;
use crate::command::time_adjust::LeaveTimeAdjust;
use crate::command::version::{ReadVersion, Version};
use crate::error::{ReplyError, SensorError};
use crate::frame::Message;
use crate::status::Meaning;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Quit,
    Switch,
    LeaveTimeAdjust,
    LeaveUpdate,
    Reset,
    Version,
    Parameters,
    Info,
}

/// Connecting, under way.
#[derive(Debug)]
pub(super) struct Connecting {
    step: Step,
    exchange: Exchange,
    give_up_at: Instant,
    mode_changes_left: u8,
    /// `SCIP2.0` has been sent, so that silence or a bad `VV` is no longer a reason to try it.
    switched: bool,
    /// A version whose sums were wrong, to be taken if no better one comes.
    doubtful_version: Option<(Version, usize)>,
    version: Option<Version>,
    parameters: Option<ParameterReply>,
}

impl Connecting {
    pub(super) fn begin(now: Instant, desk: &mut Desk) -> Self {
        desk.identity = None;
        Self {
            step: Step::Quit,
            exchange: Exchange::begin(&Quit, now, desk),
            give_up_at: now.saturating_add(desk.options.connect_timeout),
            mode_changes_left: desk.options.mode_changes,
            switched: false,
            doubtful_version: None,
            version: None,
            parameters: None,
        }
    }

    fn go(&mut self, step: Step, now: Instant, desk: &mut Desk) -> Outcome {
        self.step = step;
        self.exchange = match step {
            Step::Quit => Exchange::begin(&Quit, now, desk),
            Step::Switch => Exchange::begin(&SwitchProtocol, now, desk),
            Step::LeaveTimeAdjust => Exchange::begin(&LeaveTimeAdjust, now, desk),
            Step::LeaveUpdate | Step::Reset => Exchange::begin(&Reset, now, desk),
            Step::Version => Exchange::begin(&ReadVersion, now, desk),
            Step::Parameters => Exchange::begin(&ReadParameters, now, desk),
            Step::Info => Exchange::begin(&ReadInfo, now, desk),
        };
        Outcome::Continue
    }

    /// The device is in another mode than thought: change it and begin again, but not for ever.
    fn change_mode(&mut self, to: Step, seen: Meaning, now: Instant, desk: &mut Desk) -> Outcome {
        if self.mode_changes_left == 0 {
            return Outcome::Fault(SensorError::WrongMode { last: seen });
        }
        self.mode_changes_left -= 1;
        self.switched |= to == Step::Switch;
        self.go(to, now, desk)
    }

    fn on_error(&mut self, error: ReplyError, now: Instant, desk: &mut Desk) -> Outcome {
        match error.refusal() {
            Some(seen @ Meaning::OldProtocol) if self.step != Step::Switch => {
                self.change_mode(Step::Switch, seen, now, desk)
            }
            Some(seen @ (Meaning::Undefined | Meaning::Denied))
                if self.step != Step::LeaveTimeAdjust =>
            {
                self.change_mode(Step::LeaveTimeAdjust, seen, now, desk)
            }
            Some(seen @ Meaning::FirmwareUpdate) => {
                self.change_mode(Step::LeaveUpdate, seen, now, desk)
            }
            _ => match self.exchange.unusable(error, now, desk) {
                Ok(()) => Outcome::Continue,
                Err(failure) => self.on_failure(failure, now, desk),
            },
        }
    }

    /// A step was tried as often as allowed.
    fn on_failure(&mut self, failure: SensorError, now: Instant, desk: &mut Desk) -> Outcome {
        match (self.step, self.doubtful_version.take()) {
            // TM2 is a means only: the QT after it tells whether it helped.
            (Step::LeaveTimeAdjust, _) => self.go(Step::Quit, now, desk),
            (Step::Quit | Step::Version, doubtful) if !self.switched => {
                self.doubtful_version = doubtful;
                self.switched = true;
                self.go(Step::Switch, now, desk)
            }
            (Step::Version, Some((version, lines))) => {
                desk.reject(Rejection::ToleratedSums { lines });
                self.version = Some(version);
                self.go(Step::Parameters, now, desk)
            }
            _ => Outcome::Fault(failure),
        }
    }

    fn on_info(&mut self, status: String, desk: &mut Desk) -> Outcome {
        let (Some(version), Some(parameters)) = (self.version.take(), self.parameters.take())
        else {
            return Outcome::Fault(self.exchange.failure());
        };
        let identity = Identity {
            model: parameters.model,
            vendor: version.vendor,
            product: version.product,
            firmware: version.firmware,
            protocol: version.protocol,
            serial: version.serial,
            parameters: parameters.parameters,
            status,
        };
        desk.identity = Some(identity.clone());
        desk.tell(Event::Connected(identity));
        Outcome::Idle
    }

    fn take(
        &mut self,
        message: &Message,
        now: Instant,
        desk: &mut Desk,
    ) -> Result<Outcome, ReplyError> {
        Ok(match self.step {
            Step::Quit => {
                Quit.parse(message)?;
                let next = if desk.options.reset_on_connect {
                    Step::Reset
                } else {
                    Step::Version
                };
                self.go(next, now, desk)
            }
            Step::Switch => {
                SwitchProtocol.parse(message)?;
                self.go(Step::Quit, now, desk)
            }
            Step::LeaveTimeAdjust => {
                LeaveTimeAdjust.parse(message)?;
                self.go(Step::Quit, now, desk)
            }
            Step::LeaveUpdate => {
                Reset.parse(message)?;
                self.go(Step::Quit, now, desk)
            }
            Step::Reset => {
                Reset.parse(message)?;
                self.go(Step::Version, now, desk)
            }
            Step::Version => {
                if let Ok(doubtful) = ReadVersion.parse_leniently(message) {
                    self.doubtful_version = Some(doubtful);
                }
                self.version = Some(ReadVersion.parse(message)?);
                self.go(Step::Parameters, now, desk)
            }
            Step::Parameters => {
                self.parameters = Some(ReadParameters.parse(message)?);
                self.go(Step::Info, now, desk)
            }
            Step::Info => {
                let info = ReadInfo.parse(message)?;
                if info.is_trouble() {
                    return Ok(Outcome::Fault(SensorError::Trouble {
                        status: info.status,
                    }));
                }
                self.on_info(info.status, desk)
            }
        })
    }
}

impl Dialogue for Connecting {
    fn state(&self) -> &'static str {
        "connecting"
    }

    fn deadline(&self) -> Instant {
        self.exchange.deadline.min(self.give_up_at)
    }

    fn on_message(&mut self, message: &Message, now: Instant, desk: &mut Desk) -> Outcome {
        match self.take(message, now, desk) {
            Ok(outcome) => outcome,
            // A scan of a stream that was left on, or a late reply: not what is waited for.
            Err(ReplyError::Echo { .. }) => Outcome::Continue,
            Err(error) => self.on_error(error, now, desk),
        }
    }

    fn on_deadline(&mut self, now: Instant, desk: &mut Desk) -> Outcome {
        if now >= self.give_up_at {
            let (limit, command) = (desk.options.connect_timeout, self.exchange.command());
            return Outcome::Fault(SensorError::ConnectTimeout { limit, command });
        }
        match self.exchange.again(now, desk) {
            Ok(()) => Outcome::Continue,
            Err(failure) => self.on_failure(failure, now, desk),
        }
    }
}
