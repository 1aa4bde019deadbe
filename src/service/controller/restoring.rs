//! A restore while the service runs: its files are copied beside the visits; between two of them the database is replaced.

use super::{Controller, send};
use crate::patrol::event::PatrolRequest;
use crate::patrol::severity::Severity;
use crate::service::message::{RestoreReply, RestoreStep, ServiceMessage};
use crate::service::record_time::record_time_now;
use crate::service::reference_cache::ReferenceCache;
use crate::service::running_restore::{RestorePhase, RunningRestore};
use crate::store::{PreparedRestore, StoreError};
use std::path::PathBuf;
use tokio::sync::oneshot;

impl Controller {
    pub(super) fn restore(&mut self, from: PathBuf, client: oneshot::Sender<RestoreReply>) {
        if self.restore.is_some() {
            // The client may have disconnected.
            let _ = client.send(Err("a restore is under way; try again after it".to_owned()));
            return;
        }
        self.restore = Some(RunningRestore {
            from,
            client,
            phase: RestorePhase::Beside,
            deferred: None,
        });
        // After what was submitted before: a retention that deletes what the backup names.
        let inbox = self.services.inbox.clone();
        self.services.writer.submit(
            |ledger| (ledger.store.dir().to_owned(), ledger.store.disk()),
            move |(dir, disk)| send(&inbox, step(RestoreStep::Quiet(dir, disk))),
        );
    }

    pub(super) fn restore_step(&mut self, done: RestoreStep) {
        let Some(restore) = &mut self.restore else {
            return;
        };
        let inbox = self.services.inbox.clone();
        match done {
            RestoreStep::Quiet(dir, disk) => {
                let from = restore.from.clone();
                tokio::task::spawn_blocking(move || {
                    let prepared = PreparedRestore::new(&dir, &from, disk, |_, _| ());
                    send(&inbox, step(RestoreStep::Prepared(prepared)));
                });
            }
            RestoreStep::Prepared(Ok(prepared)) => {
                restore.phase = RestorePhase::Waiting(Box::new(prepared));
                self.replace_store_if_idle();
            }
            RestoreStep::InPlace(Ok((prepared, start))) => {
                let text = format!("restored from {}", restore.from.display());
                // What was known of the old one.
                self.references = ReferenceCache::default();
                self.health.clear();
                self.report_store_start(&start);
                self.log_event(Severity::Warning, "store", text);
                self.go_on();
                tokio::task::spawn_blocking(move || {
                    send(&inbox, step(RestoreStep::Checked(prepared.finish())));
                });
            }
            RestoreStep::Checked(Ok(result)) => {
                if let Some(restore) = self.restore.take() {
                    let _ = restore.client.send(Ok(result));
                }
            }
            RestoreStep::Prepared(Err(why)) | RestoreStep::InPlace(Err(why)) => {
                self.fail_restore(&why, "the store is as it was");
            }
            RestoreStep::Checked(Err(why)) => {
                self.fail_restore(&why, "the backup is in place, and could not be checked");
            }
        }
    }

    /// Replaces the database where no visit is under way.
    pub(super) fn replace_store_if_idle(&mut self) {
        if self.machine.current().is_none() {
            self.replace_store();
        }
    }

    /// Whether a request has to wait for the restore; it is prepared when that is done.
    pub(super) fn waits_for_restore(&mut self, request: &PatrolRequest) -> bool {
        // Nothing of it was read from the old store yet, and no other one is under way.
        self.replace_store();
        match &mut self.restore {
            Some(restore) if matches!(restore.phase, RestorePhase::Replacing) => {
                restore.deferred = Some(request.clone());
                true
            }
            _ => false,
        }
    }

    /// A request that is dropped waits no longer.
    pub(super) fn forget_deferred(&mut self, id: u64) {
        if let Some(restore) = &mut self.restore {
            restore.deferred.take_if(|request| request.id == id);
        }
    }

    fn replace_store(&mut self) {
        let Some(restore) = &mut self.restore else {
            return;
        };
        match std::mem::replace(&mut restore.phase, RestorePhase::Replacing) {
            RestorePhase::Waiting(prepared) => {
                let inbox = self.services.inbox.clone();
                self.services.writer.submit(
                    move |ledger| ledger.restore(*prepared, &record_time_now()),
                    move |done| send(&inbox, step(RestoreStep::InPlace(done))),
                );
            }
            phase => restore.phase = phase,
        }
    }

    fn fail_restore(&mut self, why: &StoreError, state: &str) {
        self.go_on();
        if let Some(restore) = self.restore.take() {
            let from = restore.from.display();
            let text = format!("restore from {from} failed: {why}; {state}");
            self.log_event(Severity::Error, "store", text.clone());
            let _ = restore.client.send(Err(text));
        }
    }

    fn go_on(&mut self) {
        if let Some(restore) = &mut self.restore {
            restore.phase = RestorePhase::Beside;
        }
        if let Some(request) = self.restore.as_mut().and_then(|r| r.deferred.take()) {
            self.prepare(request);
        }
    }
}

fn step(step: RestoreStep) -> ServiceMessage {
    ServiceMessage::RestoreStep(Box::new(step))
}
