//! Replies to requests (scip2 section 6); those that measure are in `measuring`, those that change settings in `settings`.

use super::constants::{REBOOT_AFTER, REBOOT_TWICE_WITHIN, REPLY_SPREAD, TM_REPLY, TM_SPREAD};
use super::emulated_laser::EmulatedLaser;
use super::fault::LaserFault;
use super::identity::{self, DeviceCondition};
use super::range_source::RangeSource;
use super::request::{EmulatedCommand, RequestLine};
use super::state::{LaserState, ProtocolVersion};
use super::status::ReplyStatus;
use super::wire;
use std::time::Duration;

/// The outcome of a command.
pub(super) enum CommandReply {
    /// A status alone.
    Status(ReplyStatus),
    /// Status 00 and these lines.
    Lines(Vec<u8>),
    /// Status 00 and the lines of a scan.
    Scan(Vec<u8>),
}

impl EmulatedLaser {
    pub(super) fn answer(
        &mut self,
        request: &RequestLine,
        duplicate: bool,
        t: Duration,
        source: &mut dyn RangeSource,
    ) {
        let delay = if request.is_time() {
            TM_REPLY + self.rng.duration_below(TM_SPREAD)
        } else {
            self.rng.duration_below(REPLY_SPREAD)
        };
        if self.state.protocol == ProtocolVersion::Scip1 {
            let reply = self.scip1_reply(request);
            return self.emit(reply, t, t + delay, false);
        }
        if request.is_unsupported_measurement(self.options.profile.generation)
            && self.faults.happens(LaserFault::Deafened, t)
        {
            self.state.deaf = true;
        }
        if self.state.deaf {
            return self.out.count_lost();
        }
        let baud = self.out.baud();
        let answer = match self.execute(request, duplicate, t, source) {
            Ok(answer) => answer,
            Err(status) => CommandReply::Status(status),
        };
        let mut reply = request.line().to_vec();
        reply.push(b'\n');
        let is_scan = matches!(answer, CommandReply::Scan(_));
        match answer {
            CommandReply::Status(status) => wire::push_summed(&mut reply, &status.0),
            CommandReply::Lines(lines) | CommandReply::Scan(lines) => {
                wire::push_summed(&mut reply, &ReplyStatus::DONE.0);
                reply.extend_from_slice(&lines);
            }
        }
        reply.push(b'\n');
        // A change of bit rate follows the reply that confirms it.
        let new_baud = self.out.baud();
        self.out.set_baud(baud);
        self.emit(reply, t, t + delay, is_scan);
        self.out.set_baud(new_baud);
    }

    /// In SCIP 1.1: `V`, the switch to SCIP 2.0, and `E` for everything else (scip2 section 9).
    fn scip1_reply(&mut self, request: &RequestLine) -> Vec<u8> {
        let mut reply = request.line().to_vec();
        match (request.line(), &self.options.profile.scip1) {
            (b"V", Some(lines)) => {
                reply.extend_from_slice(b"\n0\n");
                identity::push_scip1_version(&mut reply, &self.options.profile, lines);
                reply.push(b'\n');
            }
            (b"SCIP2.0", _) => {
                self.state.protocol = ProtocolVersion::Scip2;
                self.state.stop();
                reply.extend_from_slice(b"\n0\n\n");
            }
            _ => reply.extend_from_slice(b"\nE\n\n"),
        }
        reply
    }

    fn execute(
        &mut self,
        request: &RequestLine,
        duplicate: bool,
        t: Duration,
        source: &mut dyn RangeSource,
    ) -> Result<CommandReply, ReplyStatus> {
        let generation = self.options.profile.generation;
        let ethernet = generation.is_ethernet();
        if self.state.time_adjust && !request.is_time() && !ethernet {
            return Err(ReplyStatus::UNDEFINED);
        }
        if self.state.firmware_update && !matches!(request.body(), b"VV" | b"II" | b"RS") {
            return Err(if request.line() == b"SCIP2.0" {
                ReplyStatus::UNDEFINED
            } else {
                ReplyStatus::FIRMWARE_UPDATE
            });
        }
        let command = request.command(generation)?;
        let allowed = request.is_time() || command.is_query() || command == EmulatedCommand::Reset;
        if self.state.time_adjust && !allowed {
            return Err(ReplyStatus::DENIED);
        }
        if duplicate {
            return Err(ReplyStatus::BUFFER_SHORTAGE);
        }
        let parameters = request.parameters();
        let mut lines = Vec::new();
        let status = match command {
            EmulatedCommand::Version => {
                identity::push_version(&mut lines, &self.options.profile);
                self.faults.corrupt_version(&mut lines, t);
                return Ok(CommandReply::Lines(lines));
            }
            EmulatedCommand::Parameters => {
                identity::push_parameters(&mut lines, &self.options.profile);
                return Ok(CommandReply::Lines(lines));
            }
            EmulatedCommand::Info => {
                let condition = self.condition(t);
                identity::push_info(&mut lines, &self.options.profile, &condition);
                return Ok(CommandReply::Lines(lines));
            }
            EmulatedCommand::Time => return self.time(parameters, t),
            EmulatedCommand::Latest => return self.latest(request, t, source),
            EmulatedCommand::State => {
                wire::push_summed(&mut lines, self.state_digits(t));
                return Ok(CommandReply::Lines(lines));
            }
            EmulatedCommand::LaserOn => self.laser_on_command(t),
            EmulatedCommand::Quit => {
                self.state.stop();
                self.state.asleep = false;
                ReplyStatus::DONE
            }
            EmulatedCommand::Sleep => {
                self.state.stop();
                self.state.asleep = true;
                ReplyStatus::DONE
            }
            EmulatedCommand::Reset => self.reset(t),
            EmulatedCommand::SoftReset => self.soft_reset(t),
            EmulatedCommand::Reboot => self.reboot(t),
            EmulatedCommand::BitRate => self.bit_rate(parameters),
            EmulatedCommand::MotorSpeed => self.motor_speed(parameters, t),
            EmulatedCommand::Sensitivity => self.sensitivity(parameters)?,
            EmulatedCommand::SimulateFailure => self.simulate_failure(parameters, t)?,
            EmulatedCommand::Stream => self.start_stream(request, t)?,
        };
        Ok(CommandReply::Status(status))
    }

