//! Modes, saved settings, host port, network id, supply.

use std::time::Duration;

use super::{RequestOutcome, RequestResult};
use crate::emulator::command::{DefaultsAction, ModeSwitch};
use crate::emulator::constants::{BAUD_RATES, E_SERIES_BAUD_RATES, MAX_BYTE_GAP_MS, MAX_UNIT_ID};
use crate::emulator::options::Supply;
use crate::emulator::replies::{self, RequestRefusal};
use crate::emulator::settings::UnitSettings;
use crate::emulator::state::EmulatedHead;

impl EmulatedHead {
    /// Echo, feedback, control and execution mode, scan at power-up.
    pub(super) fn switch(&mut self, switch: ModeSwitch, state: Option<bool>) -> RequestResult {
        let settings = &mut self.settings;
        let Some(on) = state else {
            return Ok(RequestOutcome::Answer(match switch {
                ModeSwitch::Echo => replies::echo(settings.echo),
                ModeSwitch::Verbose => replies::feedback(settings.verbose),
                ModeSwitch::Velocity => {
                    replies::control(settings.velocity_mode, self.options.e_series)
                }
                ModeSwitch::Slaved => {
                    self.e_series()?;
                    replies::execution(self.settings.slaved)
                }
                ModeSwitch::ScanAtPowerUp => replies::scan_at_power_up(settings.scan_at_power_up),
            }));
        };
        match switch {
            ModeSwitch::Echo => settings.echo = on,
            ModeSwitch::Verbose => settings.verbose = on,
            ModeSwitch::Velocity => self.set_velocity_mode(on),
            ModeSwitch::Slaved => {
                settings.slaved = on;
                if !on {
                    self.start_held_back();
                }
            }
            ModeSwitch::ScanAtPowerUp => settings.scan_at_power_up = on,
        }
        Ok(RequestOutcome::Done)
    }

    /// `DS DR DF`. The network id survives `DF`, or a unit on a shared line would become unreachable.
    pub(super) fn defaults(&mut self, which: DefaultsAction) -> RequestResult {
        let restored = match which {
            DefaultsAction::Save => {
                self.saved = self.settings.clone();
                self.eeprom_writes = self.eeprom_writes.saturating_add(1);
                return Ok(RequestOutcome::Done);
            }
            DefaultsAction::Restore => self.saved.clone(),
            DefaultsAction::Factory => UnitSettings {
                unit_id: self.settings.unit_id,
                ..UnitSettings::factory(&self.options)
            },
        };
        if self.moving() {
            return Err(RequestRefusal::InMotion);
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
            return Ok(RequestOutcome::Done);
        }
        Ok(self.recompute(restored))
    }

    /// `@(baud,delay,T or F)`; the reply still goes out at the old speed.
    pub(super) fn host_port(&mut self, baud: u32, gap_ms: i32, keep: bool) -> RequestResult {
        let known = BAUD_RATES.contains(&baud)
            || (self.options.e_series && E_SERIES_BAUD_RATES.contains(&baud));
        if !known || !(0..=MAX_BYTE_GAP_MS).contains(&gap_ms) {
            return Err(RequestRefusal::IllegalCommand);
        }
        self.next_baud = Some(baud);
        self.byte_gap = Duration::from_millis(u64::from(gap_ms.unsigned_abs()));
        self.power_up_baud = if keep { baud } else { 9600 };
        Ok(RequestOutcome::Done)
    }

    /// `U`.
    pub(super) fn unit_id(&mut self, id: Option<i32>) -> RequestResult {
        let Some(id) = id else {
            return Ok(RequestOutcome::Answer(replies::unit_id(
                self.settings.unit_id,
            )));
        };
        self.settings.unit_id = valid_id(id)?;
        Ok(RequestOutcome::Done)
    }

    /// `_`; it has no reply of its own.
    pub(super) fn select_unit(&mut self, id: i32) -> RequestResult {
        match valid_id(id) {
            Ok(id) => self.select(id == 0 || id == self.settings.unit_id),
            Err(refusal) if self.selected => return Err(refusal),
            Err(_) => {}
        }
        Ok(RequestOutcome::NoReply)
    }

    /// What `O` reports now.
    pub(super) fn supply_now(&self) -> Supply {
        let faulty = self.faults.supply(self.now).map(|(volts, degf)| Supply {
            volts,
            temperature_f: [degf; 3],
        });
        faulty.or(self.supply).unwrap_or(self.options.supply)
    }
}

fn valid_id(id: i32) -> Result<u8, RequestRefusal> {
    u8::try_from(id)
        .ok()
        .filter(|_| id <= MAX_UNIT_ID)
        .ok_or(RequestRefusal::IllegalUnitId)
}
