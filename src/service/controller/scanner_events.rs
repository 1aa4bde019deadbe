//! What the scanner reports, as events of the patrol and health incidents.

use super::Controller;
use crate::patrol::event::PatrolEvent;
use crate::service::scanner_thread::ScannerEvent;

impl Controller {
    pub(super) fn scanner_event(&mut self, event: ScannerEvent) -> PatrolEvent {
        match event {
            ScannerEvent::Ready(identity) => {
                self.services
                    .status
                    .send_modify(|status| status.devices.identity = identity);
                self.note_health("devices", None);
                PatrolEvent::DevicesReady
            }
            ScannerEvent::Failed(reason) => {
                self.note_health("devices", Some(&reason));
                PatrolEvent::DevicesFailed(reason)
            }
            ScannerEvent::Absent(reason) => {
                self.note_health("devices", Some(&reason));
                PatrolEvent::DevicesAbsent(reason)
            }
            ScannerEvent::Lost(reason) => {
                self.note_health("devices", Some(&reason));
                PatrolEvent::DevicesLost(reason)
            }
            ScannerEvent::Homed => PatrolEvent::HeadHomed,
            ScannerEvent::HomingDone => PatrolEvent::HomingDone,
            ScannerEvent::Closed => PatrolEvent::DevicesClosed,
            ScannerEvent::Swept(id, raw_sweep, dialogue) => {
                let now = self.services.scanner.clock().now();
                let spent = now.saturating_sub(self.sweep_started);
                if let Some(active) = self.active.as_mut().filter(|a| a.request.id == id) {
                    active.timing.sweep += spent.as_secs_f64() * 1e3;
                    active.dialogue = dialogue;
                    self.raw_sweep = Some(*raw_sweep);
                }
                PatrolEvent::SweepDone(id)
            }
            ScannerEvent::Returned(duration) => {
                let return_ms = duration.map(|duration| duration.as_secs_f64() * 1e3);
                self.services
                    .status
                    .send_modify(|status| status.devices.return_ms = return_ms);
                // The patrol has no event for it.
                PatrolEvent::Tick
            }
            ScannerEvent::SweepFailed(id, error, dialogue) => {
                if let Some(active) = self.active.as_mut().filter(|a| a.request.id == id) {
                    active.dialogue = dialogue;
                }
                if error.lost {
                    self.note_health("devices", Some(&error.reason));
                } else if !self.machine.is_cancelled(id) {
                    self.note_health("sweep", Some(&error.reason));
                }
                PatrolEvent::SweepFailed {
                    id,
                    reason: error.reason,
                    lost: error.lost,
                }
            }
        }
    }
}
