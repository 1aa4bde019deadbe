//! Streaming: every scan is checked, a silent device is restarted (scip2 sections 6, 13 and 14).
//!
//! ```text
//! MD --00--> flowing --silence--> QT, MD --silence--> RS, MD --silence--> fault
//! ```
//!
//! Only a run of good scans makes `QT` the next step again, so that a device that keeps stopping ends in a fault. On
//! RS-232C at another rate than the default, `RS` changes the rate too: the device falls silent, the dialogue ends in a
//! fault, and the port is reopened at the default rate.

use std::time::Duration;

use super::action::{LaserEvent, Rejection};
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::pending_request::PendingRequest;
use super::recovery::{RecoveryCause, RecoveryStep};
use super::stamp_continuity::{StampAdvance, StampContinuity};
use crate::command::quit::Quit;
use crate::command::request::ScipRequest;
use crate::command::reset::ResetLaser;
use crate::command::stream::{StreamReply, StreamRequest};
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::scan::LaserScan;
use crate::status::StatusMeaning;

#[derive(Debug)]
enum StreamStage {
    /// The request waits for its acknowledgement.
    Requested(PendingRequest),
    /// Scans come; the next data are due by this instant.
    Running(Duration),
    /// `QT` or `RS` waits for its reply.
    Restarting(RecoveryStep, PendingRequest),
}

#[derive(Debug)]
pub(super) struct Streaming {
    request: StreamRequest,
    /// Of a counted stream; 0 for an endless one.
    scans_left: u8,
    data_timeout: Duration,
    stage: StreamStage,
    continuity: StampContinuity,
    damaged_in_a_row: u8,
    /// The last attempt; forgotten after a run of good scans.
    last_restart: Option<RecoveryStep>,
    good_since_restart: u32,
    announced: bool,
    /// Each acknowledgement from now on ends a recovery.
    restarted: bool,
    timer_reset: bool,
}

impl Streaming {
    /// `period` is the time between two scans of the plan.
    pub(super) fn start(
        request: StreamRequest,
        period: Duration,
        now: Duration,
        context: &mut DriverContext,
    ) -> Self {
        let bytes = request.span.reply_bytes(request.line().len());
        let on_the_wire = context
            .options
            .link_bytes_per_second
            .map_or(Duration::ZERO, |rate| {
                Duration::try_from_secs_f64(bytes as f64 / f64::from(rate.max(1)))
                    .unwrap_or_default()
            });
        Self {
            request,
            scans_left: request.count,
            data_timeout: period
                .max(on_the_wire)
                .saturating_mul(context.options.silent_periods.max(1))
                .max(context.options.min_silence),
            stage: StreamStage::Requested(PendingRequest::send(&request, now, context)),
            continuity: StampContinuity::new(period, &context.options),
            damaged_in_a_row: 0,
            last_restart: None,
            good_since_restart: 0,
            announced: false,
            restarted: false,
            timer_reset: false,
        }
    }

    /// Due time of the first data after a (re)start.
    fn first_data_by(&self, now: Duration, context: &DriverContext) -> Duration {
        now.saturating_add(context.options.reply_timeout)
            .saturating_add(self.data_timeout)
    }

    fn run(&mut self, now: Duration, context: &mut DriverContext) {
        if !std::mem::replace(&mut self.announced, true) {
            context.emit(LaserEvent::Streaming);
        }
        if self.restarted {
            context.emit(LaserEvent::Recovered {
                timer_reset: std::mem::take(&mut self.timer_reset),
            });
        }
        self.good_since_restart = 0;
        self.damaged_in_a_row = 0;
        self.stage = StreamStage::Running(self.first_data_by(now, context));
    }

    /// The next attempt: `QT`, then `RS`, then a fault.
    fn recover(
        &mut self,
        cause: RecoveryCause,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let step = match self.last_restart {
            None => RecoveryStep::Quit,
            Some(RecoveryStep::Quit) => RecoveryStep::Reset,
            Some(RecoveryStep::Reset) => {
                return Self::fault(ScipError::StreamLost { cause }, context);
            }
        };
        self.last_restart = Some(step);
        self.restarted = true;
        context.emit(LaserEvent::Recovering { cause, step });
        let pending = match step {
            RecoveryStep::Quit => PendingRequest::send(&Quit, now, context),
            RecoveryStep::Reset => PendingRequest::send(&ResetLaser, now, context),
        };
        self.stage = StreamStage::Restarting(step, pending);
        DialogueOutcome::Continue
    }

