//! From text to the method that knows.

use super::{Executed, Outcome};
use crate::twin::command::{Command, LimitCommand, Quantity};
use crate::twin::parser::parse;
use crate::twin::replies::{self, Refusal};
use crate::twin::settings::{LimitMode, ResetSelect};
use crate::twin::unit::Twin;

impl Twin {
    /// Executes one request and prints its reply.
    pub(in crate::twin) fn execute(&mut self, text: &[u8]) {
        let command = parse(text);
        if !self.selected && !matches!(command, Ok(Command::Select(_))) {
            return;
        }
        match command.and_then(|command| self.perform(command)) {
            Ok(Outcome::Done) => self.reply(Ok(None)),
            Ok(Outcome::Say(answer)) => self.reply(Ok(Some(answer))),
            Ok(Outcome::Silent) => {}
            Err(refusal) => self.reply(Err(refusal)),
        }
        if let Some(baud) = self.next_baud.take() {
            self.baud = baud;
        }
    }

    fn perform(&mut self, command: Command) -> Executed {
        match command {
            Command::Axis(axis, quantity, value) => match quantity {
                Quantity::Position | Quantity::Offset => self.position(axis, quantity, value),
                Quantity::Minimum
                | Quantity::Maximum
                | Quantity::UserMinimum
                | Quantity::UserMaximum => self.limit(axis, quantity, value),
                Quantity::Resolution => self.resolution(axis, value),
                _ => self.speed(axis, quantity, value),
            },
            Command::Hold(axis, None) => {
                Ok(Outcome::Say(replies::hold(axis, self.settings.axis(axis))))
            }
            Command::Hold(axis, Some(power)) => {
                self.settings.axis_mut(axis).hold = power;
                Ok(Outcome::Done)
            }
            Command::Moving(axis, None) => Ok(Outcome::Say(replies::moving(
                axis,
                self.settings.axis(axis),
            ))),
            Command::Moving(axis, Some(power)) => {
                self.settings.axis_mut(axis).moving = power;
                Ok(Outcome::Done)
            }
            Command::Step(axis, None) => Ok(Outcome::Say(replies::step_mode(
                axis,
                self.settings.axis(axis),
            ))),
            Command::Step(axis, Some(mode)) => {
                self.settings.axis_mut(axis).step_mode = mode;
                Ok(Outcome::Done)
            }
            Command::Switch(switch, state) => self.switch(switch, state),
            Command::Limits(LimitCommand::Query) => {
                Ok(Outcome::Say(replies::limits(self.settings.limits)))
            }
            Command::Limits(LimitCommand::Enable) => self.limit_mode(LimitMode::Factory),
            Command::Limits(LimitCommand::Disable) => self.limit_mode(LimitMode::Off),
            Command::Limits(LimitCommand::User) => self
                .e_series()
                .and_then(|()| self.limit_mode(LimitMode::User)),
            Command::Await => self.wait(),
            Command::Halt { pan, tilt } => self.halt(pan, tilt),
            Command::Monitor(range) => self.monitor(range),
            Command::Reset => {
                self.begin_reset(true, true, false);
                Ok(Outcome::Silent)
            }
            Command::ResetSelect { pan, tilt }
                if self.options.axis_reset_at_once && (pan || tilt) =>
            {
                self.begin_reset(pan, tilt, false);
                Ok(Outcome::Silent)
            }
            Command::ResetSelect { pan, tilt } => {
                self.settings.reset_at_power_up = ResetSelect { pan, tilt };
                Ok(Outcome::Done)
            }
            Command::Defaults(which) => self.defaults(which),
            Command::Version => Ok(Outcome::Say(replies::Answer::same(
                self.options.firmware.clone(),
            ))),
            Command::Supply => Ok(Outcome::Say(replies::supply(&self.supply_now()))),
            Command::HostPort { baud, gap_ms, keep } => self.host_port(baud, gap_ms, keep),
            Command::UnitId(id) => self.unit_id(id),
            Command::Select(id) => self.select_unit(id),
            Command::Preset(what, index) => self.preset(what, index),
            Command::Batch(values) => self.e_series().and_then(|()| self.batch(values)),
            Command::BatchTimed => self.e_series().and_then(|()| self.batch_timed()),
            Command::Menu => {
                replies::MENU.iter().for_each(|line| self.emit_line(line));
                Ok(Outcome::Silent)
            }
            Command::OptionBoard if self.options.option_board => Ok(Outcome::Done),
            Command::OptionBoard => Err(Refusal::IllegalCommand),
        }
    }

    /// Refuses what only the E series knows.
    pub(super) fn e_series(&self) -> Result<(), Refusal> {
        if self.options.e_series {
            Ok(())
        } else {
            Err(Refusal::IllegalCommand)
        }
    }
}
