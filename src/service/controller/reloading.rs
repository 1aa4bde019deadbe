//! Applying a configuration that was read again, and keeping the last good one.

use super::Controller;
use crate::config::{LoadedConfig, Settings, keep_last_good};
use crate::patrol::event::SettingsChange;
use crate::patrol::severity::Severity;
use crate::service::message::ServiceMessage;
use crate::service::reading_result::reading_result;
use crate::service::record_time::record_time_now;
use crate::service::reference_cache::ReferenceCache;
use crate::service::replies::ReloadReply;
use std::sync::Arc;
use tokio::sync::oneshot;

impl Controller {
    pub(in crate::service) fn notify_reloading(&self) {
        self.services.systemd.reloading();
    }

    /// Keeps the configuration that is in force. One that is already the last good one is reported: its files have mistakes.
    pub(super) fn keep_configuration(&mut self, loaded: &LoadedConfig) {
        if !loaded.refused.is_empty() {
            let mistakes: Vec<String> = loaded.refused.iter().map(ToString::to_string).collect();
            let text = format!(
                "the configuration has mistakes; the last good one is in force: {}",
                mistakes.join("; ")
            );
            return self.log_event(Severity::Error, "service", text);
        }
        let (loaded, inbox) = (loaded.clone(), self.services.inbox.clone());
        // On the writer's thread: a slow disk does not hold up the loop, a hung one is noticed.
        self.services.writer.submit(
            move |_| {
                let folder = loaded.settings.store.dir.display().to_string();
                keep_last_good(&loaded).map_err(|error| (folder, error))
            },
            move |kept| {
                if let Err((folder, error)) = kept {
                    let text =
                        format!("the configuration in force is not kept in {folder}: {error}");
                    let note = ServiceMessage::Note(Severity::Warning, "service".to_owned(), text);
                    // The loop may have ended before the writer.
                    let _ = inbox.send(note);
                }
            },
        );
    }

    /// Reports why the files are not taken, in the status and to the client that asked.
    pub(super) fn refuse_reload(
        &mut self,
        mistakes: Vec<String>,
        client: Option<oneshot::Sender<ReloadReply>>,
    ) {
        let mut reply = ReloadReply {
            at: record_time_now().to_rfc3339(),
            mistakes,
            ..ReloadReply::default()
        };
        self.services.status.send_modify(|status| {
            reply.files.clone_from(&status.config_files);
            status.config_read = reply.clone();
        });
        if let Some(client) = client {
            // It may have disconnected.
            let _ = client.send(reply);
        }
    }

    pub(super) fn settings_change(&self, new: &Settings) -> SettingsChange {
        let old = &self.settings;
        if old.laser == new.laser && old.ptu == new.ptu {
            SettingsChange::KeepDevices
        } else {
            SettingsChange::ReopenDevices
        }
    }

    pub(super) fn apply_settings(&mut self) {
        let Some(loaded) = self.next_config.take() else {
            return;
        };
        let (old, new) = (&self.settings, &loaded.settings);
        let changed = [
            ("store.dir", old.store.dir != new.store.dir),
            ("api.socket", old.api != new.api),
            ("log.to", old.log.to != new.log.to),
        ];
        let changed = changed.into_iter().filter(|(_, changed)| *changed);
        let needs_restart: Vec<String> = changed.map(|(key, _)| key.to_owned()).collect();
        for key in &needs_restart {
            tracing::warn!("{key} changed; it takes effect when the service is restarted");
        }
        if let Some(log) = &self.services.log {
            log.set(&new.log.level);
        }
        // The cached ones were prepared under the old settings.
        self.references = ReferenceCache::default();
        self.settings = Arc::new(loaded.settings.clone());
        let ptu = &self.settings.ptu;
        self.machine
            .suspect_turns(ptu.suspect_pan_rad, ptu.suspect_tilt_rad);
        let reply = ReloadReply {
            needs_restart,
            ..reading_result(&loaded)
        };
        self.services.status.send_modify(|status| {
            status.robot.clone_from(&loaded.settings.robot.name);
            status.config_files.clone_from(&reply.files);
            status.config_loaded_at.clone_from(&reply.at);
            status.config_read = reply.clone();
        });
        let text = "configuration reloaded".to_owned();
        self.log_event(Severity::Info, "service", text);
        self.keep_configuration(&loaded);
        for client in self.reload_clients.drain(..) {
            // It may have disconnected.
            let _ = client.send(reply.clone());
        }
        self.services.systemd.ready();
    }

    pub(super) fn keep_settings(&mut self, errors: &[String]) {
        let text = format!(
            "configuration not reloaded, the old one stays: {}",
            errors.join("; ")
        );
        self.log_event(Severity::Error, "service", text);
        self.services.systemd.ready();
    }
}