    /// Turns the laser off, if the device still listens, since nobody will read its scans.
    fn fault(error: ScipError, context: &mut DriverContext) -> DialogueOutcome {
        context.send(Quit.to_bytes());
        DialogueOutcome::Fault(error)
    }

    fn on_stream(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let mut next_data_by = now.saturating_add(self.data_timeout);
        let outcome = match self.request.parse(message) {
            Err(ReplyError::Echo { .. }) => {
                context.reject(Rejection::Unsolicited {
                    echo: message.echo().into(),
                });
                return DialogueOutcome::Continue;
            }
            Err(error) => self.on_damage(error, now, context),
            Ok(StreamReply::Acknowledged) => DialogueOutcome::Continue,
            Ok(StreamReply::Scan(scan)) => self.on_scan(scan, message, context),
            Ok(StreamReply::Verifying(status)) => {
                context.emit(LaserEvent::Verifying { status });
                next_data_by = now.saturating_add(context.options.verify_timeout);
                DialogueOutcome::Continue
            }
            Ok(StreamReply::Resumed) => {
                context.emit(LaserEvent::VerifiedNormal);
                self.continuity.interrupted();
                next_data_by = self.first_data_by(now, context);
                DialogueOutcome::Continue
            }
            Ok(StreamReply::Trouble(status)) => {
                Self::fault(ScipError::Hardware { status }, context)
            }
        };
        if let StreamStage::Running(data_by) = &mut self.stage {
            *data_by = next_data_by;
        }
        outcome
    }

    fn on_damage(
        &mut self,
        error: ReplyError,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let fell_back = error.refusal() == Some(StatusMeaning::OldProtocol);
        context.reject(Rejection::Reply(error));
        self.damaged_in_a_row = self.damaged_in_a_row.saturating_add(1);
        if fell_back {
            DialogueOutcome::Fault(ScipError::FellBackToScip11)
        } else if self.damaged_in_a_row >= context.options.max_damaged_in_a_row {
            self.recover(RecoveryCause::Damage, now, context)
        } else {
            DialogueOutcome::Continue
        }
    }

    fn on_scan(
        &mut self,
        scan: LaserScan,
        message: &ScipMessage,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let stamp_ms = scan.stamp_ms;
        match self.continuity.advance(stamp_ms) {
            StampAdvance::Next => {}
            StampAdvance::Gap(lost) => context.emit(LaserEvent::LostScans(lost)),
            StampAdvance::Repeated(repeats) => {
                context.reject(Rejection::RepeatedStamp { stamp_ms });
                return if repeats >= context.options.stale_repeats {
                    Self::fault(ScipError::StaleStamp { stamp_ms, repeats }, context)
                } else {
                    DialogueOutcome::Continue
                };
            }
            StampAdvance::Jump {
                advance_ms,
                in_a_row: jumps,
            } => {
                let expected_ms = self.continuity.period_ms();
                context.reject(Rejection::StampJump {
                    advance_ms,
                    expected_ms,
                });
                return if jumps >= context.options.max_jumps_in_a_row {
                    Self::fault(
                        ScipError::ErraticStamps {
                            jumps,
                            advance_ms,
                            expected_ms,
                        },
                        context,
                    )
                } else {
                    DialogueOutcome::Continue
                };
            }
        }
        let last = self.request.count > 0 && scan.remaining == 0;
        // A restart asks for these.
        self.scans_left = scan.remaining;
        self.damaged_in_a_row = 0;
        self.good_since_restart = self.good_since_restart.saturating_add(1);
        if self.good_since_restart >= context.options.good_scans_to_recover {
            self.last_restart = None;
        }
        let ScipMessage {
            first_byte_at,
            last_byte_at,
            ..
        } = *message;
        context.emit(LaserEvent::Scan {
            scan,
            first_byte_at,
            last_byte_at,
        });
        if last {
            context.emit(LaserEvent::Stopped);
            return DialogueOutcome::Idle;
        }
        DialogueOutcome::Continue
    }

