//! `SS`, `CR`, `HS` and `DB`: what changes how the sensor works (protocol section 6).

use super::Instant;
use super::constants::{BAUD_OF_OTHER_MODELS, BAUDS, HARDWARE_STATUS, MAX_SPEED_LEVEL};
use super::engine::Twin;
use super::identity;
use super::profile::Generation;
use super::request::decimal;
use super::state::{Malfunction, Rehearsal, Status};

/// 00, or the number of what is wrong.
fn done_or(wrong: Option<u8>) -> Status {
    wrong.map_or(Status::DONE, Status::number)
}

impl Twin {
    /// `SS`. Ethernet models have no such line.
    pub(super) fn bit_rate(&mut self, parameters: &[u8]) -> Status {
        if self.options.profile.generation.is_ethernet() {
            return Status::NOT_SUPPORTED;
        }
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

    /// `CR`: 00 and 99 both mean the nominal speed. The UTM answers 04 (logs L3 and L4).
    pub(super) fn motor_speed(&mut self, parameters: &[u8], t: Instant) -> Status {
        let level = match (decimal(parameters), self.options.profile.generation) {
            (_, Generation::Ethernet) => return Status::NOT_SUPPORTED,
            (None, _) => return Status::number(1),
            (_, Generation::Top) => return Status::number(4),
            (Some(99), _) => 0,
            (Some(level), _) => level,
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

    /// `HS`.
    pub(super) fn sensitivity(&mut self, parameters: &[u8]) -> Result<Status, Status> {
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
    pub(super) fn rehearse(&mut self, parameters: &[u8], t: Instant) -> Result<Status, Status> {
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
            let malfunction = Malfunction {
                status: HARDWARE_STATUS,
                until: None,
                rehearsed: true,
            };
            self.fail(malfunction, t);
        }
        Ok(Status::DONE)
    }
}
