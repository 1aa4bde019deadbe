//! What the conductor does beside the patrol: settings, the event log, old sweeps, the status.

use super::Conductor;
use crate::config::Settings;
use crate::patrol::event::Change;
use crate::patrol::machine::Devices;
use crate::service::constants::RETENTION_PAUSE;
use crate::service::judge::ReadyReferences;
use crate::service::replies::{CurrentStatus, DevicesStatus};
use crate::service::stamp::stamp_now;
use crate::store::{Level, Retention};
use std::sync::Arc;
use std::time::Instant;

/// Bytes of a GiB.
const GIB: f64 = 1024.0 * 1024.0 * 1024.0;

impl Conductor {
    pub(super) fn change(&self, new: &Settings) -> Change {
        let now = &self.settings;
        if now.laser == new.laser && now.ptu == new.ptu {
            Change::Plain
        } else {
            Change::Devices
        }
    }

    pub(super) fn apply(&mut self) {
        let Some(loaded) = self.next.take() else {
            return;
        };
        let (old, new) = (&self.settings, &loaded.settings);
        let fixed = [
            ("store.dir", old.store.dir != new.store.dir),
            ("api.socket", old.api != new.api),
            ("log.to", old.log.to != new.log.to),
        ];
        for (key, _) in fixed.iter().filter(|(_, changed)| *changed) {
            tracing::warn!("{key} changes when the service starts anew");
        }
        if let Some(log) = &self.hands.log {
            log.set(&new.log.level);
        }
        // Kept references were made under the old settings.
        self.ready = ReadyReferences::default();
        self.settings = Arc::new(loaded.settings.clone());
        self.hands.status.send_modify(|status| {
            status.robot.clone_from(&loaded.settings.robot.name);
            status.config_files = loaded
                .files
                .iter()
                .map(|f| f.display().to_string())
                .collect();
            status.config_loaded_at = stamp_now().text();
        });
        let text = "configuration read again and put in force".to_owned();
        self.note(Level::Info, "service", text);
        self.hands.systemd.ready();
    }

    pub(super) fn keep(&mut self, mistakes: &[String]) {
        let text = format!(
            "configuration not put in force, the old one stays: {}",
            mistakes.join("; ")
        );
        self.note(Level::Error, "service", text);
        self.hands.systemd.ready();
    }

    pub(super) fn note(&mut self, level: Level, device: &str, text: String) {
        match level {
            Level::Info => tracing::info!(DEVICE = device, "{device}: {text}"),
            Level::Warning => tracing::warn!(DEVICE = device, "{device}: {text}"),
            Level::Error => tracing::error!(DEVICE = device, "{device}: {text}"),
        }
        let device = device.to_owned();
        self.hands.ledger.ask_spare(
            move |store| store.note_event(level, &device, &text, &stamp_now()),
            |noted| {
                if let Err(error) = noted {
                    tracing::error!("event not noted: {error}");
                }
            },
        );
    }

    pub(super) fn retain(&mut self) {
        self.retention_due = Instant::now() + RETENTION_PAUSE;
        let store = &self.settings.store;
        let age = Some(store.keep_days)
            .filter(|days| *days > 0.0 && self.wall.is_steady(self.started.elapsed()))
            .map(|days| jiff::SignedDuration::from_secs((days * 86_400.0) as i64));
        let retention = Retention {
            older_than: age.and_then(|age| jiff::Timestamp::now().checked_sub(age).ok()),
            most_bytes: (store.keep_gib > 0.0).then_some((store.keep_gib * GIB) as u64),
        };
        self.hands.ledger.ask_spare(
            move |store| store.retain(&retention),
            |swept| match swept {
                Ok(swept) if swept.sweeps > 0 => {
                    tracing::info!("{} old sweeps deleted, {} bytes", swept.sweeps, swept.bytes);
                }
                Ok(_) => {}
                Err(error) => tracing::error!("old sweeps not deleted: {error}"),
            },
        );
    }

    pub(super) fn tell_status(&mut self) {
        let (state, reason) = match self.machine.devices() {
            Devices::Opening => ("opening", None),
            Devices::Ready => ("ready", None),
            Devices::Lost { reason, .. } => ("lost", Some(reason.clone())),
            Devices::Closed => ("closed", None),
        };
        let current = self.machine.in_hand().map(|(request, _)| CurrentStatus {
            task: request.task.word().to_owned(),
            waypoint: request.waypoint.clone(),
        });
        let phase = self.machine.phase();
        let mut line = match &current {
            Some(current) if !current.waypoint.is_empty() => {
                format!("{phase} ({} {})", current.task, current.waypoint)
            }
            Some(current) => format!("{phase} ({})", current.task),
            None => phase.to_owned(),
        };
        line.push_str(&format!("; devices {state}"));
        if let Some(reason) = &reason {
            line.push_str(&format!(": {}", reason.lines().next().unwrap_or_default()));
        }
        self.hands.systemd.status(line);
        let waiting = self.machine.waiting();
        self.hands.status.send_modify(|status| {
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