    fn on_requested(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match self.request.parse(message) {
            Ok(StreamReply::Acknowledged) => {
                self.run(now, context);
                DialogueOutcome::Continue
            }
            // Only the acknowledgement was lost.
            Ok(_) => {
                self.run(now, context);
                self.on_stream(message, now, context)
            }
            Err(ReplyError::Echo { .. }) => DialogueOutcome::Continue,
            Err(error) => {
                context.reject(Rejection::Reply(error.clone()));
                match error.refusal() {
                    Some(StatusMeaning::OldProtocol) => {
                        DialogueOutcome::Fault(ScipError::FellBackToScip11)
                    }
                    // The plan itself is refused: a restart would not help.
                    Some(StatusMeaning::BadParameter(_)) => {
                        if let StreamStage::Requested(pending) = &mut self.stage {
                            pending.note_error(error);
                            context.emit(LaserEvent::RequestFailed(pending.failure()));
                        }
                        DialogueOutcome::Idle
                    }
                    _ => self.recover(RecoveryCause::NotAcknowledged, now, context),
                }
            }
        }
    }

    fn on_restarting(
        &mut self,
        step: RecoveryStep,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        let reply = match step {
            RecoveryStep::Quit => Quit.parse(message),
            RecoveryStep::Reset => ResetLaser.parse(message),
        };
        match reply {
            Ok(()) => {
                match step {
                    RecoveryStep::Quit => self.continuity.interrupted(),
                    RecoveryStep::Reset => {
                        self.continuity.reset();
                        self.timer_reset = true;
                    }
                }
                self.request.count = self.scans_left;
                let request = self.request;
                self.stage = StreamStage::Requested(PendingRequest::send(&request, now, context));
                DialogueOutcome::Continue
            }
            // A scan still on its way.
            Err(ReplyError::Echo { .. }) => DialogueOutcome::Continue,
            Err(error) => {
                context.reject(Rejection::Reply(error.clone()));
                if error.refusal() == Some(StatusMeaning::OldProtocol) {
                    return DialogueOutcome::Fault(ScipError::FellBackToScip11);
                }
                let again = match &mut self.stage {
                    StreamStage::Restarting(_, pending) => pending.retry_after(error, now, context),
                    _ => Ok(()),
                };
                self.on_restart_attempt(again, now, context)
            }
        }
    }

    fn on_restart_attempt(
        &mut self,
        again: Result<(), ScipError>,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match again {
            Ok(()) => DialogueOutcome::Continue,
            Err(_) => self.recover(RecoveryCause::Silence, now, context),
        }
    }
}

impl Dialogue for Streaming {
    fn state(&self) -> &'static str {
        "streaming"
    }

    fn deadline(&self) -> Duration {
        match &self.stage {
            StreamStage::Requested(pending) | StreamStage::Restarting(_, pending) => {
                pending.deadline
            }
            StreamStage::Running(data_by) => *data_by,
        }
    }

    fn on_message(
        &mut self,
        message: &ScipMessage,
        now: Duration,
        context: &mut DriverContext,
    ) -> DialogueOutcome {
        match self.stage {
            StreamStage::Requested(_) => self.on_requested(message, now, context),
            StreamStage::Running(_) => self.on_stream(message, now, context),
            StreamStage::Restarting(step, _) => self.on_restarting(step, message, now, context),
        }
    }

    fn on_deadline(&mut self, now: Duration, context: &mut DriverContext) -> DialogueOutcome {
        match &mut self.stage {
            // A second MD would be refused if only the acknowledgement was lost: QT first.
            StreamStage::Requested(_) => self.recover(RecoveryCause::NotAcknowledged, now, context),
            StreamStage::Running(_) => self.recover(RecoveryCause::Silence, now, context),
            StreamStage::Restarting(_, pending) => {
                let again = pending.resend(now, context);
                self.on_restart_attempt(again, now, context)
            }
        }
    }
}
