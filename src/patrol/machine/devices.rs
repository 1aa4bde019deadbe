//! What the machine does about the devices: open, greet, lose and try again.

use super::{Devices, Machine, Step};
use crate::patrol::action::{Action, Weight};
use crate::patrol::constants::{ABSENT_RETRY, FIRST_RETRY, LONGEST_RETRY};
use crate::patrol::event::{Change, Request};
use std::time::Duration;

impl Machine {
    pub(super) fn apply_change(&mut self, out: &mut Vec<Action>) {
        if matches!(self.in_hand, Some((_, Step::Sweeping))) {
            return;
        }
        let Some(change) = self.change.take() else {
            return;
        };
        out.push(Action::ApplySettings);
        if change == Change::Devices {
            if self.devices == Devices::Opening {
                out.push(Action::CancelDevices);
            }
            self.open(out);
        }
    }

    pub(super) fn open(&mut self, out: &mut Vec<Action>) {
        self.devices = Devices::Opening;
        out.push(Action::OpenDevices);
    }

    pub(super) fn devices_ready(&mut self, out: &mut Vec<Action>) {
        if self.stopping {
            return;
        }
        self.devices = Devices::Ready;
        self.pause = FIRST_RETRY;
        self.absent = None;
        out.push(Action::Note(Weight::Info, "devices ready".to_owned()));
        if let Some(request) = self.take_waiting() {
            self.sweep(request, out);
        }
    }

    pub(super) fn devices_failed(&mut self, now: Duration, reason: String, out: &mut Vec<Action>) {
        if self.stopping {
            return;
        }
        // The same failure again is no news for the log.
        if self.pause == FIRST_RETRY {
            out.push(Action::Note(Weight::Error, reason.clone()));
        }
        let retry_at = now + self.pause;
        self.pause = (2 * self.pause).min(LONGEST_RETRY);
        self.devices = Devices::Lost { reason, retry_at };
        // It had its attempt.
        if let Some(request) = self.take_waiting() {
            self.no_devices(request, out);
        }
    }

    pub(super) fn devices_absent(&mut self, now: Duration, reason: String, out: &mut Vec<Action>) {
        if self.stopping {
            return;
        }
        if self.absent.as_ref() != Some(&reason) {
            out.push(Action::Note(Weight::Error, reason.clone()));
            self.absent = Some(reason.clone());
        }
        let retry_at = now + ABSENT_RETRY;
        self.devices = Devices::Lost { reason, retry_at };
        if let Some(request) = self.take_waiting() {
            self.no_devices(request, out);
        }
    }

    pub(super) fn no_devices(&mut self, request: Request, out: &mut Vec<Action>) {
        if let Devices::Lost { reason, .. } = &self.devices {
            let reason = format!("no devices: {reason}");
            self.not_swept(request, reason, out);
        }
    }
}
