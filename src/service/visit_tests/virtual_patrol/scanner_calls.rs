//! What the scanner thread does beside sweeping, without a thread.

use super::VirtualPatrol;
use crate::devices::Cancel;
use crate::patrol::event::PatrolEvent;
use crate::service::constants::IDLE_CHECK_INTERVAL;
use crate::service::scanner::{ConnectError, DeviceNoteSink, ScannerConnector};

impl VirtualPatrol {
    pub(super) fn check_idle_devices(&mut self) {
        if self.devices.now() < self.last_idle_check + IDLE_CHECK_INTERVAL {
            return;
        }
        self.last_idle_check = self.devices.now();
        self.report_lost_devices();
    }

    pub(super) fn report_lost_devices(&mut self) {
        let error = self
            .scanner
            .as_mut()
            .and_then(|scanner| scanner.check_connected().err());
        if let Some(error) = error.filter(|error| error.lost) {
            self.events
                .push_back(PatrolEvent::DevicesLost(error.reason));
        }
    }

    pub(super) fn report_homing(&mut self) {
        let homings = self.scanner.as_ref().map(|scanner| scanner.homings());
        if let Some(homings) = homings.filter(|homings| *homings != self.homings) {
            self.homings = homings;
            self.events.push_back(PatrolEvent::HeadHomed);
        }
    }

    pub(super) fn resume_or_connect(&mut self) -> Result<(), ConnectError> {
        let cancel = Cancel::new();
        if let Some(scanner) = &mut self.scanner {
            match scanner.resume(&cancel) {
                Ok(()) => return Ok(()),
                Err(error) if error.absent => return Err(error),
                Err(_) => {}
            }
        }
        self.scanner = None;
        let notes = DeviceNoteSink::new(|_, _, _| ());
        let mut scanner = self.connector.connect(&self.settings, &notes, &cancel)?;
        scanner.describe();
        self.scanner = Some(scanner);
        Ok(())
    }
}
