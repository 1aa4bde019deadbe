//! The upkeep of the store between visits.

use super::{Controller, send};
use crate::service::constants::STORAGE_INTERVAL;
use crate::service::message::ServiceMessage;
use crate::service::storage_watch::StorageWatch;
use crate::store::{Ledger, StorageReport, StoreStart};
use std::time::Instant;

impl Controller {
    /// Submits the upkeep when it is due; the first is due at once.
    pub(super) fn maintain_storage(&mut self, now: Instant) {
        if self.maintaining || now < self.maintenance_due {
            return;
        }
        self.maintaining = true;
        let inbox = self.services.inbox.clone();
        self.services
            .writer
            .submit_optional(Ledger::maintain, move |report| {
                send(&inbox, ServiceMessage::Storage(Box::new(report)));
            });
    }

    /// Reports what the start found in the store.
    pub(in crate::service) fn report_store_start(&mut self, start: &StoreStart) {
        for (severity, text) in StorageWatch::note_start(start) {
            self.log_event(severity, "store", text);
        }
    }

    pub(super) fn report_storage(&mut self, report: &StorageReport) {
        self.maintaining = false;
        self.maintenance_due = Instant::now() + STORAGE_INTERVAL;
        for (severity, text) in self.storage.note(report) {
            self.log_event(severity, "store", text);
        }
        let low_space = self.storage.low_space().map(str::to_owned);
        self.note_health("storage", low_space.as_deref());
    }

    /// The last chance: what is not stored now is in the journal of the system only.
    pub(super) fn write_held_visits(&mut self) {
        self.services.writer.submit(Ledger::retry, |retry| {
            if let (true, Some(why)) = (retry.held + retry.waiting > 0, &retry.why) {
                tracing::error!(
                    "{} visits and the files of {} more were never stored: {why}",
                    retry.held,
                    retry.waiting
                );
            }
        });
    }
}
