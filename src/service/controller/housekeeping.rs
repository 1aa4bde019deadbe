//! What the controller does besides the patrol: event log, retention, status.

use super::{Controller, send};
use crate::patrol::machine::DeviceAvailability;
use crate::patrol::severity::Severity;
use crate::service::constants::{RETENTION_INTERVAL, UNSEEN_CHECK_INTERVAL};
use crate::service::message::ServiceMessage;
use crate::service::message_id;
use crate::service::record_time::record_time_now;
use crate::service::replies::{CurrentStatus, DevicesStatus};
use crate::store::{HealthEvent, Retention, StoreError};
use std::time::{Duration, Instant};

const BYTES_PER_GIB: f64 = 1024.0 * 1024.0 * 1024.0;

impl Controller {
    pub(super) fn log_event(&mut self, severity: Severity, device: &str, text: String) {
        write_to_log(severity, device, &text);
        let device = device.to_owned();
        self.services.writer.submit_optional(
            move |ledger| {
                let now = record_time_now();
                ledger.store.note_event(severity, &device, &text, &now)
            },
            |written| {
                if let Err(error) = written {
                    tracing::error!("event not written to the store: {error}");
                }
            },
        );
    }

    pub(super) fn log_note(&mut self, severity: Severity, device: String, text: String) {
        self.log_event(severity, &device, text.clone());
        self.device_notes.insert(device, text);
    }

    /// What the patrol says of its devices. A device that said it itself is not logged twice.
    pub(super) fn log_patrol(&mut self, severity: Severity, text: String) {
        let is_noted = self
            .device_notes
            .values()
            .any(|note| note.starts_with(&text));
        if !is_noted {
            self.log_event(severity, "devices", text);
        }
    }

    /// `None`: nothing is wrong with the subject. What was noted already is not noted again, unless it could not be written.
    pub(super) fn note_health(&mut self, subject: &'static str, reason: Option<&str>) {
        let reason = reason.map(|text| text.replace('\n', " "));
        if self.health.get(subject) == Some(&reason) {
            return;
        }
        self.health.insert(subject, reason.clone());
        let inbox = self.services.inbox.clone();
        self.services.writer.submit_optional(
            move |ledger| {
                ledger
                    .store
                    .note_health(subject, reason.as_deref(), &record_time_now())
            },
            move |written| {
                if written.is_err() {
                    send(&inbox, ServiceMessage::HealthUnwritten(subject));
                }
                report_health(written);
            },
        );
    }

    pub(super) fn watch_clock(&mut self) {
        self.note_clock(self.started.elapsed(), jiff::Timestamp::now());
    }

    /// `elapsed`: monotonic time since the start.
    pub(super) fn note_clock(&mut self, elapsed: Duration, wall: jiff::Timestamp) {
        let was_set = self.wall_clock.update(elapsed, wall);
        if was_set {
            self.note_health(
                "clock",
                Some("the wall clock was set: earlier times may be wrong"),
            );
        } else if self.wall_clock.is_stable(elapsed) {
            self.note_health("clock", None);
        }
    }

    pub(super) fn note_unseen(&mut self) {
        self.unseen_due = Instant::now() + UNSEEN_CHECK_INTERVAL;
        let hours = self.settings.alarms.unseen_after_h;
        self.services.writer.submit_optional(
            move |ledger| {
                let now = record_time_now();
                let after = jiff::SignedDuration::from_secs((3600.0 * hours) as i64);
                let before = (hours > 0.0).then(|| now.at.checked_sub(after).ok());
                ledger.store.note_unseen(before.flatten(), &now)
            },
            report_health,
        );
    }

    pub(super) fn apply_retention(&mut self) {
        self.retention_due = Instant::now() + RETENTION_INTERVAL;
        let store = &self.settings.store;
        let is_stable = self.wall_clock.is_stable(self.started.elapsed());
        let days_ago = |days: f64| {
            let age = jiff::SignedDuration::from_secs((days * 86_400.0) as i64);
            let is_set = days > 0.0 && is_stable;
            is_set
                .then(|| jiff::Timestamp::now().checked_sub(age).ok())
                .flatten()
        };
        let retention = Retention {
            older_than: days_ago(store.keep_days),
            max_bytes: (store.keep_gib > 0.0).then_some((store.keep_gib * BYTES_PER_GIB) as u64),
            unnamed_older_than: days_ago(store.keep_unnamed_days),
        };
        self.services.writer.submit_optional(
            move |ledger| ledger.store.apply_retention(&retention),
            |result| match result {
                Ok(deleted) if deleted.sweeps > 0 => {
                    tracing::info!(
                        "{} old sweeps deleted, {} bytes",
                        deleted.sweeps,
                        deleted.bytes
                    );
                }
                Ok(_) => {}
                Err(error) => tracing::error!("old sweeps not deleted: {error}"),
            },
        );
    }

