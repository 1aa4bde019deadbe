//! The answers to requests (protocol section 6). What measures stands in `measuring`, what sets in `settings`.

use super::constants::{REBOOT_AFTER, REBOOT_TWICE_WITHIN, REPLY_SPREAD, TM_REPLY, TM_SPREAD};
use super::engine::Twin;
use super::fault::Fault;
use super::identity::{self, Condition};
use super::request::{Command, Request};
use super::state::{Protocol, State, Status};
use super::surroundings::Surroundings;
use super::{Instant, wire};

/// What a command came to.
pub(super) enum Answer {
    /// A status and nothing else.
    Status(Status),
    /// Status 00 and these lines.
    Lines(Vec<u8>),
    /// Status 00 and the lines of a scan.
    Scan(Vec<u8>),
}

impl Twin {
    /// Answers `request` at `t`.
    pub(super) fn answer(
        &mut self,
        request: &Request,
        duplicate: bool,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) {
        let delay = if request.is_time() {
            TM_REPLY + self.noise.spread(TM_SPREAD)
        } else {
            self.noise.spread(REPLY_SPREAD)
        };
        if self.state.protocol == Protocol::Scip1 {
            let reply = self.scip1_reply(request);
            return self.emit(reply, t, t + delay, false);
        }
        if request.is_foreign_measurement(self.options.profile.generation)
            && self.faults.happens(Fault::Deafened, t)
        {
            self.state.deaf = true;
        }
        if self.state.deaf {
            return self.out.lose();
        }
        let baud = self.out.baud();
        let answer = match self.carry_out(request, duplicate, t, surroundings) {
            Ok(answer) => answer,
            Err(status) => Answer::Status(status),
        };
        let mut reply = request.line().to_vec();
        reply.push(b'\n');
        let is_scan = matches!(answer, Answer::Scan(_));
        match answer {
            Answer::Status(status) => wire::push_summed(&mut reply, &status.0),
            Answer::Lines(lines) | Answer::Scan(lines) => {
                wire::push_summed(&mut reply, &Status::DONE.0);
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

    /// SCIP1.1 (section 9): `V`, the switch, and `E` for everything else.
    fn scip1_reply(&mut self, request: &Request) -> Vec<u8> {
        let mut reply = request.line().to_vec();
        match (request.line(), &self.options.profile.scip1) {
            (b"V", Some(lines)) => {
                reply.extend_from_slice(b"\n0\n");
                identity::push_scip1_version(&mut reply, &self.options.profile, lines);
                reply.push(b'\n');
            }
            (b"SCIP2.0", _) => {
                self.state.protocol = Protocol::Scip2;
                self.state.stop();
                reply.extend_from_slice(b"\n0\n\n");
            }
            _ => reply.extend_from_slice(b"\nE\n\n"),
        }
        reply
    }

    fn carry_out(
        &mut self,
        request: &Request,
        duplicate: bool,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) -> Result<Answer, Status> {
        let generation = self.options.profile.generation;
        let ethernet = generation.is_ethernet();
        if self.state.time_adjust && !request.is_time() && !ethernet {
            return Err(Status::UNDEFINED);
        }
        if self.state.firmware_update && !matches!(request.body(), b"VV" | b"II" | b"RS") {
            return Err(if request.line() == b"SCIP2.0" {
                Status::UNDEFINED
            } else {
                Status::FIRMWARE_UPDATE
            });
        }
        let command = request.command(generation)?;
        let allowed = request.is_time() || command.is_question() || command == Command::Reset;
        if self.state.time_adjust && !allowed {
            return Err(Status::DENIED);
        }
        if duplicate {
            return Err(Status::BUFFER_SHORTAGE);
        }
        let parameters = request.parameters();
        let mut lines = Vec::new();
        let status = match command {
            Command::Version => {
                identity::push_version(&mut lines, &self.options.profile);
                self.faults.spoil_version(&mut lines, t);
                return Ok(Answer::Lines(lines));
            }
            Command::Parameters => {
                identity::push_parameters(&mut lines, &self.options.profile);
                return Ok(Answer::Lines(lines));
            }
            Command::Status => {
                let condition = self.condition(t);
                identity::push_condition(&mut lines, &self.options.profile, &condition);
                return Ok(Answer::Lines(lines));
            }
            Command::Time => return self.time(parameters, t),
            Command::Latest => return self.latest(request, t, surroundings),
            Command::State => {
                wire::push_summed(&mut lines, self.state_digits(t));
                return Ok(Answer::Lines(lines));
            }
            Command::LaserOn => self.laser_on_command(t),
            Command::Quit => {
                self.state.stop();
                self.state.asleep = false;
                Status::DONE
            }
            Command::Sleep => {
                self.state.stop();
                self.state.asleep = true;
                Status::DONE
            }
            Command::Reset => self.reset(t),
            Command::SoftReset => self.soft_reset(t),
            Command::Reboot => self.reboot(t),
            Command::BitRate => self.bit_rate(parameters),
            Command::MotorSpeed => self.motor_speed(parameters, t),
            Command::Sensitivity => self.sensitivity(parameters)?,
            Command::Rehearsal => self.rehearse(parameters, t)?,
            Command::Stream => self.start_stream(request, t)?,
        };
        Ok(Answer::Status(status))
    }

    fn condition(&mut self, t: Instant) -> Condition {
        Condition {
            laser: self.state.laser,
            speed_level: self.state.speed_level,
            sensitive: self.state.sensitive,
            baud: self.out.baud(),
            timer: self.timer.at(t),
            firmware_update: self.state.firmware_update,
            trouble: self.faults.happens(Fault::TroubleStat, t)
                || self.state.malfunction_at(t).is_some(),
        }
    }

    fn time(&mut self, parameters: &[u8], t: Instant) -> Result<Answer, Status> {
        let answers_always = self.options.profile.generation.is_ethernet();
        let status = match (parameters, self.state.time_adjust) {
            (b"0", false) if answers_always && self.state.stream.is_some() => Status::DENIED,
            (b"0", false) => {
                self.state.stop();
                self.state.time_adjust = true;
                Status::DONE
            }
            (b"0", true) => Status::number(2),
            (b"1", adjusting) if adjusting || answers_always => {
                let (mut time, mut lines) = (Vec::new(), Vec::new());
                wire::push_number(&mut time, self.timer.at(t), 4);
                wire::push_summed(&mut lines, &time);
                return Ok(Answer::Lines(lines));
            }
            (b"1", _) => Status::number(4),
            (b"2", true) => {
                self.state.time_adjust = false;
                Status::DONE
            }
            (b"2", false) => Status::number(3),
            _ => Status::number(1),
        };
        Ok(Answer::Status(status))
    }

    fn laser_on_command(&mut self, t: Instant) -> Status {
        if self.state.asleep {
            return Status::DENIED;
        }
        if self.state.malfunction_at(t).is_some() {
            return Status::number(1);
        }
        if self.state.laser || self.state.stream.is_some() {
            return Status::number(2);
        }
        self.state.laser = true;
        Status::DONE
    }

    /// Laser off, motor, sensitivity and bit rate to default, timer to zero. What the power-up alone forgets stays; the
    /// firmware update mode ends (section 5).
    fn reset(&mut self, t: Instant) -> Status {
        if self.state.speed_level != 0 {
            self.motor.set_speed(self.options.profile.speed_rpm, t);
        }
        self.restart(t);
        Status::DONE
    }

    fn restart(&mut self, t: Instant) {
        self.state = State {
            protocol: Protocol::Scip2,
            malfunction: self.state.malfunction,
            rehearsal: self.state.rehearsal,
            ..State::powered_up(&self.options)
        };
        self.timer.reset(t);
        self.out.reset_baud();
    }

    /// `RT`: as `RS`, but motor and bit rate stay (section 6).
    fn soft_reset(&mut self, t: Instant) -> Status {
        let (level, baud) = (self.state.speed_level, self.out.baud());
        self.restart(t);
        self.state.speed_level = level;
        self.out.set_baud(baud);
        Status::DONE
    }

    /// `RB`: the first is refused with 01, a second within a second starts the sensor anew (section 10).
    fn reboot(&mut self, t: Instant) -> Status {
        let twice = self
            .state
            .reboot_asked
            .replace(t)
            .is_some_and(|first| t.saturating_sub(first) <= REBOOT_TWICE_WITHIN);
        if !twice {
            return Status::number(1);
        }
        self.state.reboot_at = Some(t.saturating_add(REBOOT_AFTER));
        Status::DONE
    }

    /// `%ST`: the state as three digits (section 10).
    fn state_digits(&self, t: Instant) -> &'static [u8; 3] {
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
        } else if state.laser {
            b"003"
        } else {
            b"000"
        }
    }
}
