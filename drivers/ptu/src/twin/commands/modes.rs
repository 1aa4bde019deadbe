//! Switches, saved settings, line and network.

use std::time::Duration;

use super::{Executed, Outcome};
use crate::twin::command::{Defaults, Switch};
use crate::twin::constants::{BAUD_RATES, E_BAUD_RATES, MAX_BYTE_GAP_MS, MAX_UNIT_ID};
use crate::twin::options::Supply;
use crate::twin::replies::{self, Refusal};
use crate::twin::settings::Settings;
use crate::twin::unit::Twin;

impl Twin {
    /// Echo, feedback, control and execution mode, scan at power-up.
    pub(super) fn switch(&mut self, switch: Switch, state: Option<bool>) -> Executed {
        let settings = &mut self.settings;
        let Some(on) = state else {
            return Ok(Outcome::Say(match switch {
                Switch::Echo => replies::echo(settings.echo),
                Switch::Verbose => replies::feedback(settings.verbose),
                Switch::Velocity => replies::control(settings.velocity_mode, self.options.e_series),
                Switch::Slaved => {
                    self.e_series()?;
                    replies::execution(self.settings.slaved)
                }
                Switch::ScanAtPowerUp => replies::scan_at_power_up(settings.scan_at_power_up),
            }));
        };
        match switch {
            Switch::Echo => settings.echo = on,
            Switch::Verbose => settings.verbose = on,
            Switch::Velocity => self.set_velocity_mode(on),
            Switch::Slaved => {
                settings.slaved = on;
                if !on {
                    self.release();
                }
            }
            Switch::ScanAtPowerUp => settings.scan_at_power_up = on,
        }
        Ok(Outcome::Done)
    }

    /// `DS DR DF`. The network id outlives `DF`, or a unit on a shared line would be lost.
    pub(super) fn defaults(&mut self, which: Defaults) -> Executed {
        let restored = match which {
            Defaults::Save => {
                self.saved = self.settings.clone();
                self.eeprom_writes = self.eeprom_writes.saturating_add(1);
                return Ok(Outcome::Done);
            }
            Defaults::Restore => self.saved.clone(),
            Defaults::Factory => Settings {
                unit_id: self.settings.unit_id,
                ..Settings::factory(&self.options)
            },
        };
        if self.moving() {
            return Err(Refusal::InMotion);
        }
        let mut restored = restored;
        for (new, old) in restored.axes.iter_mut().zip(&self.settings.axes) {
            new.count_in(old.counted_in);
        }
        self.held_back = [None; 2];
        if restored
            .axes
            .iter()
            .zip(&self.settings.axes)
            .all(|(new, old)| new.same_tables(old))
        {
            self.settings = restored;
            return Ok(Outcome::Done);
        }
        Ok(self.recompute(restored))
    }

    /// `@(baud,delay,T or F)`; the reply still goes at the old speed.
    pub(super) fn host_port(&mut self, baud: u32, gap_ms: i32, keep: bool) -> Executed {
        let known =
            BAUD_RATES.contains(&baud) || (self.options.e_series && E_BAUD_RATES.contains(&baud));
        if !known || !(0..=MAX_BYTE_GAP_MS).contains(&gap_ms) {
            return Err(Refusal::IllegalCommand);
        }
        self.next_baud = Some(baud);
        self.byte_gap = Duration::from_millis(u64::from(gap_ms.unsigned_abs()));
        self.power_up_baud = if keep { baud } else { 9600 };
        Ok(Outcome::Done)
    }

    /// `U`.
    pub(super) fn unit_id(&mut self, id: Option<i32>) -> Executed {
        let Some(id) = id else {
            return Ok(Outcome::Say(replies::unit_id(self.settings.unit_id)));
        };
        self.settings.unit_id = valid_id(id)?;
        Ok(Outcome::Done)
    }

    /// `_`: has no reply of its own.
    pub(super) fn select_unit(&mut self, id: i32) -> Executed {
        match valid_id(id) {
            Ok(id) => self.select(id == 0 || id == self.settings.unit_id),
            Err(refusal) if self.selected => return Err(refusal),
            Err(_) => {}
        }
        Ok(Outcome::Silent)
    }

    /// What `O` reports now.
    pub(super) fn supply_now(&self) -> Supply {
        let scripted = || {
            self.options
                .supply_script
                .iter()
                .rev()
                .find(|(at, _)| *at <= self.now)
                .map(|(_, s)| *s)
        };
        let sagging = self.faults.supply(self.now).map(|(volts, degf)| Supply {
            volts,
            temperature_f: [degf; 3],
        });
        sagging
            .or(self.supply)
            .or_else(scripted)
            .unwrap_or(self.options.supply)
    }
}

fn valid_id(id: i32) -> Result<u8, Refusal> {
    u8::try_from(id)
        .ok()
        .filter(|_| id <= MAX_UNIT_ID)
        .ok_or(Refusal::IllegalUnitId)
}
