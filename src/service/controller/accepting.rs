//! What a client accepts: its reference is made beside the visits and stored between two writes.

use super::{Controller, send};
use crate::service::acceptance::{Acceptance, refused};
use crate::service::message::{AcceptClient, AcceptRequest, ServiceMessage};
use crate::service::message_id;
use crate::service::record_time::record_time_now;
use crate::store::{Store, StoreError};
use std::sync::Arc;
use tokio::runtime::Handle;

impl Controller {
    /// Makes the reference, after what was submitted before is written.
    pub(super) fn accept(&mut self, request: AcceptRequest, client: AcceptClient) {
        if self.restore.is_some() {
            return refuse(request.id, client);
        }
        let (inbox, pool) = (self.services.inbox.clone(), Handle::current());
        let settings = Arc::clone(&self.settings);
        self.services.writer.submit(
            |ledger| ledger.store.dir().to_owned(),
            move |dir| {
                pool.spawn_blocking(move || {
                    let prepared = Store::open_for_reading(&dir)
                        .and_then(|store| Acceptance::prepare(&store, &settings, request.id));
                    let prepared = Box::new(prepared);
                    send(
                        &inbox,
                        ServiceMessage::AcceptPrepared(prepared, request, client),
                    );
                });
            },
        );
    }

    /// On disk before the client hears of it.
    pub(super) fn store_acceptance(
        &mut self,
        prepared: Result<Acceptance, StoreError>,
        request: AcceptRequest,
        client: AcceptClient,
    ) {
        if self.restore.is_some() {
            return refuse(request.id, client);
        }
        let inbox = self.services.inbox.clone();
        self.services.writer.submit(
            move |ledger| {
                let acceptance = match prepared {
                    Ok(acceptance) => acceptance,
                    Err(why) => return (None, Err(why)),
                };
                // A visit that is held was compared with the reference of before.
                let upkeep = ledger.is_behind().then(|| ledger.maintain());
                if upkeep.as_ref().is_some_and(|report| report.retry.held > 0) {
                    let why = "visits are held in memory until the disk takes them; try again then";
                    return (upkeep, Err(refused(request.id, why.to_owned())));
                }
                let by = &request.by;
                let accepted = acceptance.store(&mut ledger.store, by, &record_time_now());
                if let Ok(reply) = &accepted {
                    let (alarm, waypoint, version) = (reply.alarm, &reply.waypoint, reply.version);
                    tracing::info!(MESSAGE_ID = message_id::REFERENCE_TAKEN, WAYPOINT = %waypoint, ALARM_ID = alarm,
                        "{waypoint}: reference version {version} taken: alarm {alarm} accepted by {by}");
                }
                (upkeep, accepted)
            },
            move |(upkeep, accepted)| {
                if let Some(report) = upkeep {
                    send(&inbox, ServiceMessage::Storage(Box::new(report)));
                }
                // The client may have disconnected.
                let _ = client.send(accepted);
            },
        );
    }
}

/// Its number may be another alarm's in the store that is being restored.
fn refuse(id: i64, client: AcceptClient) {
    let why = "a restore is under way; try again after it".to_owned();
    let _ = client.send(Err(refused(id, why)));
}