    pub(super) fn publish_status(&mut self) {
        let (state, reason) = match self.machine.devices() {
            DeviceAvailability::Opening => ("opening", None),
            DeviceAvailability::Ready | DeviceAvailability::Homing => ("ready", None),
            DeviceAvailability::Lost { reason, .. } => ("lost", Some(reason.clone())),
            DeviceAvailability::Closed => ("closed", None),
        };
        let current = self.machine.current();
        let stage = current.map(|(request, stage)| (request.id, stage));
        self.estimate.update(stage, Instant::now());
        let current = current.map(|(request, _)| CurrentStatus {
            task: request.task.as_str().to_owned(),
            waypoint: request.waypoint.clone(),
            progress: self.progress_of(request),
        });
        let phase = self.machine.phase();
        let task = current
            .as_ref()
            .map(|c| (c.task.as_str(), c.waypoint.as_str()));
        let line = status_line(phase, task, state, reason.as_deref());
        self.services.systemd.status(line);
        let waiting = self.machine.queued();
        self.services.status.send_modify(|status| {
            phase.clone_into(&mut status.phase);
            status.devices = DevicesStatus {
                state: state.to_owned(),
                reason,
                identity: std::mem::take(&mut status.devices.identity),
                return_ms: status.devices.return_ms,
            };
            status.current = current;
            status.waiting = waiting;
        });
    }
}

/// What systemd shows. `task`: the request under way and its waypoint, empty where it has none.
fn status_line(
    phase: &str,
    task: Option<(&str, &str)>,
    devices: &str,
    reason: Option<&str>,
) -> String {
    let devices = format!("devices {devices}");
    let mut line = match task {
        Some((task, "")) => format!("{phase} ({task}); {devices}"),
        Some((task, waypoint)) => format!("{phase} ({task} {waypoint}); {devices}"),
        None if phase == devices => devices,
        None => format!("{phase}; {devices}"),
    };
    if let Some(reason) = reason {
        line.push_str(&format!(": {}", reason.lines().next().unwrap_or_default()));
    }
    line
}

fn write_to_log(severity: Severity, device: &str, text: &str) {
    let kind = message_id::of_event(device);
    match severity {
        Severity::Info => {
            tracing::info!(MESSAGE_ID = kind, DEVICE = device, "{device}: {text}")
        }
        Severity::Warning => {
            tracing::warn!(MESSAGE_ID = kind, DEVICE = device, "{device}: {text}")
        }
        Severity::Error => {
            tracing::error!(MESSAGE_ID = kind, DEVICE = device, "{device}: {text}")
        }
    }
}

/// The beginnings and ends of health incidents, after the store has them.
fn report_health(written: Result<impl IntoIterator<Item = HealthEvent>, StoreError>) {
    match written {
        Ok(events) => events
            .into_iter()
            .for_each(|event| write_to_log(event.severity, "health", &event.text)),
        Err(error) => tracing::error!("health incident not written to the store: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{report_health, status_line, write_to_log};
    use crate::patrol::severity::Severity;
    use crate::service::captured_log::captured;
    use crate::service::message_id;
    use crate::store::HealthEvent;

    #[test]
    fn the_status_line_has_phase_request_and_devices_each_once() {
        let lost = status_line("devices lost", None, "lost", Some("laser: gone\nand more"));
        assert_eq!(lost, "devices lost: laser: gone");
        let waiting = status_line("preparing", Some(("visit", "hall")), "lost", Some("gone"));
        assert_eq!(waiting, "preparing (visit hall); devices lost: gone");
        let sweep = status_line("sweeping", Some(("sweep", "")), "ready", None);
        assert_eq!(sweep, "sweeping (sweep); devices ready");
        assert_eq!(
            status_line("idle", None, "ready", None),
            "idle; devices ready"
        );
    }

    #[test]
    fn the_journal_has_the_beginnings_and_ends_of_health_incidents_that_are_stored() {
        let event = |severity, text: &str| HealthEvent {
            severity,
            text: text.to_owned(),
        };
        let events = vec![
            event(Severity::Warning, "clock: set"),
            event(Severity::Info, "sweep: over"),
        ];
        let log = captured(|| report_health(Ok(events)));
        let kind = message_id::of_event("health");
        assert_eq!(log.matches(kind).count(), 2, "{log}");
        let lines: Vec<&str> = log.lines().collect();
        assert!(lines[0].contains("WARN") && lines[0].contains("health: clock: set"));
        assert!(lines[1].contains("INFO") && lines[1].contains("health: sweep: over"));
        assert_eq!(captured(|| report_health(Ok(None::<HealthEvent>))), "");
    }

    #[test]
    fn every_event_has_its_kind_at_every_severity() {
        for device in ["laser", "store", "service", "health"] {
            let kind = format!("MESSAGE_ID=\"{}\"", message_id::of_event(device));
            for (severity, level) in [
                (Severity::Info, "INFO"),
                (Severity::Warning, "WARN"),
                (Severity::Error, "ERROR"),
            ] {
                let line = captured(|| write_to_log(severity, device, "away"));
                let text = format!("{device}: away");
                for part in [level, &kind, &text] {
                    assert!(line.contains(part), "{line}");
                }
            }
        }
    }
}
