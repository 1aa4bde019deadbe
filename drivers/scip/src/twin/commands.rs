//! The answers to requests (protocol section 6), one function per command that does more than tell.

use super::constants::{
    BAUD_OF_OTHER_MODELS, BAUDS, HARDWARE_STATUS, MAX_SPEED_LEVEL, REPLY_SPREAD, TM_REPLY,
    TM_SPREAD,
};
use super::engine::Twin;
use super::fault::Fault;
use super::identity::{self, Condition};
use super::request::{Command, Request, decimal};
use super::scanning::Window;
use super::state::{Malfunction, Protocol, Rehearsal, State, Status, Stream};
use super::surroundings::Surroundings;
use super::{Instant, wire};

/// What a command came to.
enum Answer {
    /// A status and nothing else.
    Status(Status),
    /// Status 00 and these lines.
    Lines(Vec<u8>),
    /// Status 00 and the lines of a scan.
    Scan(Vec<u8>),
}

/// 00, or the number of what is wrong.
fn done_or(wrong: Option<u8>) -> Status {
    wrong.map_or(Status::DONE, Status::number)
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
        if self.state.time_adjust && !request.is_time() {
            return Err(Status::UNDEFINED);
        }
        let command = request.command()?;
        if duplicate {
            return Err(Status::BUFFER_SHORTAGE);
        }
        let parameters = request.parameters();
        let mut lines = Vec::new();
        let status = match command {
            Command::Version => {
                identity::push_version(&mut lines, &self.options.profile);
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
            Command::LaserOn => self.laser_on_command(t),
            Command::Quit => {
                self.state.stop();
                Status::DONE
            }
            Command::Reset => self.reset(t),
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
            trouble: self.faults.happens(Fault::TroubleStat, t)
                || self.state.malfunction_at(t).is_some(),
        }
    }

    fn time(&mut self, parameters: &[u8], t: Instant) -> Result<Answer, Status> {
        let status = match (parameters, self.state.time_adjust) {
            (b"0", false) => {
                self.state.stop();
                self.state.time_adjust = true;
                Status::DONE
            }
            (b"0", true) => Status::number(2),
            (b"1", true) => {
                let (mut time, mut lines) = (Vec::new(), Vec::new());
                wire::push_number(&mut time, self.timer.at(t), 4);
                wire::push_summed(&mut lines, &time);
                return Ok(Answer::Lines(lines));
            }
            (b"1", false) => Status::number(4),
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
        if self.state.malfunction_at(t).is_some() {
            return Status::number(1);
        }
        if self.state.laser || self.state.stream.is_some() {
            return Status::number(2);
        }
        self.state.laser = true;
        Status::DONE
    }

    /// Laser off, motor, sensitivity and bit rate to default, timer to zero. What the power-up alone forgets stays.
    fn reset(&mut self, t: Instant) -> Status {
        if self.state.speed_level != 0 {
            self.motor.set_speed(self.options.profile.speed_rpm, t);
        }
        self.state = State {
            protocol: Protocol::Scip2,
            malfunction: self.state.malfunction,
            rehearsal: self.state.rehearsal,
            ..State::powered_up(&self.options)
        };
        self.timer.reset(t);
        self.out.reset_baud();
        Status::DONE
    }

    fn bit_rate(&mut self, parameters: &[u8]) -> Status {
        let wrong = match decimal(parameters) {
            None => Some(1),
            Some(_) if self.options.profile.usb_only_text.is_some() => Some(4),
            Some(baud) if baud == BAUD_OF_OTHER_MODELS => Some(4),
            Some(baud) if !BAUDS.contains(&baud) => Some(2),
            Some(baud) if baud == self.out.baud() => Some(3),
            Some(baud) => {
                self.out.set_baud(baud);
                None
            }
        };
        done_or(wrong)
    }

    /// 00 and 99 both mean the nominal speed.
    fn motor_speed(&mut self, parameters: &[u8], t: Instant) -> Status {
        let level = match decimal(parameters) {
            None => return Status::number(1),
            Some(99) => 0,
            Some(level) => level,
        };
        let Some(level) = u8::try_from(level)
            .ok()
            .filter(|level| *level <= MAX_SPEED_LEVEL)
        else {
            return Status::number(2);
        };
        if level == self.state.speed_level {
            return Status::number(3);
        }
        self.state.speed_level = level;
        self.motor
            .set_speed(identity::speed_rpm(&self.options.profile, level), t);
        Status::DONE
    }

    fn sensitivity(&mut self, parameters: &[u8]) -> Result<Status, Status> {
        if !self.options.profile.high_sensitivity {
            return Err(Status::TOO_FEW_PARAMETERS);
        }
        let sensitive = match parameters {
            b"0" => false,
            b"1" => true,
            _ => return Ok(Status::number(1)),
        };
        if sensitive == self.state.sensitive {
            return Ok(Status::number(2));
        }
        self.state.sensitive = sensitive;
        Ok(Status::DONE)
    }

    /// `DB`: what is played is told in [`Rehearsal`]. 01, which plays a SCIP1.1 sensor, is not supported.
    fn rehearse(&mut self, parameters: &[u8], t: Instant) -> Result<Status, Status> {
        if !self.options.profile.rehearsals {
            return Err(Status::UNDEFINED);
        }
        let malfunction = self.state.malfunction_at(t);
        if malfunction.is_some_and(|malfunction| !malfunction.rehearsed) {
            return Ok(Status::number(5));
        }
        let rehearsal = match parameters {
            b"01" => return Ok(Status::number(4)),
            b"02" => Rehearsal::Malfunction,
            b"03" => Rehearsal::Recovers,
            b"04" => Rehearsal::Fails,
            b"05" => Rehearsal::FailsAtOnce,
            b"10" => {
                let over = self.state.rehearsal.take().is_none();
                self.state.malfunction = None;
                return Ok(done_or(over.then_some(3)));
            }
            _ => return Ok(Status::number(1)),
        };
        if self.state.rehearsal == Some(rehearsal) {
            return Ok(Status::number(2));
        }
        self.state.rehearsal = Some(rehearsal);
        if rehearsal == Rehearsal::Malfunction {
            self.fail(
                Malfunction {
                    status: HARDWARE_STATUS,
                    until: None,
                    rehearsed: true,
                },
                t,
            );
        }
        Ok(Status::DONE)
    }

    fn latest(
        &mut self,
        request: &Request,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) -> Result<Answer, Status> {
        let window = Window::parse(request.parameters(), request.two_characters())?;
        if let Some(malfunction) = self.state.malfunction_at(t) {
            return Err(Status::number(malfunction.status));
        }
        if !self.state.laser {
            return Err(Status::LASER_OFF);
        }
        let mut lines = Vec::new();
        window.push_scan(
            &mut lines,
            self.measure(self.motor.revolution_at(t), t, surroundings),
        );
        Ok(Answer::Scan(lines))
    }

    fn start_stream(&mut self, request: &Request, t: Instant) -> Result<Status, Status> {
        let parameters = request.parameters();
        let window = Window::parse(parameters, request.two_characters())?;
        let number = |from: usize, to: usize, status: u8| {
            parameters
                .get(from..to)
                .and_then(decimal)
                .ok_or(Status::number(status))
        };
        let interval = number(10, 11, 6)?;
        let count = number(11, 13, 7)?;
        if let Some(malfunction) = self.state.malfunction_at(t) {
            return Err(Status::number(malfunction.status));
        }
        if self.state.stream.is_some() {
            return Err(Status::BUFFER_SHORTAGE);
        }
        self.state.laser = true;
        self.state.stream = Some(Stream {
            head: request.body().get(..13).unwrap_or_default().to_vec(),
            tail: request.tail().to_vec(),
            window,
            interval: u64::from(interval),
            count,
            sent: 0,
            next_revolution: self.motor.revolution_at(t) + 1,
            pause: None,
        });
        Ok(Status::DONE)
    }
}
