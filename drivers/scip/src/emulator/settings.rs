//! `SS`, `CR`, `HS` and `DB`: requests that change settings (scip2 section 6).

use super::constants::{BAUD_OF_OTHER_MODELS, BAUDS, HARDWARE_STATUS, MAX_SPEED_LEVEL};
use super::emulated_laser::EmulatedLaser;
use super::identity;
use super::profile::LaserGeneration;
use super::state::{Malfunction, SimulatedFailure};
use super::status::ReplyStatus;
use super::wire::decimal;
use std::time::Duration;

/// The number of the error, or 00 without one.
fn status_from_error(error: Option<u8>) -> ReplyStatus {
    error.map_or(ReplyStatus::DONE, ReplyStatus::number)
}

impl EmulatedLaser {
    /// `SS`. Ethernet models have no serial line.
    pub(super) fn bit_rate(&mut self, parameters: &[u8]) -> ReplyStatus {
        if self.options.profile.generation.is_ethernet() {
            return ReplyStatus::NOT_SUPPORTED;
        }
        let error = match decimal(parameters) {
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
        status_from_error(error)
    }

    /// `CR`: 00 and 99 both mean the nominal speed. The UTM answers 04 (logs L3 and L4).
    pub(super) fn motor_speed(&mut self, parameters: &[u8], t: Duration) -> ReplyStatus {
        let level = match (decimal(parameters), self.options.profile.generation) {
            (_, LaserGeneration::Ethernet) => return ReplyStatus::NOT_SUPPORTED,
            (None, _) => return ReplyStatus::number(1),
            (_, LaserGeneration::TopUrg) => return ReplyStatus::number(4),
            (Some(99), _) => 0,
            (Some(level), _) => level,
        };
        let Some(level) = u8::try_from(level)
            .ok()
            .filter(|level| *level <= MAX_SPEED_LEVEL)
        else {
            return ReplyStatus::number(2);
        };
        if level == self.state.speed_level {
            return ReplyStatus::number(3);
        }
        self.state.speed_level = level;
        self.motor
            .set_speed(identity::speed_rpm(&self.options.profile, level), t);
        ReplyStatus::DONE
    }

    /// `HS`.
    pub(super) fn sensitivity(&mut self, parameters: &[u8]) -> Result<ReplyStatus, ReplyStatus> {
        if !self.options.profile.high_sensitivity {
            return Err(ReplyStatus::TOO_FEW_PARAMETERS);
        }
        let sensitive = match parameters {
            b"0" => false,
            b"1" => true,
            _ => return Ok(ReplyStatus::number(1)),
        };
        if sensitive == self.state.sensitive {
            return Ok(ReplyStatus::number(2));
        }
        self.state.sensitive = sensitive;
        Ok(ReplyStatus::DONE)
    }

    /// `DB`, see [`SimulatedFailure`]. 01, a malfunction in SCIP 1.1, is not supported.
    pub(super) fn simulate_failure(
        &mut self,
        parameters: &[u8],
        t: Duration,
    ) -> Result<ReplyStatus, ReplyStatus> {
        if !self.options.profile.failure_simulation {
            return Err(ReplyStatus::UNDEFINED);
        }
        let malfunction = self.state.malfunction_at(t);
        if malfunction.is_some_and(|malfunction| !malfunction.simulated) {
            return Ok(ReplyStatus::number(5));
        }
        let simulation = match parameters {
            b"01" => return Ok(ReplyStatus::number(4)),
            b"02" => SimulatedFailure::Malfunction,
            b"03" => SimulatedFailure::Recovers,
            b"04" => SimulatedFailure::Fails,
            b"05" => SimulatedFailure::FailsAtOnce,
            b"10" => {
                let over = self.state.simulation.take().is_none();
                self.state.malfunction = None;
                return Ok(status_from_error(over.then_some(3)));
            }
            _ => return Ok(ReplyStatus::number(1)),
        };
        if self.state.simulation == Some(simulation) {
            return Ok(ReplyStatus::number(2));
        }
        self.state.simulation = Some(simulation);
        if simulation == SimulatedFailure::Malfunction {
            let malfunction = Malfunction {
                status: HARDWARE_STATUS,
                until: None,
                simulated: true,
            };
            self.fail(malfunction, t);
        }
        Ok(ReplyStatus::DONE)
    }
}
