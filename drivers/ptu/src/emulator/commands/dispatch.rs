//! From the text of a request to the method that executes it.

use super::{RequestOutcome, RequestResult};
use crate::emulator::command::{AxisParameter, HeadRequest, LimitAction};
use crate::emulator::parser::parse;
use crate::emulator::replies::{self, RequestRefusal};
use crate::emulator::settings::{LimitMode, ResetSelection};
use crate::emulator::state::EmulatedHead;

impl EmulatedHead {
    /// Executes one request and prints its reply.
    pub(in crate::emulator) fn execute(&mut self, text: &[u8]) {
        let command = parse(text);
        if !self.selected && !matches!(command, Ok(HeadRequest::Select(_))) {
            return;
        }
        match command.and_then(|command| self.perform(command)) {
            Ok(RequestOutcome::Done) => self.reply(Ok(None)),
            Ok(RequestOutcome::Answer(answer)) => self.reply(Ok(Some(answer))),
            Ok(RequestOutcome::NoReply) => {}
            Err(refusal) => self.reply(Err(refusal)),
        }
        if let Some(baud) = self.next_baud.take() {
            self.baud = baud;
        }
    }

    fn perform(&mut self, command: HeadRequest) -> RequestResult {
        match command {
            HeadRequest::Axis(axis, parameter, value) => match parameter {
                AxisParameter::Position | AxisParameter::RelativePosition => {
                    self.position(axis, parameter, value)
                }
                AxisParameter::Minimum
                | AxisParameter::Maximum
                | AxisParameter::UserMinimum
                | AxisParameter::UserMaximum => self.limit(axis, parameter, value),
                AxisParameter::Resolution => self.resolution(axis, value),
                _ => self.speed(axis, parameter, value),
            },
            HeadRequest::HoldPower(axis, None) => Ok(RequestOutcome::Answer(replies::hold(
                axis,
                self.settings.axis(axis),
            ))),
            HeadRequest::HoldPower(axis, Some(power)) => {
                self.settings.axis_mut(axis).hold = power;
                Ok(RequestOutcome::Done)
            }
            HeadRequest::MovePower(axis, None) => Ok(RequestOutcome::Answer(replies::moving(
                axis,
                self.settings.axis(axis),
            ))),
            HeadRequest::MovePower(axis, Some(power)) => {
                self.settings.axis_mut(axis).moving = power;
                Ok(RequestOutcome::Done)
            }
            HeadRequest::StepMode(axis, None) => Ok(RequestOutcome::Answer(replies::step_mode(
                axis,
                self.settings.axis(axis),
            ))),
            HeadRequest::StepMode(axis, Some(mode)) => {
                self.settings.axis_mut(axis).step_mode = mode;
                Ok(RequestOutcome::Done)
            }
            HeadRequest::Switch(switch, state) => self.switch(switch, state),
            HeadRequest::Limits(LimitAction::Query) => Ok(RequestOutcome::Answer(replies::limits(
                self.settings.limits,
            ))),
            HeadRequest::Limits(LimitAction::Enable) => self.limit_mode(LimitMode::Factory),
            HeadRequest::Limits(LimitAction::Disable) => self.limit_mode(LimitMode::Off),
            HeadRequest::Limits(LimitAction::User) => self
                .e_series()
                .and_then(|()| self.limit_mode(LimitMode::User)),
            HeadRequest::Await => self.await_motion(),
            HeadRequest::Halt { pan, tilt } => self.halt(pan, tilt),
            HeadRequest::Monitor(range) => self.monitor(range),
            HeadRequest::Reset => {
                self.begin_reset(true, true, false);
                Ok(RequestOutcome::NoReply)
            }
            HeadRequest::ResetSelect { pan, tilt }
                if self.options.axis_reset_at_once && (pan || tilt) =>
            {
                self.begin_reset(pan, tilt, false);
                Ok(RequestOutcome::NoReply)
            }
            HeadRequest::ResetSelect { pan, tilt } => {
                self.settings.reset_at_power_up = ResetSelection { pan, tilt };
                Ok(RequestOutcome::Done)
            }
            HeadRequest::Defaults(which) => self.defaults(which),
            HeadRequest::Version => Ok(RequestOutcome::Answer(replies::QueryAnswer::same(
                self.options.firmware.clone(),
            ))),
            HeadRequest::Supply => Ok(RequestOutcome::Answer(replies::supply(&self.supply_now()))),
            HeadRequest::HostPort { baud, gap_ms, keep } => self.host_port(baud, gap_ms, keep),
            HeadRequest::UnitId(id) => self.unit_id(id),
            HeadRequest::Select(id) => self.select_unit(id),
            HeadRequest::Preset(what, index) => self.preset(what, index),
            HeadRequest::Batch(values) => self.e_series().and_then(|()| self.batch(values)),
            HeadRequest::BatchTimed => self.e_series().and_then(|()| self.batch_timed()),
            HeadRequest::Menu => {
                replies::MENU.iter().for_each(|line| self.emit_line(line));
                Ok(RequestOutcome::NoReply)
            }
            HeadRequest::OptionBoard if self.options.option_board => Ok(RequestOutcome::Done),
            HeadRequest::OptionBoard => Err(RequestRefusal::IllegalCommand),
        }
    }

    /// Refuses commands that only the E series has.
    pub(super) fn e_series(&self) -> Result<(), RequestRefusal> {
        if self.options.e_series {
            Ok(())
        } else {
            Err(RequestRefusal::IllegalCommand)
        }
    }
}
