//! Opening the devices, and retries after failure or loss.

use super::{DeviceAvailability, PatrolMachine, RequestStage};
use crate::patrol::action::PatrolAction;
use crate::patrol::constants::{ABSENT_RETRY_PAUSE, INITIAL_RETRY_PAUSE, MAX_RETRY_PAUSE};
use crate::patrol::event::{PatrolRequest, SettingsChange};
use crate::patrol::severity::Severity;
use std::time::Duration;

impl PatrolMachine {
    pub(super) fn apply_change(&mut self, out: &mut Vec<PatrolAction>) {
        if matches!(self.current, Some((_, RequestStage::Sweeping))) {
            return;
        }
        let Some(change) = self.pending_change.take() else {
            return;
        };
        out.push(PatrolAction::ApplySettings);
        if change == SettingsChange::ReopenDevices {
            if self.devices == DeviceAvailability::Opening {
                out.push(PatrolAction::CancelDevices);
            }
            self.open(out);
        }
    }

    pub(super) fn open(&mut self, out: &mut Vec<PatrolAction>) {
        self.devices = DeviceAvailability::Opening;
        out.push(PatrolAction::OpenDevices);
    }

    pub(super) fn devices_ready(&mut self, out: &mut Vec<PatrolAction>) {
        if self.stopping {
            return;
        }
        self.devices = DeviceAvailability::Ready;
        self.retry_pause = INITIAL_RETRY_PAUSE;
        self.reported_absence = None;
        out.push(PatrolAction::LogEvent(
            Severity::Info,
            "devices ready".to_owned(),
        ));
        if let Some(request) = self.take_waiting_for_devices() {
            self.start_sweep(request, out);
        }
    }

    pub(super) fn devices_failed(
        &mut self,
        now: Duration,
        reason: String,
        out: &mut Vec<PatrolAction>,
    ) {
        if self.stopping {
            return;
        }
        // Log a repeated failure once.
        if self.retry_pause == INITIAL_RETRY_PAUSE {
            out.push(PatrolAction::LogEvent(Severity::Error, reason.clone()));
        }
        let retry_at = now + self.retry_pause;
        self.retry_pause = (2 * self.retry_pause).min(MAX_RETRY_PAUSE);
        self.devices = DeviceAvailability::Lost { reason, retry_at };
        // Its own attempt has failed.
        if let Some(request) = self.take_waiting_for_devices() {
            self.devices_unavailable(request, out);
        }
    }

    pub(super) fn devices_absent(
        &mut self,
        now: Duration,
        reason: String,
        out: &mut Vec<PatrolAction>,
    ) {
        if self.stopping {
            return;
        }
        if self.reported_absence.as_ref() != Some(&reason) {
            out.push(PatrolAction::LogEvent(Severity::Error, reason.clone()));
            self.reported_absence = Some(reason.clone());
        }
        let retry_at = now + ABSENT_RETRY_PAUSE;
        self.devices = DeviceAvailability::Lost { reason, retry_at };
        if let Some(request) = self.take_waiting_for_devices() {
            self.devices_unavailable(request, out);
        }
    }

    pub(super) fn devices_unavailable(
        &mut self,
        request: PatrolRequest,
        out: &mut Vec<PatrolAction>,
    ) {
        if let DeviceAvailability::Lost { reason, .. } = &self.devices {
            let reason = format!("no devices: {reason}");
            self.sweep_unavailable(request, reason, out);
        }
    }

    pub(super) fn take_waiting_for_devices(&mut self) -> Option<PatrolRequest> {
        let id = match &self.current {
            Some((request, RequestStage::Waiting)) => request.id,
            _ => return None,
        };
        self.take_current(id, RequestStage::Waiting)
    }
}