    fn condition(&mut self, t: Duration) -> DeviceCondition {
        DeviceCondition {
            laser_on: self.state.laser_on,
            speed_level: self.state.speed_level,
            sensitive: self.state.sensitive,
            baud: self.out.baud(),
            timer: self.timer.at(t),
            firmware_update: self.state.firmware_update,
            trouble: self.faults.happens(LaserFault::TroubleStat, t)
                || self.state.malfunction_at(t).is_some(),
        }
    }

    fn time(&mut self, parameters: &[u8], t: Duration) -> Result<CommandReply, ReplyStatus> {
        let answers_always = self.options.profile.generation.is_ethernet();
        let status = match (parameters, self.state.time_adjust) {
            (b"0", false) if answers_always && self.state.stream.is_some() => ReplyStatus::DENIED,
            (b"0", false) => {
                self.state.stop();
                self.state.time_adjust = true;
                ReplyStatus::DONE
            }
            (b"0", true) => ReplyStatus::number(2),
            (b"1", adjusting) if adjusting || answers_always => {
                let (mut time, mut lines) = (Vec::new(), Vec::new());
                wire::push_number(&mut time, self.timer.at(t), 4);
                wire::push_summed(&mut lines, &time);
                return Ok(CommandReply::Lines(lines));
            }
            (b"1", _) => ReplyStatus::number(4),
            (b"2", true) => {
                self.state.time_adjust = false;
                ReplyStatus::DONE
            }
            (b"2", false) => ReplyStatus::number(3),
            _ => ReplyStatus::number(1),
        };
        Ok(CommandReply::Status(status))
    }

    fn laser_on_command(&mut self, t: Duration) -> ReplyStatus {
        if self.state.asleep {
            return ReplyStatus::DENIED;
        }
        if self.state.malfunction_at(t).is_some() {
            return ReplyStatus::number(1);
        }
        if self.state.laser_on || self.state.stream.is_some() {
            return ReplyStatus::number(2);
        }
        self.state.laser_on = true;
        ReplyStatus::DONE
    }

    /// Laser off; motor, sensitivity and bit rate to default; timer to zero; the firmware update mode ends (scip2 section
    /// 5). A malfunction stays: only a power cycle ends it.
    fn reset(&mut self, t: Duration) -> ReplyStatus {
        if self.state.speed_level != 0 {
            self.motor.set_speed(self.options.profile.speed_rpm, t);
        }
        self.restart(t);
        ReplyStatus::DONE
    }

    fn restart(&mut self, t: Duration) {
        self.state = LaserState {
            protocol: ProtocolVersion::Scip2,
            malfunction: self.state.malfunction,
            simulation: self.state.simulation,
            ..LaserState::powered_up(&self.options)
        };
        self.timer.reset(t);
        self.out.reset_baud();
    }

    /// `RT`: as `RS`, but motor and bit rate stay (scip2 section 6).
    fn soft_reset(&mut self, t: Duration) -> ReplyStatus {
        let (level, baud) = (self.state.speed_level, self.out.baud());
        self.restart(t);
        self.state.speed_level = level;
        self.out.set_baud(baud);
        ReplyStatus::DONE
    }

    /// `RB`: the first gets 01, another within one second restarts the sensor (scip2 section 10).
    fn reboot(&mut self, t: Duration) -> ReplyStatus {
        let twice = self
            .state
            .first_reboot_request_at
            .replace(t)
            .is_some_and(|first| t.saturating_sub(first) <= REBOOT_TWICE_WITHIN);
        if !twice {
            return ReplyStatus::number(1);
        }
        self.state.reboot_at = Some(t.saturating_add(REBOOT_AFTER));
        ReplyStatus::DONE
    }

    /// `%ST`: the state as three digits (scip2 section 10).
    fn state_digits(&self, t: Duration) -> &'static [u8; 3] {
        let state = &self.state;
        if state.malfunction_at(t).is_some() {
            b"900"
        } else if state.reboot_at.is_some() {
            b"001"
        } else if state.time_adjust {
            b"002"
        } else if state.asleep {
            b"005"
        } else if state.stream.is_some() {
            b"004"
        } else if state.laser_on {
            b"003"
        } else {
            b"000"
        }
    }
}
